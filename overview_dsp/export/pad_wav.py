"""Four channels for pads whose voice coils are channels 3 and 4 (DualSense): clicks, vibration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.rendering.offline import Result
from overview_dsp.rendering.trace import Trace

CHANNELS = 4


def pad_samples(result: Result[Trace | None]) -> NDArray[np.float32]:
    """Return float32 (frames, 4): click left and right, tactor left and right."""
    return np.ascontiguousarray(result.samples[:, [0, 0, 1, 1]])
