"""Public objects in a console or a failed test: a line or two, never all of their data."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import overview_dsp as ov

LONGEST = 200
FACES = (ov, ov.actuators, ov.export, ov.live, ov.measure, ov.presets)
# opened with a device, in tests/live
NEEDS_A_DEVICE = {"OutputStream"}


def public_classes():
    return {
        name: getattr(face, name)
        for face in FACES
        for name in face.__all__
        if inspect.isclass(getattr(face, name))
        and not issubclass(getattr(face, name), BaseException)
    }


@pytest.fixture(scope="module")
def objects(match, football, tmp_path_factory):
    """Objects of every public class, made of the bundled data."""
    folder = tmp_path_factory.mktemp("written")
    gesture = ov.sweep(0.5) + ov.tap(0.7, 0.2)
    result = ov.render(match, football, gesture, sample_rate=8000)
    engine = result.engine
    job = ov.RenderJob(match, football, ov.tap(0.5, 0.1))
    (rendered,) = ov.render_many([job], sample_rate=8000, tail="none", threads=1)
    report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, sample_rate=8000)
    felt = ov.measure.felt_events(football, [match], {"fast": ov.sweep(1.0)}, sample_rate=8000)
    arm = ov.measure.arm_report(football, [match], {"arm 1 s": ov.arm(1.0)})
    shown = ov.measure.perceptual_features(
        football, match, {"fast": ov.sweep(1.0)}, sample_rate=8000
    )
    asked = ov.measure.observe(
        football, modalities=["touch"], movement="mixed", learned=2, held_out=1
    )
    (scores,) = asked.sets
    c2 = ov.load_actuator("c2")
    exported = ov.export.export(result, "ahap", folder / ("long-name" * 9 + ".ahap"))
    clip = ov.export.read_clip(exported.files[0])
    builder = ov.CurveBuilder()
    builder.append(np.arange(100.0))
    stream = ov.live.NullStream(engine)
    to_file = ov.render_to_file(match, football, ov.tap(0.5, 0.1), folder / "a.wav", 8000)
    other = football.with_changes({"surface.friction": 6e-4})
    made = [
        *(match, match.events[3], match.intensity, football, football.tags, gesture, result),
        *(result.trace, result.strikes, engine, engine.meters, engine.surface, job, rendered),
        *(asked, scores, scores.strokes["mixed"]["touch"], scores.strokes["mixed"]["touch"].kinds),
        *(report, report.strokes[0], report.strokes[0].kinds[0], c2, builder, to_file),
        *(arm, arm.strokes[0], *felt, *shown.values()),
        *(exported, exported.error, clip, ov.live.OutputSettings(actuator=c2), stream),
        *(stream.meters, ov.live.SignalSettings(3, gain_db=-6.0), ov.RegularTimes(1000, 0.001)),
        ov.LiveTimeline("A name as long as titles are, and longer still"),
        *football.kinds.values(),
        *football.kinds["goal"].modes,
        *ov.presets.PARAMETERS.values(),
        *ov.actuators.PARAMETERS.values(),
        *engine.parameters.values(),
        *(ov.load_preset(name) for name in ov.bundled_presets()),
        *ov.presets.differences(football, other),
        ov.actuators.ActuatorStage(c2, 8000),
        ov.actuators.ProtectionReport(1.23456789, 12),
        ov.actuators.ResonanceFit(251.23456, 11.8, 0.2, 0.41, *np.zeros((3, 500))),
        ov.export.Transient(1.0 / 3.0, 2.0 / 3.0, 1.0 / 7.0, "near_miss"),
        ov.live.OutputDevice(3, "A name as long as drivers give", "ALSA", 2, 48e3, 1 / 97, True),
        ov.measure.onsets(result.samples[:, 0], 8000),
        ov.measure.strokes(result.trace.touching, result.trace.cursor)[0],
        ov.measure.TuningResult(football, 2.1234567890123, True),
    ]
    return made


def test_every_public_class_is_looked_at(objects):
    assert {type(made).__name__ for made in objects} | NEEDS_A_DEVICE == set(public_classes())


def test_every_repr_is_a_line_or_two(objects):
    for made in objects:
        text = repr(made)
        assert len(text) < LONGEST, text
        assert "\n" not in text
        assert type(made).__name__ in text
        assert " at 0x" not in text


def test_a_long_title_is_shortened(match):
    timeline = ov.Timeline("word " * 1000, 10.0, match.events[:1])
    assert len(repr(timeline)) < LONGEST
    assert len(repr(ov.RenderJob(timeline, ov.load_preset("plain"), ov.tap(0.5)))) < LONGEST


def test_equality_and_hash_are_those_of_the_fields():
    goal = ov.load_preset("football").kinds["goal"]
    same = ov.load_preset("football").kinds["goal"]
    assert goal == same
    assert hash(goal) == hash(same)
    match, again = ov.load_timeline("made-up-share"), ov.load_timeline("made-up-share")
    assert match == again
    assert hash(match.intensity) == hash(again.intensity)
    assert match != ov.Timeline(match.title, match.duration_s, match.events)


def test_an_event_kind_shows_what_differs_from_the_defaults():
    kind = ov.EventKind(height=4.0, width_percent=2.0)
    assert repr(kind) == "EventKind(height=4.0, width_percent=2.0)"
