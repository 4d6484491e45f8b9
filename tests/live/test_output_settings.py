"""What a device is given, after the engine: gain, mute, delay, ceiling, channels, the last fade."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.live.output import devices
from overview_dsp.live.output import settings as output_settings
from overview_dsp.live.output.devices import find_device, open_error
from overview_dsp.live.output.settings import (
    OutputSettings,
    SignalSettings,
    load_settings,
    parse_channels,
    remembered_actuator,
    save_settings,
)
from overview_dsp.live.output.stream import compile_python_path, connect, run_block


@pytest.fixture
def football(rigid_football):
    """Here: it sounds within a tenth of a second."""
    return rigid_football


def played(match, football, settings, change=None, channels=2, block=480):
    """A tap and recoil through the device's stage, float32 (frames, channels)."""
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 480)
    assert connect(engine, settings) == channels
    compile_python_path(engine)
    engine.control(3.0, True, 0)
    engine.control(3.0, False, 24_000)
    blocks = []
    while engine.sample_time < 48_000:
        if change is not None and engine.sample_time == 4800:
            change(engine)
        blocks.append(np.ones((block, channels), dtype=np.float32))
        if run_block(engine, blocks[-1]):
            break
    return np.concatenate(blocks)[:48_000]


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


COILS = {"gain_db": 3.0, "delay_ms": 7.0, "ceiling_db": -6.0}
PAD = OutputSettings(SignalSettings((1, 2), -6.0), SignalSettings((3, 4), **COILS))
C2 = ov.load_actuator("c2")


@pytest.mark.parametrize("actuator", [None, C2], ids=["plain", "c2"])
@pytest.mark.parametrize("block", [480, 37])
def test_what_goes_to_several_channels_is_the_same_to_the_bit(match, football, actuator, block):
    one = OutputSettings(SignalSettings(1, -6.0), SignalSettings(3, **COILS), actuator)
    heard = played(match, football, replace(PAD, actuator=actuator), channels=4, block=block)
    alone = played(match, football, one, channels=3, block=block)
    assert np.abs(heard).max(axis=0).min() > 0.1  # all of them sound
    for channel, same in enumerate((0, 0, 2, 2)):
        assert np.array_equal(heard[:, channel], alone[:, same])


def test_each_signal_can_use_any_channels_and_unused_channels_are_silent(match, football, plain):
    settings = OutputSettings(SignalSettings((64, 2, 33)), SignalSettings((5, 1)))
    heard = played(match, football, settings, channels=64)
    for signal, columns in enumerate(([63, 1, 32], [4, 0])):
        assert (heard[:, columns] == plain[:, [signal]]).all()
    silent = sorted(set(range(64)) - {63, 1, 32, 4, 0})
    assert not heard[:, silent].any()


def test_a_stream_without_settings_forgets_the_several_of_the_one_before(match, football, plain):
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 480)
    connect(engine, PAD)
    engine.set_channels(0, 1)
    assert connect(engine, None) == 2
    out = np.ones((480, 4), dtype=np.float32)
    engine.control(3.0, True, 0)
    for start in range(0, 4800, 480):
        run_block(engine, out)
        assert np.array_equal(out[:, :2], plain[start : start + 480])
        assert not out[:, 2:].any()


def test_an_ending_fades_all_of_several_channels(match, football):
    def stop(engine):
        engine.memory.view(np.int64)[layout.L_STOP] = 1

    heard = played(match, football, PAD, stop, channels=4)
    assert len(heard) == 4800 + 960
    assert np.array_equal(heard[:, 0], heard[:, 1])
    assert np.array_equal(heard[:, 2], heard[:, 3])
    assert np.abs(heard[4800:5000]).max(axis=0).min() > 0.0
    assert not heard[-1].any()


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
        ({"gain_db": 30.0}, "gain 30 is out of range; must be -60 to 24"),
        ({"gain_db": float("nan")}, "gain nan isn't a number"),
        ({"delay_ms": 101.0}, "delay 101 is out of range; must be 0 to 100"),
        ({"ceiling_db": 1.0}, "ceiling 1 is out of range; must be -60 to 0"),
        ({"channel": -1}, "channel -1 is out of range"),
        ({"channel": 1}, "both use channel 1"),
        ({"channel": (3, 1)}, "both use channel 1"),
        ({"channel": (3, 3)}, "channel 3 is listed twice"),
        ({"channel": (3, 0)}, "channel 0 is out of range; must be 1 to 64"),
        ({"channel": (3, 65)}, "channel 65 is out of range"),
        ({"channel": ()}, "channels are empty; use 0 for none"),
        ({"channel": 1.5}, "channel 1.5 must be a whole number"),
        ({"channel": "3+4"}, "channel '3\\+4' isn't a number"),
    ],
)
def test_an_invalid_output_setting_gives_a_one_line_error(values, words):
    with pytest.raises(ov.InputError, match=words):
        OutputSettings().changed(tactor=values)


def test_channels_are_typed_as_numbers_joined_by_plus():
    assert [parse_channels(text) for text in ("0", "3", "3+4", "4+3+9")] == [
        0,
        3,
        (3, 4),
        (4, 3, 9),
    ]
    for text, words in (
        ("", "channel '' must be a number, several"),
        ("3,4,", "channel '3,4,' must be"),
        ("3+", "channel '3\\+' must be"),
        ("-1", "channel -1 is out of range; must be 0 to 64"),
        ("0+1", "channel 0 is out of range; must be 1 to 64"),
    ):
        with pytest.raises(ov.InputError, match=words):
            parse_channels(text)


@pytest.mark.parametrize("tactor", [4, (4, 6), 0])
def test_settings_are_remembered_for_each_device(tmp_path, monkeypatch, tactor):
    monkeypatch.setattr(output_settings, "settings_file", lambda: tmp_path / "a" / "outputs.json")
    pad = OutputSettings(SignalSettings(3), SignalSettings(tactor, -3.0, True, 20.0, -6.0))
    assert load_settings("pad") == OutputSettings()
    save_settings("pad", pad)
    save_settings("other", OutputSettings())
    assert load_settings("pad") == pad
    (tmp_path / "a" / "outputs.json").write_text('{"pad": {"click": {}}}')
    with pytest.raises(ov.InputError, match=r"outputs\.json: settings of 'pad' are damaged"):
        load_settings("pad")


def test_settings_written_by_hand_or_by_an_earlier_version_are_taken(tmp_path, monkeypatch):
    path = tmp_path / "outputs.json"
    monkeypatch.setattr(output_settings, "settings_file", lambda: path)
    signal = '"gain_db": 0.0, "mute": false, "delay_ms": 0.0, "ceiling_db": 0.0}'
    path.write_text(
        f'{{"pad": {{"click": {{"channel": 1, {signal}, "tactor": {{"channel": [3, 4], {signal}}}}}'
    )
    assert load_settings("pad") == OutputSettings(SignalSettings(1), SignalSettings((3, 4)))
    assert remembered_actuator("pad") is None


@pytest.mark.parametrize(
    ("name", "channels", "is_pad"),
    [
        ("DualSense Wireless Controller: USB Audio (hw:1,0) (ALSA)", 4, True),
        ("Speakers (Wireless Controller) (Windows WASAPI)", 4, True),
        ("Wireless Controller (ALSA)", 2, False),
        ("HDA Intel PCH (ALSA)", 4, False),
    ],
)
def test_a_pad_with_coils_plays_on_them_until_other_settings_are_remembered(
    tmp_path, monkeypatch, name, channels, is_pad
):
    monkeypatch.setattr(output_settings, "settings_file", lambda: tmp_path / "outputs.json")
    assert output_settings.is_pad(name, channels) == is_pad
    first = load_settings(name, channels)
    assert first.channels_text == (
        "clicks on 1+2, tactor on 3+4" if is_pad else "clicks on 1, tactor on 2"
    )
    assert remembered_actuator(name, channels) == ("dualsense" if is_pad else None)
    save_settings(name, OutputSettings())
    assert load_settings(name, channels) == OutputSettings()
    assert remembered_actuator(name, channels) is None


def test_the_output_called_pad_is_one_with_coils_of_the_usual_host(monkeypatch):
    def there(*outputs):
        found = [
            ov.live.OutputDevice(index, name, host, channels, 48_000.0, 0.01, index == 0)
            for index, (name, host, channels) in enumerate(outputs)
        ]
        monkeypatch.setattr(devices, "devices", lambda: found)

    usual = ("Built-in", "WASAPI", 2)
    there(usual, ("DualSense", "MME", 4), ("DualSense", "WASAPI", 4))
    assert find_device("pad").index == 2
    there(usual, ("DualSense", "MME", 4))
    assert find_device("pad").index == 1
    there(usual, ("Wireless Controller", "WASAPI", 2))
    with pytest.raises(ov.InputError, match=r"--device pad: no output .* by USB"):
        find_device("pad")


class TwoChannels:
    """PortAudio that has one output, of two channels."""

    class PortAudioError(Exception):
        pass

    def query_devices(self, device, kind):
        return {"name": "Pad", "hostapi": 0, "max_output_channels": 2}

    def query_hostapis(self, host):
        return {"name": "ALSA"}


def test_an_output_that_has_lost_channels_is_refused_with_where_they_are_remembered(
    tmp_path, monkeypatch
):
    path = tmp_path / "outputs.json"
    monkeypatch.setattr(output_settings, "settings_file", lambda: path)
    sounddevice = TwoChannels()

    def refusal():
        why = sounddevice.PortAudioError("Invalid number of channels [PaErrorCode -9998]")
        return str(open_error(sounddevice, "Pad", 4, 48_000.0, why))

    given = refusal()
    assert given == (
        "output device 'Pad' (Pad): Invalid number of channels [PaErrorCode -9998]; it has 2 "
        "channels, but 4 are needed; use `overview play` with --set click.channel=1 --set "
        "tactor.channel=2, or the command `channels 1 2` during playback"
    )
    save_settings("Pad (ALSA)", PAD)
    assert refusal() == given.replace("needed;", f"needed by its settings in {path};")


def test_any_gain_above_0_db_is_limited_at_the_ceiling():
    memory = np.zeros(layout.TOTAL)
    for gain_db, limited in ((0.0, 0.0), (0.5, 1.0), (6.0, 1.0)):
        OutputSettings().changed(click={"gain_db": gain_db}).write(memory, 48_000.0)
        assert memory[layout.L_WANTED + 2 * layout.SIGNALS] == limited
