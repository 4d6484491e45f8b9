"""A lesson: its content, its scores over days, an untrained learner, and a robot in a terminal."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.errors import InputError
from overview_studies.lesson import MAX_TAUGHT_KINDS, QUESTIONS, label, lesson_of, make_lesson
from overview_studies.lesson_learner import Learner, compare_orders, lived_examples, taught_share
from overview_studies.lesson_scores import Attempt
from overview_studies.lesson_terminal import TerminalLesson
from overview_studies.training import training_of
from studies.tests.files import design_of, study_of, written
from tests.cli.running import environment, overview, refused

PRESETS = ("football", "heart", "plain", "crowd")


@pytest.fixture(scope="module")
def football():
    return make_lesson("football")


@pytest.fixture(scope="module", params=PRESETS)
def lesson(request):
    return make_lesson(request.param, seed=3)


def test_every_kind_is_taught_alone_in_a_pair_and_among_others_before_it_is_asked(lesson):
    assert 2 <= len(lesson.kinds) <= MAX_TAUGHT_KINDS
    alone = [step.kind for step in lesson.steps if step.part == "alone"]
    pairs = [step.examples[-1].kinds for step in lesson.steps if step.part == "pair"]
    crowds = [step for step in lesson.steps if step.part == "crowd"]
    assert alone == list(lesson.kinds)
    assert {kind for pair in pairs for kind in pair} == set(lesson.choices)
    assert [step.kind for step in crowds] == list(lesson.choices)
    assert {one.kind for one in lesson.questions} == set(lesson.choices)
    parts = [step.part for step in (*lesson.steps, *lesson.questions)]
    assert parts == sorted(parts, key=["alone", "pair", "crowd", "question"].index)
    for step in crowds:
        crowd = step.examples[-1]
        assert len(crowd.kinds) >= 3
        assert crowd.kinds.count(step.kind) == 1
        place = crowd.kinds.index(step.kind) + 1
        assert step.text == f"{label(step.kind)} among others: number {place} of {len(crowd.kinds)}"


def test_a_reference_is_just_before_each_pair_and_each_crowd(lesson):
    for step in lesson.steps:
        *references, last = step.examples
        if step.part == "pair":
            assert references == [lesson.references[kind] for kind in last.kinds]
        elif step.part == "crowd":
            assert references == [lesson.references[step.kind]]
        for reference in references:
            assert len(reference.kinds) == 1


def test_the_questions_are_balanced_and_of_another_order_with_another_seed(football):
    orders = set()
    for seed in range(5):
        questions = make_lesson("football", seed=seed).questions
        kinds = [one.kind for one in questions]
        orders.add(tuple(kinds))
        assert len(questions) == QUESTIONS
        counts = Counter(kinds).values()
        assert max(counts) - min(counts) <= 1
        assert all(a != b for a, b in pairwise(kinds))
        # not the very example that was taught
        for one in questions:
            taught = football.references[one.kind].timeline.events[0].time_s
            assert one.examples[0].timeline.events[0].time_s != taught
    assert len(orders) == 5


def test_the_same_seed_gives_the_same_lesson(football):
    again = make_lesson("football")
    assert again.digest == football.digest != make_lesson("football", seed=1).digest
    for one, other in zip(football.steps, again.steps, strict=True):
        for a, b in zip(one.examples, other.examples, strict=True):
            assert a.timeline.events == b.timeline.events
            assert np.array_equal(a.gesture.theta2, b.gesture.theta2)


def test_a_lesson_of_football_takes_about_three_minutes(football):
    assert 60.0 < football.duration_s < 100.0  # of sounds alone
    assert football.minutes == 3
    # strongest first
    assert football.kinds[0] == "goal"
    # of the data first, then other kinds of the preset
    assert set(ov.load_timeline("world-cup-final-2018").kinds()) <= set(football.kinds)


def test_crowds_are_parts_of_the_data_where_it_has_them(football):
    match = ov.load_timeline("world-cup-final-2018")
    titles = {step.kind: step.examples[-1].timeline for step in football.steps
              if step.part == "crowd"}  # fmt: skip
    assert titles["own_goal"].provenance == match.provenance
    assert titles["own_goal"].intensity is not None
    assert titles["red_card"].provenance == "example of a lesson"  # the match has none


def test_kinds_that_feel_the_same_are_named_as_such_and_not_asked():
    preset = ov.load_preset("football")
    twins = {**preset.kinds, "penalty": preset.kinds["goal"]}
    lesson = lesson_of(replace(preset, kinds=twins), None, 0)
    kept, dropped = sorted(("goal", "penalty"), key=lesson.kinds.index)
    assert lesson.same == {dropped: kept}
    assert dropped not in lesson.choices
    (step,) = (one for one in lesson.steps if one.part == "alone" and one.kind == dropped)
    assert f"feels the same as {kept}" in step.text
    assert [one.kinds for one in step.examples] == [(kept,), (dropped,)]


def test_every_example_of_a_lesson_sounds_and_has_all_its_events(lesson):
    for step in (*lesson.steps, *lesson.questions):
        for example in step.examples:
            result = ov.render(example.timeline, lesson.preset, example.gesture, 48_000, tail=0.5)
            assert np.abs(result.samples).max() > 0.01
            assert len(result.strikes.event) == len(example.kinds)


def attempt(path, today, again=False, preset="plain"):
    return Attempt(path, preset, lambda seed: make_lesson(preset, None, seed), today, again)


def finish(one, wrong=()):
    while (step := one.current) is not None:
        if step.part != "question":
            one.complete(one.done)
            continue
        number = len(one.answers)
        others = [kind for kind in one.lesson.choices if kind != step.kind]
        one.complete(one.done, others[0] if number in wrong else step.kind)
    return one.score


def test_scores_of_several_days_are_stored_with_dates_and_mistakes(tmp_path):
    path = tmp_path / "data" / "lessons.json"
    first = attempt(path, "2026-11-20")
    assert first.last is None
    assert first.steps[0].part == "alone"
    assert finish(first, wrong=(0, 4, 5)).right == 7
    later = attempt(path, "2026-11-27")
    assert "Last time 7 of 10 on 2026-11-20." in later.welcome
    assert [one.part for one in later.steps] == ["question"] * QUESTIONS
    assert [one.kind for one in later.steps] != [one.kind for one in first.lesson.questions]
    assert finish(later).text == "10 of 10 right."
    again = attempt(path, "2026-11-28", again=True)
    assert again.steps[0].part == "alone"
    assert [(one.date, one.right) for one in again.scores] == [
        ("2026-11-20", 7), ("2026-11-27", 10)]  # fmt: skip
    mistakes = again.scores[0].confused
    assert len(mistakes) == 3
    assert all(kind != answer for kind, answer in mistakes)
    assert mistakes[0][0] == first.lesson.questions[0].kind
    # other presets have scores of their own
    assert attempt(path, "2026-11-28", preset="crowd").last is None


def test_a_lesson_that_was_interrupted_continues_at_the_same_step(tmp_path):
    path = tmp_path / "lessons.json"
    one = attempt(path, "2026-11-20")
    for _ in range(len(one.lesson.steps)):
        one.complete(one.done)
    one.complete(one.done, one.lesson.choices[0])
    other = attempt(path, "2026-11-21")
    assert other.done == len(one.lesson.steps) + 1
    assert other.answers == one.answers
    assert "You continue at step" in other.welcome
    # a request that is sent twice is stored once
    other.complete(other.done - 1, other.lesson.choices[1])
    assert other.answers == one.answers
    finish(other)
    assert attempt(path, "2026-11-22").done == 0


def test_wrong_steps_and_answers_are_refused_and_nothing_is_stored(tmp_path):
    one = attempt(tmp_path / "lessons.json", "2026-11-20")
    for step, answer in ((1, None), (0, "strong"), (-1, None)):
        with pytest.raises(InputError):
            one.complete(step, answer)
    for _ in range(len(one.lesson.steps)):
        one.complete(one.done)
    done = one.done
    for answer in (None, "goal"):
        with pytest.raises(InputError):
            one.complete(done, answer)
    assert attempt(tmp_path / "lessons.json", "2026-11-20").done == done


def test_a_damaged_file_of_scores_is_reported_and_not_overwritten(tmp_path):
    path = tmp_path / "lessons.json"
    attempt(path, "2026-11-20").complete(0)
    begun = json.loads(path.read_text())
    progress = begun["plain"]["progress"]
    changes = (
        {"done": 1_000_000}, {"done": -1}, {"done": "x"}, {"answers": ["goal"]}, {"answers": 3},
        {"seed": None}, {"whole": "perhaps"}, {"digest": 1},
    )  # fmt: skip
    entries = [{"progress": {**progress, **change}} for change in changes]
    entries += [[], 3, {"scores": 3}, {"scores": [{"date": "2026-11-20"}]}, {"progress": []}]
    for text in ("{", "[]", *(json.dumps({"plain": entry}) for entry in entries)):
        path.write_text(text)
        with pytest.raises(InputError, match=r"lessons\.json"):
            attempt(path, "2026-11-20")
        assert path.read_text() == text


def test_a_preset_that_cannot_be_taught_is_an_error_in_one_line():
    refused(overview("learn", "footbal"), "football")
    preset = ov.load_preset("football")
    goal = preset.kinds["goal"]
    for names in (["goal"], ["goal", "penalty"]):
        kinds = {"default": preset.kinds["default"], **dict.fromkeys(names, goal)}
        with pytest.raises(InputError, match="preset football"):
            lesson_of(replace(preset, kinds=kinds), None, 0)


def test_an_untrained_learner_names_more_kinds_after_the_order_of_the_lesson(football):
    """Than after the same examples in a random order: 200 learners, 95 % interval."""
    shares = compare_orders(football, 200, seed=1)
    gain = shares[:, 0] - shares[:, 1]
    half = 1.96 * gain.std(ddof=1) / np.sqrt(len(gain))
    print(f"ordered {shares[:, 0].mean():.3f}, random {shares[:, 1].mean():.3f}, "
          f"gain {gain.mean():.3f} +- {half:.3f}")  # fmt: skip
    assert gain.mean() - half > 0.01
    assert 0.6 < shares[:, 0].mean() < 0.95


def test_a_learner_without_examples_names_nothing_and_learns_from_one(football):
    lived = lived_examples(football)
    learner = Learner(np.random.default_rng(1), memory=0.0)
    assert learner.name(lived[0].features[0]) == ""
    learner.learn(lived[0])
    assert learner.name(lived[1].features[0]) == lived[0].kinds[0]
    asked = [(one.kinds[0], one.features[0]) for one in lived[: len(football.kinds)]]
    assert taught_share(lived, asked, np.random.default_rng(1), memory=0.0, repeats=40) > 0.9
    # with noise alone, which no example has any effect on, it guesses
    assert taught_share(lived, asked, np.random.default_rng(1), memory=1e4, repeats=40) < 0.4


def pressed(*keys):
    left = list(keys)
    return lambda: left.pop(0) if left else ""


def lines_of(capsys):
    return capsys.readouterr().out.splitlines()


def test_the_terminal_prints_plain_lines_and_repeats_and_ends(tmp_path, capsys):
    played = []

    def play(example):
        played.append(example.kinds)
        return list(example.kinds)

    path = tmp_path / "lessons.json"
    one = attempt(path, "2026-11-20")
    assert not TerminalLesson(one, play, pressed("r", "x", "\n", "q"), False).run()
    said = lines_of(capsys)
    assert not any("\x1b" in line for line in said)
    assert "1 of 18: strong" in said
    assert played == [("strong",), ("strong",), ("firm",)]
    assert "Your place is stored. Continue: overview learn plain" in said
    # the next pass continues there
    one = attempt(path, "2026-11-20")
    choices = one.lesson.choices
    wanted = [choices.index(question.kind) for question in one.lesson.questions]
    answers = [str(1 + index) for index in wanted]
    answers[3] = str(1 + (wanted[3] + 1) % 3)
    assert TerminalLesson(one, play, pressed(*["\n"] * 7, *answers), False).run()
    said = lines_of(capsys)
    mistake = choices[(wanted[3] + 1) % 3]
    right = one.lesson.questions[3].kind
    assert f"It was {right}, not {mistake}. Again, {right}:" in said
    assert f"9 of 10 right. Confused: {right} with {mistake}." in said
    assert one.score.right == 9


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("preset", ["crowd", pytest.param("football", marks=pytest.mark.soak)])
def test_a_robot_in_a_terminal_hears_every_example_and_has_the_right_score(preset, tmp_path):
    from tests.live.terminal import Terminal

    lesson, scores = make_lesson(preset), tmp_path / "scores.json"
    expected = [list(one.kinds) for step in (*lesson.steps, *lesson.questions)
                for one in step.examples]  # fmt: skip
    arguments = ["learn", preset, "--device", "none", "--scores", scores, "--json"]
    reports, correct = [], 0

    def told(terminal):
        """Whole lines so far."""
        return [json.loads(line) for line in bytes(terminal.shown).split(b"\r\n")[:-1]
                if line.startswith(b"{")]  # fmt: skip

    def run(stop_at):
        """Press keys until a step or the end; the reports of this pass."""
        nonlocal correct
        terminal = Terminal(arguments, environment())
        done = 0
        while True:
            terminal.wait_for(lambda done=done: len(told(terminal)) > done)
            report = told(terminal)[done]
            done += 1
            if "right" in report and "of" in report:
                break
            here = report.get("step", len(lesson.steps) + report.get("question", 0))
            if ("step" in report or "question" in report) and here == stop_at:
                terminal.press("q")
                terminal.wait_for(lambda: any("stopped" in one for one in told(terminal)))
                break
            if "step" in report:
                terminal.press("\n")
            elif "question" in report:
                number = report["question"] - 1
                right = lesson.questions[number].kind
                index = report["choices"].index(right)
                if number in (1, 6):
                    index = (index + 1) % len(report["choices"])
                else:
                    correct += 1
                terminal.press(str(1 + index))
        found = told(terminal)
        _, code = terminal.end()
        assert code == 0
        assert terminal.echoed
        return found

    first = run(len(lesson.steps) + 3)
    reports = [*first, *run(None)]
    played = [one for one in reports if "played" in one]
    # the example during which q was pressed is played again
    cut = next(i for i, one in enumerate(reports) if "stopped" in one)
    before = sum("played" in one for one in reports[:cut])
    del played[before - 1]
    assert all(one["struck"] == one["played"] for one in played)
    corrections = [[lesson.questions[n].kind] for n in (1, 6)]
    assert Counter(map(tuple, (one["played"] for one in played))) == Counter(
        map(tuple, [*expected, *corrections])
    )
    assert reports[-1]["right"] == correct == 8
    stored = json.loads(scores.read_text())[preset]
    assert stored["scores"][0]["right"] == 8
    assert "progress" not in stored


def test_without_a_terminal_keys_are_lines_and_the_end_of_the_input_stores_the_place(tmp_path):
    scores = tmp_path / "scores.json"
    command = [sys.executable, "-m", "overview_dsp", "learn", "plain", "--device", "none"]
    done = subprocess.run(
        [*command, "--scores", str(scores)], input="\n\n", capture_output=True, text=True,
        check=False, env=environment(),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "3 of 18: light" in done.stdout
    assert "Your place is stored" in done.stdout
    assert json.loads(scores.read_text())["plain"]["progress"]["done"] == 2


TRAINED = """
title = "Trained"
seed = 4
participants = 2
[task]
name = "identify"
[stimuli]
made = { kinds = ["goal", "foul", "yellow_card"] }
gestures = ["sweep:0.5"]
[training]
criterion = 8
most_rounds = 2
[phases]
main = { repeats = 1 }
"""


def test_a_study_begins_with_the_lesson_about_its_kinds(tmp_path):
    study, lists = study_of(tmp_path, TRAINED)
    lesson = training_of(design_of(tmp_path, TRAINED))
    orders = []
    for content in lists.values():
        steps = content["steps"]
        examples = [step for step in steps if step["type"] == "example"]
        questions = [step for step in steps if step.get("phase") == "practice"]
        assert steps[: len(examples) + QUESTIONS] == [*examples, *questions]
        assert [step["text"] for step in examples] == [step.text for step in lesson.steps]
        for step, taught in zip(examples, lesson.steps, strict=True):
            assert [study["stimuli"][key]["answer"] for key in step["stimuli"]] == [
                one.kinds[0] for one in taught.examples
            ]
        assert {(one["criterion"], one["rounds"], one["feedback"]) for one in questions} == {
            (0.8, 2, True)}  # fmt: skip
        for one in questions:
            assert study["stimuli"][one["stimuli"][0]]["answer"] == one["correct"]
        orders.append([one["correct"] for one in questions])
        # no stimulus of the lesson is in a condition
        taught = {key for one in (*examples, *questions) for key in one["stimuli"]}
        main = [step for step in steps if step.get("phase") == "main"]
        assert len(main) == 3
        assert not taught & {key for step in main for key in step["stimuli"]}
    assert orders[0] != orders[1]
    assert Counter(orders[0]) == Counter(orders[1])


def test_answers_of_the_training_are_not_analysed(tmp_path):
    from overview_studies.analysis import analyse
    from overview_studies.observers import Observers, simulate_answers

    study, lists = study_of(tmp_path, TRAINED)
    answers = simulate_answers(study, lists, Observers(3.0), 6, 1)
    trained = [trial for trial, _, _ in answers.sessions[0].trials if trial.startswith("b0-p")]
    assert len(trained) == QUESTIONS
    (matrix,) = analyse(answers).matrices.values()
    assert matrix.sum() == 6 * 3


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("most_rounds = 2", "most_rounds = 4", "training.most_rounds"),
        ("criterion = 8", "criterion = 11", "training.criterion"),
        ("criterion = 8", "lesson = false", "training.lesson"),
        ('gestures = ["sweep:0.5"]', 'presets = ["football", "plain"]', "one preset"),
        ('name = "identify"', 'name = "count"', "identify"),
    ],
)
def test_a_training_that_cannot_be_is_refused_with_its_key(tmp_path, old, new, reason):
    toml = written(tmp_path, TRAINED.replace(old, new))
    line = refused(overview("study", "lists", toml, "-o", tmp_path / "lists"), reason)
    assert "training" in line or "plain" in line


def test_a_study_with_a_training_is_built_with_all_its_sounds(tmp_path):
    toml = written(tmp_path, TRAINED)
    outcome = overview("study", "build", toml, "-o", tmp_path / "folder")
    assert outcome.code == 0, outcome.err
    study = json.loads((tmp_path / "folder" / "study.json").read_text())
    content = json.loads((tmp_path / "folder" / "lists" / "001.json").read_text())
    for step in content["steps"]:
        for key in step.get("stimuli", []):
            assert (tmp_path / "folder" / study["stimuli"][key]["image"]).is_file()
            assert study["stimuli"][key]["sha256"]
