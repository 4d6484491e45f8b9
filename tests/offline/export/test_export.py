"""A gesture baked to each format: valid, near to what was felt, its goals kept."""

from __future__ import annotations

import itertools
import json
from functools import cache
from xml.etree import ElementTree

import jsonschema
import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.errors import InputError
from overview_dsp.offline.export.clip import clip_of
from overview_dsp.offline.export.writing import export
from tests.offline.export import schemas

SCHEMAS = {
    ".ahap": schemas.AHAP,
    ".haptic": schemas.HAPTIC,
    ".hjif": schemas.HJIF,
    ".json": schemas.ANDROID,
}
GESTURES = {
    "sweep": ov.sweep(4.0),
    "fast": ov.sweep(1.0),
    "tap": ov.tap(0.8, 1.5),
    "long": ov.sweep(90.0),
}


@pytest.fixture(scope="module", params=list(GESTURES))
def result(request, match, football):
    return ov.render(match, football, GESTURES[request.param])


@pytest.fixture(scope="module")
def exported(result, tmp_path_factory):
    """What an export of a gesture gave, which is made once in each format."""
    folder = tmp_path_factory.mktemp("exported")

    @cache
    def made(to):
        return export(result, to, folder / f"clip.{'json' if to == 'android' else to}")

    return made


def goal_times(result):
    kinds = np.array([result.engine.timeline.events[e].kind for e in result.strikes.event])
    return result.strikes.time_s[np.isin(kinds, ("goal", "own_goal"))]


@pytest.mark.parametrize("to", [to for to in ov.export.formats() if to != "wav4"])
def test_every_document_is_valid_and_near_to_what_was_felt(exported, to):
    done = exported(to)
    for path in done.files:
        if path.suffix in SCHEMAS:
            jsonschema.validate(json.loads(path.read_text()), SCHEMAS[path.suffix])
    assert done.error is not None
    assert done.error.median_db <= 1.5
    assert done.error.within_percent >= 90.0


def test_every_goal_is_a_transient_at_its_strike(result, exported):
    ahap = exported("ahap").files
    strikes = json.loads(ahap[1].read_text())["Pattern"]
    haptic = json.loads(exported("haptic").files[0].read_text())
    points = haptic["signals"]["continuous"]["envelopes"]["amplitude"]
    hjif = json.loads(exported("hjif").files[0].read_text())
    waves = hjif["perceptions"][0]["channels"][1]["bands"][0]["effects"]
    found = {
        "ahap": np.array([entry["Event"]["Time"] for entry in strikes]),
        "haptic": np.array([point["time"] for point in points if "emphasis" in point]),
        "hjif": np.array([wave["position"] / 1000.0 for wave in waves]),
    }
    goals = goal_times(result)
    assert len(goals) >= 6
    felt = goals[goals < clip_of(result).duration_s]
    for times in found.values():
        for goal in felt:
            assert np.abs(times - goal).min() <= 0.005


def test_ahap_splits_at_30_seconds_and_counts_curve_times_from_the_curve(result, exported):
    vibration = json.loads(exported("ahap").files[0].read_text())["Pattern"]
    events = [entry["Event"] for entry in vibration if "Event" in entry]
    curves = [entry["ParameterCurve"] for entry in vibration if "ParameterCurve" in entry]
    length = clip_of(result).duration_s
    assert len(events) == len(curves) == max(1, int(np.ceil(length / 30.0)))
    for event, following in itertools.pairwise(events):
        assert following["Time"] == pytest.approx(event["Time"] + event["EventDuration"])
    assert events[-1]["Time"] + events[-1]["EventDuration"] == pytest.approx(length)
    for event, curve in zip(events, curves, strict=True):
        times = [point["Time"] for point in curve["ParameterCurveControlPoints"]]
        assert curve["Time"] == event["Time"]
        assert times[0] == 0.0
        assert times == sorted(set(times))
        assert times[-1] == pytest.approx(event["EventDuration"])


def test_a_haptic_clip_begins_at_0_and_emphasis_is_above_the_envelope(exported):
    path = exported("haptic").files[0]
    envelopes = json.loads(path.read_text())["signals"]["continuous"]["envelopes"]
    amplitude, frequency = envelopes["amplitude"], envelopes["frequency"]
    assert amplitude[0]["time"] == frequency[0]["time"] == 0.0
    times = [point["time"] for point in amplitude]
    assert all(a < b for a, b in itertools.pairwise(times))
    assert frequency[-1]["time"] <= times[-1]
    emphases = [point for point in amplitude if "emphasis" in point]
    assert emphases
    assert all(point["emphasis"]["amplitude"] >= point["amplitude"] for point in emphases)


def test_hjif_carries_the_friction_itself(result, exported):
    path = exported("hjif").files[0]
    friction = json.loads(path.read_text())["perceptions"][1]
    assert friction["perception_modality"] == "Friction"
    frames = friction["channels"][0]["bands"][0]["effects"][0]["keyframes"]
    at = np.array([frame["relative_position"] for frame in frames])
    value = np.array([frame["amplitude_modulation"] for frame in frames])
    assert (at[0], at[-1]) == (0, 18_000)
    surface = result.engine.surface
    phi = np.radians(np.arange(0, 18_001, 7) / 100.0)
    told = np.interp(np.degrees(phi) * 100.0, at, value) * surface.friction.max()
    true = surface.friction_at(phi)
    # a tick is four cells, and steep flanks of goals lie between ticks
    near = np.abs(20.0 * np.log10(told / true)) <= 1.5
    assert near.mean() >= 0.97
    assert 0.9 <= value.max() <= 1.0


def test_android_never_stops_inside_the_clip_and_its_xml_says_the_same(result, exported):
    done = exported("android")
    document = json.loads(done.files[0].read_text())
    timings, amplitudes = document["waveform"]["timings"], document["waveform"]["amplitudes"]
    assert len(timings) == len(amplitudes)
    assert all(t % 10 == 0 for t in timings[:-1])
    length_ms = len(clip_of(result).level) - 1
    assert sum(timings) == length_ms
    root = ElementTree.parse(done.files[1]).getroot()
    assert root.tag == "vibration-effect"
    entries = root.findall("./waveform-effect/waveform-entry")
    assert [int(entry.get("durationMs")) for entry in entries] == timings
    assert [int(entry.get("amplitude")) for entry in entries] == amplitudes
    for effect, following in itertools.pairwise(document["envelopeEffects"]):
        assert following["startMs"] == effect["startMs"] + sum(
            point["durationMs"] for point in effect["controlPoints"]
        )
    assert all(e["controlPoints"][-1]["amplitude"] == 0.0 for e in document["envelopeEffects"])


def test_four_channels_are_clicks_and_vibration(result, tmp_path):
    export(result, "wav4", tmp_path / "clip.wav")
    samples, rate = soundfile.read(tmp_path / "clip.wav", dtype="float32")
    assert (samples.shape[1], rate) == (4, 48_000)
    for channel, source in enumerate((0, 0, 1, 1)):
        np.testing.assert_allclose(
            samples[:, channel], result.samples[:, source], atol=3.0 / 32768.0
        )


def test_more_points_are_nearer(match, football, tmp_path):
    result = ov.render(match, football, ov.sweep(2.0))
    errors = [
        export(result, "haptic", tmp_path / "clip.haptic", points).error.median_db
        for points in (5.0, 20.0, 80.0)
    ]
    assert errors[0] > errors[1] > errors[2]


def test_an_invalid_export_is_an_error_of_one_line(match, football, tmp_path):
    still = ov.render(match, football, ov.pause(0.5))
    with pytest.raises(InputError, match="the gesture has no vibration"):
        export(still, "ahap", tmp_path / "x.ahap")
    with pytest.raises(InputError, match="one of ahap, haptic, hjif, android, wav4"):
        export(still, "mp3", tmp_path / "x.mp3")
    bare = ov.render(match, football, ov.tap(0.5), trace=False)
    with pytest.raises(InputError, match="trace"):
        export(bare, "ahap", tmp_path / "x.ahap")
    assert list(tmp_path.iterdir()) == []


def test_a_part_can_be_exported(tmp_path, monkeypatch):
    from tests.cli.running import overview

    monkeypatch.chdir(tmp_path)
    for name, options in (("a", ("--window", "goal:2-45", "goal:2+5")), ("b", ())):
        outcome = overview(
            *("export", "world-cup-final-2018", "--gesture", "sweep:0.5", "--to", "wav4"),
            *(*options, "-o", f"{name}.wav"),
        )
        assert outcome.code == 0, outcome.err
    assert (tmp_path / "a.wav").read_bytes() != (tmp_path / "b.wav").read_bytes()
    refused = overview(*("export", "world-cup-final-2018", "--to", "wav4", "--zoom-to", "dog:1"))
    assert refused.code == 2
    assert refused.errors[0].startswith("error: --zoom-to: the timeline has no event of kind 'dog'")
