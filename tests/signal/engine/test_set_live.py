"""What is set while it plays is heard as if it had been so from the start."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.design.presets.parameters import PARAMETERS
from tests.signal.engine.test_engine import prepared, run

RATE = 8000
GESTURE = ov.sweep(0.3, 0.0, 0.7)
BEFORE = 0.2
AFTER = 1.2
OF_SURFACE = [id for id in PARAMETERS if id.startswith("surface.")]


def other_value(parameter):
    """A value of a parameter that is far from its own."""
    if parameter.choices:
        return next(one for one in parameter.choices if one != parameter.default)
    return (
        parameter.high
        if parameter.default < 0.5 * (parameter.low + parameter.high)
        else (parameter.low)
    )


def base(id):
    """A preset in which more of the surface's parameters are heard."""
    preset = ov.load_preset("football")
    pattern = next(one for one in PARAMETERS["surface.pattern"].choices if one != "none")
    for needed, value in (("surface.pattern", pattern), ("surface.pattern_height", 3.0)):
        if needed != id:
            preset = preset.with_value(needed, value)
    return preset


def played(engine, at=BEFORE):
    """Its sound and trace: nothing for a while, then a gesture."""
    stamps = GESTURE.stamps(RATE) + round(at * RATE)
    engine.control_all(GESTURE.theta2, GESTURE.touching, stamps, GESTURE.source)
    samples, trace = run(engine, round((at + AFTER) * RATE))
    return samples[round(at * RATE) :], trace[round(at * RATE) :]


@pytest.mark.filterwarnings("ignore:surface.torque_ratio holds the disk")
@pytest.mark.parametrize("model", PARAMETERS["surface.model"].choices)
def test_every_parameter_of_the_surface_set_live_is_that_surface(model, match):
    heard_of = set()
    for id in OF_SURFACE:
        if id == "surface.model":
            continue
        preset = base(id).with_value("surface.model", model)
        value = other_value(PARAMETERS[id])
        engine = prepared(preset, match, RATE)
        engine.set(id, value)
        samples, trace = played(engine)
        wanted, wanted_trace = played(prepared(preset.with_value(id, value), match, RATE))
        if model == "detent":  # a pull at rest moves the disk a little while the surfaces fade
            assert np.abs(trace[:, 5] - wanted_trace[:, 5]).max() < 2e-3, id
        else:
            assert np.array_equal(trace[:, 3:8], wanted_trace[:, 3:8]), id
            assert np.abs(samples - wanted).max() < 1e-3, id
        unchanged, _ = played(prepared(preset, match, RATE))
        if not np.array_equal(wanted, unchanged):
            heard_of.add(id)
    assert {"surface.friction", "surface.intensity_gain"} <= heard_of


def test_how_the_disk_is_released_may_be_set_while_it_is_held(match, football):
    """It counts when the hand lets go: shaft 2 stays, or leaves."""

    def released(*choices):
        engine = prepared(football.with_value("disk.release", choices[0]), match, RATE)
        engine.control(2.0, True)
        run(engine, RATE)
        for choice in choices[1:]:
            engine.set("disk.release", choice)
        run(engine, 3 * RATE)
        engine.control(2.0, False)
        return run(engine, RATE)[1]

    recoil, back = released("recoil"), released("return")
    engaged = 9
    assert not recoil[100:, engaged].any()
    assert back[100:, engaged].all()
    assert not np.array_equal(recoil[:, 3], back[:, 3])
    for choices, wanted in (
        (("recoil", "return"), back),
        (("return", "recoil"), recoil),
        (("recoil", "return", "recoil"), recoil),
    ):
        assert np.array_equal(released(*choices)[:, :7], wanted[:, :7]), choices


# --- hands ----------------------------------------------------------------------------------------


def touch(engine, source, theta2, touching=True):
    engine.control(theta2, touching, source=source)
    run(engine, 64)


def test_of_many_hands_the_last_to_touch_is_the_heir(match, football):
    engine = prepared(football, match, RATE)
    order = ["midi", "touch", "serial", "remote", "twist", "osc"]
    assert sorted(order) == sorted(SOURCES)
    for number, source in enumerate(order):
        touch(engine, source, 0.1 * number)
        assert engine.active_input == (source, 0.1 * number)
    # one that moves while another holds takes nothing, but is heir where it is now
    touch(engine, "twist", 3.0)
    assert engine.active_input == ("osc", 0.5)
    # one that lets go while another holds is no heir any more
    touch(engine, "remote", 0.3, False)
    touch(engine, "osc", 0.5, False)
    assert engine.active_input == ("twist", 3.0)
    # touching again is touching last
    touch(engine, "midi", 0.0, False)
    touch(engine, "midi", 1.0)
    assert engine.active_input == ("midi", 1.0)
    for source, heir in (("midi", "twist"), ("twist", "serial"), ("serial", "touch")):
        touch(engine, source, 0.0, False)
        assert engine.active_input[0] == heir
        assert engine.meters.touching
    touch(engine, "touch", 0.0, False)
    assert engine.active_input is None
    assert not engine.meters.touching


def test_three_hands_at_one_sample_are_taken_in_the_order_of_sources(match, football):
    for first in range(3):
        engine = prepared(football, match, RATE)
        hands = ["touch", "serial", "remote"]
        for source in hands[first:] + hands[:first]:  # in whatever order they were written
            engine.control(1.0, True, sample_time=50, source=source)
        run(engine, 100)
        assert engine.active_input[0] == "remote"
        for source, heir in (("remote", "serial"), ("serial", "touch")):
            touch(engine, source, 1.0, False)
            assert engine.active_input[0] == heir


def test_an_heir_takes_the_disk_from_where_it_is_without_a_step(match, football):
    # without the clutch the trace has the hand's own angle
    engine = prepared(football.with_changes({"clutch.max_speed_ratio": 0.0}), match, RATE)
    touch(engine, "touch", 0.5)
    touch(engine, "twist", 2.0)
    run(engine, 2 * RATE)
    engine.control(2.0, False, source="twist")
    _, trace = run(engine, RATE)
    steps = np.abs(np.diff(trace[:, 1]))
    assert steps.max() < 0.1  # the hand's angle glides; a touch would be a step of 1.5 rad
    assert trace[-1, 1] == pytest.approx(0.5, abs=1e-3)
