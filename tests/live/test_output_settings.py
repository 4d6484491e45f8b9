"""What a device is given, after the engine: gain, mute, delay, ceiling, channels, the last fade."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.live import output_settings
from overview_dsp.live.output_settings import (
    OutputSettings,
    SignalSettings,
    load_settings,
    save_settings,
)
from overview_dsp.live.python_path import connect, run_block


@pytest.fixture
def football(rigid_football):
    """Here: it sounds within a tenth of a second."""
    return rigid_football


def played(match, football, settings, change=None, channels=2):
    """A tap and recoil through the device's stage, float32 (frames, channels)."""
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 480)
    assert connect(engine, settings) == channels
    engine.control(3.0, True, 0)
    engine.control(3.0, False, 24_000)
    blocks = []
    while engine.sample_time < 48_000:
        if change is not None and engine.sample_time == 4800:
            change(engine)
        blocks.append(np.ones((480, channels), dtype=np.float32))
        if run_block(engine, blocks[-1]):
            break
    return np.concatenate(blocks)


@pytest.fixture
def plain(match, football):
    return ov.render(match, football, ov.tap(3.0 / np.pi, 0.5), tail=0.5, trace=False).samples[
        :48_000
    ]


def test_settings_left_alone_change_no_bit(match, football, plain):
    assert np.array_equal(played(match, football, OutputSettings()), plain)


def test_each_signal_has_its_own_gain_delay_and_channel(match, football, plain):
    settings = OutputSettings(
        SignalSettings(4, gain_db=-20.0, delay_ms=10.0), SignalSettings(3, delay_ms=100.0)
    )
    heard = played(match, football, settings, channels=4)
    assert not heard[:, :2].any()
    assert np.array_equal(heard[4800:, 2], plain[:-4800, 1])
    assert not heard[:4800, 2].any()
    assert np.allclose(heard[480:, 3], plain[:-480, 0] * 0.1, rtol=1e-6, atol=1e-9)


def test_a_muted_or_unconnected_signal_is_silent_and_the_other_untouched(match, football, plain):
    for silent in (SignalSettings(2, mute=True), SignalSettings(0)):
        heard = played(match, football, OutputSettings(tactor=silent))
        assert not heard[:, 1].any()
        assert np.array_equal(heard[:, 0], plain[:, 0])


@pytest.mark.parametrize("ceiling_db", [-6.0, -20.0])
def test_nothing_passes_a_ceiling_whatever_the_gain(match, football, ceiling_db):
    loud = SignalSettings(2, gain_db=24.0, ceiling_db=ceiling_db)
    heard = played(match, football, OutputSettings(SignalSettings(1, gain_db=24.0), loud))
    assert np.abs(heard[:, 1]).max() <= 10 ** (ceiling_db / 20)
    assert np.abs(heard[:, 0]).max() <= 1.0


def test_a_gain_changed_while_it_sounds_arrives_within_twenty_milliseconds(match, football, plain):
    quieter = OutputSettings(tactor=SignalSettings(2, gain_db=-40.0))
    heard = played(
        match, football, OutputSettings(), lambda e: quieter.write(e.memory, e.sample_rate)
    )
    assert np.array_equal(heard[:4800], plain[:4800])
    assert np.allclose(heard[5761:, 1], plain[5761:, 1] * 0.01, rtol=1e-6, atol=1e-9)


def test_stopping_fades_to_zero_without_a_step(match, football, plain):
    def stop(engine):
        engine.memory.view(np.int64)[layout.L_STOP] = 1

    heard = played(match, football, OutputSettings(), stop)
    assert len(heard) == 4800 + 960
    assert np.abs(plain[4800:5760, 1]).max() > 0.1  # it was sounding
    assert not heard[-1].any()
    assert np.abs(heard[-48:]).max() < 0.01


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"gain_db": 30.0}, "gain 30 is out of range; it is -60 to 24"),
        ({"gain_db": float("nan")}, "gain nan isn't a number"),
        ({"delay_ms": 101.0}, "delay 101 is out of range; it is 0 to 100"),
        ({"ceiling_db": 1.0}, "ceiling 1 is out of range; it is -60 to 0"),
        ({"channel": -1}, "channel -1 is out of range"),
        ({"channel": 1}, "can't share channel 1"),
    ],
)
def test_what_a_device_cannot_be_given_is_one_line(values, words):
    with pytest.raises(ov.InputError, match=words):
        OutputSettings().changed(tactor=values)


def test_settings_are_remembered_for_each_device(tmp_path, monkeypatch):
    monkeypatch.setattr(output_settings, "settings_file", lambda: tmp_path / "a" / "outputs.json")
    pad = OutputSettings(SignalSettings(3), SignalSettings(4, -3.0, True, 20.0, -6.0))
    assert load_settings("pad") == OutputSettings()
    save_settings("pad", pad)
    save_settings("other", OutputSettings())
    assert load_settings("pad") == pad
    (tmp_path / "a" / "outputs.json").write_text('{"pad": {"click": {}}}')
    with pytest.raises(ov.InputError, match=r"outputs\.json: the settings of 'pad' are damaged"):
        load_settings("pad")
