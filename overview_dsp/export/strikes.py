"""How a player is taken to render a strike, where a format leaves that to the device."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from overview_dsp.export.clip import LEVELS_PER_S, STRIKE_S


def with_strikes(
    level: NDArray[np.float64], struck: Iterable[tuple[float, float]]
) -> NDArray[np.float64]:
    """An amplitude curve (one value a millisecond) with (time s, amplitude) strikes on it.

    A strike decays linearly over `STRIKE_S`; the stronger of both is what is felt.
    """
    found = level.copy()
    fall = np.linspace(1.0, 0.0, round(STRIKE_S * LEVELS_PER_S), endpoint=False)
    for time_s, amplitude in struck:
        first = round(time_s * LEVELS_PER_S)
        reach = found[first : first + len(fall)]
        np.maximum(reach, amplitude * fall[: len(reach)], out=reach)
    return found
