"""What the bundled presets say of themselves: characters that aren't loudness, voices, goals."""

from __future__ import annotations

import functools
import itertools
import json
import warnings

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.library import has_tag, is_for_use
from overview_dsp.measure.level_matching import level_matched_distance, perceptual_features
from tests.cli.running import overview

NAMES = ov.bundled_presets()
SWEEPS = {"medium": ov.sweep(3.0), "fast": ov.sweep(1.5)}
RATE = 32_000.0
PHONE_HZ = 500.0
"""What a phone's speaker carries begins here."""


DATA = ("world-cup-final-2018", "made-up-share", "crowd")


@functools.cache
def timeline_of(data):
    return ov.measure.random_crowd(1) if data == "crowd" else ov.load_timeline(data)


@functools.cache
def character_of(name, data):
    """A preset's perceptual_features on a match, a share or a recording."""
    with warnings.catch_warnings():
        # kinds of other data are felt as the default
        warnings.filterwarnings("ignore", "preset .* has no ", ov.OverviewWarning)
        return perceptual_features(ov.load_preset(name), timeline_of(data), sample_rate=RATE)


@pytest.mark.soak
def test_with_levels_matched_any_two_presets_differ_by_two_steps_on_a_match_or_a_series():
    nearest = dict.fromkeys(itertools.combinations(NAMES, 2), 0.0)
    for data in DATA:  # the next one only for pairs that this doesn't tell
        for first, second in [pair for pair, steps in nearest.items() if steps < 2.0]:
            steps = level_matched_distance(character_of(first, data), character_of(second, data))
            nearest[first, second] = max(steps, nearest[first, second])
    assert {pair: round(steps, 2) for pair, steps in nearest.items() if steps < 2.0} == {}


def test_gain_is_no_character(match, football):
    turned = football.with_changes({"tactor.gain_db": -7.0, "click.gain_db": -14.0})
    one, other = (perceptual_features(preset, match, SWEEPS, RATE) for preset in (football, turned))
    assert level_matched_distance(one, other) < 0.5


def test_a_telegraph_taps_high_and_dry_and_the_wind_is_low():
    share = {name: character_of(name, "made-up-share") for name in ("series", "stocks", "weather")}
    for way in ("slow", "medium", "fast"):
        assert share["weather"][way].brightness_hz < 0.75 * share["series"][way].brightness_hz
        assert share["stocks"][way].brightness_hz > share["weather"][way].brightness_hz


@pytest.mark.parametrize("first", ["series", "stocks", "weather"])
def test_series_stocks_and_weather_have_click_voices_of_their_own(first):
    own = ov.load_preset(first).kinds
    for second in {"series", "stocks", "weather"} - {first}:
        other = ov.load_preset(second).kinds
        assert all(own[kind].modes != other[kind].modes for kind in own)


def part_above(modes, hertz):
    """How much of a click's energy lies above a frequency, by its modes."""
    energy = np.array([10.0 ** (mode.gain_db / 10.0) * mode.decay_ms for mode in modes])
    high = np.array([mode.frequency_hz >= hertz for mode in modes])
    return float(energy[high].sum() / energy.sum())


@pytest.mark.parametrize("name", NAMES)
def test_a_phones_speaker_carries_every_presets_goal(name):
    preset = ov.load_preset(name)
    kind = preset.kinds[preset.kind_for("goal") or "default"]
    assert part_above(kind.modes, PHONE_HZ) >= 0.2


@pytest.mark.parametrize("name", NAMES)
def test_a_goal_is_heard_above_500_hz(name, match):
    preset = ov.load_preset(name)
    goals = tuple(event for event in match.events if event.kind == "goal")
    only = ov.Timeline("goals", duration_s=match.duration_s, events=goals)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "preset .* has no ", ov.OverviewWarning)
        result = ov.render(only, preset, ov.sweep(1.5), sample_rate=RATE, tail="none")
    first = round(result.strikes.of_events().time_s[0] * RATE)
    click = result.samples[first : first + round(0.1 * RATE), 0].astype(np.float64)
    power = np.abs(np.fft.rfft(click)) ** 2
    high = np.fft.rfftfreq(len(click), 1.0 / RATE) >= PHONE_HZ
    assert power[high].sum() >= 0.15 * power.sum() > 0.0


def listed(*options):
    done = overview("presets", "list", "--json", *options)
    assert done.code == 0, done.err
    return {one["name"] for one in json.loads(done.out)}


def test_presets_are_listed_by_use_and_by_scale():
    assert listed("--for", "stocks") == {"stocks"}
    assert listed("--for", "football") == {name for name in NAMES if name.startswith("football")}
    assert listed("--for", "shares") == {"series", "stocks"}
    calm = listed("--tag", "energy<2")
    assert calm == {name for name in NAMES if ov.load_preset(name).tags.energy < 2}
    assert listed("--tag", "in company", "--tag", "energy=1") == {"football-discreet"}
    assert listed("--for", "submarines") == set()
    assert "no preset matches" in overview("presets", "list", "--for", "submarines").out


@pytest.mark.parametrize("tag", ["energy=9", "size=3", "energy<", "<3"])
def test_a_tag_that_is_none_is_an_error_of_one_line(tag):
    done = overview("presets", "list", "--tag", tag)
    assert done.code == 2
    assert done.errors[0].startswith(f"error: --tag {tag!r} is not valid; allowed: a use")


def test_a_use_is_found_by_its_words(football):
    assert is_for_use(football, "Football")
    assert is_for_use(football, "matches")
    assert not is_for_use(football, "foot")
    assert has_tag(football, "tempo>2")
    assert not has_tag(football, "tempo>3")


def test_a_new_preset_names_its_schema_for_editors(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    import tomllib

    path = tmp_path / "mine.toml"
    done = overview("presets", "new", "mine", "-o", str(path))
    assert done.code == 0, done.err
    line = path.read_text().splitlines()[0]
    assert line == "#:schema ./preset.schema.json"
    schema = json.loads((tmp_path / line.removeprefix("#:schema ./")).read_text())
    jsonschema.validate(tomllib.loads(path.read_text()), schema)
    assert ov.load_preset(path).title == "mine"
