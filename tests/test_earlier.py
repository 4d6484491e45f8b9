"""Files that version 0.1.0 wrote load, and mean what they meant (tests/earlier/README.md)."""

from __future__ import annotations

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from tests.cli.running import overview

EARLIER = Path(__file__).parent / "earlier" / "0.1.0"
RATE = 8_000


def named(folder, pattern):
    found = sorted((EARLIER / folder).glob(pattern))
    assert found
    return pytest.mark.parametrize("path", found, ids=lambda path: path.name)


@named("takes", "*.csv")
def test_a_take_of_an_earlier_version_replays_by_the_present_release_rule(match, football, path):
    with pytest.warns(
        ov.OverviewWarning, match="of an older version, in which a release let"
    ) as noted:
        gesture = ov.load_gesture(path)
    assert len(noted) == 1
    assert "\n" not in str(noted[0].message)
    result = ov.render(match, football, gesture, sample_rate=RATE)
    assert np.abs(result.samples).max(axis=0).min() > 0.0
    trace = result.trace
    disengages = np.flatnonzero(np.diff(trace.engaged) < 0.0)
    # the disk is where the hand was before it is released
    assert len(disengages)
    latest = np.searchsorted(gesture.time_s, trace.time[disengages], side="right") - 1
    targets = gesture.theta2[latest] / math.pi
    assert trace.cursor[disengages] == pytest.approx(targets, abs=0.008)
    assert not trace.touching[disengages + 1].any()


def test_the_command_line_says_so_in_one_line(tmp_path):
    take = EARLIER / "takes" / "sweep-and-tap.csv"
    done = overview(
        "render", "world-cup-final-2018", "--gesture", take, "--sample-rate", RATE,
        "-o", tmp_path / "take.wav",
    )  # fmt: skip
    assert done.code == 0
    assert [line[:6] for line in done.err.splitlines() if "older version" in line] == ["note: "]


def test_a_take_that_is_recorded_now_has_the_version_and_the_angle_map(match, football, tmp_path):
    from overview_dsp.live.takes.takes import Recorder

    mapped = football.with_values(surface__angle_map=0.7)
    engine = ov.Engine(mapped, match)
    engine.prepare(RATE, 256)
    recorder = Recorder(engine, tmp_path / "take.csv", {})
    engine.control(1.0, True, 0)
    engine.process(np.zeros((256, 2), np.float32))
    recorder.close()
    beside = json.loads((tmp_path / "take.json").read_text())
    assert beside["overview_take"] == 2
    assert beside["angle_map"] == 0.7
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ov.load_gesture(tmp_path / "take.csv")


@named("states", "*.engine.json")
def test_a_state_of_an_earlier_version_keeps_how_fast_a_tap_unfolds(match, path):
    engine = ov.Engine(ov.load_preset("plain"), match)
    engine.load_state(path.read_bytes())
    old, now = json.loads(path.read_text())["values"], engine.preset.values
    assert now["clutch.max_speed_ratio"] == old["disk.catch_up"] == 1.1
    # a tap took unfold_s / catch_up
    assert now["clutch.tap_duration_s"] == pytest.approx(old["disk.unfold_s"] / 1.1)
    assert old["disk.unfold_s"] == (2.1 if path.name.startswith("football") else 2.0)
    assert now["tactor.gain_db"] == -7.5
    assert now["disk.k2"] == 0.0051
    assert engine.seed == 3
    again = ov.Engine(ov.load_preset("plain"), match)
    again.load_state(engine.save_state())
    assert dict(again.preset.values) == dict(now)


@named("presets", "*.toml")
def test_a_preset_of_an_earlier_version_loads_and_renders(match, path):
    preset = ov.load_preset(path)
    text = path.read_text()
    if "catch_up = " in text:
        ratio, tap_s = (
            float(text.split(f"{key} = ")[1].split()[0]) for key in ("catch_up", "unfold_s")
        )
        assert preset.values["clutch.max_speed_ratio"] == ratio
        assert preset.values["clutch.tap_duration_s"] == pytest.approx(tap_s / (ratio or 1.0))
    result = ov.render(match, preset, ov.tap(0.5), sample_rate=RATE, trace=False, tail=0.5)
    assert np.abs(result.samples).max() > 0.0


RENAMED = {
    "surface.ambience": ("surface.intensity_gain", 1.5),
    "surface.grip": ("surface.torque_ratio", 4.0),
    "surface.ring": ("surface.decay_scale", 0.5),
    "tactor.full_torque_mnm": ("tactor.reference_torque_mnm", 70.0),
    "click.full_torque_mnm": ("click.reference_torque_mnm", 60.0),
    "twist.turn_deg": ("twist.engage_deg", 7.0),
    "twist.join_ms": ("twist.blend_ms", 90.0),
    "follow.map": ("follow.layout", "whole"),
}
"""Parameters of preset schema 3 that have another name in schema 4, with a value of each."""


def test_a_preset_of_schema_3_loads_with_the_names_of_schema_4(tmp_path):
    lines = ["schema = 3", 'title = "t"', 'description = "d"']
    for id, (_, value) in RENAMED.items():
        section, key = id.split(".")
        lines += [] if f"[{section}]" in lines else [f"[{section}]"]
        lines.append(f"{key} = {json.dumps(value)}")
    kind = "height = 4\nwidth_percent = 1\n"
    lines += ["[kinds.default]", kind, "[kinds.goal]", kind, 'also = ["shot"]\nring = 0.2\n']
    path = tmp_path / "schema3.toml"
    path.write_text("\n".join(lines))
    preset = ov.load_preset(path)
    for id, value in RENAMED.values():
        assert preset.values[id] == value
    assert preset.kind_for("shot") == "goal"
    assert preset.kinds["goal"].decay_scale == 0.2
    # a name of schema 3 is unknown in a file of schema 4
    path.write_text("\n".join(lines).replace("schema = 3", "schema = 4"))
    with pytest.raises(ov.InputError, match=r"schema3\.toml:\d+: unknown key kinds\.goal\.also"):
        ov.load_preset(path)


def test_states_and_takes_with_the_names_of_schema_3_load(match, football):
    from overview_dsp.signal.engine.replay import apply_change

    engine = ov.Engine(football, match)
    state = json.loads(engine.save_state())
    for earlier, (now, value) in RENAMED.items():
        del state["values"][now]
        state["values"][earlier] = value
    for kind in state["kinds"].values():
        kind["also"], kind["ring"] = kind.pop("aliases"), kind.pop("decay_scale")
    engine.load_state(json.dumps(state).encode())
    assert engine.preset.kinds == football.kinds
    for id, value in RENAMED.values():
        assert engine.preset.values[id] == value
    engine.prepare(RATE, 256)
    apply_change(engine, match, {"set": {"tactor.full_torque_mnm": 33.0}})
    assert engine.preset.values["tactor.reference_torque_mnm"] == 33.0
    del state["values"], state["overview_state"]
    apply_change(engine, match, {"preset": {**state, "values": {"surface.ambience": 2.5}}})
    assert engine.preset.values["surface.intensity_gain"] == 2.5
