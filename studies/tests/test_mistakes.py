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
        ('start = ["consent"]', 'start = ["consent", "about.html"]', "questionnaires",
         "an HTML file in the folder"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_line_and_remedy(tmp_path, line, mistake, key, remedy):
    assert STUDY.count(line) == 1
    path = written(tmp_path, STUDY.replace(line, mistake))
    outcome = overview("study", "check", path)
    refused(outcome, key, remedy)
    assert re.search(r"study\.toml:\d+: ", outcome.err), outcome.err


def test_what_is_missing_is_named(tmp_path):
    for section, key in (("title", "title"), ("[stimuli]", "stimuli"), ("[task]", "task")):
        lines = STUDY.splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith(section))
        end = start + 1
        while section.startswith("[") and not lines[end].startswith("["):
            end += 1
        path = written(tmp_path, "\n".join([*lines[:start], *lines[end:]]))
        refused(overview("study", "check", path), f"{key} is missing")


def test_a_file_of_another_kind_is_named(tmp_path):
    path = written(tmp_path, STUDY)
    refused(overview("study", "analyse", path), "study.toml", "not a file of answers")
    refused(overview("study", "serve", path), "no study", "overview study build")
    (tmp_path / "utf16.toml").write_bytes(STUDY.encode("utf-16"))
    refused(overview("study", "check", tmp_path / "utf16.toml"), "utf16.toml", "UTF-8")


def test_a_study_without_a_mistake_has_no_warning_and_one_without_consent_has(tmp_path):
    outcome = overview("study", "check", written(tmp_path, STUDY))
    assert outcome.code == 0
    assert "NO" not in outcome.out
    without = STUDY.replace('start = ["consent"]', "start = []")
    assert "NO consent form" in overview("study", "check", written(tmp_path, without)).out
