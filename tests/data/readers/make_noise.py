"""Noise as electrodes and muscles make it, added to an ECG by the rules of the noise stress test.

The stress test's own noise (MIT-BIH NSTDB, record `em`) isn't in this project, so it is made up of
what that record is made of: an electrode that is knocked (bumps about as long as a QRS complex) and
pulled (jumps that creep back), both now stronger and now weaker, the baseline's wander, muscles.
How much of each, and how long the bumps are, was chosen so that two published detectors do on
record 118e24 at 6 dB about what they do in the stress test itself: NeuroKit2's rodrigues2021
0.89 sensitivity / 0.77 precision (there 0.895 / 0.792), wfdb's xqrs 0.92 / 0.71 (0.889 / 0.699).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

_PARTS = (1.0, 0.1, 0.3)
"""Rms of electrode, wander and muscles."""

_KNOCKS_A_SECOND = 6.0
_KNOCK_S = (0.01, 0.02)
"""Standard deviations of a knock's bell, s."""

_PULLS_A_SECOND = 0.5
_SWELL = 0.7
"""Standard deviation of the electrode's level, natural logarithm, over some 20 s."""


def electrode_noise(seconds: float, rate: float, seed: int) -> NDArray[np.float64]:
    """Make noise of about unit power."""
    rng = np.random.default_rng(seed)
    count = round(seconds * rate)
    time = np.arange(count) / rate

    def filtered(order: int, edges: float | tuple[float, float]) -> NDArray[np.float64]:
        kind = "bandpass" if isinstance(edges, tuple) else "lowpass"
        sections = butter(order, edges, kind, fs=rate, output="sos")
        return unit(sosfilt(sections, rng.normal(size=count)))

    electrode = np.zeros(count)
    for _ in range(rng.poisson(_PULLS_A_SECOND * seconds)):
        first = rng.integers(count)
        back, rise = rng.uniform(0.1, 1.5), rng.uniform(0.005, 0.04)
        since = time[: min(count - first, int(6 * back * rate))]
        pull = np.exp(-since / back) - np.exp(-since / rise)
        electrode[first : first + len(since)] += 2.0 * rng.normal() * pull
    for _ in range(rng.poisson(_KNOCKS_A_SECOND * seconds)):
        centre, width = rng.uniform(0, seconds), np.exp(rng.uniform(*np.log(_KNOCK_S)))
        low, high = np.searchsorted(time, [centre - 4 * width, centre + 4 * width])
        bump = np.exp(-0.5 * ((time[low:high] - centre) / width) ** 2)
        electrode[low:high] += 2.0 * rng.normal() * bump
    electrode *= np.exp(_SWELL * filtered(1, 0.05))
    wander = filtered(2, (0.05, 0.7))
    muscles = filtered(2, (15.0, min(100.0, 0.45 * rate))) * np.exp(0.7 * filtered(1, 0.3))
    parts = zip(_PARTS, (electrode, wander, muscles), strict=True)
    return sum((part * unit(signal) for part, signal in parts), np.zeros(count))


def unit(signal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the signal with mean 0 and rms 1."""
    return (signal - signal.mean()) / signal.std()


def with_noise(
    ecg: NDArray[np.float64], rate: float, beats: NDArray[np.int64], snr_db: float, seed: int
) -> NDArray[np.float64]:
    """Add noise so that the ECG is so many dB above it, both measured as the stress test does.

    The signal's power is that of a sine of the QRS complexes' usual height from peak to peak; the
    noise's is the square of its usual deviation in a second (PhysioNet's `nst`; "usual": the mean
    without the highest and lowest 5 %).
    """
    noise = electrode_noise(len(ecg) / rate, rate, seed)[: len(ecg)]
    reach, second = round(0.05 * rate), round(rate)
    heights = [np.ptp(ecg[b - reach : b + reach]) for b in beats if reach <= b < len(ecg) - reach]
    signal_power = _usual(np.array(heights[:300])) ** 2 / 8.0
    whole = noise[: len(noise) // second * second].reshape(-1, second)
    noise_power = _usual(whole.std(axis=1)) ** 2
    return ecg + noise * np.sqrt(signal_power / noise_power / 10.0 ** (snr_db / 10.0))


def _usual(values: NDArray[np.float64]) -> float:
    ordered = np.sort(values)
    omitted = int(0.05 * len(ordered))
    return float(ordered[omitted : len(ordered) - omitted].mean())


class RealNoise:
    """The electrode noise of the stress test, from two recordings of record 118.

    118e00 begins 20,000 samples after 118e24 and its first 40 s are clean. Their difference after
    that is 24.4 s of the noise, which is repeated there and back.
    """

    def __init__(self, folder: Path) -> None:
        loud, quiet = (np.loadtxt(folder / "ecg" / f"118e{db}.csv") for db in ("00", "24"))
        noise = ((loud[:23_200] - quiet[20_000:]) / (1.0 - 10.0**-1.2))[14_400:]
        noise -= noise.mean()
        self.loop = np.concatenate([noise, noise[::-1]])
        beats = np.loadtxt(folder / "ecg" / "118e24_ann.csv").astype(np.int64)
        self._height = usual_height(quiet, beats)

    def added(
        self, ecg: NDArray[np.float64], beats: NDArray[np.int64], snr_db: float, offset: int
    ) -> NDArray[np.float64]:
        """Add the noise to an ECG at 360 Hz, from an offset in samples on."""
        noise = np.resize(np.roll(self.loop, -offset), len(ecg))
        return ecg + noise * usual_height(ecg, beats) / self._height * 10.0 ** (-snr_db / 20.0)


def usual_height(ecg: NDArray[np.float64], beats: NDArray[np.int64]) -> float:
    """Return the median height of the QRS complexes at 360 Hz, from peak to peak."""
    heights = [np.ptp(ecg[b - 18 : b + 18]) for b in beats if 18 <= b < len(ecg) - 18]
    return float(np.median(heights))
