"""Meters of a session's output across several streams."""

from __future__ import annotations

from types import SimpleNamespace

import overview_dsp as ov
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
