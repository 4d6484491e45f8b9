"""An actuator's drive, bit for bit: compiled against plain Python, and renders without one."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.signal.actuators.library import load_actuator
from overview_dsp.signal.actuators.stage import ActuatorStage
from tests.interpreted import interpreted


def driven():
    """An overdriven edge, heat, a braked edge, silence, the skin's weighting."""
    time = np.arange(9600) / 48_000
    tone = 1.5 * np.sin(1571.0 * time) * (time < 0.12)
    sounds = []
    for name in ("c2", "lra", "cmf"):
        samples = np.stack([np.zeros(9600), tone], axis=1).astype(np.float32)
        ActuatorStage(load_actuator(name), 48_000).process(samples, 1)
        sounds.append(samples.tobytes())
    return b"".join(sounds)


def test_compiled_and_interpreted_drives_are_the_same_bits():
    compiled = driven()
    assert len(compiled) == 3 * 9600 * 8
    assert np.frombuffer(compiled, np.float32).any()
    assert interpreted("tests.signal.actuators.test_bits", "driven()") == compiled


def test_an_actuator_changes_the_tactors_channel_alone(match, football):
    gesture = ov.tap(0.6, 0.1)
    plain = ov.render(match, football, gesture, tail=0.2)
    result = ov.render(match, football, gesture, tail=0.2, actuator=load_actuator("c2"))
    assert np.array_equal(result.samples[:, 0], plain.samples[:, 0])
    assert np.array_equal(result.trace["torque"], plain.trace["torque"])
    expected = plain.samples.copy()
    ActuatorStage(load_actuator("c2"), 48_000).process(expected, 1)
    assert np.array_equal(result.samples, expected)
    assert not np.array_equal(result.samples[:, 1], plain.samples[:, 1])
    assert plain.protected is None
    assert result.protected is not None


def test_a_render_to_a_file_is_driven_as_one_to_arrays(match, football, tmp_path):
    import soundfile

    c2 = load_actuator("c2")
    path = tmp_path / "a.wav"
    ov.render_to_file(match, football, ov.tap(0.6, 0.1), path, 8000, subtype="FLOAT", actuator=c2)
    result = ov.render(match, football, ov.tap(0.6, 0.1), 8000, actuator=c2)
    assert np.array_equal(soundfile.read(path, dtype="float32")[0], result.samples)


def test_a_render_until_rest_ends_after_the_drive_has(match, football):
    slow = load_actuator("voice_coil")
    slow = type(slow)(
        "slow",
        "slow",
        "slow",
        {
            **{id: value for id, value in slow.values.items() if id != "resonance.q"},
            "resonance.frequency_hz": 20.0,
            "resonance.q": 100.0,
            "resonance.tolerance_percent": 0.0,
            "shaping.overdrive": 4.0,
        },
    )
    football = football.with_changes({"disk.k1": 0.01})  # at rest before such a drive is
    plain = ov.render(match, football, ov.tap(0.2, 0.05), 8000, trace=False)
    with pytest.warns(ov.OverviewWarning, match="set that to 20 Hz"):
        result = ov.render(match, football, ov.tap(0.2, 0.05), 8000, trace=False, actuator=slow)
    assert len(result.samples) > len(plain.samples)
    assert not result.samples[-round(0.05 * 8000) :].any()


@pytest.mark.parametrize(
    ("samples", "channel", "words"),
    [
        (np.zeros((8, 2)), 1, "float32"),
        (np.zeros(8, dtype=np.float32), 0, r"\(frames, channels\)"),
        (np.zeros((2, 8), dtype=np.float32).T, 1, "C-ordered"),
        ([[0.0, 0.0]], 1, "array"),
        (np.zeros((8, 2), dtype=np.float32), 2, "channel 2 is not one of 2"),
        (np.zeros((8, 2), dtype=np.float32), -1, "channel -1 is not one of 2"),
    ],
)
def test_what_a_stage_cannot_drive_is_an_error_of_one_line(samples, channel, words):
    with pytest.raises(ov.InputError, match=words):
        ActuatorStage(load_actuator("c2"), 48_000).process(samples, channel)


@pytest.mark.parametrize("rate", [0.1, -48_000.0, float("nan"), float("inf")])
def test_a_rate_that_cannot_be_is_an_error_of_one_line(rate):
    with pytest.raises(ov.InputError, match="needs a sample rate above 556 Hz"):
        ActuatorStage(load_actuator("c2"), rate)
