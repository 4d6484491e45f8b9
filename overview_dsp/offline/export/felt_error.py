"""How far an exported clip is from what was rendered, as a finger perceives it.

Felt level: RMS over 10 ms in dB, as in `measure.felt`; both sides count as silent below 46 dB under
full scale. An error of up to one just noticeable step is no error to a finger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.breakpoints import felt_db
from overview_dsp.offline.export.clip import LEVELS_PER_S
from overview_dsp.units import FELT_WINDOW_S

NOTICEABLE_DB = 2.3
"""One step of amplitude on the skin (Israr and Tan 2006: 2.2 to 2.5 dB)."""


@dataclass(frozen=True)
class FeltError:
    """How far an exported clip is from what was rendered, as a finger takes it.

    Attributes
    ----------
    median_db, largest_db : float
        Of the level over 10 ms, dB.
    within_percent : float
        The part of the clip within one just noticeable step (2.3 dB), %.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> ov.export.export(result, "haptic", "match.haptic").error.within_percent > 50.0
    True
    """

    median_db: float
    largest_db: float
    within_percent: float


def felt_error(played: NDArray[np.float64], rendered: NDArray[np.float64]) -> FeltError:
    """Compare two amplitude curves of one value a millisecond; a missing end is silence."""
    count = max(len(played), len(rendered))
    sides = [np.pad(side, (0, count - len(side))) for side in (played, rendered)]
    error = np.abs(_windows_db(sides[0]) - _windows_db(sides[1]))
    return FeltError(
        float(np.median(error)),
        float(error.max()),
        float(100.0 * np.mean(error <= NOTICEABLE_DB)),
    )


def _windows_db(level: NDArray[np.float64]) -> NDArray[np.float64]:
    width = round(FELT_WINDOW_S * LEVELS_PER_S)
    padded = np.pad(level, (0, -len(level) % width))
    return felt_db(np.sqrt(np.mean(padded.reshape(-1, width) ** 2, axis=1)))
