"""The example of each task runs as it is: no warning, and observers whose answers are analysed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from overview_studies.analysis import analyse
from overview_studies.design import load_design
from overview_studies.dry_run import rehearse
from overview_studies.folder import draft_study
from overview_studies.observers import Observers, simulate_answers
from overview_studies.scripts import MAIN_MEASURES
from studies.tests.files import varying, written

EXAMPLES = Path(__file__).parents[1] / "examples"
NAMES = ("identify", "detect", "compare", "adjust", "staircase", "quest", "search")


def test_each_task_of_the_list_has_an_example():
    assert {path.name for path in EXAMPLES.iterdir()} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_an_example_has_no_flaw_and_an_estimate(name):
    design = load_design(EXAMPLES / name / "study.toml")
    assert rehearse(design) == ([], 18)
    study, lists = draft_study(design)
    per_step = 0.22 if name in ("staircase", "quest") else 1.0
    found = analyse(simulate_answers(study, lists, Observers(per_step), 12, 1))
    main = MAIN_MEASURES[design.file.task.name]
    lines = [one for one in found.estimates if one.measure == main]
    assert len(lines) == {"search": 3}.get(name, 2 if study["factors"] else 1)
    assert all(one.estimate.low <= one.estimate.mean <= one.estimate.high for one in lines)


def test_a_study_of_sight_asks_for_what_is_seen_and_announces_its_channels(tmp_path):
    text = (EXAMPLES / "search" / "study.toml").read_text()
    text = text[: text.index("[text.conditions]")].replace('"search"', '"identify"').replace(
        'question = "Go back to the goal."\n', "").replace('kinds = ["goal"]',
        'kinds = ["goal", "foul"]').replace('target = "goal"\n', "")  # fmt: skip
    (tmp_path / "study.toml").write_text(text)
    study, lists = draft_study(load_design(tmp_path / "study.toml"))
    assert "Attend to what you see, feel and hear." in study["text"]["instructions"]
    pauses = [step["text"] for step in lists[1]["steps"] if step["type"] == "break"]
    assert any("You see it, and do not feel or hear it." in pause for pause in pauses)
    (tmp_path / "study.toml").write_text(
        text.replace('within = ["both", "visual", "all"]', 'between = ["click", "tactor"]').replace(
            ', order = "williams"', "").replace("channel =", "mapping =").replace(
            '["click", "tactor"]', '["friction", "static"]')
        + '[output]\nchannel = "visual"\n'
    )  # fmt: skip
    study, _ = draft_study(load_design(tmp_path / "study.toml"))
    assert "Attend to what you see. Then choose" in study["text"]["instructions"]
    assert study["task"]["question"] == "What did you see?"
    more = 'method = "yesno"\n[output]\nchannel = "visual"'
    study, _ = draft_study(load_design(written(tmp_path, varying("staircase", more))))
    assert study["task"]["words"] == {"1": "I saw it", "0": "I saw nothing"}


def test_instructions_fit_the_gestures_and_a_change_is_announced_between_blocks():
    design = load_design(EXAMPLES / "detect" / "study.toml")
    study, lists = draft_study(design)
    assert study["text"]["instructions"].startswith("Press Play")
    (pause,) = [step for step in lists[1]["steps"] if step["type"] == "break"]
    assert re.fullmatch("New in the next part: .* your (left|right) hand.", pause["text"])
    design = load_design(EXAMPLES / "identify" / "study.toml")
    study, lists = draft_study(design)
    assert study["text"]["instructions"].startswith("Move along the field")
    for one in lists.values():
        heads = [step for step in one["steps"] if step["type"] == "instructions"]
        told = {step["factors"]["input"]: step["text"] for step in heads}
        assert "finger" in told["touch"]
        assert "roll" in told["twist"]
        (pause,) = [step for step in one["steps"] if step["type"] == "break"]
        assert heads[1]["text"] in pause["text"]
