"""Look-ahead limiter: keeps true peaks (ITU-R BS.1770-5, annex 2) below a ceiling.

The gain is known for the whole render before it is applied: the minimum over the look-ahead, then
its mean over the same time. So it changes smoothly and is low enough at each peak.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.arrays import FloatArray, SampleArray

STEP_S = 1e-3  # resolution of the gain, s
LOOK_AHEAD_S = 5e-3  # time over which the gain falls before a peak, and rises after it, s

_OVERSAMPLING = 4
_MARGIN = 64  # frames on both sides that the interpolation needs
_LEAST_FRAMES = 1 << 14  # frames that are interpolated at once


class TruePeaks:
    """Meter for the true peak of each step of 1 ms (`step_frames`), fed with blocks."""

    def __init__(self, sample_rate: float) -> None:
        self.step_frames = max(round(STEP_S * sample_rate), 1)
        self._waiting = np.zeros(_MARGIN, np.float32)
        self._found: list[FloatArray] = []

    def feed(self, samples: SampleArray) -> None:
        """Feed the next samples, float32 (frames,)."""
        self._waiting = np.concatenate([self._waiting, samples])
        if len(self._waiting) >= _LEAST_FRAMES:
            self._measure()

    def finish(self) -> FloatArray:
        """Return the peak of each step, linear."""
        self._waiting = np.pad(self._waiting, (0, 2 * _MARGIN + self.step_frames))
        self._measure()
        return np.concatenate(self._found)

    def _measure(self) -> None:
        from scipy.signal import resample_poly  # slow

        steps = (len(self._waiting) - 2 * _MARGIN) // self.step_frames
        count = steps * self.step_frames
        fine = resample_poly(self._waiting[: count + 2 * _MARGIN], _OVERSAMPLING, 1)
        inside = fine[_OVERSAMPLING * _MARGIN :][: _OVERSAMPLING * count]
        self._found.append(np.abs(inside).reshape(steps, -1).max(axis=1))
        self._waiting = self._waiting[count:]


class Limiter:
    """Gain that is lowered where the peaks would be above a ceiling.

    `peaks`, `step_frames`: true peak and frames of each step, from `TruePeaks`.
    `gain`, `ceiling`: gain outside of the peaks, and highest peak, linear.
    `lowest`: lowest gain relative to `gain`, linear; 1 without peaks above the ceiling.
    """

    def __init__(self, peaks: FloatArray, step_frames: int, gain: float, ceiling: float) -> None:
        from scipy.ndimage import minimum_filter1d, uniform_filter1d  # slow

        needed = np.minimum(1.0, ceiling / np.maximum(gain * peaks, 1e-30))
        width = 2 * round(LOOK_AHEAD_S / STEP_S) + 1
        # one step more on both sides, because the gain is interpolated between steps
        lowest = minimum_filter1d(needed, width + 2, mode="nearest")
        shape = uniform_filter1d(lowest, width, mode="nearest")
        self.lowest, self._gains = float(shape.min()), gain * shape
        self._step_frames = step_frames
        self._frame = 0

    def apply(self, samples: SampleArray) -> None:
        """Apply the gain to the next samples, float32 (frames,), in place."""
        frames = self._frame + np.arange(len(samples))
        self._frame += len(samples)
        steps = (frames + 0.5) / self._step_frames - 0.5
        samples *= np.interp(steps, np.arange(len(self._gains)), self._gains).astype(np.float32)
