from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import hilbert

import overview_dsp as ov
from overview_dsp.signal.actuators.library import load_actuator
from overview_dsp.signal.actuators.sweep import log_sweep
from tests.signal.actuators.driving import RATE, driven, motion


def test_a_sweep_takes_the_same_time_for_each_octave_at_an_even_level():
    tone = log_sweep(50.0, 800.0, 4.0, -20.0, RATE)
    assert len(tone) == 4 * RATE
    analytic = hilbert(tone)
    hertz = np.diff(np.unwrap(np.angle(analytic))) * RATE / (2.0 * np.pi)
    for second, expected in ((1.0, 100.0), (2.0, 200.0), (3.0, 400.0)):
        assert hertz[round(second * RATE)] == pytest.approx(expected, rel=1e-3)
    assert np.abs(analytic)[RATE // 10 : -RATE // 10] == pytest.approx(0.1, rel=0.01)
    assert abs(tone[0]) < 1e-12
    assert abs(tone[-1]) < 1e-12


def test_a_sweep_finds_an_actuators_resonance_and_width():
    """What the sweep is for: measured from its motion, a C-2 is what its profile says."""
    c2 = load_actuator("c2").unshaped
    low, high, seconds = 150.0, 400.0, 30.0
    drive, stage = driven(c2, log_sweep(low, high, seconds, -9.0, RATE))
    assert stage.protected.reduction_db == 0.0
    level = np.abs(hilbert(motion(c2, drive)))
    at = low * (high / low) ** (np.arange(len(level)) / len(level))
    assert at[np.argmax(level)] == pytest.approx(250.0, rel=0.01)
    felt = at[level > level.max() * np.sqrt(0.5)]
    assert felt.max() - felt.min() == pytest.approx(250.0 / c2.q, rel=0.03)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((200.0, 100.0, 1.0, 0.0), "must rise within 1 to 21600 Hz"),
        ((20.0, 30_000.0, 1.0, 0.0), "within 1 to 21600 Hz"),
        ((0.0, 100.0, 1.0, 0.0), "must rise within 1 to"),
        ((float("nan"), 100.0, 1.0, 0.0), "from nan to 100 Hz"),
        ((20.0, 100.0, 0.0, 0.0), "sweep duration is 0 s; must be 0.1 to 600 s"),
        ((20.0, 100.0, float("inf"), 0.0), "sweep duration is inf s"),
        ((20.0, 100.0, 1.0, 3.0), "level is 3 dB; must be -80 to 0 dB"),
    ],
)
def test_a_sweep_that_cannot_be_is_an_error_of_one_line(given, words):
    with pytest.raises(ov.InputError, match=words):
        log_sweep(*given, RATE)
