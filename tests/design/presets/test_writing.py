"""Presets written, compared, blended and told about."""

from __future__ import annotations

import itertools
import json
import tomllib

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.comparing import differences
from overview_dsp.design.presets.library import LIBRARY, bundled_presets
from overview_dsp.design.presets.morphing import morph, randomize
from overview_dsp.design.presets.reference import json_schema, reference
from overview_dsp.design.presets.serialization import preset_from_dict, preset_to_dict
from overview_dsp.design.presets.validation import parse_preset
from overview_dsp.design.presets.writing import preset_template, preset_toml, save_preset
from overview_dsp.errors import InputError
from tests.design.presets.strategies import presets


def same(first, second):
    return not differences(first, second) and (first.tags, first.authors, first.title) == (
        second.tags,
        second.authors,
        second.title,
    )


@given(presets())
def test_a_preset_comes_back_from_its_file_and_from_a_state_byte_for_byte(preset):
    text = preset_toml(preset)
    again = parse_preset(text, preset.name, "x.toml")
    assert same(again, preset)
    assert preset_toml(again) == text
    state = json.dumps(preset_to_dict(preset))
    restored = preset_from_dict(json.loads(state))
    assert same(restored, preset)
    assert json.dumps(preset_to_dict(restored)) == state


@pytest.mark.parametrize("name", bundled_presets())
def test_bundled_presets_fit_the_editors_schema_and_come_back(name, tmp_path):
    preset = ov.load_preset(name)
    jsonschema.validate(
        tomllib.loads((LIBRARY.bundled_folder / f"{name}.toml").read_text(encoding="utf-8")),
        json_schema(),
    )
    again = ov.load_preset(save_preset(preset, tmp_path / f"{name}.toml"))
    assert same(again, preset)
    jsonschema.validate(tomllib.loads(preset_toml(preset)), json_schema())


@pytest.mark.parametrize(
    "text", ['[disk]\nk1 = "much"', "[dsik]\nk1 = 1e-3", "[disk]\nk1 = 1e9", "[disk]\nk7 = 1"]
)
def test_the_editors_schema_finds_faults(text):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(f"schema = 2\n{text}\n"), json_schema())
    jsonschema.validate(tomllib.loads('schema = 2\n[disk]\nk1 = "$soft / 2"\n'), json_schema())


def test_the_schema_is_json():
    json.dumps(json_schema(), allow_nan=False)


def test_a_started_preset_is_its_base_until_it_is_changed(football):
    text = preset_template("football", football, "mine")
    own = parse_preset(text, "mine", "mine.toml", lambda name, _: (name, base_text(name)))
    assert own.title == "mine"
    assert differences(own, football) == []
    height = f"{football.kinds['goal'].height:g}"
    changed = text.replace(f"# [kinds.goal]\n# height = {height}", "[kinds.goal]\nheight = 50")
    own = parse_preset(changed, "mine", "mine.toml", lambda name, _: (name, base_text(name)))
    assert [one.id for one in differences(football, own)] == ["kinds.goal.height"]


@pytest.mark.parametrize("name", ["football", "heart", "ratchet"])
def test_a_started_preset_without_its_comment_signs_is_its_base(name):
    base = ov.load_preset(name)
    lines = preset_template(name, base, "mine").splitlines()
    start = lines.index("# drop = []  # Kinds of the extended preset that are removed.")
    prose = [line for line in lines[start:] if "These are the values" in line or "heading." in line]
    kept = [line.removeprefix("# ") for line in lines[start:] if line not in prose]
    text = "\n".join(line for line in lines[:start] if "extends" not in line) + "\n"
    own = parse_preset(text + "\n".join(kept), "mine", "mine.toml")
    assert own.kinds == base.kinds
    assert (own.values, own.points, own.tags.data) == (base.values, base.points, base.tags.data)


def base_text(name):
    return (LIBRARY.bundled_folder / f"{name}.toml").read_text(encoding="utf-8")


def test_a_morph_goes_from_one_to_the_other_by_steps_of_one_ratio(football):
    heart = ov.load_preset("heart")
    found = morph(football, heart, 5)
    assert all(found[0].values[id] == value for id, value in football.values.items())
    assert all(found[-1].values[id] == value for id, value in heart.values.items())
    assert found[0].kinds["goal"] == football.kinds["goal"]
    assert found[-1].kinds["beat"] == heart.kinds["beat"]
    friction = [preset.number("surface.friction") for preset in found]
    ratios = {round(b / a, 9) for a, b in itertools.pairwise(friction)}
    assert len(ratios) == 1
    for preset in found:
        assert same(parse_preset(preset_toml(preset), preset.name, "x"), preset)
    for steps in (1, 1001):
        with pytest.raises(InputError, match="2 to 1000"):
            morph(football, heart, steps)


@given(presets(), st.integers(0, 2**31), st.floats(0.0, 1.0))
def test_chance_makes_valid_presets_and_the_same_seed_the_same_one(preset, seed, amount):
    found = randomize(preset, seed, amount)
    assert preset_toml(found) == preset_toml(randomize(preset, seed, amount))
    assert same(parse_preset(preset_toml(found), found.name, "x"), found)
    if amount == 0.0:
        assert all(found.values[id] == pytest.approx(value) for id, value in preset.values.items())


def test_the_reference_names_every_parameter():
    text = reference()
    for parameter in ov.presets.PARAMETERS.values():
        assert f"| `{parameter.key}` |" in text
        assert parameter.doc in text
