"""What the tests of actuators share: a drive, the motion it makes, and how fast that rises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import cont2discrete, lfilter

from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import ActuatorStage

RATE = 48_000
ROUNDING = 1.0 + 1e-6
"""What a float32 may add."""


def driven(actuator, signal, rate=RATE, sizes=None):
    """The drive of a signal, float64, and the stage that made it; in blocks of these sizes."""
    stage = ActuatorStage(actuator, rate)
    samples = np.zeros((len(signal), 2), dtype=np.float32)
    with np.errstate(over="ignore"):
        samples[:, 1] = signal
    start = 0
    for size in sizes or [len(signal)]:
        stage.process(samples[start : start + size], 1)
        start += size
    if start < len(signal):
        stage.process(samples[start:], 1)
    return samples[:, 1].astype(float), stage


def changed(actuator: Actuator, **values) -> Actuator:
    """An actuator with some of its values changed: `drive__peak=2.0`."""
    given = {key.replace("__", "."): value for key, value in values.items()}
    return replace(actuator, values={**actuator.values, **given})


def motion(actuator, drive, rate=RATE):
    """How an actuator moves, by scipy: a mass on a spring, its drive held from sample to sample."""
    w0 = 2.0 * np.pi * actuator.resonance_hz
    system = ([w0 * w0], [1.0, w0 / actuator.q, w0 * w0])
    b, a, _ = cont2discrete(system, 1.0 / rate)
    return lfilter(b.ravel(), a, drive)


def envelope(signal, frequency_hz, rate=RATE):
    """Amplitude of a vibration over its last period."""
    turning = np.exp(-2j * np.pi * frequency_hz / rate * np.arange(len(signal)))
    period = round(rate / frequency_hz)
    mean = np.convolve(signal * turning, np.ones(period) / period)[: len(signal)]
    return 2.0 * np.abs(mean)


def burst(frequency_hz, on_s, off_s, amplitude=1.0, rate=RATE):
    """A tone for so long, then silence for so long."""
    tone = amplitude * np.sin(2.0 * np.pi * frequency_hz / rate * np.arange(round(on_s * rate)))
    return np.concatenate([tone, np.zeros(round(off_s * rate))])


def rise_ms(level, full, rate=RATE):
    """From 10 to 90 % of `full`, ms."""
    return 1e3 / rate * (np.argmax(level >= 0.9 * full) - np.argmax(level >= 0.1 * full))


def fall_ms(level, full, rate=RATE):
    """From 90 to 10 % of `full`, ms, of a level that begins above both."""
    return 1e3 / rate * (np.argmax(level < 0.1 * full) - np.argmax(level < 0.9 * full))


def highest_mean_square(drive, frames):
    """Highest mean square over so many frames, silence before and after included."""
    power = np.cumsum(np.concatenate([np.zeros(frames), drive * drive]))
    return (power[frames:] - power[: len(power) - frames]).max() / frames
