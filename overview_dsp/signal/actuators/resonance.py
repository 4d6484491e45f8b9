"""Fit of an actuator's resonance to a recording of a sweep.

The sweep is deconvolved from the recording, so its start in the recording doesn't matter. A window
around the impulse response removes later noise, and the harmonics of distortion, which precede it
(Farina, "Simultaneous measurement of impulse response and distortion with a swept-sine technique",
AES 108, 2000). Frequency, Q and gain of a mass on a spring are then fitted to the level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage, optimize

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.public import short
from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS
from overview_dsp.signal.actuators.sweep import log_sweep

QUANTITIES = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""What a sensor measures: the power of frequency by which it exceeds the displacement."""

BEFORE_S, AFTER_S = 0.1, 1.0  # window around the impulse response; a Q of 100 at 100 Hz is in it
LEAST_S = 4.0  # duration of a sweep; in a shorter one, any click seems to be its response
POINTS_PER_OCTAVE = 96
EDGE = 1.05  # the first and last 5 % of the sweep are faded, so they are left out
INSIDE = 1.3  # least ratio between the resonance and the ends of the response
LEAST_SNR_DB = 10.0
LEAST_EXPLAINED = (
    0.4  # part of the recording's energy that is the sweep; of noise up to 0.3 seems so
)
FEW = 20  # samples that a highest peak may have, or a noise
MOST_AT_PEAK = 0.3  # samples within 0.1 % of the highest among those within 10 %; a tone has 0.1
LARGEST_RESIDUAL_DB = 3.0  # RMS deviation from the model within an octave of the resonance
LEAST_TOLERANCE = 0.2  # percent: an actuator's resonance changes with grip and temperature
LARGEST_TOLERANCE = 10.0  # percent
CORRELATED = 4.0  # neighbouring points with one error

_Q = ACTUATOR_PARAMETERS["resonance.q"]


@dataclass(frozen=True)
class ResonanceFit:
    """Resonance of an actuator, fitted to a recording.

    Attributes
    ----------
    frequency_hz, q : float
        Resonance.
    tolerance_percent : float
        Largest likely error of the frequency: three standard errors, at least 0.2 %.
    residual_db : float
        RMS deviation of the response from the model within an octave of the resonance, dB.
    response_hz, response_db, model_db : float64 (points,)
        Measured and modelled level of the displacement, relative to that at the resonance.

    Examples
    --------
    >>> ov.actuators.ResonanceFit(250.0, 12.0, 0.2, 0.4, *np.zeros((3, 0))).q
    12.0
    """

    frequency_hz: float
    q: float
    tolerance_percent: float
    residual_db: float
    response_hz: FloatArray
    response_db: FloatArray
    model_db: FloatArray

    def __repr__(self) -> str:
        tolerance = f"{self.tolerance_percent:g} %"
        return f"<ResonanceFit: {self.frequency_hz:.4g} Hz within {tolerance}, Q {self.q:.3g}>"


def fit_resonance(
    recording: FloatArray,
    sample_rate: float,
    low_hz: float,
    high_hz: float,
    seconds: float,
    quantity: str = "acceleration",
) -> ResonanceFit:
    """Fit frequency and Q of a resonance to a recording of a logarithmic sweep.

    Parameters
    ----------
    recording : float64 (frames,)
        One channel of a microphone or accelerometer that contains the whole sweep.
    sample_rate : float
        Hz.
    low_hz, high_hz, seconds : float
        First and last frequency, Hz, and duration of the sweep, as for `log_sweep`.
    quantity : {"acceleration", "velocity", "displacement"}
        What the sensor measures. A microphone close to the actuator measures acceleration.

    Returns
    -------
    ResonanceFit
        Resonance, its tolerance, and the response.

    Raises
    ------
    InputError
        A sweep of less than an octave or 4 s; a recording that is too short, noisy or clipped, of
        something else, or without a resonance in the sweep's range.

    Examples
    --------
    >>> from scipy.signal import bilinear, lfilter
    >>> sweep = ov.actuators.log_sweep(50.0, 1000.0, 4.0, level_db=-9.0, sample_rate=8000)
    >>> w = 2.0 * np.pi * 200.0
    >>> moved = lfilter(*bilinear([1.0, 0.0, 0.0], [1.0, w / 8.0, w * w], 8000), sweep)
    >>> fit = ov.actuators.fit_resonance(moved, 8000, 50.0, 1000.0, 4.0)
    >>> round(fit.frequency_hz), round(fit.q)
    (200, 8)
    """
    if quantity not in QUANTITIES:
        raise InputError(f"quantity is {short(quantity)}; must be one of {', '.join(QUANTITIES)}")
    recording = validation.floats(recording, "recording")
    sweep = log_sweep(low_hz, high_hz, seconds, 0.0, sample_rate)
    if high_hz / low_hz < 2.0 * EDGE**2 or seconds < LEAST_S:
        raise InputError(
            f"sweep is from {low_hz:g} to {high_hz:g} Hz in {seconds:g} s; must span over an "
            f"octave, and last {LEAST_S:g} s or more"
        )
    _require_sound(recording)
    hertz, level = _response(recording, sweep, sample_rate, low_hz * EDGE, high_hz / EDGE)
    level = level - 20.0 * QUANTITIES[quantity] * np.log10(hertz)
    fits = [
        _fit(hertz, level, start, q)
        for start in np.geomspace(hertz[0] * EDGE, hertz[-1] / EDGE, 8)
        for q in (2.0, 15.0)
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    # again, without the points far below the peak, where distortion and noise matter most
    near = np.abs(np.log2(hertz) - best.x[0] / math.log(2.0)) <= 1.0
    if np.count_nonzero(near) > POINTS_PER_OCTAVE // 4:
        best = _fit(hertz[near], level[near], *np.exp(best.x[:2]))
    frequency, q = np.exp(best.x[:2]).tolist()
    residual = float(np.sqrt(np.mean(np.square(best.fun))))
    variance = np.linalg.pinv(best.jac.T @ best.jac)[0, 0] * residual**2 * CORRELATED
    tolerance = max(LEAST_TOLERANCE, 300.0 * math.sqrt(variance))
    inside = (
        hertz[0] * INSIDE < frequency < hertz[-1] / INSIDE and 1.01 * _Q.low < q < 0.99 * _Q.high
    )
    if not (inside and residual <= LARGEST_RESIDUAL_DB and tolerance <= LARGEST_TOLERANCE):
        raise InputError(
            f"no resonance between {hertz[0]:.3g} and {hertz[-1]:.3g} Hz explains the recording "
            f"(closest: {frequency:.4g} Hz, Q {q:.3g}, off by {residual:.1f} dB RMS); put the "
            "sensor onto the actuator, check the quantity, or sweep other frequencies"
        )
    model = _model_db(hertz, frequency, q)
    return ResonanceFit(
        frequency, q, math.ceil(10.0 * tolerance) / 10.0, residual, hertz, level - best.x[2], model
    )


def _fit(hertz: FloatArray, level: FloatArray, frequency: float, q: float) -> Any:
    """Fit log frequency, log Q and gain (dB) to a level (dB), from a frequency and a Q."""

    def deviation(values: FloatArray) -> FloatArray:
        found: FloatArray = level - values[2] - _model_db(hertz, *np.exp(values[:2]))
        return found

    low = [math.log(hertz[0]), math.log(_Q.low), -np.inf]
    high = [math.log(hertz[-1]), math.log(_Q.high), np.inf]
    start = [math.log(frequency), math.log(q), np.interp(frequency, hertz, level)]
    return optimize.least_squares(
        deviation, np.clip(start, low, high), bounds=(low, high), loss="soft_l1"
    )


def _model_db(hertz: FloatArray, frequency: float, q: float) -> FloatArray:
    """Return the displacement at frequencies relative to that at the resonance, dB."""
    u = hertz / frequency
    return -10.0 * np.log10(np.square(q * (1.0 - u * u)) + u * u)


def _require_sound(recording: FloatArray) -> None:
    """Check that samples are finite and not clipped, which lowers the Q; InputError otherwise."""
    if not np.isfinite(recording).all():
        raise InputError("the recording has samples that are not finite; record it again")
    level = np.abs(recording)
    highest = level.max(initial=0.0)
    at_peak = np.count_nonzero(level > 0.999 * highest)
    if at_peak > max(FEW, MOST_AT_PEAK * np.count_nonzero(level > 0.9 * highest)):
        raise InputError(
            f"the recording is clipped ({at_peak} samples at its highest level); lower its level"
        )


def _response(
    recording: FloatArray, sweep: FloatArray, sample_rate: float, low: float, high: float
) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and level, dB, of the recording relative to the sweep, without noise."""
    if len(recording) < len(sweep):
        raise InputError(
            f"the recording lasts {len(recording) / sample_rate:.2f} s; must contain the whole "
            f"sweep of {len(sweep) / sample_rate:.2f} s"
        )
    before, after = round(BEFORE_S * sample_rate), round(AFTER_S * sample_rate)
    size = len(recording) + len(sweep) + 4 * after
    reference = np.fft.rfft(sweep, size)
    power = np.square(np.abs(reference))
    bins = np.fft.rfftfreq(size, 1.0 / sample_rate)
    recorded = np.fft.rfft(recording, size)
    recorded[(bins < low / EDGE) | (bins > high * EDGE)] = 0.0
    impulse = np.fft.irfft(recorded * np.conj(reference) / (power + 1e-6 * power.max()), size)
    starts = len(recording) - len(sweep) + 2 * after  # a second less or more than fits
    peak = int(np.argmax(np.abs(np.roll(impulse, after)[:starts]))) - after
    window = np.concatenate([np.hanning(2 * before)[:before], np.hanning(2 * after)[after:]])
    length = 2 ** math.ceil(math.log2(4 * len(window)))
    # noise: the same window where the response has decayed
    response, later = (
        np.roll(impulse, before - at)[: len(window)] * window for at in (peak, peak + 2 * after)
    )
    heard, noise = (np.abs(np.fft.rfft(one, length)) for one in (response, later))
    explained = np.roll(np.fft.irfft(np.fft.rfft(response, size) * reference, size), peak - before)
    whole = np.fft.irfft(recorded, size)
    if not np.sum((whole - explained) ** 2) < (1.0 - LEAST_EXPLAINED) * np.sum(whole**2):
        raise InputError(
            "the recording is mostly something else than this sweep; record closer to the "
            "actuator, or give the frequencies and the duration of its sweep"
        )
    hertz = np.geomspace(low, high, round(math.log2(high / low) * POINTS_PER_OCTAVE))
    at = np.fft.rfftfreq(length, 1.0 / sample_rate)
    levels = 20.0 * np.log10(np.maximum(np.interp(hertz, at, heard), 1e-12))
    power = ndimage.uniform_filter1d(np.square(np.interp(hertz, at, noise)), POINTS_PER_OCTAVE // 2)
    clear = levels - 10.0 * np.log10(np.maximum(power, 1e-24)) > LEAST_SNR_DB
    if np.count_nonzero(clear) < POINTS_PER_OCTAVE:
        raise InputError(
            "the recording has less than an octave that is 10 dB above its noise; record closer "
            "to the actuator, at a higher level, or a longer sweep of the same options"
        )
    return hertz[clear], levels[clear]
