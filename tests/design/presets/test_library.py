from __future__ import annotations

import json
import os
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets import library
from overview_dsp.design.presets.describe import character, describe, describe_json
from overview_dsp.design.presets.parameters import PARAMETERS


def refused(name, *words: str) -> None:
    with pytest.raises(ov.InputError) as error:
        ov.load_preset(name)
    assert "\n" not in str(error.value)
    for word in words:
        assert word in str(error.value)


def test_there_are_bundled_presets_and_football_is_one():
    assert "football" in ov.bundled_presets()


@pytest.mark.parametrize("name", ov.bundled_presets())
def test_every_bundled_preset_is_valid_and_plays_the_bundled_match(name, match):
    preset = ov.load_preset(name)
    assert preset.name == name
    assert preset.title
    assert preset.description
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # a kind it doesn't name is felt as its default, which is allowed
        warnings.filterwarnings("ignore", "preset .* has no ", ov.OverviewWarning)
        surface = ov.build_surface(match, preset)
    assert (surface.friction > 0.0).all()


@pytest.mark.parametrize("name", ov.bundled_presets())
def test_every_bundled_preset_begins_with_what_it_feels_and_sounds_like(name):
    header = (library.LIBRARY.bundled_folder / f"{name}.toml").read_text(encoding="utf-8")
    header = header.split("schema =")[0]
    assert "Feels like" in header
    assert "Sounds like" in header


def test_football_names_every_kind_of_the_bundled_match(match, football):
    assert set(match.kinds()) <= set(football.kinds)


def test_a_preset_is_found_by_its_name_and_by_its_path(tmp_path):
    text = (library.LIBRARY.bundled_folder / "football.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    mine, football = ov.load_preset(path), ov.load_preset("football")
    assert mine.name == "mine"
    assert (mine.values, mine.kinds) == (football.values, football.kinds)
    assert ov.load_preset(str(path)) == mine


def test_a_byte_order_mark_and_windows_line_ends_change_nothing(tmp_path):
    text = (library.LIBRARY.bundled_folder / "football.toml").read_text(encoding="utf-8")
    path = tmp_path / "football.toml"
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert ov.load_preset(path) == ov.load_preset("football")


def test_a_misspelt_name_is_an_error_of_one_line_with_the_nearest_one():
    refused("footbal", "'footbal'", "did you mean 'football'")


@pytest.mark.parametrize("name", ["", "a\0b", "a\0b.toml", "x" * 5000, "x" * 5000 + ".toml", "."])
def test_a_name_that_is_no_name_is_an_error_of_one_line(name):
    refused(name)


def test_a_missing_file_and_a_folder_are_one_line(tmp_path):
    refused(tmp_path / "no.toml", "no.toml", "no such file")
    (tmp_path / "a.toml").mkdir()
    refused(tmp_path / "a.toml", "a.toml", "is a folder")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_instead_of_waited_for(tmp_path):
    os.mkfifo(tmp_path / "p.toml")
    refused(tmp_path / "p.toml", "p.toml")


def test_a_file_that_is_too_long_or_no_text_is_an_error_of_one_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(b"#" * 1_000_001)
    refused(path, "mine.toml", "1,000,000 bytes")
    path.write_bytes(b"schema = 1\n\xff\n")
    refused(path, "mine.toml", "UTF-8", "byte 11")


@given(st.binary(max_size=200))
def test_any_bytes_are_a_preset_or_one_line(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(data)
    refused(path, str(path))


def test_the_description_names_every_parameter_with_its_value_range_and_meaning(football):
    page = describe(football)
    for known in PARAMETERS.values():
        line = next(line for line in page.splitlines() if known.doc in line)
        assert known.key in line
        assert f"({known.allowed})" in line
    for kind in football.kinds:
        assert f"  {kind} " in page


def test_the_description_stars_what_differs_from_the_default(football):
    changed = football.with_values(tactor__gain_db=-7.25)
    lines = describe(changed).splitlines()
    line = next(line for line in lines if PARAMETERS["tactor.gain_db"].doc in line)
    assert line.startswith(" *gain_db")
    assert "-7.25 dB" in line
    for line in describe(football.with_values(tactor__gain_db=0.0)).splitlines():
        assert PARAMETERS["tactor.gain_db"].doc not in line or line.startswith("  gain_db")


def test_the_description_as_data_is_json_with_everything_in_it(football):
    data = json.loads(json.dumps(describe_json(football), allow_nan=False))
    assert {id: entry["value"] for id, entry in data["parameters"].items()} == football.values
    assert set(data["kinds"]) == set(football.kinds)


def test_the_character_follows_from_the_disks_equation(football):
    # held: s**2 J + s B + k = 0 has its double root at damping 1
    critical = (
        2.0
        * (
            (football.number("disk.k1") + football.number("disk.k2"))
            * football.number("disk.inertia")
        )
        ** 0.5
    )
    facts = character(football.with_values(surface__friction=critical))
    assert facts["held_damping"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("kinds", "name"),
    [
        ({"goal": 3, "foul": 20}, "football"),
        ({"beat": 900, "premature": 3}, "heart"),
        ({"cheer": 1}, "crowd"),
        ({"highest": 1, "year": 10}, "series"),
        ({}, "series"),
        ({"sneeze": 2}, "plain"),
        ({"goal": 1, "sneeze": 2}, "plain"),
        ({"sneeze": 2, "day": 9, "hour": 20}, "plain"),
        ({"goal": 2, "substitution": 2, "minute": 20}, "football"),
    ],
)
def test_the_preset_that_names_most_of_the_kinds_fits(kinds, name):
    assert library.fitting_preset(kinds).preset == name


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Return a function that writes a preset into the user's folder."""
    monkeypatch.setenv("OVERVIEW_PRESETS", str(tmp_path / "own"))
    (tmp_path / "own").mkdir()

    def write(name: str, text: str) -> None:
        head = f'schema = 4\ntitle = "{name}"\ndescription = "own"\n'
        (tmp_path / "own" / f"{name}.toml").write_text(head + text)

    return write


def test_a_users_preset_is_chosen_for_the_kinds_that_it_names_best(own):
    own("tennis", 'extends = "plain"\n[kinds.strong]\naliases = ["ace", "double_fault"]\n')
    fit = library.fitting_preset({"ace": 8, "double_fault": 2, "let": 3, "minute": 40})
    assert (fit.preset, fit.named, fit.kinds) == ("tennis", 2, 3)
    assert str(fit) == "preset tennis fits the data best, with 2 of 3 event kinds"
    assert library.fitting_preset({"ace": 1, "let": 3}).preset == "plain"
    timeline = ov.Timeline("", 9.0, events=(ov.Event(3.0, "ace"),))
    assert ov.render(timeline, sample_rate=8000).engine.preset.name == "tennis"


def test_a_users_variation_is_chosen_before_a_bundled_preset_only_if_it_says_its_data(own):
    match = {"goal": 3, "foul": 20}
    own("mine", 'extends = "football"\n')
    assert library.fitting_preset(match).preset == "football"
    own("mine", 'extends = "football"\n[tags]\ndata = ["events"]\n')
    assert library.fitting_preset(match).preset == "mine"
    own("more", 'extends = "mine"\n')  # the data are not inherited
    assert library.fitting_preset(match).preset == "mine"
    own("more", 'extends = "football"\n[kinds.offside]\nheight = 3.0\nwidth_percent = 0.3\n')
    assert library.fitting_preset({**match, "offside": 2}).preset == "more"


def test_a_users_preset_is_chosen_for_curves_only_if_it_says_so(own):
    own("mine", 'extends = "series"\n')
    assert library.fitting_preset({}).preset == "series"
    own("mine", 'extends = "series"\n[tags]\ndata = ["series"]\n')
    assert library.fitting_preset({}).preset == "mine"
    assert library.fitting_preset({}, "LUFS").preset == "crowd"


def test_an_invalid_preset_of_the_user_is_named_and_passed_over(own):
    own("broken", 'extends = "plain"\n[disk]\nk1 = 9e9\n')
    with pytest.warns(ov.OverviewWarning, match=r"not considered .*broken\.toml:6: disk\.k1"):
        assert library.fitting_preset({"goal": 1}).preset == "football"


def test_unknown_data_of_a_preset_are_refused(own):
    own("mine", 'extends = "series"\n[tags]\ndata = ["weather"]\n')
    refused("mine", "mine.toml:6", "tags.data", "recordings")


def test_a_recording_without_a_cheer_is_felt_as_a_recording():
    for unit, name in (("LUFS", "crowd"), ("°C", "series")):
        curve = ov.Intensity(np.arange(4.0), np.arange(4.0), unit)
        assert library.fitting_preset_for(ov.Timeline("", 3.0, intensity=curve)).preset == name
