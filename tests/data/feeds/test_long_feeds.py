"""Ten hours of a feed: memory that doesn't grow."""

from __future__ import annotations

import tracemalloc

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line, take_line


def hour_of(live, hour):
    for second in range(3600 * hour, 3600 * (hour + 1), 5):
        take_line(live, encode_line({"sample": [second, (second * 7 % 100) / 100.0]}))
        event = {"time_s": second, "kind": "foul", "label": str(second)}
        take_line(live, encode_line({"event": event, "id": str(second)}))
        if second % 50 == 0:
            take_line(live, encode_line({"retract": str(second)}))
        if second % 900 == 0:
            live.snapshot()


def test_ten_hours_of_a_feed_leave_memory_flat(monkeypatch):
    # a fiftieth of what comes and of what is kept: ten hours in seconds
    monkeypatch.setattr("overview_dsp.data.feeds.feed_history.MAX_SAMPLES", 1_310)
    monkeypatch.setattr("overview_dsp.data.feeds.feed_history.MAX_EVENTS", 400)
    monkeypatch.setattr("overview_dsp.data.feeds.feed_history.MAX_TAKEN_BACK", 100)
    live = ov.LiveTimeline(expect_s=5700.0)
    tracemalloc.start()
    held = []
    for hour in range(10):
        hour_of(live, hour)
        held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert max(held[4:]) < 1.3 * max(held[2:4])
    assert live.snapshot().known_until_s > 35_900.0
    assert live.snapshot().intensity.count <= 1_310
