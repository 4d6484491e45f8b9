"""Ticks of a match's windows: its minutes, as on the board."""

from __future__ import annotations

import pytest

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.ticks import KINDS, halves_of


def match(*halves_min: float, also: tuple[Event, ...] = (Event(61.0, "foul"),)) -> Timeline:
    edges = [60.0 * sum(halves_min[:i]) for i in range(len(halves_min) + 1)]
    return Timeline("x", edges[-1], (*(Event(at, "period") for at in edges), *also))


def marks(part: Timeline) -> dict[str, tuple[float, str]]:
    return {e.label: (round(e.time_s, 6), e.kind) for e in part.events if e.kind in KINDS}


def test_ticks_of_a_match_are_its_minutes_with_added_time_and_the_half() -> None:
    found = marks(match(48.0, 50.0).window(44 * 60.0, 52 * 60.0))
    assert found["minute 45, first half"] == (60.0, "quarter_hour")
    assert found["45+0:30"] == (90.0, "second")
    assert found["minute 45+2, first half"] == (180.0, "minute")
    assert found["45:30"] == (270.0, "second")  # the second half begins at 48:00
    assert found["minute 46, second half"] == (300.0, "minute")


def test_a_window_of_a_window_has_the_minutes_of_the_whole() -> None:
    whole = match(46.0, 45.0, 16.0, 17.0)
    at = (46 + 45 + 16 + 16) * 60.0
    outer = whole.window(at - 600.0, at + 60.0)
    assert marks(outer.window(590.0, 620.0)) == marks(whole.window(at - 10.0, at + 20.0))
    words = "minute 120+1, extra time, second half"
    assert marks(outer.window(590.0, 620.0))[words] == (10.0, "minute")


@pytest.mark.parametrize(
    "events",
    [
        match(20.0, 50.0),
        match(48.0),
        match(48.0, 50.0, also=()),
        match(45.0, 45.0, 15.0, 15.0, 9.0),
    ],
    ids=["too short", "one half", "no word of a match", "five"],
)
def test_what_is_no_whole_match_has_ticks_of_its_clock(events: Timeline) -> None:
    assert halves_of(events.events) == ()
    assert "minute 19" in marks(events.window(1000.0, 1200.0))
