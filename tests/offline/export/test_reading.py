"""Haptic clips read back: our own as written, others' by the formats' rules, broken ones."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.validation import parse_preset
from overview_dsp.design.presets.writing import preset_toml
from overview_dsp.errors import InputError
from overview_dsp.offline.export import ahap
from overview_dsp.offline.export.clip import clip_of, perceptual_error
from overview_dsp.offline.export.reading import amplitude_profile, modes, read_clip, with_layer
from overview_dsp.offline.export.writing import export


@pytest.fixture(scope="module")
def result(match, football):
    return ov.render(match, football, ov.sweep(3.0))


def write(folder, document, name="clip.json"):
    path = folder / name
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def continuous(*events, curve=()):
    pattern = [
        {
            "Event": {
                "EventType": "HapticContinuous",
                "Time": start,
                "EventDuration": length,
                "EventParameters": [
                    {"ParameterID": "HapticIntensity", "ParameterValue": intensity}
                ],
            }
        }
        for start, length, intensity in events
    ]
    if curve:
        start, points = curve
        pattern.append(
            {
                "ParameterCurve": {
                    "ParameterID": "HapticIntensityControl",
                    "Time": start,
                    "ParameterCurveControlPoints": [
                        {"Time": time, "ParameterValue": value} for time, value in points
                    ],
                }
            }
        )
    return {"Version": 1.0, "Pattern": pattern}


def test_an_exported_clip_comes_back_as_it_was(result, tmp_path):
    files = export(result, "ahap", tmp_path / "clip.ahap").files
    level = clip_of(result).level
    assert perceptual_error(read_clip(files[0]).level, level).median_db < 0.8
    strikes = read_clip(files[1]).transients
    told = clip_of(result).transients
    assert len(strikes) == len(told)
    np.testing.assert_allclose(
        [strike.amplitude for strike in strikes], [strike.amplitude for strike in told], atol=1e-3
    )
    haptic = read_clip(export(result, "haptic", tmp_path / "clip.haptic").files[0])
    assert perceptual_error(haptic.level, level).median_db < 0.8
    assert len(haptic.transients) == len(told)


def test_curve_times_count_from_the_curve_and_intensity_multiplies(tmp_path):
    document = continuous((0.5, 1.0, 0.8), curve=(1.0, [(0.0, 1.0), (0.5, 0.5)]))
    level = read_clip(write(tmp_path, document)).level
    assert level[100] == 0.0
    assert level[700] == pytest.approx(0.64)
    assert level[1000] == pytest.approx(0.64)
    assert level[1250] == pytest.approx((0.8 * 0.75) ** 2)
    assert level[1500] == pytest.approx(0.16)


def test_a_clip_becomes_a_friction_profile(tmp_path, match, football):
    rising = read_clip(
        write(tmp_path, continuous((0.0, 1.0, 1.0), curve=(0.0, [(0.0, 0.0), (1.0, 1.0)])))
    )
    points = amplitude_profile(rising)
    assert points[-1] == 1.0
    assert list(points) == sorted(points)
    football = football.with_values(surface__angle_map=0.0)
    layered = with_layer(football, "goal", rising, "tactor")
    assert layered.kinds["goal"].modes == football.kinds["goal"].modes
    surface = ov.build_surface(match, layered)
    goal = surface.position_of(match.event("goal", 1).time_s)
    width = football.kinds["goal"].width_percent / 100.0
    before, after = (surface.friction_at(np.pi * (goal + part * width)) for part in (-0.5, 0.5))
    assert after > 2.0 * before
    again = parse_preset(preset_toml(layered), "x", "x.toml")
    assert again.kinds["goal"].points == points


def test_strikes_become_modes_sharp_ones_high(tmp_path):
    document = {
        "Version": 1.0,
        "Pattern": [
            {
                "Event": {
                    "EventType": "HapticTransient",
                    "Time": time,
                    "EventParameters": [
                        {"ParameterID": "HapticIntensity", "ParameterValue": intensity},
                        {"ParameterID": "HapticSharpness", "ParameterValue": sharpness},
                    ],
                }
            }
            for time, intensity, sharpness in ((0.0, 1.0, 0.0), (0.1, 0.5, 1.0))
        ],
    }
    dull, sharp = modes(read_clip(write(tmp_path, document)))
    assert (dull.frequency_hz, sharp.frequency_hz) == (100.0, 6400.0)
    assert dull.decay_ms > sharp.decay_ms
    assert (dull.gain_db, sharp.gain_db) == (0.0, pytest.approx(-12.0, abs=0.1))


GOOD = continuous((0.0, 1.0, 1.0), curve=(0.0, [(0.0, 0.0), (1.0, 1.0)]))


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ("", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[]", "must be AHAP"),
        ({"Pattern": 3}, "Pattern = 3 is not a list"),
        ({"Pattern": [3]}, r"Pattern\[0\] = 3 is not an object"),
        ({"Pattern": []}, "has no vibration"),
        (
            continuous((-1.0, 1.0, 1.0)),
            r"Pattern\[0\].Event.Time = -1.0 is out of range",
        ),
        (
            continuous((0.0, 1e9, 1.0)),
            "EventDuration = 1000000000.0 .*; must be 0 to 600 s",
        ),
        (
            continuous((0.0, 1.0, 7.0)),
            r"Parameters\[0\].ParameterValue = 7.0 .*; must be 0 to 1",
        ),
        ({"signals": {}}, "signals.continuous is missing"),
        (
            {"signals": {"continuous": {"envelopes": {"amplitude": []}}}},
            "amplitude: List should have at least 2 items",
        ),
    ],
)
def test_a_broken_clip_is_an_error_of_one_line(tmp_path, document, words):
    with pytest.raises(InputError, match=words) as caught:
        read_clip(write(tmp_path, document))
    assert "\n" not in str(caught.value)


def test_a_reader_accepts_missing_keys_that_players_do_not_need_and_a_check_names_them(tmp_path):
    lenient = continuous((0.0, 1.0, 0.8))
    event = lenient["Pattern"][0]["Event"]
    event["EventParameters"].append({"ParameterID": "Warmth", "ParameterValue": 9.0})
    event["Comment"] = "soft"
    sound = {"EventType": "AudioCustom", "Time": 0.2, "EventWaveformPath": 3}
    lenient["Pattern"] += [{"Event": sound}, {"Event": {"EventType": "Smell", "Time": 0.0}}]
    lenient["Pattern"] += [{"Parameter": {"ParameterID": "x", "Time": 0.0, "ParameterValue": 7.0}}]
    lenient["Pattern"] += [{"Comment": "nothing"}]
    lenient |= {"Version": 7, "Metadata": 3}
    path = write(tmp_path, lenient)
    assert read_clip(path).level == pytest.approx(np.full(1001, 0.64))
    faults = "\n".join(ov.export.check_clip(path))
    for words in ("Warmth", "Comment", "Version", "Metadata", "Smell", "EventWaveformPath"):
        assert words in faults
    haptic = json.loads(json.dumps(HAPTIC))
    del haptic["version"], haptic["signals"]["continuous"]["envelopes"]["frequency"]
    haptic["signals"]["continuous"]["envelopes"]["amplitude"][1]["note"] = "strong"
    path = write(tmp_path, haptic)
    assert read_clip(path).transients[0].amplitude == 0.9
    assert {"version is missing", "metadata is missing"} <= set(ov.export.check_clip(path))


@pytest.mark.parametrize(
    ("damage", "fault"),
    [
        ({"ParameterID": "Warmth"}, "EventParameters[0].ParameterID = 'Warmth' is not allowed"),
        ({"ParameterValue": 1.5}, "EventParameters[0].ParameterValue = 1.5 is out of range"),
        ({"ParameterValue": None}, "EventParameters[0]: ParameterValue is null"),
        ({"Value": 1.0}, "unknown key Pattern[0].Event.EventParameters[0].Value"),
    ],
)
def test_a_check_names_the_location_of_a_fault(tmp_path, damage, fault):
    document = continuous((0.0, 1.0, 1.0))
    document["Pattern"][0]["Event"]["EventParameters"][0] |= damage
    (line,) = ov.export.check_clip(write(tmp_path, document))
    assert fault in line


def test_garbage_is_refused_in_one_line(tmp_path):
    path = tmp_path / "x.ahap"
    for seed in range(3):
        path.write_bytes(np.random.default_rng(seed).bytes(1_000_000))
        with pytest.raises(InputError, match="not JSON"):
            read_clip(path)
        preset = tmp_path / "x.toml"
        preset.write_bytes(path.read_bytes())
        with pytest.raises(InputError) as caught:
            ov.load_preset(preset)
        assert "\n" not in str(caught.value)


LEAVES = st.none() | st.booleans() | st.floats() | st.text(max_size=3) | st.integers()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_change_of_a_clip_is_read_or_one_line(tmp_path, data):
    document = json.loads(json.dumps(data.draw(st.sampled_from([GOOD, HAPTIC]))))
    for _ in range(data.draw(st.integers(1, 3))):
        node = document
        while True:
            keys = list(node) if isinstance(node, dict) else list(range(len(node)))
            key = data.draw(st.sampled_from(keys))
            if isinstance(node[key], dict | list) and node[key] and data.draw(st.booleans()):
                node = node[key]
                continue
            node[key] = data.draw(LEAVES | st.just([]) | st.just({}))
            break
    caught = None
    try:
        read_clip(write(tmp_path, document))
    except InputError as error:
        caught = error
    assert caught is None or "\n" not in str(caught)


HAPTIC = {
    "version": {"major": 1, "minor": 0, "patch": 0},
    "signals": {
        "continuous": {
            "envelopes": {
                "amplitude": [
                    {"time": 0.0, "amplitude": 0.0},
                    {
                        "time": 0.5,
                        "amplitude": 0.5,
                        "emphasis": {"amplitude": 0.9, "frequency": 0.3},
                    },
                    {"time": 1.0, "amplitude": 0.0},
                ],
                "frequency": [],
            }
        }
    },
}


def test_a_single_transient_is_a_clip(tmp_path, football):
    document = {
        "Version": 1.0,
        "Pattern": [
            {
                "Event": {
                    "EventType": "HapticTransient",
                    "Time": 0.0,
                    "EventParameters": [
                        {"ParameterID": "HapticIntensity", "ParameterValue": 0.8},
                        {"ParameterID": "HapticSharpness", "ParameterValue": 0.4},
                    ],
                }
            }
        ],
    }
    clip = read_clip(write(tmp_path, document))
    assert clip.played[1:-1] == pytest.approx(0.64)
    assert len(clip.played) == 13  # a half at both ends
    layered = with_layer(football, "goal", clip, "both").kinds["goal"]
    assert set(layered.points[8:-8]) == {1.0}
    assert len(layered.modes) == 1


@pytest.mark.parametrize("gesture", [ov.sweep(3.0), ov.tap(0.8, 1.5)], ids=["sweep", "tap"])
@pytest.mark.parametrize("to", ["ahap", "haptic", "hjif"])
def test_what_was_exported_comes_back_within_a_step(match, football, tmp_path, gesture, to):
    result = ov.render(match, football, gesture)
    clip = clip_of(result)
    for path in export(result, to, tmp_path / f"clip.{to}").files:
        back = read_clip(path)
        error = perceptual_error(back.played, clip.level)
        assert error.median_db <= 0.5
        assert error.within_percent >= 90.0
        assert len(back.transients) == len(clip.transients)
        for one, other in zip(back.transients, clip.transients, strict=True):
            assert abs(one.time_s - other.time_s) <= 0.005
            assert one.amplitude == pytest.approx(other.amplitude, rel=0.01)


def test_a_folder_is_read_by_the_names_of_its_clips(tmp_path, result):
    from tests.cli.running import overview

    folder = tmp_path / "clips"
    folder.mkdir()
    export(result, "ahap", folder / "goal.ahap")
    export(result, "haptic", folder / "foul.haptic")
    (folder / "notes.txt").write_text("none")
    out = tmp_path / "made.toml"
    done = overview("presets", "import", str(folder), "-o", str(out))
    assert done.code == 0, done.err
    made = ov.load_preset(out)
    for kind in ("goal", "foul"):
        assert len(made.kinds[kind].points) == 64
    refused = overview("presets", "import", str(folder), "--as", "goal", "-o", str(out))
    assert refused.code == 2
    assert "2 clips for one kind" in refused.errors[0]
    (folder / "foul.haptic").unlink()
    done = overview("presets", "import", str(folder), "--as", "red_card", "-o", str(out))
    assert done.code == 0, done.err
    assert len(ov.load_preset(out).kinds["red_card"].points) == 64
    for empty in (tmp_path / "empty", tmp_path / "nowhere.ahap"):
        refused = overview("presets", "import", str(empty), "-o", str(out))
        assert refused.code == 2
        assert len(refused.errors) == 1


def test_200_mutated_clips_are_refused_in_one_line(tmp_path, result):
    """Each is damaged where it matters: a value that no device could play, or a missing one."""
    files = [*export(result, "ahap", tmp_path / "c.ahap").files]
    files += export(result, "haptic", tmp_path / "c.haptic").files
    documents = [json.loads(path.read_text()) for path in files]
    rng = np.random.default_rng(0)
    keys = ("Time", "ParameterValue", "time", "amplitude", "EventDuration", "frequency")
    bad = (-1.0, 1e9, "1", None, True, [], {}, float("nan"))
    for _ in range(200):
        document = json.loads(json.dumps(documents[rng.integers(len(documents))]))
        spots = [
            (node, key)
            for node in walked(document)
            if isinstance(node, dict)
            for key in keys
            if key in node and not isinstance(node[key], list)
        ]
        node, key = spots[rng.integers(len(spots))]
        node[key] = bad[rng.integers(len(bad))]
        path = write(tmp_path, document, "mutated.json")
        with pytest.raises(InputError) as caught:
            read_clip(path)
        assert "\n" not in str(caught.value)


def walked(node):
    yield node
    for inner in (
        node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()
    ):
        yield from walked(inner)


def test_before_its_first_point_a_curve_leaves_a_vibration_as_it_is():
    pattern = levels_of(continuous((0.0, 1.0, 1.0), curve=(0.5, [(0.0, 0.2), (0.5, 0.2)])))
    assert pattern[400] == 1.0
    assert pattern[600] == pytest.approx(0.04)


def levels_of(document):
    level, _ = ahap.decoded(ahap.Ahap.model_validate(document))
    return level


@pytest.mark.parametrize("suffix", ["json", "xml"])
def test_an_android_waveform_is_read_from_json_and_xml(match, football, tmp_path, suffix):
    result = ov.render(match, football, ov.sweep(1.0))
    clip = clip_of(result)
    files = {one.suffix: one for one in export(result, "android", tmp_path / "clip.json").files}
    back = read_clip(files[f".{suffix}"])
    assert back.transients == ()
    error = perceptual_error(back.played, clip.level, clip.transients)
    assert error.median_db <= 1.0
    made = with_layer(football, "goal", back, "both").kinds["goal"]
    assert max(made.points) == 1.0
    assert made.modes == football.kinds["goal"].modes


def note(start, gain=1.0, keyframes=()):
    effect = {"m_type": 0}
    if keyframes:
        frames = [{"m_time": time, "m_value": value} for time, value in keyframes]
        effect = {"m_amplitudeModulation": {"m_extrapolationStrategy": 0, "m_keyframes": frames}}
    return {"m_startingPoint": start, "m_length": 0.022, "m_gain": gain, "m_hapticEffect": effect}


def haps(*melodies, gain=1.0):
    empty = {"m_loop": 0, "m_maximum": 1.0, "m_gain": 1.0, "m_signalEvaluationMethod": 3}
    listed = [{"m_mute": 0, "m_gain": 1.0, "m_notes": list(notes)} for notes in melodies]
    return {
        "m_version": "5",
        "m_description": "",
        "m_HDFlag": 0,
        "m_time_unit": 0,
        "m_length_unit": 7,
        "m_gain": gain,
        "m_stiffness": empty | {"m_melodies": []},
        "m_texture": empty | {"m_melodies": []},
        "m_vibration": empty | {"m_melodies": listed},
    }


def test_haps_has_curves_transients_and_gains_that_multiply(tmp_path):
    document = haps(
        [note(0.1, 0.5), note(0.3)], [note(0.2, 0.5, [(0.0, 0.0), (0.4, 1.0)])], gain=0.8
    )
    path = tmp_path / "clip.haps"
    path.write_text(json.dumps(document))
    assert ov.export.check_clip(path) == []
    clip = read_clip(path)
    assert [(one.time_s, one.amplitude) for one in clip.transients] == [(0.1, 0.4), (0.3, 0.8)]
    assert len(clip.level) == 601
    assert clip.level[[100, 200, 400, 600]] == pytest.approx([0.0, 0.0, 0.2, 0.4])
    document["m_vibration"]["m_melodies"][1]["m_mute"] = 1
    path.write_text(json.dumps(document))
    assert not read_clip(path).level.any()


def test_an_hjif_of_short_and_long_waves_and_transients(tmp_path, match, football):
    result = ov.render(match, football, ov.sweep(0.5))
    path = export(result, "hjif", tmp_path / "clip.hjif").files[0]
    document = json.loads(path.read_text())
    band = {
        "band_type": "Transient",
        "lower_frequency_limit": 50,
        "upper_frequency_limit": 500,
        "block_length": 16,
        "effects": [
            {
                "effect_type": "Basis",
                "position": 100,
                "keyframes": [{"relative_position": 0, "amplitude_modulation": 0.7}],
            }
        ],
    }
    document["perceptions"][0]["channels"] = [
        {**document["perceptions"][0]["channels"][0], "frequency_sampling": 8000, "bands": [band]}
    ]
    path.write_text(json.dumps(document))
    clip = read_clip(path)
    assert [(one.time_s, one.amplitude) for one in clip.transients] == [(0.1, 0.7)]
    assert not clip.level.any()
    assert clip.played[[99, 101, 121]] == pytest.approx([0.0, 0.7, 0.7])
    band["effects"][0]["position"] = 10**9
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"lasts 1e\+06 s; at most 600 s are allowed"):
        read_clip(path)
