"""Presets made from presets: extends, variables, older schemas, and where a fault stands."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.expressions import evaluate
from overview_dsp.errors import InputError

BASE = """schema = 2
title = "base"
description = "b"
[variables]
hard = 10
[disk]
k1 = 2e-3
[kinds.default]
height = "$hard"
width_percent = 1
modes = [{ frequency_hz = 500, decay_ms = 20 }]
[kinds.goal]
height = "$hard * (2 + 1) - 5"
width_ms = 300
"""


@pytest.fixture
def write(tmp_path):
    def put(text, name="own.toml"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    put(BASE, "base.toml")
    return put


def refused(path, *words):
    with pytest.raises(InputError) as caught:
        ov.load_preset(path)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_a_preset_does_not_say_is_its_bases(write):
    own = ov.load_preset(
        write(
            'schema = 2\nextends = "base.toml"\ntitle = "own"\n[disk]\nk2 = 5e-3\n'
            "[kinds.goal]\nheight = 7\n"
        )
    )
    assert (own.title, own.description, own.name) == ("own", "b", "own")
    assert (own.number("disk.k1"), own.number("disk.k2")) == (2e-3, 5e-3)
    assert own.kinds["goal"].height == 7.0
    assert own.kinds["goal"].width_ms == 300.0
    assert own.kinds["default"].modes == (ov.ClickMode(500.0, 20.0),)


def test_a_variable_set_anew_moves_all_that_is_worked_out_from_it(write):
    assert ov.load_preset(write(BASE)).kinds["goal"].height == 25.0
    own = ov.load_preset(
        write('schema = 2\nextends = "base.toml"\n[variables]\nhard = 20\n', "harder.toml")
    )
    assert own.kinds["default"].height == 20.0
    assert own.kinds["goal"].height == 55.0


def test_a_width_of_the_other_sort_takes_the_bases_place(write):
    own = ov.load_preset(
        write('schema = 2\nextends = "base.toml"\n[kinds.goal]\nwidth_percent = 0.5\n')
    )
    assert own.kinds["goal"].width_ms is None
    assert own.kinds["goal"].width_percent == 0.5


def test_a_bundled_preset_can_be_extended_by_name(write):
    own = ov.load_preset(write('schema = 2\nextends = "football"\n[surface]\nambience = 2\n'))
    football = ov.load_preset("football")
    assert own.kinds == football.kinds
    assert own.number("surface.intensity_gain") == 2.0


def test_own_presets_are_found_by_name(tmp_path, monkeypatch, write):
    monkeypatch.setenv("OVERVIEW_PRESETS", str(tmp_path))
    assert ov.load_preset("base").title == "base"
    own = ov.load_preset(write('schema = 2\nextends = "base"\ntitle = "x"\n', "over.toml"))
    assert own.kinds["goal"].height == 25.0


@pytest.mark.parametrize("version", [1, 2, 3, 4])
def test_older_schemas_are_read(write, version):
    text = BASE.replace("schema = 2", f"schema = {version}")
    assert ov.load_preset(write(text)) == ov.load_preset(write(BASE))


def test_a_dropped_kind_is_gone_with_its_aliases_and_can_be_made_anew(write):
    drop = 'schema = 4\nextends = "football"\ntitle = "x"\ndrop = ["goal", "touch"]\n'
    own, football = ov.load_preset(write(drop)), ov.load_preset("football")
    assert set(football.kinds) - set(own.kinds) == {"goal", "touch"}
    assert own.kind_for("goal") is own.kind_for("minute") is None
    anew = ov.load_preset(write(f"{drop}[kinds.goal]\nheight = 3.0\nwidth_percent = 0.3\n"))
    assert anew.kinds["goal"] == ov.EventKind(3.0, 0.3)  # nothing of football's goal


def test_tags_and_authors_are_kept(write):
    own = ov.load_preset(
        write(
            'schema = 2\nextends = "base.toml"\nauthors = ["A", "B"]\n'
            '[tags]\nenergy = 4\ntempo = 1.5\nusage = ["alarm"]\n'
        )
    )
    assert own.authors == ("A", "B")
    assert (own.tags.energy, own.tags.roughness, own.tags.usage) == (4.0, None, ("alarm",))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('schema = 2\nextends = "nothing.toml"\n', ("extends", "nothing.toml", "no such file")),
        ('schema = 2\nextends = "footbal"\n', ("did you mean 'football'",)),
        ('schema = 2\nextends = "own.toml"\n', ("extends it in turn",)),
        (
            'schema = 4\nextends = "base.toml"\ndrop = ["gaol"]\n',
            ("own.toml:3", "drop has 'gaol'; must be a list of kinds", "did you mean 'goal'"),
        ),
        (
            'schema = 4\nextends = "base.toml"\ndrop = "goal"\n',
            ("own.toml:3", "drop has 'goal'", "a list of kinds"),
        ),
        (
            'schema = 4\nextends = "base.toml"\ndrop = ["default"]\n',
            ("kinds.default is missing",),
        ),
        ("schema = 2\nextends = 3\n", ("extends = 3", "a preset's name")),
        (
            'schema = 2\nextends = "base.toml"\n[kinds.goal]\nheight = "$hart"\n',
            ("own.toml:4", "kinds.goal.height", "did you mean 'hard'"),
        ),
        (
            'schema = 2\nextends = "base.toml"\n[disk]\nk1 = "$hard / 0"\n',
            ("own.toml:4", "disk.k1", "divides by zero"),
        ),
        (
            'schema = 2\nextends = "base.toml"\n[variables]\nhard = 1e6\n',
            ("base.toml:9", "kinds.default.height = 1000000.0 is out of range"),
        ),
        (
            'schema = 2\nextends = "base.toml"\n[disk]\nk1 = "open($hard)"\n',
            ("own.toml:4", "is not an expression"),
        ),
        ('schema = 2\nextends = "base.toml"\n[tags]\nenergy = 9\n', ("own.toml:4", "tags.energy")),
        ('schema = 2\nextends = "base.toml"\n[tags]\nenrgy = 2\n', ("did you mean 'energy'",)),
        ('schema = 2\nextends = "base.toml"\nvariables = 3\n', ("variables",)),
        ("schema = 9\n" + BASE.split("\n", 1)[1], ("schema = 9 is not known", "1 to 4")),
    ],
)
def test_a_fault_is_an_error_of_one_line_that_names_the_file_it_stands_in(write, text, words):
    refused(write(text), *words)


def test_presets_that_extend_each_other_end_in_one_line(write):
    write('schema = 2\nextends = "b.toml"\n', "a.toml")
    refused(write('schema = 2\nextends = "a.toml"\n', "b.toml"), "extends it in turn")
    for i in range(12):
        write(f'schema = 2\nextends = "x{i + 1}.toml"\n', f"x{i}.toml")
    refused(write("schema = 2\n", "x12.toml").with_name("x0.toml"), "extend each other")


@given(st.text(max_size=30))
def test_any_expression_is_a_number_or_one_line(text):
    try:
        value = evaluate(text + "$a", {"a": 2.0})
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert isinstance(value, float)


@pytest.mark.parametrize(
    ("text", "value"),
    [("$a", 3.0), ("-$a + 1", -2.0), ("2 * ($a - 1) / 4", 1.0), ("$a*$b", 1.5)],
)
def test_expressions_are_arithmetic(text, value):
    assert evaluate(text, {"a": 3.0, "b": 0.5}) == value


@pytest.mark.parametrize(
    "text", ["$a ** 9999", "$a if 1 else 2", "$a.real", "[$a]", "$a; 1", "$a" + "+1" * 200, "$a(1)"]
)
def test_more_than_arithmetic_is_refused(text):
    with pytest.raises(InputError):
        evaluate(text, {"a": 3.0})
