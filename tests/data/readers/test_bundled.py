from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.data.analysis.crowd_excitement import FOOTBALL_KINDS
from overview_dsp.data.readers import bundled_timeline, load_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.world_cup_final import final


@pytest.fixture(scope="module")
def bundled() -> Timeline:
    return bundled_timeline()


def test_the_bundled_file_is_what_the_facts_and_the_formula_give(bundled: Timeline) -> None:
    expected = final()
    for name in ("title", "duration_s", "events", "details", "gaps", "provenance", "notes"):
        assert getattr(bundled, name) == getattr(expected, name), name
    assert bundled.intensity is not None
    assert expected.intensity is not None
    assert bundled.intensity.unit == expected.intensity.unit
    assert np.array_equal(bundled.intensity.time_s, expected.intensity.time_s)
    # rounded to 4 decimals; exp differs between machines in its last bit
    np.testing.assert_allclose(bundled.intensity.value, expected.intensity.value, atol=1.01e-4)


def test_the_goals_are_those_of_the_final(bundled: Timeline) -> None:
    goals = [event for event in bundled.events if event.kind in ("goal", "own_goal")]
    scores = [event.label.split()[0] for event in goals]
    assert scores == ["1-0", "1-1", "2-1", "3-1", "4-1", "4-2"]
    first_half = 48 * 60
    clock = [t / 60 if t < first_half else (t - first_half) / 60 + 45 for t in _times(goals)]
    assert [int(minute) + 1 for minute in clock] == [18, 28, 38, 59, 65, 69]
    assert [event.kind for event in goals] == ["own_goal"] + ["goal"] * 5


def test_the_demo_has_something_of_most_kinds(bundled: Timeline) -> None:
    kinds = bundled.kinds()
    assert set(kinds) == FOOTBALL_KINDS - {"red_card"}
    assert kinds["yellow_card"] == 3
    assert 15 <= kinds["foul"] <= 20
    assert 3 <= kinds["near_miss"] <= 6
    assert [e.label for e in bundled.events if e.kind == "period"] == [
        "kick-off",
        "half-time",
        "full time",
    ]


def test_what_is_made_up_says_so_and_what_is_a_fact_does_not(bundled: Timeline) -> None:
    for event in bundled.events:
        assert ("(synthetic)" in event.label) == (event.kind in ("foul", "near_miss")), event
    assert "synthetic" in bundled.provenance
    assert "public facts" in bundled.provenance
    assert any("made up" in note for note in bundled.notes)
    assert {event.kind for event in bundled.details} == {"touch"}
    assert any("touches" in note and "made up" in note for note in bundled.notes)
    assert bundled.intensity is not None
    assert "synthetic" in bundled.intensity.unit


def test_no_made_up_event_is_near_a_goal(bundled: Timeline) -> None:
    goals = np.array(_times(e for e in bundled.events if "goal" in e.kind))
    made_up = np.array(_times(e for e in bundled.events if "synthetic" in e.label))
    assert np.abs(made_up[:, None] - goals).min() >= 45.0


def test_at_least_half_of_the_timeline_is_free_of_events(bundled: Timeline) -> None:
    at = np.arange(0.0, bundled.duration_s)
    near = np.abs(at[:, None] - np.array(_times(bundled.events))).min(axis=1) <= 40.0
    assert near.mean() <= 0.5


def test_the_bundled_match_is_loaded_by_its_name(bundled: Timeline) -> None:
    assert load_timeline("world-cup-final-2018") == bundled
    with pytest.raises(InputError, match="there is world-cup-final-2018"):
        bundled_timeline("world-cup-final-1930")
    with pytest.raises(InputError, match="duration_s does not apply"):
        load_timeline("world-cup-final-2018", duration_s=10.0)


def _times(events: object) -> list[float]:
    return [event.time_s for event in events]  # type: ignore[attr-defined]
