from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.data.analysis import rhythm
from overview_dsp.data.analysis.rhythm import (
    Beats,
    beat_events,
    heart_rate,
    mean_rate,
    variability,
)


def beats(times: list[float], kinds: list[str] | None = None) -> Beats:
    found = tuple(kinds) if kinds else ("beat",) * len(times)
    return Beats(np.array(times), found, ("",) * len(times), annotated=kinds is not None)


def steady(count: int = 40, interval: float = 0.8) -> list[float]:
    return [1.0 + interval * i for i in range(count)]


def test_a_steady_heart_has_one_rate_and_only_beats() -> None:
    curve = heart_rate(np.array(steady()), ())
    assert curve is not None
    assert curve.unit == "bpm"
    assert curve.value == pytest.approx(np.full(40, 75.0))
    events, notes = beat_events(beats(steady()), ())
    assert [event.kind for event in events] == ["beat"] * 40
    assert notes == ()
    assert mean_rate(np.array(steady()), ()) == pytest.approx(75.0)


def test_the_rate_follows_a_change_within_a_few_beats() -> None:
    times = np.cumsum([1.0] * 20 + [0.5] * 20)
    curve = heart_rate(times, ())
    assert curve is not None
    assert curve.at(np.array([10.0, 28.0])) == pytest.approx([60.0, 120.0])


def test_a_premature_beat_and_its_pause_leave_the_rate_alone() -> None:
    times = np.array(steady())
    times[20] -= 0.3
    curve = heart_rate(times, ())
    assert curve is not None
    assert abs(curve.value[10:16] - 75.0).max() < 1e-9
    assert abs(curve.value - 75.0).max() < 4.0


def test_a_premature_beat_is_detected_by_its_interval_and_weighs_how_early_it_is() -> None:
    times = steady()
    times[20] -= 0.24
    times[30] -= 0.4
    events, _ = beat_events(beats(times), ())
    first, second = (event for event in events if event.kind != "beat")
    assert (first.kind, first.time_s) == ("premature", times[20])
    assert first.weight == pytest.approx(1.0)
    assert second.weight == pytest.approx(0.5 / 0.3)
    assert "30 % early" in first.label


def test_what_was_said_of_a_beat_outranks_its_interval() -> None:
    times = steady()
    times[20] -= 0.24
    events, _ = beat_events(beats(times, ["beat"] * 40), ())
    assert {event.kind for event in events} == {"beat"}
    kinds = ["beat"] * 40
    kinds[20] = "premature_ventricular"
    events, _ = beat_events(beats(times, kinds), ())
    (other,) = (event for event in events if event.kind != "beat")
    assert (other.kind, other.weight) == ("premature_ventricular", pytest.approx(1.0))


def test_a_missed_beat_is_where_it_was_due() -> None:
    times = steady()
    due = times.pop(20)
    events, _ = beat_events(beats(times), ())
    (missed,) = (event for event in events if event.kind != "beat")
    assert missed.kind == "missed_beat"
    assert missed.time_s == pytest.approx(due)
    assert missed.weight == pytest.approx(1.0)
    assert "1.60 s without a beat, 2.0 times" in missed.label


def test_the_pause_after_a_premature_beat_is_no_missed_beat_unless_it_is_longer() -> None:
    times = steady()
    times[20] -= 0.35  # then 1.44 of the usual interval, 1.6 with the next line
    times[21:] = [time + 0.1 for time in times[21:]]
    kinds = [event.kind for event in beat_events(beats(times), ())[0]]
    assert kinds.count("premature") == 1
    assert "missed_beat" not in kinds
    times[21:] = [time + 0.8 for time in times[21:]]
    assert "missed_beat" in [event.kind for event in beat_events(beats(times), ())[0]]


def test_a_slow_change_of_rate_makes_no_event() -> None:
    intervals = np.linspace(1.2, 0.4, 400)
    events, _ = beat_events(beats(list(np.cumsum(intervals))), ())
    assert {event.kind for event in events} == {"beat"}


def test_no_interval_reaches_over_a_gap() -> None:
    times = [time for time in steady(60) if not 20.0 < time < 30.0]
    gaps = ((20.0, 30.0),)
    curve = heart_rate(np.array(times), gaps)
    assert curve is not None
    assert curve.value == pytest.approx(np.full(len(times), 75.0))
    assert {event.kind for event in beat_events(beats(times), gaps)[0]} == {"beat"}
    assert mean_rate(np.array(times), gaps) == pytest.approx(75.0)
    assert "missed_beat" in {event.kind for event in beat_events(beats(times), ())[0]}


def test_variability_is_the_rmssd() -> None:
    random = np.random.default_rng(1)
    times = np.cumsum(0.8 + 0.03 * random.normal(size=400))
    curve = variability(times, ())
    assert curve is not None
    assert curve.unit == "ms"
    middle = 200
    intervals = np.diff(times)[middle - 16 : middle + 15]
    assert curve.value[middle] == pytest.approx(1000 * np.sqrt(np.mean(np.diff(intervals) ** 2)))
    flat = variability(np.array(steady()), ())
    assert flat is not None
    assert flat.value.max() < 1e-3
    assert variability(np.array([1.0, 2.0]), ()) is None


def test_one_beat_has_no_rate() -> None:
    assert heart_rate(np.array([1.0]), ()) is None
    assert mean_rate(np.array([1.0]), ()) is None
    assert [event.kind for event in beat_events(beats([1.0]), ())[0]] == ["beat"]


def test_what_a_timeline_cannot_hold_is_left_out_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rhythm, "MAX_EVENTS", 20)
    times = steady()
    times[20] -= 0.3
    events, notes = beat_events(beats(times), ())
    assert [event.kind for event in events] == ["premature"]
    assert "39 steady beats are left out" in notes[0]
    kinds = ["premature_atrial"] * 40
    events, notes = beat_events(beats(times, kinds), ())
    assert len(events) == 20
    assert "of 40 unsteady beats" in notes[0]
    assert max(event.weight for event in events) > 1.0
