"""Each task: lists, simulated answers and measures."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.special import ndtr

from overview_studies.adaptive import Run, quest_table
from overview_studies.analysis import analyse
from overview_studies.observers import Observers, _run, simulate_answers
from overview_studies.report import methods_text, summary
from overview_studies.scales import scale_of
from overview_studies.scoring import search_path
from overview_studies.thresholds import run_threshold
from studies.tests.files import IDENTIFY, lists_of, other, study_of, varying
from studies.tests.test_examples import EXAMPLES
from studies.tests.test_simulated_studies import drafted, steps_at_threshold


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


def take_of(*positions):
    """A touch that moves on by each of these positions, one a second."""
    events = [[48_000 * i, math.pi * at, 1, "touch"] for i, at in enumerate(positions)]
    return {"sample_rate": 48_000, "events": [*events, [48_000 * len(positions), 0.0, 0, "touch"]]}


def test_the_movement_of_a_search_has_a_time_a_path_and_returns():
    def measured(*positions):
        return search_path(take_of(*positions), 0.5, 0.05)

    # past it, to the end and back to it
    assert measured(0.0, 0.4, 0.6, 1.0, 0.5) == pytest.approx(
        {"time_s": 4.0, "path": 1.5, "returns": 1.0}
    )
    assert measured(0.0, 0.5)["returns"] == 0.0
    assert measured(0.5, 0.9, 0.5, 0.1, 0.5)["returns"] == 2.0
    # staying at it is one visit
    assert measured(0.0, 0.47, 0.5, 0.53)["returns"] == 0.0
    assert search_path(None, 0.5, 0.05) == {}


def test_search_has_hits_time_path_and_returns_by_touch_and_by_sight(tmp_path):
    text = (
        other("search", stimuli='made = { kinds = ["goal"], variants = 4 }').replace(
            "sweep:0.5", "free"
        )
        + '[factors]\nchannel = { within = ["both", "visual", "all"], order = "williams" }\n'
    )
    text += '[text.conditions]\n"channel.both" = "a"\n"channel.visual" = "b"\n"channel.all" = "c"\n'
    effects = {("channel", "visual"): 2.0, ("channel", "all"): 3.0}
    found = analysed(tmp_path, text.replace('"search"', '"search"\ntarget = "goal"'), 18,
                     Observers(1.0, effects=effects))  # fmt: skip
    for name in ("hits", "time", "path", "returns", "rt"):
        touch, both = (found.line(name, channel=one).estimate for one in ("both", "all"))
        assert math.isfinite(touch.mean)
        if name in ("time", "path", "returns"):
            assert touch.mean > both.mean
    assert found.line("hits", channel="all").estimate.mean > 0.8
    _, lists = study_of(tmp_path, text)
    output = {step["factors"]["channel"]: step["output"] for step in lists[1]["steps"]
              if step["type"] == "trial"}  # fmt: skip
    assert not output["both"]["visual"]
    assert output["visual"]["tactor_db"] is None
    assert output["all"]["visual"]
    assert output["all"]["tactor_db"] == 0.0


BAD_ROWS = [
    ({"response": "here"}, "response is 'here'; must be a place"),
    ({"response": [0.2]}, "must be a place"),
    ({"take": {"events": [[0, 1.0, 1]]}}, "take must have a sample_rate"),
    ({"take": {"sample_rate": 48_000, "events": [[0, "x", 1]]}}, "take must have"),
    ({"take": "none"}, "take must have"),
    ({"takes": 3}, "take must have"),
]


@pytest.mark.parametrize(("bad", "reason"), BAD_ROWS)
def test_a_bad_row_of_a_search_excludes_one_participant_with_one_line(tmp_path, bad, reason):
    from overview_studies.tables import responses_csv

    text = (
        other("search", stimuli='made = { kinds = ["goal"], variants = 2 }')
        .replace("sweep:0.5", "free")
        .replace('"search"', '"search"\ntarget = "goal"')
    )
    study, lists = study_of(tmp_path, text)
    answers = simulate_answers(study, lists, Observers(), 2, 1)
    trial, received, row = answers.sessions[0].trials[0]
    answers.sessions[0].trials[0] = (trial, received, {**row, **bad})
    assert responses_csv(answers).count("\n") == 1 + 2 * 4
    found = analyse(answers)
    assert list(found.excluded) == ["sim001"]
    assert found.excluded["sim001"].startswith(f"impossible answer {trial}: ")
    assert reason in found.excluded["sim001"]
    assert "\n" not in found.excluded["sim001"]


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


def test_adjustments_at_the_end_of_the_levels_are_named_and_not_averaged(tmp_path):
    text = (EXAMPLES / "adjust" / "study.toml").read_text()
    between, at_end = (
        analysed(tmp_path, text.replace("standard = -9.0", f"standard = {one}"), 12, Observers(1.0))
        for one in (-9.0, -15.0)
    )
    assert not between.missing
    assert math.isfinite(between.line("adjusted", input="touch").estimate.mean)
    assert math.isnan(at_end.line("adjusted", input="touch").estimate.mean)
    assert all(re.fullmatch(r"\d of 8 answers are at the lowest level", one.reason)
               for one in at_end.missing)  # fmt: skip


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


def test_a_threshold_of_a_staircase_allows_for_a_d_prime_that_is_not_proportional():
    """The observers' d' grows with the distance to the power of 1.5, not 1 as the prior expects."""
    name, d = "staircase", 0.22
    study, lists = drafted(name)
    truth = steps_at_threshold(study, d)
    steps = [one for each in lists.values() for one in each["steps"] if one["type"] == "adaptive"]

    class Bent:
        def steps(self, levels):
            return truth * (np.arange(1.0, len(levels) + 1.0) / truth) ** 1.5 - 1.0

    rng = np.random.default_rng(0)
    found = []
    for i in range(240):
        step = steps[i % len(steps)]
        rows = dict(_run(Bent(), step, d, 0.0, rng))
        found.append(run_threshold(scale_of(study), step, rows, -18.0))
    known = [2.0 * (one + 18.0) for one in found if not isinstance(one, str)]
    assert len(known) >= 228
    # 16 % too small if d' were proportional
    assert np.mean(known) == pytest.approx(truth, rel=0.13)


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


def text_of_methods(folder, text):
    return methods_text(analysed(folder, text, 2, Observers(1.0)))


def test_the_methods_say_how_a_threshold_was_found(tmp_path):
    stairs = text_of_methods(tmp_path, varying("staircase", "standard = 2.0\ndown = 3"))
    for part in ("2 interleaved staircases", "3 correct answers in a row", "79.4% correct",
                 "steps of 2, 1 levels", "8 reversals each", "at most 60 trials a run",
                 "the logarithm of the level with the share of correct answers",
                 "a power of the distance from the standard", "a lapse rate of 1%",
                 "fewer than 6 reversals", "two intervals"):  # fmt: skip
        assert part in stairs, part
    quest = text_of_methods(
        tmp_path, varying("quest", 'method = "yesno"\nmax_trials = 20') + "catch = 0.2\n"
    )
    for part in ("QUEST+ presented", "in 20 trials a run", "posterior mean of the logarithm",
                 "did not change the level"):  # fmt: skip
        assert part in quest, part
    assert "Psychometric functions" not in stairs + quest
    compare = text_of_methods(tmp_path, varying("compare"))
    assert "Psychometric functions" in compare
    assert "staircase" not in compare.lower()
    adjust = text_of_methods(tmp_path, varying("adjust"))
    assert "the logarithm of the level less that of the standard" in adjust


def test_the_methods_name_the_rules_of_exclusion_and_count_trials_of_each_phase(tmp_path):
    text = varying("quest", 'method = "yesno"\nmax_trials = 20') + "catch = 0.2\n"
    study, lists = study_of(tmp_path, text)
    catches = sum(sum(step["catch"]) for step in lists[1]["steps"] if step["type"] == "adaptive")
    found = analyse(simulate_answers(study, {1: lists[1]}, Observers(1.0), 2, 1))
    methods = methods_text(found)
    assert f"{20 - catches} main, {catches} catch" in methods
    assert "an incomplete session. Excluded: no participant." in methods
    strict = text + "[exclude]\nincomplete = false\n"
    assert "an incomplete session" not in text_of_methods(tmp_path, strict)
    asked = IDENTIFY + "[exclude]\nattention = 0.5\n"
    assert "less than 50% of the attention trials correct" in text_of_methods(tmp_path, asked)


def test_the_reason_of_a_missing_threshold_counts_no_catch_trial(tmp_path):
    text = varying("staircase", 'method = "yesno"\nmax_trials = 30') + "catch = 0.3\n"
    found = analysed(tmp_path, text, 8, Observers(6.0))
    reasons = [one.reason for one in found.missing if " trials are at " in one.reason]
    assert reasons
    main = [row for row in found.answers.rows() if row["phase"] == "main"]
    for one in found.missing:
        own = sum(row["participant"] == one.participant for row in main)
        if one.reason in reasons:
            assert f"of {own} trials are at" in one.reason


@pytest.mark.parametrize("task", ["compare", "staircase"])
def test_the_figure_of_levels_has_the_reported_means(tmp_path, task):
    from overview_studies.figures import psychometric_figure

    standard = "standard = 8.0" if task == "compare" else "standard = 2.0\nreversals = 12"
    text = varying(task, standard).replace("[2.0, 4.0, 8.0, 16.0, 32.0]", HALVES) + (
        '[factors]\nmapping = { within = ["friction", "static"] }\n'
    )
    found = analysed(tmp_path, text, 12, Observers(0.6 if task == "compare" else 0.12))
    axes = psychometric_figure(found).axes[0]
    labels = [one.get_text() for one in axes.get_legend().get_texts()]
    measure = "pse" if task == "compare" else "threshold"
    means = [found.line(measure, mapping=one).estimate.mean for one in ("friction", "static")]
    assert any(map(math.isfinite, means))
    for mean, label in zip(means, labels, strict=True):
        assert label.endswith(f" {mean:.3g}" if math.isfinite(mean) else ": no threshold")


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


QUEST = [  # keys, observers, and the position of the threshold or the least part who have none
    ("standard = -18.0", Observers(0.22), math.sqrt(2.0) * 0.6745 / 0.22, 0.0),
    ("standard = -18.0", Observers(0.15), math.sqrt(2.0) * 0.6745 / 0.15, 0.0),
    ("standard = -18.0", Observers(1.0, lapse=1.0), None, 0.95),  # they guess
    ('method = "yesno"', Observers(0.2), 4.0, 0.0),
    ('method = "yesno"', Observers(0.05), None, 0.8),  # they feel what is 7 steps stronger
]


@pytest.mark.parametrize("runs", [3, pytest.param(100, marks=pytest.mark.soak)])
@pytest.mark.parametrize(("more", "observers", "at", "without"), QUEST)
def test_quest_plus_finds_thresholds_and_names_those_who_feel_no_level(
    tmp_path, more, observers, at, without, runs
):
    text = (EXAMPLES / "quest" / "study.toml").read_text().replace("standard = -18.0", more)
    study, lists = study_of(tmp_path, text)
    held, missing = 0, 0
    for run in range(runs):
        found = analyse(simulate_answers(study, lists, observers, 12, run))
        one = found.line("threshold").estimate
        missing += len(found.missing)
        held += at is not None and one.low <= -18.0 + 0.5 * at <= one.high
    print(f"{more}, {observers}: held {held} of {runs}, missing {missing} of {12 * runs}")
    assert without <= missing / (12 * runs) <= (0.05 if at is not None else 1.0)
    if at is not None:
        assert held >= (0.8 * runs if runs > 3 else 2)


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
    weak = Observers(0.95, effects={("mapping", "static"): -0.83})
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


LAPSES = [(0.0, 0.0), (0.0, 0.1), (0.04, 0.04)]  # random answers with friction and with static


@pytest.mark.parametrize("runs", [6, pytest.param(100, marks=pytest.mark.soak)])
@pytest.mark.parametrize("lapses", LAPSES)
def test_lapses_in_one_condition_make_no_difference_of_jnds(tmp_path, lapses, runs):
    """Twelve people, 20 trials a level; JNDs are equal, and the answers alone are simulated."""
    text = (EXAMPLES / "compare" / "study.toml").read_text()
    text += '[factors]\nmapping = { within = ["friction", "static"], order = "williams" }\n'
    study, lists = study_of(tmp_path, text)
    names = {
        number: {step["id"]: step["factors"]["mapping"] for step in one["steps"]
                 if step["type"] == "trial"} for number, one in lists.items()
    }  # fmt: skip
    jnd = 2.0 * 0.6745 * math.sqrt(2.0) / 1.2  # dB; levels are 2 dB apart
    held, ratios = np.zeros(3), []
    for run in range(runs):
        calm, tired = (simulate_answers(study, lists, Observers(1.2, 0.1, lapse), 12, run)
                       for lapse in lapses)  # fmt: skip
        for first, second in zip(calm.sessions, tired.sessions, strict=True):
            own = names[first.number]
            both = zip(first.trials, second.trials, strict=True)
            first.trials[:] = [b if own.get(a[0]) == "static" else a for a, b in both]
        found = analyse(calm)
        friction, static = (found.line("jnd", mapping=one).estimate for one in study["factors"]
                            ["mapping"]["levels"])  # fmt: skip
        (change,) = [one.estimate for one in found.differences if one.measure == "jnd"]
        ratios.append(static.mean / friction.mean)
        held += [change.low <= 0.0 <= change.high, friction.low <= jnd <= friction.high,
                 static.low <= jnd <= static.high]  # fmt: skip
    rate = found.line("lapse", mapping="static").estimate
    assert rate.low < rate.high
    ratio = np.exp(np.nanmean(np.log(ratios)))  # a mean may lack too many participants
    print(f"lapses {lapses}: ratio of JNDs {ratio:.3f}; of {runs} intervals those that contain "
          f"the difference, the JNDs: {held}")  # fmt: skip
    assert 0.85 < ratio < 1.15
    assert held[0] >= (0.9 * runs if runs >= 100 else runs - 2)


def test_a_list_of_an_earlier_version_counts_the_levels(tmp_path):
    """QUEST+ tables were made of the indices of levels, whatever their distances."""
    text = varying("quest", "standard = 2.0\nmax_trials = 60").replace(
        "[2.0, 4.0, 8.0, 16.0, 32.0]", "[2.0, 3.0, 4.0, 20.0, 21.0]"
    )
    study, lists = study_of(tmp_path, text)
    step = next(one for one in lists[1]["steps"] if one["type"] == "adaptive")
    # as version 0.2.0 wrote it: 9 thresholds of 9 slopes and lapse rates each, and only these keys
    rows = [0.5 + (0.5 - lapse) * ndtr((np.arange(4.0) - threshold) / slope)
            for threshold in np.linspace(-0.5, 3.5, 9) for slope in (0.5, 1.0, 2.0)
            for lapse in (0.0, 0.02, 0.05)]  # fmt: skip
    old = {**step, "quest": {"p": np.array(rows).T.tolist(), "prior": [1.0 / 81.0] * 81}}
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
        found[name] = run_threshold(scale_of(study), one, responses, 2.0)
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
