"""Meters of a session's output across several streams."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

import overview_dsp as ov
from overview_dsp.live.output import reconnecting_stream
from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import StreamMeters
from overview_dsp.live.session.session import Session


def make_stream(callbacks):
    """Return a stream without a device that has had a number of callbacks of 64 frames."""
    meters = StreamMeters(callbacks, 64 * callbacks, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return SimpleNamespace(
        name="counting",
        block_size=64,
        active=True,
        connections=None,
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
    pass_time(5.0, 0)
    (line,) = session.take_messages()
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
