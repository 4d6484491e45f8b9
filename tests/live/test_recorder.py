"""Record and replay: what the kernel applied gives the same samples offline, bit for bit."""

from __future__ import annotations

import json
import threading

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.live.takes.takes import Recorder
from tests.profiles import share

CONTROLS = st.lists(
    st.tuples(
        st.floats(-1.0, 4.0) | st.sampled_from([float("nan"), float("inf")]),
        st.booleans(),
        st.sampled_from(SOURCES),
    ),
    max_size=3,
)
CHANGES = st.one_of(
    st.none(),
    st.tuples(st.just("tactor.gain_db"), st.floats(-40.0, 0.0)),
    st.tuples(st.just("disk.inertia"), st.floats(1e-5, 1e-4)),
    st.tuples(st.just("disk.release"), st.sampled_from(["recoil", "return"])),
    st.tuples(st.just("kinds.goal.height"), st.floats(1.0, 100.0)),
    st.tuples(st.just("window"), st.floats(0.0, 5000.0)),
    st.tuples(st.just("preset"), st.sampled_from(["football", "series"])),
)
BLOCKS = st.lists(st.tuples(CONTROLS, CHANGES, st.integers(1, 3000)), min_size=1, max_size=25)


def play(match, preset, blocks, path):
    """Play as a live session would, as soon as possible, and record it."""
    engine = ov.Engine(preset, match)
    engine.prepare(48_000, 8192)
    recorder = Recorder(engine, path, {"title": match.title})
    sounds = []
    for controls, change, frames in blocks:
        for theta2, touching, source in controls:
            engine.control(theta2, touching, source=source)
        try:
            if change is None:
                pass
            elif change[0] == "window":
                window = (change[1], change[1] + 300.0)
                engine.set_timeline(match.window(*window), window=window)
            elif change[0] == "preset":
                engine.set_preset(ov.load_preset(change[1]))
            else:
                engine.set(*change)
        except ov.InputError:
            pass  # the series preset has no goal
        except ov.OverviewError:
            pass  # two surfaces fade already
        sounds.append(np.empty((frames, 2), dtype=np.float32))
        engine.process(sounds[-1])
        recorder.poll()
    recorder.close()
    return np.concatenate(sounds)


@given(BLOCKS)
@settings(
    max_examples=share(0.6),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
def test_a_recorded_take_replays_bit_for_bit(match, football, tmp_path, blocks):
    path = tmp_path / "take.csv"
    heard = play(match, football, blocks, path)
    replayed = ov.render(match, football, ov.load_gesture(path), tail=1.0, trace=False).samples
    assert np.array_equal(replayed[: len(heard)], heard)


def recorded(match, football, tmp_path):
    path = tmp_path / "take.csv"
    blocks = [([(1.0, True, "touch")], ("tactor.gain_db", -6.0), 4800), ([], None, 48)]
    play(match, football, blocks, path)
    return path


def test_a_take_says_where_each_event_was_and_the_json_beside_what_changed(
    match, football, tmp_path
):
    path = recorded(match, football, tmp_path)
    lines = path.read_text().splitlines()
    assert lines[0] == "time_s,theta2_rad,touching,sample,sample_rate,source"
    assert lines[1] == "0.0,1.0,1,0,48000.0,touch"
    assert lines[2] == "0.101,1.0,1,4848,48000.0,touch"
    beside = json.loads(path.with_suffix(".json").read_text())
    assert beside["changes"] == [{"sample": 0, "set": {"tactor.gain_db": -6.0}}]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "take.json with the parameter changes of this recorded take is missing"),
        ("{", "take.json: broken JSON"),
        ("[]", "take.json: not a take's changes"),
        ('{"overview_take": 2, "sample_rate": 0}', "sample_rate is 0"),
        ('{"overview_take": 2, "sample_rate": 48000, "changes": 3}', "changes must be a list"),
        (
            '{"overview_take": 2, "sample_rate": 48000, "changes": [{"sample": 1}]}',
            r"changes\[0\] must be one of",
        ),
        (
            '{"overview_take": 2, "sample_rate": 48000, "changes": [{"sample": -1, "set": {}}]}',
            r"changes\[0\].sample is -1",
        ),
    ],
)
def test_a_take_without_its_changes_is_refused_in_one_line(match, football, tmp_path, text, words):
    path = recorded(match, football, tmp_path)
    beside = path.with_suffix(".json")
    beside.unlink()
    if text is not None:
        beside.write_text(text)
    with pytest.raises(ov.InputError, match=words):
        ov.load_gesture(path)


def test_a_change_that_does_not_fit_is_refused_in_one_line(match, football, tmp_path):
    path = recorded(match, football, tmp_path)
    beside = path.with_suffix(".json")
    document = json.loads(beside.read_text())
    for what in ({"set": {"no.such": 1}}, {"set": 3}, {"window": [5]}, {"preset": {"name": 1}}):
        beside.write_text(json.dumps({**document, "changes": [{"sample": 5, **what}]}))
        with pytest.raises(ov.InputError):
            ov.render(match, football, ov.load_gesture(path))


def test_a_disk_that_hangs_does_not_hold_the_end_of_a_session(match, football, tmp_path):
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 8192)
    recorder = Recorder(engine, tmp_path / "take.csv", {"title": match.title})
    hangs, goes_on = threading.Event(), threading.Event()

    def write():
        hangs.set()
        goes_on.wait(60.0)

    recorder._write = write
    recorder.start()
    assert hangs.wait(30.0)
    with pytest.raises(ov.OutputError, match=r"take.csv: the disk doesn't respond"):
        recorder.close()
    goes_on.set()
    del recorder._write
    recorder.close()  # the disk is back
    assert ov.load_gesture(tmp_path / "take.csv").duration_s == 0.0
