"""What the bundled presets promise: kinds that a finger distinguishes, presets that differ."""

from __future__ import annotations

import itertools
import json
import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.batch.grid import KEY_DIGITS, preset_digest
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets import library
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.measure.arm import arm_report
from overview_dsp.measure.pictures import pages
from overview_dsp.measure.report import character_distance, feel_report
from tests.design.presets.strategies import values
from tests.parameters import first_in_gate

NAMES = ov.bundled_presets()
ASKED = {
    "stadium": "football-stadium",
    "discreet": "football-discreet",
    "training": "football-training",
    "stocks": "stocks",
    "weather": "weather",
    "heart": "heart",
    "safe's dial": "safe-dial",
    "clock key": "clock-key",
    "gravel": "gravel",
    "silk": "silk",
    "creaking door": "creaking-door",
    "ratchet": "ratchet",
}
RATE = 16_000.0
"""The disk and its vibration are the same at any rate."""

SWEEPS = {f"{seconds:g} s": sweep(seconds) for seconds in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0)}
CLOSE = {"level_db": 0.2, "event_free_db": 0.2, "contrast_db": 0.2, "click_db": 0.2}
CLOSE_RATIO = 0.05


def test_there_is_a_preset_for_every_required_character():
    assert set(ASKED.values()) <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_header_and_tags_of_each_preset_describe_its_feel_and_purpose(name):
    preset = ov.load_preset(name)
    scales = preset.tags.energy, preset.tags.roughness, preset.tags.tempo, preset.tags.pleasantness
    assert all(scale is not None for scale in scales)
    assert preset.tags.usage
    header = (library.LIBRARY.bundled_folder / f"{name}.toml").read_text(encoding="utf-8")
    for words in ("# Feels like: ", "# Sounds like: ", "# For: "):
        assert words in header


@pytest.mark.parametrize("name", NAMES)
def test_all_kinds_differ_and_none_is_masked_or_merged_in_sweeps_of_1_to_6_seconds(name):
    preset = ov.load_preset(name)
    report = feel_report(preset, pages(preset), SWEEPS, RATE)
    for seconds in SWEEPS:
        stroke = report.stroke(seconds)
        assert stroke.indistinct == (), seconds
        assert sum(kind.masked + kind.merged for kind in stroke.kinds) == 0, seconds
        assert {kind.kind for kind in stroke.kinds if kind.passed} == set(preset.kinds), seconds


@pytest.mark.parametrize("data", first_in_gate(["world-cup-final-2018", "made-up-share"]))
def test_a_finger_feels_any_two_presets_two_steps_apart_on_one_timeline(data):
    timeline = ov.load_timeline(data)
    with warnings.catch_warnings():
        # kinds of other data are felt as the default
        warnings.filterwarnings("ignore", "preset .* has no ", ov.OverviewWarning)
        reports, touched = {}, {}
        for name in NAMES:
            preset = ov.load_preset(name)
            reports[name] = feel_report(preset, timeline, sample_rate=RATE)
            features = ov.measure.perceptual_features(preset, timeline, sample_rate=RATE)
            touched[name] = {
                stroke: replace(one, brightness_hz=math.nan, decay_ms=math.nan)
                for stroke, one in features.items()
            }
    steps = {
        (first, second): max(
            character_distance(reports[first], reports[second]),
            ov.measure.level_matched_distance(touched[first], touched[second]),
        )
        for first, second in itertools.combinations(NAMES, 2)
    }
    assert {pair: round(found, 2) for pair, found in steps.items() if found < 2.0} == {}


def differences(committed, now, path=""):
    """Where two reports differ by more than rounding."""
    if isinstance(committed, dict):
        if committed.keys() != now.keys():
            return [f"{path}: {sorted(committed.keys() ^ now.keys())}"]
        return [
            d for key in committed for d in differences(committed[key], now[key], f"{path}.{key}")
        ]
    if isinstance(committed, list):
        if len(committed) != len(now):
            return [f"{path}: {len(committed)} and {len(now)}"]
        return [
            d
            for i, pair in enumerate(zip(committed, now, strict=True))
            for d in differences(*pair, f"{path}[{i}]")
        ]
    if isinstance(committed, float) and isinstance(now, float):
        absolute = CLOSE.get(path.rsplit(".", 1)[-1], 0.0)
        same = math.isclose(committed, now, rel_tol=CLOSE_RATIO, abs_tol=max(absolute, 1e-3))
        return [] if same else [f"{path}: {committed} and {now}"]
    return [] if committed == now else [f"{path}: {committed!r} and {now!r}"]


@pytest.mark.parametrize("name", NAMES)
def test_the_committed_feel_report_is_up_to_date(name):
    """`python tools/measure_presets.py` writes them anew."""
    path = library.LIBRARY.bundled_folder / "feel" / f"{name}.json"
    preset = ov.load_preset(name)
    now = feel_report(preset, pages(preset)).to_json()
    committed = json.loads(path.read_text(encoding="utf-8"))
    # what an observer tells apart takes too long to be found again here; its preset is known
    asked = preset_digest(preset)[:KEY_DIGITS]
    assert committed.pop("observer", {"preset_digest": asked})["preset_digest"] == asked
    assert committed["preset"] == name
    if "arm" in committed:
        now["arm"] = arm_report(preset, pages(preset)).to_json()
    assert differences(committed, now) == []


@st.composite
def changed(draw):
    preset = ov.load_preset(draw(st.sampled_from(NAMES)))
    ids = draw(st.lists(st.sampled_from(sorted(PARAMETERS)), unique=True, max_size=8))
    return replace(
        preset, values={**preset.values, **{id: draw(values(PARAMETERS[id])) for id in ids}}
    )


@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
@given(changed(), st.floats(0.05, 1.0))
def test_no_parameter_makes_a_preset_exceed_its_ceiling_or_give_nan(preset, seconds):
    timeline = ov.Timeline(
        "", 10.0, tuple(ov.Event(0.5 + i / 2.0, kind) for i, kind in enumerate(preset.kinds))
    )
    result = ov.render(timeline, preset, sweep(seconds), 8000.0)
    assert np.isfinite(result.samples).all()
    ceiling = 10.0 ** (preset.number("output.ceiling_db") / 20.0)
    assert np.abs(result.samples).max() <= np.float32(ceiling)
