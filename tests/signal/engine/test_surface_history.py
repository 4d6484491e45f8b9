"""Strikes are those of the surface that was under the disk, however late they are looked up."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from tests.examples import plain_preset, timeline_of

RATE = 8000
LONG = timeline_of(*(float(time_s) for time_s in range(1, 10)))
SHORT = timeline_of(5.0)


def prepared(timeline=LONG):
    engine = ov.Engine(plain_preset(), timeline)
    engine.prepare(RATE, 8 * RATE)
    return engine


def pass_all(engine, seconds=0.5):
    """Step to the end, let go; nothing is looked up."""
    now = engine.sample_time
    engine.control(np.pi, True, now)
    engine.control(np.pi, False, now + round(seconds * RATE))
    engine.process(np.empty((round(12 * seconds * RATE), 2), dtype=np.float32))


def struck_times(engine):
    return [event.time_s for event, _ in engine.pop_strike_events()]


@pytest.mark.parametrize("change", ["timeline", "preset", "parameter"])
def test_strikes_looked_up_after_a_change_are_of_the_surface_they_fell_on(change):
    once = prepared()
    pass_all(once)
    expected = struck_times(once)
    assert len(expected) > 9

    engine = prepared()
    pass_all(engine)
    if change == "timeline":
        engine.set_timeline(SHORT)
    elif change == "preset":
        engine.set_preset(plain_preset(surface__friction=2e-3))
    else:
        engine.set("surface.friction", 2e-3)
    engine.process(np.empty((RATE, 2), dtype=np.float32))
    strikes = engine.pop_strikes()
    assert [LONG.events[index].time_s for index in strikes.event] == expected


def test_strikes_before_and_after_a_change_are_each_of_their_own():
    engine = prepared()
    pass_all(engine)
    engine.set_timeline(SHORT)
    pass_all(engine)
    engine.set_timeline(LONG)
    pass_all(engine)
    times = struck_times(engine)
    there_and_back = [float(time_s) for time_s in [*range(1, 10), *range(9, 0, -1)]]
    assert times == [*there_and_back, 5.0, 5.0, *there_and_back]
    assert struck_times(engine) == []


def test_a_change_that_still_waits_says_nothing_yet():
    engine = prepared()
    engine.set_timeline(SHORT, sample_time=100 * RATE)
    pass_all(engine)
    assert set(struck_times(engine)) == {float(time_s) for time_s in range(1, 10)}


def test_more_changes_than_are_remembered_lose_only_what_nobody_took():
    engine = prepared()
    pass_all(engine)
    for number in range(300):
        engine.set_timeline(SHORT if number % 2 else LONG)
        engine.process(np.empty((RATE // 10, 2), dtype=np.float32))
    pass_all(engine)
    assert set(struck_times(engine)) == {5.0}
