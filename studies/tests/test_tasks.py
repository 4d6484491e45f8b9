"""Each task: lists, simulated answers and measures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from overview_studies.adaptive import Run, quest_table
from overview_studies.analysis import analyse
from overview_studies.observers import Observers, simulate_answers
from overview_studies.report import methods_text, summary
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
    step = {**step, "levels": list(range(20)), "stimuli": ["x"] * 20}
    step["quest"] = quest_table(np.arange(20.0), 0.5)
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


HALVES = "[2.0, 2.8284, 4.0, 5.6569, 8.0, 11.3137, 16.0, 22.6274, 32.0, 45.2548, 64.0]"
ADAPTIVE = [  # task, keys, d', and the steps from the standard (or from nothing) at the threshold
    ("staircase", "standard = 2.0", 0.12, math.sqrt(2.0) * 0.545 / 0.12),
    ("quest", "standard = 2.0\nmax_trials = 60", 0.12, math.sqrt(2.0) * 0.6745 / 0.12),
    ("staircase", 'method = "yesno"', 0.25, (1.0 + 0.545) / 0.25),
    ("quest", 'method = "yesno"\nmax_trials = 60', 0.25, 1.0 / 0.25),
]


@pytest.mark.parametrize(("task", "more", "d", "steps"), ADAPTIVE)
def test_a_threshold_is_that_of_the_observer(tmp_path, task, more, d, steps):
    text = varying(task, f"{more}\nreversals = 12" if task == "staircase" else more)
    text = text.replace("[2.0, 4.0, 8.0, 16.0, 32.0]", HALVES)
    lowest = 2.8284 if "standard" in more else 2.0
    if "yesno" in more:
        text += "catch = 0.2\n"
    found = analysed(tmp_path, text, 40, Observers(d))
    one = found.line("threshold")
    assert one.estimate.participants + len(found.missing) == 40
    assert len(found.missing) <= 8, found.missing
    # two steps double the level; the mean is of the logarithms
    assert one.estimate.mean == pytest.approx(lowest * 2.0 ** ((steps - 1.0) / 2.0), rel=0.25)


@pytest.mark.parametrize(("task", "more", "d", "steps"), ADAPTIVE)
def test_who_feels_the_lowest_level_has_no_threshold(tmp_path, task, more, d, steps):
    text = varying(task, more) + ("catch = 0.2\n" if "yesno" in more else "")
    found = analysed(tmp_path, text, 12, Observers(6.0))
    assert math.isnan(found.line("threshold").estimate.mean)
    assert len(found.missing) >= 10
    reasons = {one.reason for one in found.missing}
    assert all("lowest" in one or "outside" in one or "reversals" in one for one in reasons)
    assert "no estimate" in "\n".join(summary(found))
    assert found.missing[0].participant in methods_text(found)


def test_a_group_at_the_lowest_level_has_no_difference_from_another(tmp_path):
    text = varying("staircase", "standard = 2.0\nreversals = 12").replace(
        "[2.0, 4.0, 8.0, 16.0, 32.0]", HALVES
    )
    text += '[factors]\nmapping = { between = ["friction", "static"] }\n'
    weak = Observers(0.35, effects={("mapping", "static"): -0.23})
    found = analysed(tmp_path, text, 80, weak)
    assert 10 < len(found.missing) < 40  # those who have a threshold with friction felt less
    assert math.isnan(found.line("threshold", mapping="friction").estimate.mean)
    assert math.isfinite(found.line("threshold", mapping="static").estimate.mean)
    (difference,) = [one for one in found.differences if one.measure == "threshold"]
    assert math.isnan(difference.estimate.mean)
    assert "no estimate" in methods_text(found)


@pytest.mark.parametrize(("standard", "levels"), [
    (8.0, "[2.0, 4.0, 8.0, 16.0, 32.0]"), (10.0, "[2.5, 5.0, 10.0, 20.0, 40.0, 80.0]"),
    (20.0, "[10.0, 15.0, 20.0, 25.0, 30.0]"),
])  # fmt: skip
def test_the_point_of_equality_is_the_standard_on_any_scale(tmp_path, standard, levels):
    text = varying("compare", f"standard = {standard}")
    text = text.replace("[2.0, 4.0, 8.0, 16.0, 32.0]", levels).replace("repeats = 4", "repeats = 8")
    study, lists = study_of(tmp_path, text)
    held = 0
    for run in range(10):
        found = analyse(simulate_answers(study, lists, Observers(1.2), 24, run))
        one = found.line("pse").estimate
        held += one.low <= standard <= one.high
    assert held >= 8  # of 10; 7 or fewer come once in 80
    study, lists = study_of(tmp_path, text.replace("repeats = 8", "repeats = 60"))
    found = analyse(simulate_answers(study, lists, Observers(1.2), 8, 0))
    jnd = found.line("jnd").estimate.mean
    steps = 0.6745 * math.sqrt(2.0) / 1.2
    expected = 2.0**steps if standard != 20.0 else 5.0 * steps
    assert jnd == pytest.approx(expected, rel=0.1)
    assert found.line("jnd").unit == ("ratio of levels" if standard != 20.0 else
                                      "of the varied dimension")  # fmt: skip


def test_a_list_of_an_earlier_version_counts_the_levels(tmp_path):
    """QUEST+ tables were made of the indices of levels, whatever their distances."""
    from overview_studies.measures import run_threshold
    from overview_studies.scales import scale_of

    text = varying("quest", "standard = 2.0\nmax_trials = 60").replace(
        "[2.0, 4.0, 8.0, 16.0, 32.0]", "[2.0, 3.0, 4.0, 20.0, 21.0]"
    )
    study, lists = study_of(tmp_path, text)
    step = next(one for one in lists[1]["steps"] if one["type"] == "adaptive")
    old = {**step, "quest": quest_table(np.arange(4.0), 0.5)}
    found = {}
    for name, one in (("new", step), ("old", old)):
        run, responses = Run(one), {}
        while not run.over:
            right = run.level >= 2
            side = one["sides"][run.trial]
            responses[f"{one['id']}-{run.trial + 1:03d}"] = {
                "response": side if right else 1 - side
            }
            run.record(right)
        found[name] = run_threshold(scale_of(study), one, responses)
        steps = scale_of(study).steps(one["levels"]) if name == "new" else np.arange(4.0)
        assert found[name] == pytest.approx(np.interp(run.posterior_mean, steps, one["levels"]))
    assert found["new"] != found["old"]


def test_the_scale_is_that_of_the_parameter_or_of_the_levels():
    from overview_studies.scales import Scale, scale_kind

    assert scale_kind("tactor.frequency_hz", [100.0, 200.0, 250.0]) == "log"
    assert scale_kind("tactor.gain_db", [-6.0, 0.0, 6.0]) == "dB"
    assert scale_kind("kinds.goal.height", [2.0, 3.0, 4.0]) == "linear"
    assert scale_kind("kinds.goal.height", [2.0, 4.0, 8.0]) == "log"
    assert scale_kind("kinds.goal.height", [2.0, 4.0, 8.0], "linear") == "linear"
    assert scale_kind("timeline", ["a", "b"]) == "index"
    scale = Scale("log", [2.0, 4.0, 16.0])
    assert scale.steps([4.0, 16.0]).tolist() == pytest.approx([0.0, 4.0 / 3.0])
    assert scale.level(scale.position(4.0)) == pytest.approx(4.0)
