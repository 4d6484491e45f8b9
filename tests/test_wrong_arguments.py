"""Whatever a program gives to a public function: an answer, or a line that says what is wrong."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter

import overview_dsp as ov

WRONG: dict[str, Any] = {
    "None": None,
    "a word": "x",
    "a decimal comma": "1,5",
    "bytes": b"x",
    "below 0": -1,
    "not a number": float("nan"),
    "endless": float("inf"),
    "hundreds of digits": 10**400,
    "a list": [],
    "mixed": [1, "a", None],
    "no values": np.zeros(0),
    "a table": np.zeros((2, 3)),
    "words": np.array(["a"]),
    "an object": object(),
    "complex": 1j,
    "a mapping": {},
}


def right() -> dict[str, tuple[Any, dict[str, Any]]]:
    """Functions, and arguments that each of them takes."""
    match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    result = ov.render(match, football, "tap:0.2:0.05", 8000, tail="none")
    trace, tactor, surface = result.trace, result.samples[:, 1], result.engine.surface
    report = ov.measure.feel_report(football, match, {"fast": ov.sweep(0.3)}, 8000, recoils=False)
    kind = report.strokes[0].kinds[0]
    c2 = ov.load_actuator("c2")
    sweep = ov.actuators.log_sweep(50, 1000, 4, level_db=-9, sample_rate=8000)
    moved = lfilter(*bilinear([1.0, 0.0, 0.0], [1.0, 150.0, 1.44e6], 8000), sweep)
    engine = ov.Engine(football, match)
    engine.prepare(8000, 256)
    two = np.arange(2.0)
    sources = np.zeros(2, np.int8)
    m, p = ov.measure, ov.presets
    return {
        "sweep": (ov.sweep, {"seconds": 1.0, "start": 0.0, "end": 1.0}),
        "tap": (ov.tap, {"position": 0.5, "hold_seconds": 0.1}),
        "arm": (ov.arm, {"seconds": 1.0, "rest_s": 0.1}),
        "flick": (ov.flick, {"seconds": 0.3}),
        "scrub": (ov.scrub, {"position": 0.5, "width": 0.1, "hz": 2.0, "seconds": 1.0}),
        "pause": (ov.pause, {"seconds": 1.0}),
        "parse_gesture": (ov.parse_gesture, {"spec": "sweep:1"}),
        "save_gesture": (ov.save_gesture, {"gesture": ov.tap(0.5), "path": "take.csv"}),
        "load_gesture": (ov.load_gesture, {"path": "take.csv"}),
        "save_timeline": (ov.save_timeline, {"timeline": match, "path": "match.json"}),
        "load_preset": (ov.load_preset, {"name": "football"}),
        "load_actuator": (ov.load_actuator, {"name": "c2"}),
        "load_timeline": (
            ov.load_timeline,
            {"data": [1.0, 3.0, 2.0], "rate": 1.0, "value": None, "map": "level", "max_mb": 1.0},
        ),
        "Event": (ov.Event, {"time_s": 1.0, "kind": "goal", "label": "", "weight": 1.0}),
        "Intensity": (ov.Intensity, {"time_s": two, "value": two, "unit": "m"}),
        "RegularTimes": (ov.RegularTimes, {"count": 4, "step_s": 1.0, "first_s": 0.0}),
        "Timeline": (
            ov.Timeline,
            {
                "title": "",
                "duration_s": 9.0,
                "events": (ov.Event(1.0, "goal"),),
                "intensity": ov.Intensity(two, two),
            },
        ),
        "Gesture": (
            ov.Gesture,
            {"time_s": two, "theta2": two, "touching": two > 9.0, "duration_s": 2.0},
        ),
        "event": (match.event, {"kind": "goal", "number": 1}),
        "window": (match.window, {"start_s": 1.0, "end_s": 9.0}),
        "intensity_at": (match.intensity_at, {"times": two}),
        "build_surface": (ov.build_surface, {"timeline": match, "preset": football}),
        "Engine": (
            ov.Engine,
            {"preset": football, "timeline": match, "seed": 0, "surface": surface},
        ),
        "prepare": (
            lambda **given: ov.Engine(football, match, surface=surface).prepare(**given),
            {"sample_rate": 8000, "max_block_size": 64},
        ),
        "control": (
            functools.partial(engine.control, touching=True),
            {"theta2": 1.0, "sample_time": None, "source": "touch"},
        ),
        "control_all": (
            engine.control_all,
            {"theta2": two, "touching": two > 0, "sample_times": two, "sources": sources},
        ),
        "set": (engine.set, {"id": "tactor.gain_db", "value": -6.0, "sample_time": None}),
        "set_surface": (engine.set_surface, {"surface": surface, "sample_time": None}),
        "process": (engine.process, {"out": np.zeros((9, 2), np.float32)}),
        "load_state": (engine.load_state, {"state": engine.save_state()}),
        "pop_applied": (engine.pop_applied, {"since": 0}),
        "render": (
            ov.render,
            {
                "timeline": match,
                "preset": football,
                "gesture": "tap:0.2:0.05",
                "sample_rate": 8000,
                "seed": 0,
                "tail": "none",
                "actuator": None,
            },
        ),
        "render_to_file": (
            ov.render_to_file,
            {
                "timeline": match,
                "preset": football,
                "gesture": "tap:0.2:0.05",
                "path": "tap.wav",
                "sample_rate": 8000,
                "tail": "none",
                "subtype": None,
                "trace_path": None,
                "normalize": None,
            },
        ),
        "render_jobs": (
            lambda **given: list(ov.render_jobs(**given)),
            {"timelines": [match], "presets": [football], "gestures": [ov.tap(0.5)], "seeds": [0]},
        ),
        "morph": (p.morph, {"first": football, "second": football, "steps": 2}),
        "differences": (p.differences, {"first": football, "second": football}),
        "randomize": (p.randomize, {"preset": football, "seed": 1, "amount": 0.1}),
        "save": (p.save, {"preset": football, "path": "mine.toml"}),
        "window_db": (m.window_db, {"signal": tactor, "sample_rate": 8000, "hop_s": 0.005}),
        "strokes": (m.strokes, {"engaged": trace.engaged, "cursor": trace.cursor}),
        "onsets": (m.onsets, {"signal": tactor, "sample_rate": 8000, "floor_db": -90.0}),
        "event_levels": (
            m.event_levels,
            {"surface": surface, "columns": trace, "tactor": tactor, "sample_rate": 8000},
        ),
        "feel_report": (
            m.feel_report,
            {
                "preset": football,
                "timelines": match,
                "gestures": {"fast": ov.tap(0.2, 0.05)},
                "sample_rate": 8000,
            },
        ),
        "felt_events": (
            m.felt_events,
            {
                "preset": football,
                "timelines": [match],
                "gestures": {"fast": ov.tap(0.2, 0.05)},
                "sample_rate": 8000,
            },
        ),
        "stroke": (report.stroke, {"name": "fast"}),
        "jnd_distance": (m.jnd_distance, {"first": kind, "second": kind}),
        "character_distance": (m.character_distance, {"first": report, "second": report}),
        "random_movement": (m.random_movement, {"seed": 1}),
        "random_match": (m.random_match, {"seed": 1}),
        "random_events": (m.random_events, {"kinds": ["bell"], "seed": 1}),
        "ActuatorStage": (ov.actuators.ActuatorStage, {"actuator": c2, "sample_rate": 8000}),
        "log_sweep": (
            ov.actuators.log_sweep,
            {"low_hz": 100, "high_hz": 400, "seconds": 1, "level_db": -20, "sample_rate": 8000},
        ),
        "fit_resonance": (
            ov.actuators.fit_resonance,
            {
                "recording": moved,
                "sample_rate": 8000,
                "low_hz": 50,
                "high_hz": 1000,
                "seconds": 4,
            },
        ),
        "export": (
            ov.export.export,
            {"result": result, "to": "haptic", "path": "tap.haptic", "points_per_s": 50},
        ),
        "read_clip": (ov.export.read_clip, {"path": "tap.haptic"}),
        "encode_engine": (ov.export.encode_engine, {"engine": engine}),
        "export_board": (
            ov.export.export_board,
            {"timeline": match, "preset": football, "folder": "board", "seed": 0},
        ),
        "NullStream": (ov.live.NullStream, {"engine": engine, "block_size": 64}),
    }


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def fault(function, arguments):
    """What a call with these arguments raises that is no line for a person; empty if nothing."""
    try:
        function(**arguments)
    except ov.OverviewError as error:
        line = str(error)
        return line if line.count("\n") > 1 or len(line) > 600 else ""
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
def test_wrong_arguments_are_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    faults = []
    for name, (function, arguments) in right().items():
        function(**arguments)
        for which in arguments:
            for what, value in WRONG.items():
                if found := fault(function, {**arguments, which: value}):
                    faults.append(f"{name}({which}={what}): {found}")
    assert not faults, "\n".join(faults)
