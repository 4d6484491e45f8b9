"""A timeline that grows under a hand: held maps, what is told, takes."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

import overview_dsp as ov
from overview_dsp.design.presets.library import preset_path
from overview_dsp.kernels import layout
from overview_dsp.live.session import commands
from overview_dsp.live.takes.takes import timeline_path
from overview_dsp.measure.perception import TOUCH_FLOOR_DB, levels, touch_pulses
from overview_dsp.signal.engine import engine as engine_module
from overview_dsp.units import FELT_WINDOW_S
from tests.live.stepped_session import RATE, Session, event


@pytest.fixture
def live():
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(
        events=[event(0, "period"), event(300, "foul", "a"), event(700, "near_miss", "b")],
        clock_s=800.0,
    )
    return live


@pytest.fixture
def session(live, monkeypatch):
    made = []

    def make(**keywords):
        made.append(Session(live, monkeypatch, **keywords))
        return made[-1]

    yield make
    for one in made:
        one.player.close()


@pytest.mark.parametrize("map", ["whole", "so far"])
def test_a_finger_that_holds_through_fifty_updates_has_the_bits_of_what_it_touched(
    session, live, map
):
    live.layout = map
    one = session()
    snapshot = one.window_timeline
    alone = ov.Engine(one.player.engine.preset, snapshot)
    alone.prepare(RATE, 160)
    one.player.touch(0.12)
    one.run(0.1)
    for n in range(50):
        live.append(events=[event(820 + n, "goal", str(n))], clock_s=821.0 + n)
        one.player.touch(0.12 - 0.002 * n)
        one.run(0.04)
    alone.control(0.12 * math.pi, True, 0)
    out = np.empty((160, 2), np.float32)
    heard = []
    for block in range(len(one.output.sound)):
        step = block // 2
        if block % 2 == 0 and step >= 5 and (step - 5) % 2 == 0:
            alone.control((0.12 - 0.002 * ((step - 5) // 2)) * math.pi, True)
        alone.process(out)
        heard.append(out.copy())
    assert np.array_equal(one.samples, np.concatenate(heard))
    assert one.window_timeline is snapshot or map == "whole"  # what lies ahead comes at once
    one.player.release()
    one.run(1.5)
    assert one.window_timeline is live.padded_snapshot()
    assert one.window_timeline.kinds()["goal"] == 50


def test_new_data_beyond_a_touch_appear_during_it_without_changing_its_bits(
    session, live, tmp_path
):
    """The map is the whole: no place moves; the hand goes on and meets what is new."""
    take = tmp_path / "take.csv"
    one = session(record=take)
    alone = ov.Engine(one.player.engine.preset, one.window_timeline)
    alone.prepare(RATE, 160)
    one.player.touch(0.04)
    alone.control(0.04 * math.pi, True, 0)
    one.run(0.5)
    for n in range(50):
        at = 1000.0 + 20.0 * n
        live.append(events=[event(at, "goal" if n == 25 else "foul", str(n))], clock_s=at)
        one.run(0.06)
    assert one.window_timeline.known_until_s > 1900.0
    assert one.window_timeline.kinds()["goal"] == 1
    out, heard = np.empty((160, 2), np.float32), []
    for _ in one.output.sound:
        alone.process(out)
        heard.append(out.copy())
    assert np.array_equal(one.samples, np.concatenate(heard))
    for n in range(40):
        one.player.touch(0.04 + 0.008 * n)
        one.run(0.02)
    one.run(1.0)
    struck = [found.kind for found, _ in one.player.engine.pop_strike_events()]
    assert "goal" in struck
    assert one.player.live_updates.announced == []
    joined = one.player.engine.surface.friction
    one.player.release()
    one.run(2.5)
    assert one.window_timeline is live.padded_snapshot()
    assert not np.array_equal(one.player.engine.surface.friction, joined)  # all of it now
    heard = one.samples
    one.player.close()
    changes = ov.load_gesture(take).changes
    assert any("ahead" in change.what.get("timeline", {}) for change in changes)
    again = ov.render(str(timeline_path(take)), "football", str(take), RATE, tail="none").samples
    count = min(len(heard), len(again))
    assert np.array_equal(again[:count], heard[:count])


@pytest.mark.parametrize("how", ["so far", "a part", "behind", "retracted"])
def test_no_update_applies_during_a_touch_if_positions_move_or_passed_data_change(
    session, live, how
):
    one = session()
    if how == "so far":
        live.layout = "so far"
    if how == "a part":
        one.player.show(200.0, 800.0)
    one.run(0.2)
    one.player.touch(0.08)
    one.run(0.2)
    before = one.window_timeline
    new = 100 if how == "behind" else 2000
    live.append(events=[event(new, "goal", "1-0")], clock_s=2000.0)
    if how == "retracted":
        live.retract(event(300, "foul", "a"))
    one.run(0.5)
    assert one.window_timeline is before
    one.player.release()
    one.run(0.1)
    assert one.window_timeline is not before


def test_an_update_arrives_at_release_and_the_disk_does_not_jump(session, live):
    one = session()
    live.layout = "so far"
    one.run(0.2)
    one.player.touch(0.9)
    one.run(2.0)
    live.append(events=[event(1500, "goal", "1-0")], clock_s=1600.0)
    one.run(0.3)
    assert one.window_timeline.known_until_s == 800.0
    one.player.release()
    one.run(1.0)
    assert one.window_timeline.known_until_s == 1600.0
    trace = one.trace
    theta, omega = (trace[:, layout.TRACE_COLUMNS.index(n)] for n in ("theta1", "omega1"))
    moved = np.diff(theta) - (omega[1:] + omega[:-1]) / 2.0 / RATE
    assert np.abs(moved).max() < 1e-12


def test_an_update_waits_for_a_disk_that_is_still_on_its_way(session, live):
    one = session()
    live.layout = "so far"
    one.run(0.2)
    one.player.tap(0.9)
    one.run(0.3)
    live.append(events=[event(1500, "goal", "1-0")], clock_s=1600.0)
    one.run(0.3)
    meters = one.player.engine.meters
    assert (meters.touching, meters.engaged) == (False, True)
    assert one.window_timeline.known_until_s == 800.0
    one.run(2.0)
    assert one.window_timeline.known_until_s == 1600.0
    trace = one.trace
    cursor, engaged = (trace[:, layout.TRACE_COLUMNS.index(n)] for n in ("cursor", "engaged"))
    assert cursor[engaged > 0.5].max() == pytest.approx(0.9, abs=0.008)


def test_an_update_comes_under_a_finger_after_the_time_that_was_chosen(session, live):
    one = session(after_s=0.5)
    one.run(0.1)
    one.player.touch(0.13)
    one.run(0.1)
    live.append(events=[event(900, "foul")], clock_s=900.0)
    one.run(0.3)
    assert one.window_timeline is not live.padded_snapshot()
    one.run(0.3)
    assert one.window_timeline is live.padded_snapshot()


def test_the_end_of_a_timeline_moves_no_position_during_a_touch(session, live, tmp_path):
    take = tmp_path / "take.csv"
    one = session(after_s=0.2, record=take)
    one.run(0.1)
    events = [event(900 + 10 * n, "foul", str(n)) for n in range(5)]
    live.append(events=events, clock_s=950.0)
    one.run(0.1)
    one.player.touch(0.13)
    one.run(0.1)
    live.end(live.padded_snapshot().duration_s)
    one.run(0.5)
    assert one.window_timeline.known_until_s is None
    assert one.player.engine.surface.angle_map.is_linear
    one.player.release()
    one.run(0.5)
    assert not one.player.engine.surface.angle_map.is_linear
    heard = one.samples
    one.player.close()
    again = ov.render(str(timeline_path(take)), "football", str(take), RATE, tail="none").samples
    count = min(len(heard), len(again))
    assert np.array_equal(again[:count], heard[:count])


@pytest.mark.parametrize("preset", ["football", "plain", "series"])
def test_no_click_comes_with_an_update(monkeypatch, preset):
    live = ov.LiveTimeline("flat", layout="so far", unit="u")
    live.append(intensity=[(float(n), 0.2) for n in range(0, 1000, 10)])
    heard = []
    for update in (False, True):
        if update:
            live.append(intensity=[(float(n), 0.9) for n in range(0, 1000, 10)])
        one = Session(live, monkeypatch, preset=preset)
        one.player.touch(0.2)
        one.run(1.0)
        before = len(one.samples)
        hand = iter(np.linspace(0.2, 0.6, 60))
        if not update:
            # new while it moves, under the hand: the harshest moment there is
            def change(one=one):
                live.append(intensity=[(float(n), 0.9) for n in range(0, 1000, 10)])
                one.player.active_window.update_timeline(live.padded_snapshot())

        else:
            change = None
        for n in range(40):
            one.player.touch(next(hand))
            if n == 20 and change:
                change()
            one.run(0.02)
        heard.append(one.samples[before:])
        one.player.close()
    high = butter(6, 2000.0, "high", fs=RATE, output="sos")
    at = slice(round(0.4 * RATE), round(0.46 * RATE))
    changed, steady = (np.abs(sosfilt(high, one, axis=0))[at].max(axis=0) for one in heard)
    assert 20.0 * np.log10(max(changed[0] - steady[0], 1e-9)) <= -60.0  # the grain is there anyway
    assert 20.0 * np.log10(max(changed[1], 1e-9)) <= -120.0  # a jump in place of the fade: -115


def test_a_goal_is_under_the_hand_within_a_tenth_of_a_second(session, live):
    one = session()
    one.run(0.3)
    for n in range(20):
        live.append(events=[event(900 + 10 * n, "goal", f"{n}-0")], clock_s=900.0 + 10 * n)
        one.run(0.1)
        # what tells of it is the goal itself, and then it is in the timeline
        kinds = one.window_timeline.kinds()
        assert kinds == {"goal": 1} or kinds["goal"] == n + 1
        one.run(1.5)
        assert one.window_timeline is live.padded_snapshot()


def test_a_new_goal_is_announced_and_a_foul_is_not(session, live):
    one = session()
    one.run(0.2)
    struck = []

    def look():
        struck.extend(found.kind for found, _ in one.player.engine.pop_strike_events())

    live.append(events=[event(900, "foul", "x")], clock_s=900.0)
    one.run(1.5, look)
    assert struck == []
    assert not any("foul" in line for line in one.messages)
    live.append(events=[event(950, "goal", "1-0 Parris")], clock_s=951.0)
    one.run(1.5, look)
    assert struck
    assert set(struck) == {"goal"}
    assert "new: goal 1-0 Parris at 15:50.0" in one.messages
    assert one.window_timeline is live.padded_snapshot()
    assert not one.player.engine.meters.touching
    live.retract(event(950, "goal", "1-0 Parris"))
    one.run(1.5, look)
    assert "retracted: goal 1-0 Parris at 15:50.0" in one.messages
    assert "goal" not in one.window_timeline.kinds()


def pulses_after(one, change):
    """What a finger feels on the way out within the half second after a change of the data, dB."""
    one.run(0.2)
    before = len(one.samples)
    change()
    one.run(1.5)
    level = levels(one.samples[before : before + RATE // 2, 1], RATE, FELT_WINDOW_S, TOUCH_FLOOR_DB)
    found = level[touch_pulses(level)]
    return found[found > -40.0]  # without the rebound at the end of the tap


def test_a_withdrawn_goal_is_felt_three_times_and_a_new_one_once(session, live):
    one = session()
    goal = event(850, "goal", "1-0 Parris")
    new = pulses_after(one, lambda: live.append(events=[goal], clock_s=850.0))
    assert len(new) == 1
    before = one.window_timeline
    withdrawn = pulses_after(one, lambda: live.retract(goal))
    assert len(withdrawn) == 3
    assert withdrawn == pytest.approx(np.full(3, new[0]), abs=6.0)
    assert one.player.live_updates.announced == [goal]
    assert "goal" in before.kinds()
    assert "goal" not in one.window_timeline.kinds()
    assert one.window_timeline is live.padded_snapshot()


def test_a_corrected_scorer_is_no_withdrawn_goal(session, live):
    one = session()
    goal = event(300, "goal", "1-0 Parris")
    live.append(events=[goal], clock_s=850.0)
    one.run(1.0)

    def correct():
        live.retract(goal)
        live.append(events=[event(300, "goal", "1-0 Perry")])

    assert len(pulses_after(one, correct)) == 0
    assert [found.label for found in one.window_timeline.events if found.kind == "goal"] == [
        "1-0 Perry"
    ]


@pytest.mark.parametrize("keywords", [{"announce": "none"}, {"preset": "football-discreet"}])
def test_a_withdrawn_goal_is_not_felt_where_new_ones_are_not(session, live, keywords):
    one = session(**keywords)
    goal = event(850, "goal", "1-0 Parris")
    live.append(events=[goal], clock_s=850.0)
    assert len(pulses_after(one, lambda: live.retract(goal))) == 0
    assert any("retracted: goal" in line for line in one.messages)


@pytest.mark.parametrize(
    ("keywords", "told"),
    [
        ({"preset": "football-discreet"}, []),
        ({"preset": "football-discreet", "announce": "goal"}, ["goal"]),
        ({"announce": "none"}, []),
        ({"announce": "foul"}, ["foul", "goal"]),
    ],
)
def test_the_announced_kinds_can_be_chosen(session, live, keywords, told):
    one = session(**keywords)
    one.run(0.1)
    for new in (event(900, "foul", "x"), event(950, "goal", "y")):
        live.append(events=[new], clock_s=new.time_s)
        one.run(1.5)
    assert [new.kind for new in one.player.live_updates.announced] == told


def test_old_events_are_not_announced(session, live):
    one = session()
    live.append(events=[event(400, "goal", "late")])
    one.run(0.5)
    assert one.player.live_updates.announced == []
    assert "goal" in one.window_timeline.kinds()


def test_a_touch_ends_an_announcement(session, live):
    one = session()
    one.run(0.1)
    live.append(events=[event(900, "goal")], clock_s=900.0)
    one.run(0.06)
    assert one.window_timeline.kinds() == {"goal": 1}
    one.player.touch(0.3)
    one.run(0.04)
    assert one.window_timeline is live.padded_snapshot()
    one.run(1.0)
    assert one.player.engine.active_input == ("touch", pytest.approx(0.3 * math.pi))


def test_a_goal_during_a_touch_is_announced_at_its_release(session, live):
    one = session()
    one.player.touch(0.1)
    one.run(0.2)
    live.append(events=[event(900, "goal", "1-0")], clock_s=900.0)
    one.run(1.0)
    assert "new: goal 1-0 at 15:00.0" in one.messages
    assert one.player.live_updates.announced == []
    one.player.release()
    one.run(0.1)
    assert [new.kind for new in one.player.live_updates.announced] == ["goal"]


def test_layout_and_length_can_change_during_a_session(session, live):
    one = session()
    one.run(0.1)
    assert (one.window_timeline.duration_s, one.window_timeline.known_until_s) == (5700.0, 800.0)
    one.player.queue_command("layout", "so-far")
    one.run(0.2)
    assert (one.window_timeline.duration_s, one.window_timeline.known_until_s) == (824.0, 800.0)
    one.player.queue_command("layout", "whole")
    one.player.queue_command("expected-duration", "2h")
    one.run(0.2)
    assert {"layout so far", "layout whole", "expected duration 2h"} <= set(one.messages)
    assert (one.window_timeline.duration_s, one.window_timeline.known_until_s) == (7200.0, 800.0)
    for words in (("layout", "half"), ("expected-duration", "soon")):
        one.player.queue_command(*words)
    one.run(0.1)
    assert sum("half" in line or "soon" in line for line in one.messages) == 2


def test_the_map_is_a_presets_choice_until_a_person_makes_one(session, live, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(preset_path("football").read_text() + '\n[follow]\nlayout = "so-far"\n')
    one = session()
    one.run(0.1)
    assert one.window_timeline.duration_s == 5700.0
    one.player.use_preset(str(path))
    one.run(0.2)
    assert one.window_timeline.duration_s == 824.0
    one.player.queue_command("layout", "whole")
    one.run(0.2)
    assert one.window_timeline.duration_s == 5700.0
    given = session(layout_is_explicit=True)
    given.player.use_preset(str(path))
    given.run(0.2)
    assert given.window_timeline.duration_s == 5700.0


def test_a_part_that_is_shown_stays_while_the_whole_grows(session, live):
    one = session()
    one.player.show(200.0, 800.0)
    one.run(0.1)
    live.append(events=[event(500, "foul", "late"), event(900, "foul")], clock_s=900.0)
    one.run(0.1)
    assert one.player.window == (200.0, 800.0)
    assert [e.time_s for e in one.window_timeline.events if e.kind == "foul"] == [100.0, 300.0]


def test_a_take_of_a_live_session_is_replayed_as_it_grew_to_the_bit(
    session, live, tmp_path, monkeypatch
):
    take = tmp_path / "take.csv"
    one = session(record=take)
    one.run(0.3)
    one.player.tap(0.13)
    one.run(1.5)
    live.append(events=[event(850, "goal", "1-0")], clock_s=860.0)
    one.run(1.5)
    one.player.show(400.0, 860.0)
    one.player.tap(0.9)
    one.run(2.5)
    live.append(events=[event(900, "foul", "z")], clock_s=900.0)
    one.run(0.5)
    one.player.close()
    beside = ov.load_timeline(timeline_path(take))
    gesture = ov.load_gesture(take)
    assert {"timeline", "pattern", "window"} <= {key for c in gesture.changes for key in c.what}
    rendered = ov.render(beside, "football", gesture, RATE, tail="none").samples
    again = Session(ov.LiveTimeline(), monkeypatch, timeline=beside)
    again.player.loop.begin(gesture, "take")
    for passes in (1, 2):
        again.run(0.02)
        while again.player.loop.passes == passes:
            heard = again.samples
            again.run(0.02)
        assert len(heard) > 6.0 * RATE
        assert np.array_equal(rendered[: len(heard)], heard[: len(rendered)])
        assert np.abs(heard).max() > 0.01
    assert not any("ignored" in line for line in again.messages)
    again.player.close()


def test_a_take_of_a_live_session_is_rendered_again_to_the_bit(session, live, tmp_path):
    take = tmp_path / "take.csv"
    one = session(record=take)
    one.run(0.3)
    one.player.touch(0.15)
    one.run(0.5)
    live.append(events=[event(810, "foul", "c")], clock_s=830.0)
    one.run(0.3)
    one.player.release()
    one.run(0.3)
    live.append(events=[event(850, "goal", "1-0")], intensity=[(0.0, 0.1), (860.0, 0.9)])
    one.run(1.5)
    one.player.show(400.0, 860.0)
    one.player.tap(0.9)
    one.run(2.5)
    live.retract(event(850, "goal", "1-0"))
    live.gap(820.0, 840.0, "no camera")
    one.player.queue_command("layout", "so-far")
    one.run(0.3)
    one.player.show(0.0, one.player.timeline.duration_s)
    one.player.tap(0.7)
    one.run(2.0)
    live.end(900.0)
    one.run(0.5)
    heard = one.samples
    one.player.close()
    assert "bit-identical" in one.player.takes.summaries[0]
    assert str(timeline_path(take)) in one.player.takes.summaries[0]
    again = ov.render(
        str(timeline_path(take)), "football", str(take), sample_rate=RATE, tail="none"
    ).samples
    count = min(len(heard), len(again))
    assert abs(len(heard) - len(again)) <= 400
    assert np.abs(heard).max() > 0.01
    assert np.array_equal(again[:count], heard[:count])


@pytest.mark.parametrize("source", ["touch", "serial"])
@pytest.mark.parametrize("moment", ["before the decision", "while the surface is built"])
@pytest.mark.parametrize("map", ["whole", "so far"])
def test_a_touch_from_another_thread_keeps_its_map_though_no_block_has_read_it(
    session, live, monkeypatch, map, moment, source
):
    """At 300 times the speed a feed changes the timeline at every poll."""
    live.layout = map
    one = session()
    one.run(0.2)
    engine = one.player.engine
    build = engine_module.build_surface

    def touch():
        finger = threading.Thread(target=engine.control, args=(0.3, True, None, source))
        finger.start()
        finger.join()

    def build_late(*arguments):
        surface = build(*arguments)
        touch()
        return surface

    for n in range(6):
        held = engine.surface.angle_map
        live.append(events=[event(820 + 6000 * n, "goal", str(n))], clock_s=821.0 + 6000 * n)
        with monkeypatch.context() as patch:
            if moment == "before the decision":
                touch()
            else:
                patch.setattr(engine_module, "build_surface", build_late)
            one.messages += commands.poll(one.player).messages
        for _ in range(5):
            one.run(0.06)
            assert engine.surface.angle_map is held, f"touch {n}"
        engine.control(0.3, False, None, source)
        one.run(3.0)
        assert one.window_timeline is live.padded_snapshot()
