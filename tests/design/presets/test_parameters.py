from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS,
    MODE_PARAMETERS,
    PARAMETERS,
    parameter,
)
from tests.design.presets.strategies import presets, values

TABLES = {
    f"{table}{id}": known
    for table, entries in (
        ("", PARAMETERS),
        ("kinds.", KIND_PARAMETERS),
        ("modes.", MODE_PARAMETERS),
    )
    for id, known in entries.items()
}
NUMBERS = {id: known for id, known in TABLES.items() if not known.choices}


def one_line(error) -> str:
    text = str(error.value)
    assert "\n" not in text
    assert len(text) < 400
    return text


@pytest.mark.parametrize("known", TABLES.values(), ids=TABLES)
def test_every_parameter_says_what_it_is_and_allows_its_default(known):
    assert known.doc.endswith(".")
    if known.default is not None:
        assert known.check(known.default) == known.default


@pytest.mark.parametrize("known", NUMBERS.values(), ids=NUMBERS)
def test_a_number_is_allowed_at_both_ends_of_its_range_and_not_beyond_them(known):
    assert known.low < known.high
    assert known.check(known.low) == known.low
    assert known.check(known.high) == known.high
    if known.scale == "log":
        assert known.low > 0.0
    for outside in (math.nextafter(known.low, -math.inf), math.nextafter(known.high, math.inf)):
        with pytest.raises(ov.InputError) as error:
            known.check(outside)
        assert known.key in one_line(error)
        assert known.allowed in one_line(error)


WRONG = [math.nan, math.inf, -math.inf, "5", True, None, [1.0], 10**400, -(10**5000), "x" * 10**6]


@pytest.mark.parametrize("known", NUMBERS.values(), ids=NUMBERS)
@pytest.mark.parametrize("value", WRONG, ids=lambda value: str(type(value).__name__))
def test_what_is_not_a_finite_number_is_an_error_of_one_line_with_the_range(known, value):
    with pytest.raises(ov.InputError) as error:
        known.check(value)
    assert known.key in one_line(error)
    assert known.allowed in one_line(error)


@pytest.mark.parametrize("value", [0, 1, 1.0, "true", None, [], {}], ids=repr)
def test_a_flag_is_true_or_false_and_nothing_like_it(value):
    with pytest.raises(ov.InputError, match=r"tactor\.mute.*false or true"):
        PARAMETERS["tactor.mute"].check(value)


@pytest.mark.parametrize("value", ["Recoil", True, 1, None, ["recoil"]], ids=repr)
def test_a_choice_is_one_of_its_words(value):
    with pytest.raises(ov.InputError, match=r'disk\.release.*"recoil" or "return"'):
        PARAMETERS["disk.release"].check(value)


def test_an_integer_becomes_a_float():
    checked = PARAMETERS["tactor.frequency_hz"].check(200)
    assert isinstance(checked, float)


def test_an_unknown_name_is_an_error_of_one_line_that_knows_a_near_one():
    with pytest.raises(ov.InputError, match=r"tactor\.gain_dB.*did you mean 'tactor\.gain_db'"):
        parameter("tactor.gain_dB")


@pytest.mark.filterwarnings("ignore:.*:overview_dsp.OverviewWarning")
@given(presets())
def test_values_of_the_tables_ranges_make_valid_presets(preset):
    assert set(preset.values) == set(PARAMETERS)
    for id, known in PARAMETERS.items():
        assert known.check(preset.values[id]) == preset.values[id]
    # a valid preset is one the program can use
    timeline = ov.Timeline("t", 10.0, (ov.Event(3.0, "default"),), None)
    surface = ov.build_surface(timeline, preset)
    assert (surface.friction > 0.0).all()


def good_kind(**changes):
    return ov.EventKind(**{"height": 3.0, "width_percent": 1.0, **changes})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"height": math.nan}, "height"),
        ({"height": -1.0}, "0 to 2500"),
        ({"width_percent": 0.0}, "width_percent"),
        ({"width_percent": None}, "exactly one"),
        ({"width_ms": 5.0}, "exactly one"),
        ({"shape": "spike"}, "raised_cosine"),
        ({"gain_db": math.inf}, "gain_db"),
        ({"modes": (ov.ClickMode(440.0, math.nan),)}, r"modes\.0\.decay_ms"),
        ({"modes": (ov.ClickMode(440.0, 5.0), ov.ClickMode(1.0, 5.0))}, r"modes\.1\.frequency_hz"),
        ({"modes": (ov.ClickMode(440.0, 5.0),) * 7}, "at most 6"),
    ],
)
def test_a_kind_made_in_python_is_held_to_the_same_ranges(changes, words):
    good_kind()
    with pytest.raises(ov.InputError, match=words) as error:
        good_kind(**changes)
    one_line(error)


def test_a_preset_has_capacity_for_so_many_kinds_as_the_engine():
    from overview_dsp.kernels.layout import MAX_KINDS

    kinds = {f"kind_{i}": good_kind() for i in range(MAX_KINDS - 1)} | {"default": good_kind()}
    ov.Preset("full", "", "", {}, kinds)
    with pytest.raises(ov.InputError, match="at most 32"):
        ov.Preset("over", "", "", {}, kinds | {"one_more": good_kind()})


def test_a_preset_needs_a_default_kind():
    with pytest.raises(ov.InputError, match=r"kinds\.default"):
        ov.Preset("bare", "", "", {}, {"goal": good_kind()})


@given(st.data())
def test_a_changed_preset_differs_in_what_was_changed_only(data):
    preset = ov.Preset("p", "", "", {}, {"default": good_kind()})
    id = data.draw(st.sampled_from(list(PARAMETERS)))
    value = data.draw(values(PARAMETERS[id]))
    changed = preset.with_values(**{id.replace(".", "__"): value})
    assert changed.values[id] == value
    assert {**changed.values, id: None} == {**preset.values, id: None}
    assert preset.values[id] == PARAMETERS[id].default
