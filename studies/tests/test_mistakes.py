"""Mistakes of researchers in a study file: each is one line with file, line, key and remedy."""

from __future__ import annotations

import re

import pytest

from studies.tests.files import written
from tests.cli.running import overview, refused

STUDY = """title = "Touch against twist"
seed = 7
participants = 8
[factors]
mapping = { within = ["friction", "static"], order = "williams" }
input = { between = ["touch", "twist"] }
[task]
name = "identify"
question = "What did you feel?"
[stimuli]
made = { kinds = ["goal", "foul", "yellow_card"] }
presets = ["football"]
gestures = ["free"]
[phases]
practice = { repeats = 1, feedback = true, criterion = 0.6 }
main = { repeats = 8 }
catch = 0.2
[questionnaires]
start = ["consent"]
consent = { version = "1", text = "I take part." }
"""


@pytest.mark.parametrize(
    ("line", "mistake", "key", "remedy"),
    [
        ("participants = 8", 'participants = "eight"', "participants", "a whole number"),
        ("seed = 7", "seed = 7,", "not TOML", "before column 9"),
        ("seed = 7", "seed = 7\nseed = 8", "not TOML", "remove one of the two"),
        ("[phases]", "[phase]", "phase", "did you mean 'phases'"),
        ("catch = 0.2", "cath = 0.2", "phases.cath", "did you mean 'catch'"),
        ('name = "identify"', 'name = "identity"', "task.name", "'identify', 'locate'"),
        ('"foul", "yellow_card"', '"fould", "yellow_card"', "stimuli.made", "did you mean 'foul'"),
        ('"football"', '"footbal"', "stimuli.presets", "did you mean 'football'"),
        ('["free"]', '["sweep:fast"]', "stimuli.gestures", "sweep:SECONDS"),
        ('"static"]', '"statc"]', "factors.mapping", "did you mean 'static'"),
        ('"williams"', '"latin"', "factors.mapping.order", "'williams', 'full' or 'blocks'"),
        ("catch = 0.2", "catch = 20", "phases.catch", "at most 0.8"),
        ("criterion = 0.6", "criterion = 60", "phases.practice.criterion", "at most 1"),
        ('["touch", "twist"]', '["touch"]', "factors.input.between", "at least 2 entries"),
        ('["free"]', '["sweep:2"]', "factors.input", 'stimuli.gestures = ["free"]'),
        ('between = ["touch", "twist"]', 'between = ["touch", "twist"], within = ["a", "b"]',
         "factors.input", "either within"),
        ("input = {", "hand = {", "factors.hand", '"hand.touch" = "..." to text.conditions'),
        ('name = "identify"', 'name = "compare"', "task.vary", "set it to"),
        ('consent = { version = "1", text = "I take part." }', "", "questionnaires.consent",
         "version = "),
        ('start = ["consent"]', 'start = ["consent"]\nend = ["about.html"]',
         "20: questionnaires.end", "an HTML file in the folder"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_line_and_remedy(tmp_path, line, mistake, key, remedy):
    assert STUDY.count(line) == 1
    path = written(tmp_path, STUDY.replace(line, mistake))
    outcome = overview("study", "check", path)
    refused(outcome, key, remedy)
    assert re.search(r"study\.toml:\d+: ", outcome.err), outcome.err


def test_what_is_missing_is_named(tmp_path):
    for section, key, remedy in (
        ("title", "title", 'add title = "..."'),
        ("[stimuli]", "stimuli", "add a table [stimuli]"),
        ("[task]", "task", "add a table [task]"),
    ):
        lines = STUDY.splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith(section))
        end = start + 1
        while section.startswith("[") and not lines[end].startswith("["):
            end += 1
        path = written(tmp_path, "\n".join([*lines[:start], *lines[end:]]))
        refused(overview("study", "check", path), f"study.toml:1: {key} is missing; {remedy}")
    text = STUDY.replace('name = "identify"\n', "")
    outcome = overview("study", "check", written(tmp_path, text))
    refused(outcome, "study.toml:7: task.name is missing", "add name = ... to [task]")


def test_a_file_of_another_kind_is_named(tmp_path):
    path = written(tmp_path, STUDY)
    refused(overview("study", "analyse", path), "study.toml", "not a file of answers")
    refused(overview("study", "serve", path), "no study", "overview study build")
    (tmp_path / "utf16.toml").write_bytes(STUDY.encode("utf-16"))
    refused(overview("study", "check", tmp_path / "utf16.toml"), "utf16.toml", "UTF-8")


GAINS = "[-18.0, -17.5, -17.0, -16.5, -16.0, -15.5, -15.0, -14.5, -14.0, -13.5, -13.0]"
WEAK = """title = "How strong"
participants = 6
[task]
name = "staircase"
vary = "tactor.gain_db"
standard = -18.0
max_trials = 60
[stimuli]
made = { kinds = ["goal"] }
gestures = ["sweep:2"]
[stimuli.parameters]
"tactor.gain_db" = [-18.0, -17.5, -17.0, -16.5, -16.0, -15.5, -15.0, -14.5, -14.0, -13.5, -13.0]
[questionnaires]
start = ["consent"]
consent = { version = "1", text = "I take part." }
"""
QUEST = WEAK.replace('"staircase"', '"quest"')
FLAWS = {  # the study, what is replaced in it, the key and the remedy
    "balance": (STUDY, {"participants = 8": "participants = 7"}, "participants", "to 8"),
    "consent": (STUDY, {'start = ["consent"]': "start = []"}, "questionnaires.start",
                'add "consent"'),
    "catch trials in a row": (
        WEAK, {"standard = -18.0": 'method = "yesno"',
               "[stimuli]": "[phases]\ncatch = 0.2\n[stimuli]"},
        "phases.catch", "change seed"),
    "one answer": (STUDY, {'"identify"': '"count"', "catch = 0.2": ""},
                   "task.name", "other stimuli"),
    "no effect": (STUDY, {'"yellow_card"] }': '"yellow_card"] }\nparameters = '
                          '{ "kinds.red_card.height" = [1.0, 9.0] }'},
                  "stimuli.parameters", "no effect"),
    "unfelt": (STUDY, {'"yellow_card"] }': '"yellow_card"] }\nparameters = '
                       '{ "kinds.foul.height" = [0.3] }'}, "stimuli", "(foul) cannot be felt"),
    "floor": (WEAK, {GAINS: "[-18.0, -8.0, -3.0, 0.0, 3.0]"}, "task.vary", "nearer"),
    "ceiling": (WEAK, {GAINS: "[-18.0, -17.9, -17.8, -17.7, -17.6]"}, "task.vary", "further"),
    "floor of QUEST+": (QUEST, {GAINS: "[-18.0, -8.0, -3.0, 0.0, 3.0]"}, "task.vary", "nearer"),
    "ceiling of QUEST+": (QUEST, {GAINS: "[-18.0, -17.9, -17.8, -17.7, -17.6]"},
                          "task.vary", "further"),
    "standard at the end": (
        WEAK.replace("max_trials = 60\n", "").replace('"staircase"', '"adjust"').replace(
            "[questionnaires]", "[phases]\nmain = { repeats = 8 }\n[questionnaires]"),
        {GAINS: "[-18.0, -16.0, -14.0, -12.0, -10.0]"}, "task.standard", "beyond it"),
    "levels a hundredth of a JND apart": (
        QUEST.replace('"quest"', '"compare"').replace("max_trials = 60\n", ""),
        {GAINS: "[-18.0, -17.99, -17.98, -17.97, -17.96]"}, "task.vary", "differ more"),
    "few trials": (WEAK, {"max_trials = 60": "max_trials = 10"}, "task.max_trials", "raise"),
    "power without a factor": (WEAK, {"[questionnaires]": "[power]\neffect = 0.1\n"
                               "[questionnaires]"}, "power.effect", "add one"),
    "power of an effect above d'": (STUDY, {"[questionnaires]": "[power]\neffect = 1.5\n"
                                    "[questionnaires]"}, "power.effect", "a smaller effect"),
    "power": (STUDY, {"[questionnaires]": "[power]\neffect = 0.1\n[questionnaires]"},
              "power.share", "raise phases.main.repeats"),
}  # fmt: skip


@pytest.mark.parametrize("flaw", FLAWS)
def test_a_study_that_shows_a_flaw_when_observers_complete_it_has_a_warning(tmp_path, flaw):
    text, replaced, key, remedy = FLAWS[flaw]
    for line, replacement in replaced.items():
        assert text.count(line) == 1
        text = text.replace(line, replacement)
    outcome = overview("study", "check", written(tmp_path, text))
    assert outcome.code == 0, outcome.err
    warnings = [one for one in outcome.out.splitlines() if one.startswith("warning: ")]
    warning = next((one for one in warnings if remedy in one), outcome.out)
    assert re.match(rf"warning: \S*study\.toml:\d+: {re.escape(key)}", warning), warning


FACTOR = """[factors]
hand = { between = ["left", "right"] }
[text.conditions]
"hand.left" = "Left."
"hand.right" = "Right."
[task]
"""
SOUND = {  # without a flaw; in some only the second kind, or a frequency, differs
    "study": STUDY,
    "staircase": WEAK,
    "QUEST+": QUEST,
    "two conditions": WEAK.replace("[task]\n", FACTOR),
    "second kind": STUDY.replace(
        '"yellow_card"] }', '"yellow_card"] }\nparameters = { "kinds.foul.height" = [3.0, 4.0] }'
    ).replace("repeats = 8", "repeats = 4"),
    "frequency": WEAK.replace('"staircase"', '"compare"').replace("max_trials = 60\n", "").replace(
        "-18.0\n", "200.0\n").replace(GAINS, "[150.0, 200.0, 250.0, 300.0]").replace(
        "tactor.gain_db", "tactor.frequency_hz"),
}  # fmt: skip


@pytest.mark.parametrize("text", SOUND.values(), ids=SOUND)
def test_a_study_without_a_flaw_has_no_warning(tmp_path, text):
    outcome = overview("study", "check", written(tmp_path, text))
    assert outcome.code == 0, outcome.err
    assert "warning" not in outcome.out
    assert "observers of 3 abilities have completed it" in outcome.out
