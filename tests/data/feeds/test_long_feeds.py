"""Memory of a feed of ten hours."""

from __future__ import annotations

import tracemalloc

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line
from tests.data.feeds.feeds import apply_line


def hour_of(live, hour):
    for second in range(3600 * hour, 3600 * (hour + 1), 5):
        apply_line(live, encode_line({"sample": [second, (second * 7 % 100) / 100.0]}))
        event = {"time_s": second, "kind": "foul", "label": str(second)}
        apply_line(live, encode_line({"event": event, "id": str(second)}))
        if second % 50 == 0:
            apply_line(live, encode_line({"retract": str(second)}))
        if second % 900 == 0:
            live.snapshot()


def test_memory_does_not_grow_in_ten_hours_of_a_feed(monkeypatch):
    # a fiftieth of the data and of the capacity, so that ten hours take seconds
    monkeypatch.setattr("overview_dsp.data.feeds.feed_history.MAX_SAMPLES", 1_310)
    monkeypatch.setattr("overview_dsp.data.feeds.feed_history.MAX_EVENTS", 400)
    monkeypatch.setattr("overview_dsp.data.feeds.feed_history.MAX_RETRACTIONS", 100)
    live = ov.LiveTimeline(expected_duration_s=5700.0)
    tracemalloc.start()
    memory = []
    for hour in range(10):
        hour_of(live, hour)
        memory.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert max(memory[4:]) < 1.3 * max(memory[2:4])
    assert live.snapshot().known_until_s > 35_900.0
    assert live.snapshot().intensity.count <= 1_310
