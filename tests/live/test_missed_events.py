"""What a person missed in a live timeline: the disk visits it, in order."""

from __future__ import annotations

import math

import pytest

import overview_dsp as ov
from overview_dsp.live.session.live_updates import REST_S
from tests.live.stepped_session import Session, event


@pytest.fixture
def live():
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(
        events=[event(0, "period"), event(300, "goal", "1-0"), event(700, "near_miss", "b")],
        clock_s=800.0,
    )
    return live


@pytest.fixture
def session(live, monkeypatch):
    one = Session(live, monkeypatch, announce="none")
    yield one
    one.player.close()


def touch_and_release(session):
    session.player.touch(0.1)
    session.run(0.5)
    session.player.release()
    session.run(1.0)


def visited(session, seconds=8.0):
    """The positions at which the input rests, and the kinds that are struck, until it is over."""
    rests, struck = [], []

    def look():
        held = session.player.engine.active_input
        at = None if held is None else held[1] / math.pi
        kinds = [found.kind for found, _ in session.player.engine.pop_strike_events()]
        if at is not None:  # not in the recoil
            struck.extend(kinds)
            if not rests or abs(rests[-1] - at) > 1e-6:
                rests.append(at)

    session.player.queue_command("missed")
    session.run(seconds, look)
    return rests, struck


def test_the_disk_visits_what_is_new_since_the_release_in_order(session, live):
    touch_and_release(session)
    new = [event(1500, "foul", "c"), event(1000, "goal", "2-0"), event(1900, "red_card", "d")]
    for one in new:
        live.append(events=[one], clock_s=max(one.time_s, 1500.0))
        session.run(0.3)
    rests, struck = visited(session)
    angle_map = session.player.active_window.angle_map
    asked = [
        float(angle_map.position_of(one.time_s)) for one in sorted(new, key=lambda e: e.time_s)
    ]
    assert rests == pytest.approx([at + 0.012 for at in asked], abs=1e-9)
    assert [kind for kind in struck if kind in ("foul", "red_card")] == ["foul", "red_card"]
    assert struck.count("goal") == 2  # the first one is on the way
    assert "goal 2-0 at 16:40.0" in session.messages
    assert not session.player.pointer.touching
    # and then nothing is new
    session.player.queue_command("missed")
    session.run(0.2)
    assert "missed: no event is new since the last release" in session.messages


def test_a_time_asks_for_all_events_from_then_on(session):
    session.player.queue_command("missed", "5:00")
    session.run(2.5 * REST_S)
    assert "visiting 2 events that you missed" in session.messages
    assert "goal 1-0 at 5:00.0" in session.messages


def test_the_hand_ends_a_visit(session, live):
    touch_and_release(session)
    live.append(events=[event(900 + n, "foul", str(n)) for n in range(5)], clock_s=950.0)
    session.run(0.3)
    session.player.queue_command("missed")
    session.run(0.4)
    session.player.touch(0.05)
    session.run(6.0)
    assert session.player.pointer.position == 0.05
    assert session.player.pointer.touching


def test_a_withdrawn_goal_is_visited_as_such(session, live):
    touch_and_release(session)
    gone = event(1000, "goal", "2-0")
    live.append(events=[gone, event(1100, "foul", "x")], clock_s=1200.0)
    session.run(0.3)
    live.retract(gone)
    session.run(0.3)
    rests, struck = visited(session, 3.0)
    assert len(rests) == 2
    assert struck.count("goal") == 1  # the first goal, on the way
    assert struck.count("withdrawn_goal") == 1
    assert "withdrawn goal 2-0 at 16:40.0" in session.messages


def test_a_complete_timeline_has_nothing_to_visit(monkeypatch):
    one = Session(None, monkeypatch, timeline=ov.load_timeline("made-up-share"), preset="series")
    one.player.queue_command("missed")
    one.run(0.1)
    one.player.close()
    assert any("this timeline is complete" in line for line in one.messages)
