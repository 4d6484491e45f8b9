from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets import library
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MODE_PARAMETERS, PARAMETERS
from overview_dsp.design.presets.validation import parse_preset
from tests.design.presets.strategies import presets, toml_of, toml_value

FOOTBALL = (library.LIBRARY.bundled_folder / "football.toml").read_text(encoding="utf-8")
SMALL = """schema = 1
title = "Small"
description = "a small one"

[disk]
inertia = 2e-5

[kinds.default]
height = 3
width_percent = 1
[[kinds.default.modes]]
frequency_hz = 600
decay_ms = 30
"""


def refused(text: str, *words: str) -> str:
    with pytest.raises(ov.InputError) as error:
        parse_preset(text, "mine", "mine.toml")
    line = str(error.value)
    assert "\n" not in line
    assert len(line) < 500
    assert line.startswith("mine.toml:")
    for word in words:
        assert word in line
    return line


def one_line(error: ov.InputError) -> None:
    assert "\n" not in str(error)
    assert str(error).startswith("mine.toml:")


def line_with(text: str, start: str) -> int:
    """The last line, from 1, that begins so."""
    lines = text.splitlines()
    return max(i for i, line in enumerate(lines, 1) if line.startswith(start))


def plain() -> ov.Preset:
    return parse_preset(SMALL, "mine", "mine.toml")


@pytest.mark.parametrize("id", PARAMETERS)
def test_every_parameter_survives_the_way_through_a_file(id, tmp_path):
    known = PARAMETERS[id]
    tried = known.choices or (known.low, known.high, (known.low + known.high) / 3.0)
    for value in tried:
        preset = plain().with_changes({id: value})
        path = tmp_path / "mine.toml"
        path.write_text(toml_of(preset), encoding="utf-8")
        assert ov.load_preset(path) == preset
        assert ov.load_preset(path).values[id] == value


@given(presets())
def test_any_preset_survives_the_way_through_toml(preset):
    assert parse_preset(toml_of(preset), preset.name, "mine.toml") == preset


def test_what_a_file_leaves_out_is_the_tables_default():
    values = plain().values
    for id, known in PARAMETERS.items():
        if id != "disk.inertia":
            assert values[id] == known.default
    kind = plain().kinds["default"]
    assert kind.shape == KIND_PARAMETERS["shape"].default
    assert kind.modes[0].gain_db == MODE_PARAMETERS["gain_db"].default


NUMBERS = [id for id, known in PARAMETERS.items() if not known.choices]


@pytest.mark.parametrize("id", NUMBERS)
@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "1e300", "-1e300", '"much"', "true", "[]"])
def test_a_bad_number_names_file_line_key_and_range(id, text):
    section, key = id.split(".")
    file = (
        f"{SMALL}\n[{section}]\n{key} = {text}\n"
        if section != "disk"
        else SMALL.replace("inertia = 2e-5", f"{key} = {text}")
    )
    refused(file, f"mine.toml:{line_with(file, key)}: ", id, PARAMETERS[id].allowed)


@pytest.mark.parametrize("id", [id for id, known in PARAMETERS.items() if known.choices])
@pytest.mark.parametrize("text", ['"maybe"', "1", "nan", "{}"])
def test_a_bad_choice_names_file_line_key_and_choices(id, text):
    section, key = id.split(".")
    file = SMALL.replace("[disk]\ninertia = 2e-5", f"[{section}]\n{key} = {text}")
    refused(file, f"mine.toml:{line_with(file, key)}: ", id, PARAMETERS[id].allowed)


@pytest.mark.parametrize(("key", "known"), KIND_PARAMETERS.items(), ids=KIND_PARAMETERS)
def test_a_bad_value_of_a_kind_names_file_line_key_and_range(key, known):
    bad = '"?"' if known.choices else repr(known.high * 2.0)
    bare = SMALL.replace("height = 3\nwidth_percent = 1\n", "")
    rest = {"height": "3", "width_percent": "1", key: bad}
    if key == "width_ms":
        del rest["width_percent"]
    lines = "".join(f"{name} = {value}\n" for name, value in rest.items())
    file = bare.replace("[kinds.default]\n", f"[kinds.default]\n{lines}")
    refused(file, f"mine.toml:{line_with(file, key)}: kinds.default.{key} = ", known.allowed)


@pytest.mark.parametrize("key", MODE_PARAMETERS)
def test_a_bad_value_of_a_mode_names_file_line_key_and_range(key):
    known = MODE_PARAMETERS[key]
    rest = {"frequency_hz": "600", "decay_ms": "30", key: repr(known.high + 1.0)}
    lines = "".join(f"{name} = {value}\n" for name, value in rest.items())
    file = SMALL.replace("frequency_hz = 600\ndecay_ms = 30\n", lines)
    refused(
        file, f"mine.toml:{line_with(file, key)}: kinds.default.modes.0.{key} = ", known.allowed
    )


def test_a_fault_in_the_second_mode_is_reported_at_the_second_mode():
    file = SMALL + "[[kinds.default.modes]]\nfrequency_hz = 5\ndecay_ms = 30\n"
    last = len(file.splitlines()) - 1
    refused(file, f"mine.toml:{last}: kinds.default.modes.1.frequency_hz", "20 to 20000")


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("inertia = ", "innertia = ", ("disk.innertia", "did you mean 'inertia'")),
        ("[disk]", "[disc]", ("disc", "did you mean 'disk'")),
        ("height = ", "hight = ", ("kinds.default.hight", "did you mean 'height'")),
        ("decay_ms = ", "decay_s = ", ("kinds.default.modes.0.decay_s", "did you mean 'decay_ms'")),
        ("title = ", "titel = ", ("titel", "did you mean 'title'")),
    ],
)
def test_an_unknown_key_is_named_with_its_line_and_the_nearest_known_one(before, after, words):
    file = SMALL.replace(before, after, 1)
    messages = {refused(file)}
    # a missing key may be told first; its correction brings the unknown one
    if "is missing" in next(iter(messages)):
        file = file.replace(
            after, f"{before}1\n{after}" if before != "title = " else f'title = "x"\n{after}', 1
        )
        messages = {refused(file)}
    message = messages.pop()
    assert f"mine.toml:{line_with(file, after.strip(' ='))}: unknown key" in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ("[0.5]", ["points has 1 numbers", "2 to 256"]),
        ("[0.0, 1.5]", [":6:", "surface.points.1", "less than or equal to 1"]),
        ("[0.0, nan]", [":6:", "surface.points.1", "finite"]),
        ('"line"', [":6:", "surface.points", "list"]),
        (f"{[0.5] * 257}", [":6:", "surface.points", "256"]),
    ],
)
def test_a_map_that_is_none_names_file_line_and_what_it_may_be(points, words):
    text = SMALL.replace("[disk]", f"[surface]\npoints = {points}\n[disk]")
    refused(text, *words)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("title = 3", "title = 3 is not text"),
        ("texture = 3", "texture = 3 is not a table"),
        ("authors = 'me'", "authors = 'me' is not a list"),
        ("tags.energy = 9.0", "tags.energy = 9.0 is out of range; must be 1 to 5"),
    ],
)
def test_what_is_of_another_type_is_said_without_the_names_of_classes(lines, words):
    text = "\n".join(line for line in SMALL.splitlines() if not line.startswith("title"))
    text = text if "title" in lines else f'title = "x"\n{text}'
    message = refused(f"{lines}\n{text}", words)
    assert "valid" not in message
    assert "instance" not in message


@pytest.mark.parametrize("key", ["schema", "title", "description"])
def test_a_missing_header_is_named(key):
    file = "\n".join(line for line in SMALL.splitlines() if not line.startswith(key))
    refused(file, f"{key} is missing")


@pytest.mark.parametrize("given", ["5", "0", '"1"', "true", "1.0"])
def test_another_schema_is_refused(given):
    refused(SMALL.replace("schema = 1", f"schema = {given}"), "schema = ", "reads schema = 1 to 4")


def test_the_number_of_further_faults_is_reported():
    file = SMALL.replace("inertia = 2e-5", "inertia = 1\nk1 = -1\nk2 = 'x'")
    refused(file, "disk.inertia", "(and 2 more)")


@pytest.mark.parametrize("widths", ["", "width_percent = 1\nwidth_ms = 50\n"])
def test_a_kind_has_exactly_one_width(widths):
    file = SMALL.replace("width_percent = 1\n", widths)
    line = line_with(file, "[kinds.default]")
    refused(file, f"mine.toml:{line}: kinds.default: ", "exactly one of width_percent and width_ms")


def test_the_other_kinds_are_listed_in_the_order_of_the_file():
    names = ["sunrise", "quake", "ace", "borehole", "verse"]
    others = "".join(f"[kinds.{one}]\nheight = 1\nwidth_ms = 9\n" for one in names)
    refused(f"{SMALL}\n{others}[kinds.xx]\nheight = 1\n", "kinds.xx: ", ", ".join(names))


def test_the_default_kind_is_required():
    refused(SMALL.replace("kinds.default", "kinds.goal"), "kinds.default is missing")


def test_a_seventh_mode_is_refused():
    mode = "[[kinds.default.modes]]\nfrequency_hz = 600\ndecay_ms = 30\n"
    parse_preset(SMALL + 5 * mode, "mine", "mine.toml")
    refused(SMALL + 6 * mode, "kinds.default.modes", "6")


def test_what_is_not_toml_names_the_line():
    refused(SMALL.replace("inertia = 2e-5", "inertia 2e-5"), ":6: not TOML", "column")


@pytest.mark.parametrize(
    "text",
    [
        SMALL.replace("2e-5", "0x" + "f" * 6000),
        SMALL.replace("2e-5", "9" * 6000),
        SMALL.replace("2e-5", "[" * 5000),
        SMALL.replace("2e-5", "[" * 200 + "]" * 200),
        SMALL.replace("2e-5", '"' + "x" * 100_000 + '"'),
        SMALL.replace("inertia", '"in\\u001b[31mertia"'),
        SMALL.replace("inertia", '"in\\nertia"'),
    ],
    ids=["hex", "digits", "unclosed", "nested", "long", "escape", "newline"],
)
def test_monstrous_values_are_one_short_printable_line(text):
    assert refused(text).isprintable()


EDITS = st.one_of(
    st.tuples(st.just("delete"), st.integers(1, 40)),
    st.tuples(st.just("insert"), st.text(max_size=6)),
    st.tuples(
        st.just("insert"),
        st.sampled_from(
            [
                *("nan", "-inf", "1e999", "\n[disk]\n", "[[kinds.goal.modes]]\n", "{", "]", '"""'),
                *("\r", "= 5\n", "kinds = 3\n", "true", "\x00", "1979-05-27T07:32:00Z", "''"),
                *("0x1f", ".", "#"),
            ]
        ),
    ),
    st.tuples(st.just("copy"), st.integers(1, 200)),
)


@given(st.lists(st.tuples(st.floats(0, 1), EDITS), min_size=1, max_size=6), st.booleans())
def test_a_mutated_file_is_a_preset_or_one_line_and_never_another_exception(edits, small):
    text = SMALL if small else FOOTBALL
    for part, (what, detail) in edits:
        at = int(part * len(text))
        if what == "delete":
            text = text[:at] + text[at + detail :]
        elif what == "insert":
            text = text[:at] + detail + text[at:]
        else:
            text = text[:at] + text[at : at + detail] + text[at:]
    try:
        preset = parse_preset(text, "mine", "mine.toml")
    except ov.InputError as error:
        one_line(error)
    else:
        assert isinstance(preset, ov.Preset)


VALUES = st.recursive(
    st.one_of(
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(max_size=5),
        st.dates(),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=5,
)


def toml_of_any(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_of_any, value)) + "]"
    if isinstance(value, dict):
        return (
            "{" + ", ".join(f"{toml_value(k)} = {toml_of_any(v)}" for k, v in value.items()) + "}"
        )
    if isinstance(value, bool | str | float | int):
        return toml_value(value)
    return str(value)


@given(
    st.sampled_from(
        [
            *("schema", "title", "disk", "disk.k1", "tactor.mute", "kinds", "kinds.default"),
            *("kinds.default.modes", "kinds.default.height", "kinds.default.shape", "new.thing"),
        ]
    ),
    VALUES,
)
def test_any_value_anywhere_is_a_preset_or_one_line(key, value):
    # the file says all of it in dotted keys, the drawn one instead of its own
    said = {
        "schema": "1",
        "title": '"t"',
        "description": '"d"',
        "kinds.default.height": "3",
        "kinds.default.width_percent": "1",
    }
    said = {k: v for k, v in said.items() if k != key and not k.startswith(key + ".")}
    text = "\n".join(f"{k} = {v}" for k, v in {**said, key: toml_of_any(value)}.items())
    try:
        preset = parse_preset(text, "mine", "mine.toml")
    except ov.InputError as error:
        one_line(error)
    else:
        assert isinstance(preset, ov.Preset)
        json.dumps(dict(preset.values), allow_nan=False)


def test_a_misspelt_kind_without_a_width_names_the_kind_that_is_meant(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('schema = 4\nextends = "football"\n[kinds.gaol]\nheight = 900.0\n')
    with pytest.raises(ov.InputError, match=r"mine.toml:3: kinds.gaol: .*did you mean 'goal'\?"):
        ov.load_preset(path)
