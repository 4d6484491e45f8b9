"""Guard of a feed's times: wrong clocks wait, and the end equals the reader's timeline."""

from __future__ import annotations

import itertools
import random
from typing import Any

import pytest

import overview_dsp as ov
from overview_dsp.data.feeds import clock_guard
from overview_dsp.data.feeds.clock_guard import ClockGuard
from overview_dsp.data.feeds.feed_lines import encode_line
from overview_dsp.errors import InputError
from tests.data.feeds.feeds import lines_of, matches

HEADER = {"overview_feed": 1, "expected_duration_s": 5700.0}


def guarded(*lines: dict[str, Any]) -> tuple[ov.LiveTimeline, ClockGuard]:
    live = ov.LiveTimeline()
    guard = ClockGuard(live)
    for line in lines:
        guard.apply(encode_line(line))
    return live, guard


def clocks(*times: float) -> list[dict[str, Any]]:
    return [{"clock": time} for time in times]


def goal(time_s: float, label: str = "", **more: Any) -> dict[str, Any]:
    return {"event": {"time_s": time_s, "kind": "goal", "label": label}, **more}


def test_one_wrong_clock_does_not_make_a_match_longer_and_is_reported():
    live, guard = guarded(HEADER, *clocks(30, 60, 1_717_000_000, 1_717_000_000, 90, 120))
    assert live.duration_s == 5700.0
    assert live.now_s == 120.0
    (report,) = guard.take_reports()
    assert "held back" in report
    assert "confirm" in report


@pytest.mark.parametrize("lines", [clocks(2400, 2430), [goal(2400), {"clock": 2430}]])
def test_a_real_jump_is_applied_with_its_second_line(lines):
    live, guard = guarded(HEADER, *clocks(30, 60, 90), lines[0])
    assert live.now_s == 90.0
    guard.apply(encode_line(lines[1]))
    assert live.now_s == 2430.0
    assert not guard.held


def test_a_wrong_clock_between_right_ones_is_never_confirmed_by_a_second_wrong_one():
    live, _ = guarded(HEADER, *clocks(30, 60, 90, 500_000, 120, 500_030, 150))
    assert live.now_s == 150.0


def test_samples_a_day_apart_are_followed_from_the_third_on():
    live, _ = guarded({"overview_feed": 1}, *({"sample": [day * 86_400, 1.0]} for day in range(3)))
    assert live.now_s == 2 * 86_400.0
    guard_line = {"sample": [[day * 86_400, 1.0] for day in range(300)]}
    assert guarded(guard_line)[0].now_s == 299 * 86_400.0


def test_goals_hours_apart_are_applied_at_once_without_a_clock():
    live, _ = guarded(goal(60), goal(9_000), goal(1_700_000_000))
    assert live.now_s == 9_000.0


def test_the_end_a_correction_and_a_retraction_win_over_a_wrong_time():
    far = 90_000_000
    live, guard = guarded(
        HEADER, *clocks(30, 60, 90), goal(far, "a", id="1"), goal(far, "b", id=2),
        goal(far + 9e6, "c"), goal(45, "a", id="1"), {"retract": "2"}, {"clock": 640}, {"end": 100},
    )  # fmt: skip
    assert [event.time_s for event in live.snapshot().events] == [45.0]
    assert live.snapshot().duration_s == 100.0
    assert not live.snapshot().gaps
    assert [one.document["event"]["label"] for one in guard.dropped] == ["c"]
    assert "dropped" in guard.take_reports()[-1]


def test_an_invalid_line_with_a_far_time_is_an_error_at_once():
    _, guard = guarded(HEADER, *clocks(30, 60))
    for line in ({"clock": 10**400}, {"event": {"time_s": 9e8}}, {"gap": [9e8, 1]}):
        with pytest.raises(InputError):
            guard.apply(encode_line(line))
    assert not guard.held


def test_held_lines_are_bounded(monkeypatch):
    monkeypatch.setattr(clock_guard, "MAX_HELD", 20)
    _, guard = guarded(HEADER, *clocks(30, 60, 90, *(1e6 * 1.1**n for n in range(60))))
    assert len(guard.held) == 20
    assert len(guard.dropped) == 20


def with_faults(lines: list[dict[str, Any]], count: int, seed: int) -> list[str]:
    """Return a feed's lines with random faults: clocks, order, duplicates, corrections, cuts."""
    rng = random.Random(seed)
    ids = itertools.count()
    *body, end = [
        {**line, "id": f"e{next(ids)}"} if "event" in line else dict(line) for line in lines
    ]
    texts = [(encode_line(line), line) for line in body]
    for _ in range(count):
        place = rng.randrange(1, len(texts))
        text, line = texts[place]
        fault = rng.choice(("clock", "event", "order", "duplicate", "correction", "cut"))
        far = rng.choice((rng.uniform(2e4, 1e6), rng.uniform(1e6, 3e9)))
        if fault == "clock":
            texts.insert(place, (encode_line({"clock": rng.choice((far, -far))}), {}))
        elif fault == "event":
            texts.insert(place, (encode_line(goal(far, "wrong")), {}))
        elif fault == "order" and place > 1:
            texts[place - 1], texts[place] = texts[place], texts[place - 1]
        elif fault == "duplicate":
            texts.insert(rng.randrange(place, len(texts)), (text, {}))
        elif fault == "correction" and "event" in line:
            event = {**line["event"], "label": "a wrong scorer"}
            event["time_s"] = rng.choice((far, event["time_s"]))
            texts.insert(place, (encode_line({"event": event, "id": line["id"]}), {}))
        elif fault == "cut":
            texts.insert(place, (text[: rng.randrange(1, max(len(text) - 2, 2))], {}))
    return [text for text, _ in texts] + [encode_line(end)]


def check_faults(timeline: ov.Timeline, count: int, seed: int) -> None:
    live = ov.LiveTimeline()
    guard = ClockGuard(live)
    for text in with_faults(lines_of(timeline), count, seed):
        try:
            guard.apply(text)
        except InputError:
            continue
    got = live.snapshot()
    # events at equal times keep their order of arrival
    key = lambda event: (event.time_s, event.kind, event.label)  # noqa: E731
    assert sorted(got.events, key=key) == sorted(timeline.events, key=key), seed
    assert (got.duration_s, got.gaps) == (timeline.duration_s, timeline.gaps), seed
    assert not guard.held
    assert all(one.time_s > timeline.duration_s for one in guard.dropped)
    assert len(guard.dropped) <= count


@pytest.mark.parametrize("seed", range(20))
def test_a_feed_with_random_faults_equals_the_match_in_the_end(match, seed):
    check_faults(match, 25, seed)


@pytest.mark.soak
def test_ten_thousand_random_faults_on_the_shared_matches(data_folder):
    for number, timeline in enumerate(matches(data_folder)):
        for seed in range(20):
            check_faults(timeline, 100, 1000 * number + seed)
