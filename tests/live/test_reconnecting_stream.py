"""Meters of a session's output across several streams."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.live.output import devices, portaudio_library, reconnecting_stream
from overview_dsp.live.output.devices import OutputDevice
from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import StreamMeters
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.live.session.session import STATES, Session


def make_stream(callbacks):
    """Return a stream without a device that has had a number of callbacks of 64 frames."""
    meters = StreamMeters(callbacks, 64 * callbacks, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return SimpleNamespace(
        name="counting",
        block_size=64,
        active=True,
        connections=None,
        missing_connections=(),
        waits_for_server=False,
        meters=meters,
        start=lambda: None,
        close=lambda: None,
    )


def test_the_meters_of_all_reconnected_streams_are_added(football, match):
    engine = ov.Engine(football, match)
    engine.prepare(sample_rate=8000, max_block_size=64)
    streams = iter([make_stream(3), make_stream(5), make_stream(7)])
    output = ReconnectingStream(Session(engine), lambda *_: next(streams), OutputSettings())
    for total in (3, 3 + 5, 3 + 5 + 7):
        output.open()
        assert output.meters.callbacks == total
        output.disconnect()
        assert output.meters.callbacks == total
        assert output.meters.frames == 64 * total


def output(index, name, host="ALSA"):
    return OutputDevice(index, name, host, 2, 48_000.0, 0.005, False)


@pytest.mark.parametrize("device", ["1", "Speakers"])
def test_a_chosen_output_is_opened_again_under_any_number_and_never_another_one(
    football, match, monkeypatch, device
):
    engine = ov.Engine(football, match)
    opened, present = [], []

    def open_one(engine, device, *_):
        opened.append(device)
        return SimpleNamespace(index=1 if isinstance(device, str) else device)

    monkeypatch.setattr(reconnecting_stream, "OutputStream", open_one)
    monkeypatch.setattr(portaudio_library, "rescan", lambda: None)
    monkeypatch.setattr(devices, "devices", lambda: present)
    monkeypatch.setattr(
        reconnecting_stream,
        "find_device",
        lambda index: next(o for o in present if o.index == index),
    )
    opener = reconnecting_stream.StreamOpener(device, 256, "native")
    present[:] = [output(0, "other"), output(1, "Speakers (hw:1,0)"), output(2, "Speakers", "JACK")]
    opener(engine, OutputSettings())
    # ALSA gives the card another number, and there is an output with a longer name
    present[:] = [output(0, "External Speakers (hw:3,0)"), output(4, "Speakers (hw:2,0)")]
    opener(engine, OutputSettings())
    assert opened == [1 if device == "1" else device, 4]
    present[:] = [output(0, "External Speakers (hw:2,0)"), output(1, "Speakers", "JACK")]
    with pytest.raises(ov.InputError, match=r"output Speakers .* is not there"):
        opener(engine, OutputSettings())
    # two equal ones: that with the nearest number
    present[:] = [output(2, "Speakers (hw:2,0)"), output(5, "Speakers (hw:2,0)")]
    opener(engine, OutputSettings())
    assert opened[2:] == [5]


def test_the_default_output_is_looked_up_each_time(football, match, monkeypatch):
    opened = []
    monkeypatch.setattr(
        reconnecting_stream, "OutputStream", lambda engine, device, *_: opened.append(device)
    )
    monkeypatch.setattr(portaudio_library, "rescan", lambda: None)
    opener = reconnecting_stream.StreamOpener(None, 256, "native")
    for _ in range(2):
        opener(ov.Engine(football, match), OutputSettings())
    assert opened == [None, None]


def test_a_replay_ends_with_a_released_disk_if_its_output_cannot_restart(
    football, match, monkeypatch
):
    stream = make_stream(1)
    player = Player(
        match, PresetWatch("football"), lambda *_: stream, OutputSettings(), sample_rate=8000
    )

    def fail(begin):
        raise ov.OverviewError("the server doesn't respond")

    stream.restart = fail
    out = np.zeros((8192, 2), np.float32)
    player.touch(0.5)
    player.engine.process(out)
    assert player.engine.active_input is not None
    player.loop.begin(ov.parse_gesture("sweep:1"), "a sweep")
    player.engine.process(out)
    assert not player.loop.playing
    assert player.engine.active_input is None
    assert not player.pointer.touching
    player.close()


def test_the_state_names_what_plays_or_why_nothing_does_and_keeps_the_last_stop(
    football, match, monkeypatch
):
    monkeypatch.setattr(reconnecting_stream, "LOST_AFTER_S", 1e9)
    streams = []

    def open_one(engine, settings):
        if len(streams) == 1:
            raise ov.OverviewError("there is no output")
        streams.append(make_stream(0))
        return streams[-1]

    player = Player(match, PresetWatch("football"), open_one, OutputSettings(), sample_rate=8000)
    out = np.zeros((8192, 2), np.float32)

    def state(seconds=0.0):
        for _ in range(round(seconds * 8000 / 8192)):
            player.engine.process(out)
        status = player.poll()
        assert status.state == player.state
        assert status.state.name in STATES
        return status.state.name, status.state.reason, status.state.last_stop

    assert state() == ("starting", "opening counting", "")
    streams[0].meters = make_stream(1).meters
    assert state(1.1) == ("no input", "nothing touches the disk", "")
    player.touch(0.1)
    assert state(1.1) == ("running", "by touch", "")
    player.release()
    assert state(8.0)[0] == "no input"
    streams[0].active = False
    lost = "output lost: counting disconnected"
    assert state() == ("output lost", "counting disconnected", lost)
    player.output._retry_at = 0.0
    assert state() == ("output lost", "counting disconnected", lost)  # nor by the failed attempt
    streams.append(None)
    player.output._retry_at = 0.0
    assert state() == ("starting", "opening counting", lost)
    streams[-1].meters = make_stream(1).meters
    assert state() == ("no input", "nothing touches the disk", lost)
    streams[-1].restart = lambda begin: begin()
    player.loop.begin(ov.tap(0.1, 0.05), "take.csv", repeats=False)
    assert state() == ("running", "take.csv, pass 1", lost)
    for _ in range(100):
        if state(1.1)[0] == "paused":
            break
    ended = "paused: take.csv, pass 1, ended"
    assert state() == ("paused", "take.csv, pass 1, ended", ended)
    player.touch(0.1)
    assert state(1.1) == ("running", "by touch", ended)
    player.close()


def test_a_block_of_a_second_is_no_loss(football, match, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(reconnecting_stream, "time", SimpleNamespace(monotonic=lambda: now[0]))
    engine = ov.Engine(football, match)
    engine.prepare(sample_rate=8000, max_block_size=8192)
    stream = make_stream(1)
    stream.block_size, stream.waits_for_server = 8192, True
    session = Session(engine)
    output = ReconnectingStream(session, lambda *_: stream, OutputSettings())
    output.open()
    for number in range(100):
        now[0] += 0.1
        stream.meters = make_stream(1 + number // 10).meters
        output.poll()
    assert (output.playing, session.take_messages()) == (True, ())


def test_a_frozen_server_keeps_its_stream_which_plays_on_later(football, match, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(reconnecting_stream, "time", SimpleNamespace(monotonic=lambda: now[0]))
    engine = ov.Engine(football, match)
    engine.prepare(sample_rate=8000, max_block_size=64)
    stream, opened = make_stream(1), []
    stream.waits_for_server = True
    session = Session(engine)
    output = ReconnectingStream(session, lambda *_: opened.append(0) or stream, OutputSettings())
    output.open()

    def pass_time(seconds, callbacks):
        for _ in range(round(seconds / 0.1)):
            now[0] += 0.1
            stream.meters = make_stream(stream.meters.callbacks + callbacks).meters
            output.poll()

    pass_time(2.0, 12)
    assert (output.playing, session.take_messages()) == (True, ())
    pass_time(0.9, 0)
    (line,) = session.take_messages()  # within a second
    pass_time(4.0, 0)
    assert session.take_messages() == ()
    assert "doesn't respond" in line
    assert not output.playing
    with pytest.raises(ov.OverviewError, match="start its server"):
        output.disconnect()
    pass_time(1.0, 12)
    (line,) = session.take_messages()
    assert "reconnected" in line
    assert output.playing
    assert len(opened) == 1
    # its server ends: another stream is opened
    pass_time(2.0, 0)
    stream.active = False
    pass_time(0.1, 0)
    assert "disconnected" in session.take_messages()[-1]
    assert not output.playing
