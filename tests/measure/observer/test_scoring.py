"""Truth and score on strokes made by hand."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.measure.observer.scoring import Tally, groups_of
from overview_dsp.measure.observer.strokes import PassedEvents, passed_events, rows_of_onsets

GOAL, CARD, FOUL, NOTHING = range(4)
KINDS = ("goal", "yellow_card", "foul")


def events(*rows):
    """(kind, enters ms, leaves ms, strength)."""
    kind, enters, leaves, strength = (np.array(column) for column in zip(*rows, strict=True))
    return PassedEvents(kind, enters.astype(float), leaves.astype(float), strength.astype(float))


def counted(at, said, rows, owner=None):
    there = events(*rows)
    tally = Tally(KINDS, np.arange(4))
    owner = rows_of_onsets(np.array(at), there) if owner is None else np.array(owner)
    tally.add(np.array(at), np.array(said), owner, there.kind)
    return tally.scores(1)


def test_an_onset_belongs_to_the_event_it_falls_on_a_little_before_and_after_too():
    there = events((GOAL, 100.0, 120.0, 1.0))
    at = np.array([84, 85, 110, 160, 161])
    assert rows_of_onsets(at, there).tolist() == [-1, 0, 0, 0, -1]
    assert rows_of_onsets(at, events((GOAL, 1e6, 1e6, 1.0))).tolist() == [-1] * 5


def test_of_several_events_the_one_with_the_strongest_profile_has_the_onset():
    there = events((FOUL, 90.0, 130.0, 1.0), (GOAL, 100.0, 104.0, 90.0), (CARD, 99.0, 130.0, 9.0))
    assert rows_of_onsets(np.array([110]), there).tolist() == [1]


def test_no_onset_has_an_event_without_events():
    none = PassedEvents(np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0))
    assert rows_of_onsets(np.array([5, 9]), none).tolist() == [-1, -1]


def test_a_fouls_strength_is_its_own_even_on_top_of_a_goal(football):
    at = 1000.0
    both = ov.Timeline("", 5400.0, (ov.Event(at, "goal"), ov.Event(at + 0.5, "foul")))
    alone = ov.Timeline("", 5400.0, (ov.Event(at + 0.5, "foul"),))
    found = []
    for timeline in (both, alone):
        surface = ov.build_surface(timeline, football)
        there = passed_events(surface, np.linspace(0.0, 1.0, 50_000), 16_000)
        names = [surface.kind_names[kind] for kind in there.kind]
        found.append(dict(zip(names, there.strength, strict=True)))
    assert found[0]["foul"] == found[1]["foul"]
    assert found[0]["goal"] > 5.0 * found[0]["foul"]


def test_an_event_has_a_row_for_each_time_that_the_disk_passes_it(football):
    timeline = ov.Timeline("", 100.0, (ov.Event(50.0, "goal"),))
    surface = ov.build_surface(timeline, football)
    corners = np.array([0.0, 1.0, 2.0, 4.0])  # s; so fine that no step leaps over a goal
    places = np.interp(np.arange(400_000) / 1e5, corners, [0.0, 0.7, 0.3, 1.0])
    there = passed_events(surface, places, 1e5)
    assert len(there) == 3
    assert (there.leaves_ms - there.enters_ms < 20.0).all()
    middle = (there.enters_ms + there.leaves_ms) / 2.0
    assert middle == pytest.approx([5000 / 7, 1500.0, 2000.0 + 4000 / 7], abs=12.0)


def test_a_disk_that_trembles_does_not_turn_back(football):
    timeline = ov.Timeline("", 100.0, (ov.Event(50.0, "goal"),))
    surface = ov.build_surface(timeline, football)
    steady = np.linspace(0.0, 1.0, 8000)
    trembling = steady + 0.004 * np.sin(np.arange(8000) / 50.0)
    assert len(passed_events(surface, trembling, 1000.0)) == 1


def test_an_event_that_the_finger_passes_and_the_disk_does_not_is_missed(football):
    timeline = ov.Timeline("", 100.0, tuple(ov.Event(t, "goal") for t in (20.0, 60.0, 90.0)))
    surface = ov.build_surface(timeline, football)
    course = np.linspace(0.0, 0.5, 8000)
    assert len(passed_events(surface, course, 1000.0)) == 1
    there = passed_events(surface, course, 1000.0, 0.8)
    assert np.isfinite(there.enters_ms).tolist() == [True, False]
    # no onset belongs to it
    assert (rows_of_onsets(np.arange(0, 8000, 50), there) <= 0).all()


def test_recall_counts_events_and_precision_counts_reports():
    scores = counted(
        [100, 300, 500, 900],
        [GOAL, GOAL, FOUL, GOAL],
        [(GOAL, 95, 105, 9.0), (CARD, 295, 305, 5.0), (FOUL, 495, 505, 1.0), (FOUL, 700, 710, 1.0)],
    )
    assert scores.recall.tolist() == [1.0, 0.0, 0.5]
    assert scores.precision[GOAL] == pytest.approx(1 / 3)
    assert np.isnan(scores.precision[CARD])
    assert scores.precision[FOUL] == 1.0
    assert scores.f1.tolist() == pytest.approx([0.5, 0.0, 2 / 3])
    assert scores.balanced == pytest.approx(0.5)
    assert scores.confusion.tolist() == [[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 1], [1, 0, 0, 0]]


def test_an_event_with_several_onsets_is_recognised_if_one_is():
    rows = [(GOAL, 100, 200, 9.0)]
    assert counted([110, 150], [CARD, GOAL], rows).recall[GOAL] == 1.0
    wrong = counted([110, 150], [NOTHING, CARD], rows)
    assert wrong.confusion[GOAL].tolist() == [0, 1, 0, 0]


def test_reports_of_one_event_within_120_ms_are_one_and_others_are_not():
    rows = [(GOAL, 100, 400, 9.0)]
    assert counted([110, 200, 229], [GOAL] * 3, rows).reports[GOAL] == 1
    assert counted([110, 231], [GOAL] * 2, rows).reports[GOAL] == 2
    assert counted([110, 150], [GOAL] * 2, rows, owner=[0, -1]).reports[GOAL] == 2


def test_an_onset_answered_with_nothing_is_not_a_report():
    scores = counted([100, 600], [NOTHING, NOTHING], [(FOUL, 95, 105, 1.0)])
    assert scores.reports.sum() == 0
    assert scores.confusion[FOUL].tolist() == [0, 0, 0, 1]


def test_a_group_counts_what_any_of_its_kinds_was_taken_for():
    tally = Tally(("goal", "rest"), np.array([0, 0, 1, 2]))
    tally.add(np.array([100]), np.array([1]), np.array([0]), np.array([0]))
    assert tally.scores(1).recall[0] == 1.0


def test_kinds_of_football_form_groups_and_other_kinds_stay_single():
    groups = groups_of(("default", "goal", "own_goal", "red_card", "yellow_card", "foul"))
    assert groups == ("minor", "goal", "goal", "card", "card", "minor")
    assert groups_of(("strong", "light")) == ("strong", "light")


def test_plain_data_has_the_kinds_that_were_met_or_named():
    scores = counted([100], [GOAL], [(GOAL, 95, 105, 9.0)])
    assert scores.to_json() == {
        "balanced": 1.0,
        "kinds": {"goal": {"events": 1, "recall": 1.0, "precision": 1.0, "f1": 1.0}},
        "draws": 1,
        "confusion": [[1, 0], [0, 0]],
    }
