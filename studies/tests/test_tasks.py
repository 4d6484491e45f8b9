"""Each task: lists, simulated answers and measures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from overview_studies.adaptive import Run
from overview_studies.analysis import analyse
from overview_studies.observers import Observers, simulate_answers
from studies.tests.files import IDENTIFY, lists_of, other, study_of, varying


def analysed(folder, text, people=12, observers=None):
    study, lists = study_of(folder, text)
    return analyse(simulate_answers(study, lists, observers or Observers(), people, 1))


def test_identify_gives_a_matrix_and_sensitivity_in_each_condition(tmp_path):
    keen = Observers(3.0, effects={("mapping", "static"): -2.0})
    found = analysed(tmp_path, IDENTIFY, 12, keen)
    assert len(found.matrices) == 4
    for matrix in found.matrices.values():
        assert matrix.shape == (3, 3)
    friction = found.line("d_prime", mapping="friction", input="touch").estimate
    static = found.line("d_prime", mapping="static", input="touch").estimate
    assert friction.mean > static.mean + 0.5
    changes = {line.condition: line.estimate for line in found.differences
               if line.measure == "d_prime"}  # fmt: skip
    assert changes[(("mapping", "static - friction"),)].high < 0.0
    assert found.line("information", mapping="friction", input="touch").estimate.mean > 0.5
    assert found.line("tlx", mapping="friction", input="touch").estimate.participants == 6


def test_locate_measures_the_distance_to_the_nearest_event(tmp_path):
    text = other("locate", "catch = 0.4")
    found = analysed(tmp_path, text, 12, Observers(2.0))
    # a tenth, divided by d', off: the mean of a half normal; nearer where there are several
    assert 0.02 < found.line("location_error").estimate.mean < 0.05
    assert abs(found.line("location_bias").estimate.mean) < 0.02
    assert 0.0 <= found.line("false_alarms").estimate.mean < 0.5


def test_count_and_draw_and_adjust_are_measured(tmp_path):
    counted = analysed(tmp_path, other("count"), 8, Observers(20.0 / 2))
    assert counted.line("exact").estimate.mean > 0.95
    shapes = 'made = { curves = ["rise", "fall", "peak", "dip", "wave"], variants = 2 }'
    drawn = analysed(tmp_path, other("draw", stimuli=shapes), 8, Observers(3.0))
    assert 0.8 < drawn.line("likeness").estimate.mean < 1.0
    assert 0.05 < drawn.line("drawn_error").estimate.mean < 0.15
    adjusted = analysed(tmp_path, varying("adjust"), 12, Observers(3.0))
    one = adjusted.line("adjusted").estimate
    assert one.low < 0.0 + 1.5
    assert abs(one.mean) < 3.0


def test_compare_has_each_pair_in_both_orders_and_finds_the_standard(tmp_path):
    lists = lists_of(tmp_path, varying("compare"))
    trials = [s for s in lists[0]["steps"] if s["type"] == "trial"]
    assert len(trials) == 16
    # each comparison as often first as second
    assert sum(s["correct"] for s in trials) == 8
    found = analysed(tmp_path, varying("compare"), 24, Observers(1.5))
    assert abs(found.line("pse").estimate.mean - 8.0) < 3.0
    assert found.line("accuracy").estimate.mean > 0.8


def adaptive_step(folder, task, more):
    lists = lists_of(folder, varying(task, more))
    return next(step for step in lists[0]["steps"] if step["type"] == "adaptive")


def test_a_staircase_goes_to_where_seven_in_ten_are_right(tmp_path):
    step = adaptive_step(tmp_path, "staircase", "standard = 2.0\nmax_trials = 400\nreversals = 50")
    step = {**step, "levels": list(range(40)), "stimuli": ["x"] * 40}
    step["tracks"] = [{**t, "start": 30, "steps": [4, 2, 1]} for t in step["tracks"]]
    rng = np.random.default_rng(3)
    at = []
    run = Run(step)
    while not run.over:
        level = run.level
        at.append(level)
        chance = 0.5 + 0.5 / (1.0 + math.exp(-(level - 20) / 2.0))
        run.record(rng.random() < chance)
    # 70.7 %: 20 + 2*log(p/(1-p)) of the part above a half, 0.414
    assert abs(np.mean(at[100:]) - 19.3) < 1.2
    assert run.reversals == 100


def test_two_tracks_take_turns_and_end_each_by_itself(tmp_path):
    step = adaptive_step(tmp_path, "staircase", "standard = 2.0\nmax_trials = 60\nreversals = 2")
    run, seen = Run(step), []
    while not run.over:
        seen.append(run.level)
        run.record(len(seen) % 4 < 2)
    assert seen[0] == 3
    assert seen[1] == 1
    assert len(seen) < 60


def test_quest_plus_finds_a_threshold_and_a_reload_goes_on_where_it_was(tmp_path):
    step = adaptive_step(tmp_path, "quest", "standard = 2.0\nmax_trials = 120")
    from overview_studies.adaptive import quest_table

    step = {**step, "levels": list(range(20)), "stimuli": ["x"] * 20}
    step["quest"] = quest_table(20, 0.5)
    step["catch"], step["sides"], step["most"] = [False] * 120, [0] * 120, 120
    rng = np.random.default_rng(1)
    run, answers = Run(step), []
    while not run.over:
        chance = 0.5 + 0.48 / (1.0 + math.exp(-1.7 * (run.level - 12.0)))
        answers.append(bool(rng.random() < chance))
        run.record(answers[-1])
    assert abs(run.posterior_mean - 12.0) < 1.0
    again = Run(step)
    for answer in answers[:60]:
        again.record(answer)
    third = Run(step)
    for answer in answers[:60]:
        third.record(answer)
    assert again.level == third.level


@pytest.mark.parametrize(
    ("task", "more"),
    [
        ("staircase", 'standard = 2.0'),
        ("quest", 'standard = 2.0\nmax_trials = 25'),
        ("staircase", 'method = "yesno"'),
        ("quest", 'method = "yesno"\nmax_trials = 25'),
    ],
)  # fmt: skip
def test_adaptive_runs_give_thresholds(tmp_path, task, more):
    text = varying(task, more)
    if "yesno" in more:
        text += "catch = 0.2\n"
    found = analysed(tmp_path, text, 6, Observers(1.0))
    one = found.line("threshold").estimate
    assert one.participants == 6
    assert 2.0 <= one.mean <= 32.0
