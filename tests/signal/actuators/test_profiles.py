"""Actuator files: by name or path, strict, each mistake one line."""

from __future__ import annotations

import math
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.signal.actuators.library import (
    LIBRARY,
    actuator_names,
    load_actuator,
    parse_actuator,
)
from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS, ONE_OF
from tests.design.presets.strategies import toml_value
from tests.signal.actuators.strategies import actuators

C2 = (LIBRARY.bundled_folder / "c2.toml").read_text(encoding="utf-8")


def refused(text, *words):
    with pytest.raises(ov.InputError) as error:
        parse_actuator(text, "mine", "mine.toml")
    line = str(error.value)
    assert "\n" not in line
    assert len(line) < 400
    assert line.startswith("mine.toml")
    for word in words:
        assert word in line, line
    return line


def toml_of(actuator):
    """A file of all values of an actuator."""
    lines = ["schema = 2", f"title = {toml_value(actuator.title)}", 'description = "drawn"']
    for section in ("resonance", "drive", "shaping"):
        lines.append(f"[{section}]")
        lines += [
            f"{id.split('.')[1]} = {toml_value(value)}"
            for id, value in actuator.values.items()
            if id.split(".")[0] == section
        ]
    return "\n".join(lines)


def test_a_profile_of_schema_1_loads_with_its_earlier_keys():
    text = C2.replace("schema = 2", "schema = 1").replace("overdrive = 1", "sharpen = 4")
    earlier = parse_actuator(text + "perceptual_weighting = true\n", "c2", "c2.toml")
    assert earlier.values["shaping.overdrive"] == 4.0
    assert earlier.values["shaping.perceptual_weighting"] is True


def test_the_bundled_actuators_are_there():
    assert set(actuator_names()) >= {"c2", "cmf", "voice_coil", "lra", "dualsense", "headphones"}


@pytest.mark.parametrize("name", actuator_names())
def test_a_bundled_actuator_says_what_it_is_and_can_be_driven(name):
    actuator = load_actuator(name)
    assert actuator.title
    assert actuator.description
    assert 0.0 < actuator.nominal <= actuator.peak <= 1.0
    assert actuator.mean_square <= actuator.nominal**2
    header = (
        (LIBRARY.bundled_folder / f"{name}.toml").read_text(encoding="utf-8").split("schema")[0]
    )
    # a fact has its source, and what isn't one says so
    assert "data sheet" in header or "ssumptions" in header


def test_the_data_sheets_facts_of_the_cmf():
    cmf = load_actuator("cmf")
    assert 180.0 <= cmf.resonance_hz <= 280.0
    assert cmf.rise_ms <= 2.0 * (1.0 + 1e-12)
    assert cmf.values["drive.rated_rms"] == 0.25
    assert cmf.values["drive.peak"] == 0.5
    assert cmf.values["drive.duty"] == 0.1


def test_a_resonance_may_be_said_as_a_q_a_width_or_a_rise():
    def said(line):
        return parse_actuator(C2.replace("rise_ms = 33", line), "mine", "mine.toml")

    by_rise = said("rise_ms = 33")
    assert by_rise.q == pytest.approx(math.pi * 250.0 * 0.033 / math.log(9.0))
    assert said(f"q = {by_rise.q}").rise_ms == pytest.approx(33.0)
    assert said(f"bandwidth_hz = {250.0 / by_rise.q}").q == pytest.approx(by_rise.q)
    # its speed is 3 dB below at both ends of the width; a place is a speed over a frequency
    narrow = said("bandwidth_hz = 10")
    for half in (-5.0, 5.0):
        edge = math.hypot(250.0, half) + half
        speed = narrow.response_db(edge) + 20.0 * math.log10(edge / 250.0)
        assert speed == pytest.approx(-10.0 * math.log10(2.0))


@given(actuators())
def test_any_actuator_survives_the_way_through_toml(actuator):
    again = parse_actuator(toml_of(actuator), "drawn", "mine.toml")
    assert again.values == actuator.values
    assert (again.peak, again.nominal) == (actuator.peak, actuator.nominal)


@pytest.mark.parametrize("id", [p.id for p in ACTUATOR_PARAMETERS.values() if not p.choices])
def test_every_number_is_held_to_its_range_and_named_with_its_line(id):
    known = ACTUATOR_PARAMETERS[id]
    section, key = id.split(".")
    kept = [line for line in C2.splitlines() if not line.startswith(key + " =")]
    if id in ONE_OF:
        kept = [line for line in kept if not line.startswith("rise_ms")]
    at = kept.index(f"[{section}]") + 1
    for value in (known.low / 2.0 or -1.0, known.high * 2.0, "true", '"much"', "nan", "inf"):
        text = "\n".join([*kept[:at], f"{key} = {value}", *kept[at:]])
        refused(text, f"mine.toml:{at + 1}: {id}", known.allowed)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("rise_ms = 33", "rise_mss = 33", ("mine.toml:15: resonance.rise_mss: unknown key",
                                           "did you mean", "rise_ms")),
        ("[drive]", "[drives]", ("mine.toml:17: drives: unknown key", "drive")),
        ("schema = 2", "schema = 3", ("mine.toml:9: schema = 3; must be 2",)),
        ("schema = 2", "", ("schema is missing",)),
        ('title = "C-2 tactor"', "title = 3", ("mine.toml:10: title = 3; must be text",)),
        ("rise_ms = 33", "", ("mine.toml:14: resonance.frequency_hz: give one of", "not none")),
        ("rise_ms = 33", "rise_ms = 33\nq = 3", ("more than one",)),
        ("rise_ms = 33", "rise_ms = 1000", ("resonance.rise_ms = 1000 gives a q of 357",
                                            "0.6 to 100")),
        ("peak = 0.5", "peak = 0.2", ("mine.toml:20: drive.peak is below drive.rated_rms",)),
        ("peak = 0.5\n", "", ("drive.peak is missing; allowed: 0.0001 to 10000",)),
        ('unit = "A"', 'unit = "W"', ("drive.unit", '"A" or "V" or "full scale"')),
        ("overdrive = 1", "overdrive = 1\nperceptual_weighting = 1",
         ("shaping.perceptual_weighting",)),
        ("[drive]", "drive = 3\n[other]", ("not TOML",)),
        ("[resonance]", "[[resonance]]", ("resonance = ", "must be a table: [resonance]")),
    ],
)  # fmt: skip
def test_a_mistake_in_a_file_is_an_error_of_one_line_that_names_it(old, new, words):
    assert old in C2
    if "drive = 3" in new:
        refused(C2.replace(old, new, 1))
    else:
        refused(C2.replace(old, new, 1), *words)


@given(st.binary(max_size=300) | st.text(max_size=200).map(str.encode))
def test_garbage_is_an_error_of_one_line(tmp_path_factory, garbage):
    path = tmp_path_factory.mktemp("a") / "mine.toml"
    path.write_bytes(garbage)
    with pytest.raises(ov.InputError) as error:
        load_actuator(path)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(str(path))


def test_own_actuators_are_found_by_name_and_a_bundled_name_stays_the_bundleds(
    tmp_path, monkeypatch
):
    monkeypatch.setenv(LIBRARY.variable, str(tmp_path))
    (tmp_path / "mine.toml").write_text(C2.replace("C-2 tactor", "Mine"), encoding="utf-8")
    (tmp_path / "c2.toml").write_text(C2.replace("C-2 tactor", "Not mine"), encoding="utf-8")
    assert actuator_names()[-1] == "mine"
    assert actuator_names().count("c2") == 1
    assert load_actuator("mine").title == "Mine"
    assert load_actuator("c2").title == "C-2 tactor"
    assert load_actuator(tmp_path / "c2.toml").title == "Not mine"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("headphone", "no actuator is called 'headphone'; did you mean 'headphones'?"),
        ("nowhere/c2.toml", "no such file"),
        ("a" * 5000 + ".toml", "no such file"),
        ("", "no actuator is called ''"),
    ],
)
def test_an_actuator_that_is_not_there_is_an_error_of_one_line(name, words):
    with pytest.raises(ov.InputError) as error:
        load_actuator(name)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_folder_or_a_huge_file_is_no_actuator(tmp_path):
    folder = tmp_path / "a.toml"
    folder.mkdir()
    with pytest.raises(ov.InputError, match="is a folder"):
        load_actuator(folder)
    huge = tmp_path / "b.toml"
    huge.write_bytes(b"#" * 3_000_000)
    with pytest.raises(ov.InputError, match="larger than"):
        load_actuator(huge)
    assert os.path.getsize(huge) == 3_000_000


C2_VALUES = ov.load_actuator("c2").values


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({**C2_VALUES, "drive.rated_rms": float("nan")}, "drive.rated_rms = nan is out of range"),
        ({**C2_VALUES, "drive.peak": 1e9}, "drive.peak = 1e+09 is out of range"),
        ({**C2_VALUES, "drive.peek": 1.0}, "drive.peek: unknown key; did you mean 'drive.peak'"),
        ({**C2_VALUES, "shaping.overdrive": "4"}, "shaping.overdrive = '4' is not a number"),
        ({}, "resonance.frequency_hz is missing"),
    ],
)
def test_an_actuator_made_in_python_is_held_to_the_same_ranges(values, words):
    with pytest.raises(ov.InputError) as error:
        ov.Actuator("mine", "mine", "mine", values)
    assert words in str(error.value)


def test_an_actuator_made_in_python_needs_only_what_has_no_default():
    given = {"resonance.frequency_hz": 250, "resonance.q": 4, "drive.rated_rms": 1, "drive.peak": 2}
    mine = ov.Actuator("mine", "mine", "mine", given)
    assert mine.values["shaping.overdrive"] == 1.0
    assert mine.full_scale == 2.0
    assert (mine.peak, mine.mean_square) == (1.0, 0.25)
    assert mine.nominal == pytest.approx(math.sqrt(0.5))


@pytest.mark.parametrize("gain_db", [31.0, -31.0, float("nan")])
def test_a_calibration_out_of_range_is_refused(gain_db):
    with pytest.raises(ov.InputError, match=r"gain_db is .* dB; must be -30 to 30 dB"):
        ov.Actuator("mine", "mine", "mine", C2_VALUES, gain_db=gain_db)
