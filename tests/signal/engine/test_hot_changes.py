"""Changes while it sounds: no parameter and no surface may click."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.kernels import layout
from overview_dsp.kernels.derive import FADE_S
from overview_dsp.offline.rendering.trace import Trace
from tests.examples import plain_preset, preset_with, timeline_of

RATE = 48_000
AT = RATE  # the sample of the change
HIGH = butter(4, 2000.0, "high", fs=RATE, output="sos")
FLAT = ov.Timeline("flat", 100.0, (), ov.Intensity(np.array([0.0, 100.0]), np.array([0.5, 0.5])))
FULL = ov.Timeline("full", 100.0, (), ov.Intensity(np.array([0.0, 100.0]), np.array([1.0, 1.0])))


def played(preset, change):
    """A steady pull over a flat surface, changed after a second; float64 (frames, 2)."""
    engine = ov.Engine(preset, FLAT)
    engine.prepare(RATE, 480)
    gesture = ov.sweep(2.0)
    for stamp, theta2 in zip(gesture.stamps(RATE), gesture.theta2, strict=True):
        engine.control(float(theta2), True, int(stamp))
    blocks = []
    while engine.sample_time < 1.5 * RATE:
        if engine.sample_time == AT:
            change(engine)
        block = np.zeros((480, 2), dtype=np.float32)
        engine.process(block)
        blocks.append(block.astype(np.float64))
    return np.concatenate(blocks)


def added_click(sound):
    """How far what is above 2 kHz at the change exceeds that before and after, of the signal."""
    high = np.abs(sosfilt(HIGH, sound, axis=0))
    steady = np.maximum(
        high[AT - 4800 : AT].max(axis=0), high[AT + 12_000 : AT + 21_600].max(axis=0)
    )
    there = high[AT : AT + 4800].max(axis=0)
    signal = np.abs(sound[AT - 4800 :]).max(axis=0)
    return (there - steady) / np.maximum(signal, 1e-9)


NUMBERS = [
    (known.id, value)
    for known in PARAMETERS.values()
    for value in ((known.low, known.high) if not known.choices else known.choices)
    if not (known.id == "tactor.frequency_hz" and value >= 0.45 * RATE)
]


@pytest.mark.parametrize(("id", "value"), NUMBERS)
@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
def test_a_full_range_change_of_any_parameter_adds_no_click(football, id, value):
    # clicks of the surface's grain would hide one: it is turned off
    quiet = football.with_changes({"texture.gain_db": PARAMETERS["texture.gain_db"].low})
    sound = played(quiet, lambda engine: engine.set(id, value))
    assert added_click(sound)[1] <= 1e-3
    assert np.abs(sound).max() <= 1.0


def test_swapping_surface_preset_and_data_adds_no_click(football):
    other = football.with_changes({"tactor.gain_db": -20.0, "disk.inertia": 5e-5})
    for change in (
        lambda engine: engine.set_timeline(FULL),
        lambda engine: engine.set_surface(ov.build_surface(FULL, football)),
        lambda engine: engine.set_preset(other),
    ):
        assert added_click(played(football, change))[1] <= 1e-3


def test_a_hard_switch_would_be_heard_as_a_click(football):
    """The measure itself: muting without a glide fails it."""
    sound = played(football, lambda engine: None)
    sound[AT + 55 :] = 0.0
    assert added_click(sound)[1] > 1e-3


def held(preset):
    """An engine whose disk has been held for a second."""
    engine = ov.Engine(preset, timeline_of())
    engine.prepare(RATE, RATE)
    engine.control(2.0, True)
    trace_of(engine)
    return engine


def trace_of(engine, frames=RATE):
    table = np.zeros((frames, layout.TRACE))
    engine.process(np.zeros((frames, 2), dtype=np.float32), table)
    return Trace(table)


@pytest.mark.parametrize(
    ("id", "value", "times"), [("surface.friction", 4e-3, 4.0), ("kinds.default.height", 2.0, 3.0)]
)
def test_a_surface_set_while_it_sounds_is_under_the_disk_after_its_fade(id, value, times):
    preset = preset_with(height=0.0, width=20.0, shape="plateau", surface__friction=1e-3)
    engine = ov.Engine(preset, timeline_of(50.0))
    engine.prepare(RATE, RATE)
    engine.control(0.5 * np.pi, True)
    before = trace_of(engine).friction
    assert np.all(before == 1e-3)
    engine.set(id, value, sample_time=RATE + 100)
    friction = trace_of(engine).friction
    fade = round(FADE_S * RATE)
    assert np.all(friction[:100] == 1e-3)
    assert np.all(np.diff(friction[100 : 100 + fade]) >= 0.0)
    assert friction[100 + fade :] == pytest.approx(times * 1e-3, rel=1e-6)


@pytest.mark.parametrize(("before", "after"), [("recoil", "return"), ("return", "recoil")])
def test_a_release_set_while_it_sounds_is_that_of_a_preset_that_has_it(before, after):
    engine = held(plain_preset(disk__release=before))
    engine.set("disk.release", after)
    direct = held(plain_preset(disk__release=after))
    traces = []
    for one in (engine, direct):
        one.control(2.0, False)
        traces.append(trace_of(one))
    # letting go, "return" keeps the shaft and takes it back; "recoil" takes it away
    assert np.all(traces[0].engaged[1:] == (after == "return"))
    for name in traces[0]:
        assert np.array_equal(traces[0][name], traces[1][name])


def test_what_cannot_be_swapped_changes_nothing(football):
    engine = ov.Engine(football, FLAT)
    engine.prepare(RATE, 480)
    engine.set_timeline(FULL)
    engine.set_timeline(FLAT)
    before = (engine.surface, engine.preset, engine.timeline)
    with pytest.raises(ov.OverviewError, match="two surfaces"):
        engine.set_preset(football.with_changes({"tactor.gain_db": -20.0}))
    assert (engine.surface, engine.preset, engine.timeline) == before
