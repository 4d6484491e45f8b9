from __future__ import annotations

import pytest

from overview_dsp.errors import InputError
from overview_studies.design import load_design
from studies.tests.files import IDENTIFY, design_of, lists_of, other, varying, written


def refusal(folder, text):
    with pytest.raises(InputError) as caught:
        lists_of(folder, text)
    line = str(caught.value)
    assert "\n" not in line
    return line


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("seed = 7", "sead = 7", ("study.toml:4", "sead", "did you mean 'seed'")),
        ("participants = 4", "", ("participants is missing",)),
        ("participants = 4", "participants = 0", ("study.toml:5", "participants = 0", "1")),
        ('name = "identify"', 'name = "idenify"', ("study.toml:12", "task.name", "'identify'")),
        ('"static"', '"statik"', ("factors.mapping", "did you mean 'static'")),
        ('order = "williams"', 'order = "latin"', ("factors.mapping.order", "williams")),
        ('{ between = ["touch", "twist"] }', "{ }", ("factors.input", "within", "between")),
        ('"football"', '"fotball"', ("study.toml:16", "stimuli.presets", "football")),
        ('["free"]', '["swep:2"]', ("stimuli.gestures", "swep")),
        ("variants = 2", "variants = 0", ("stimuli.made.variants", "1")),
        ('kinds = ["goal", "foul"]', "kinds = []", ("stimuli", "either kinds or curves")),
        ("variants = 2", "places = [0.1, 0.9]", ("stimuli.made.places", "use positions")),
        ('name = "identify"', 'name = "identify"\nwords = {}', ("task.words", "use labels")),
        ("catch = 0.25", "catch = 0.95", ("phases.catch", "0.8")),
        ('["consent"]', '["consnt"]', ("questionnaires", "consnt", "tlx")),
        ('gestures = ["free"]', 'out = "x"', ("stimuli.out", "no such key")),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(tmp_path, old, new, said):
    assert old in IDENTIFY
    line = refusal(tmp_path, IDENTIFY.replace(old, new))
    for words in said:
        assert words in line, line


def test_levels_that_are_nowhere_and_tasks_that_lack_something_are_refused(tmp_path):
    assert "task.standard" in refusal(tmp_path, varying("compare", "standard = 9.0"))
    assert "task.vary" in refusal(tmp_path, other("compare"))
    assert "phases.attention" in refusal(tmp_path, other("count", "attention = 1"))
    assert "phases.catch" in refusal(tmp_path, other("draw", "catch = 0.2"))
    two = 'made = { kinds = ["goal", "foul"] }'
    text = varying("staircase").replace('made = { kinds = ["goal"] }', two)
    assert "one stimulus per level" in refusal(tmp_path, text)


def test_a_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(InputError, match="not TOML"):
        load_design(written(tmp_path, "title = "))
    with pytest.raises(InputError, match="can't be read"):
        load_design(tmp_path / "nowhere.toml")


def test_a_design_has_the_hash_of_its_text_whatever_its_line_ends(tmp_path):
    first = design_of(tmp_path, IDENTIFY).sha256
    path = tmp_path / "study.toml"
    path.write_bytes(IDENTIFY.replace("\n", "\r\n").encode())
    assert load_design(path).sha256 == first


def test_a_round_of_lists_is_groups_times_rows(tmp_path):
    assert design_of(tmp_path, IDENTIFY).lists_per_round == 4
    three = IDENTIFY.replace(
        "mapping = {",
        'hand = { within = ["left", "right", "both"], order = "williams" }\nmapping = {',
    )
    three += """
[text.conditions]
"hand.left" = "Use your left hand."
"hand.right" = "Use your right hand."
"hand.both" = "Use both hands."
"""
    assert design_of(tmp_path, three).lists_per_round == 2 * 6
