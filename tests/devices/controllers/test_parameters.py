"""Parameters from controllers: by id, and picked up without a jump."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.controllers.control_map import Control
from overview_dsp.devices.controllers.control_messages import (
    ScaleParameter,
    SoftTakeover,
    find_parameter,
    require_parameters,
    scaled_value,
)

GAIN = "tactor.gain_db"


def dialled(preset, part, pick_up, id=GAIN):
    """What a control at `part` sets, and the preset after it."""
    value = pick_up.value(preset, ScaleParameter(id, part))
    return value, preset if value is None else preset.with_changes({id: value})


def test_a_control_acts_once_it_has_reached_the_parameter(football):
    known, _ = find_parameter(football, GAIN)
    preset = football.with_changes({GAIN: known.low + 0.5 * (known.high - known.low)})
    pick_up = SoftTakeover()
    for part in (0.1, 0.2, 0.4):
        value, preset = dialled(preset, part, pick_up)
        assert value is None
    value, preset = dialled(preset, 0.6, pick_up)
    assert value == pytest.approx(known.low + 0.6 * (known.high - known.low))
    value, preset = dialled(preset, 0.1, pick_up)
    assert value == pytest.approx(known.low + 0.1 * (known.high - known.low))
    # set elsewhere: it has to be met again
    preset = preset.with_changes({GAIN: known.high})
    assert dialled(preset, 0.2, pick_up)[0] is None
    assert dialled(preset, 0.99, pick_up)[0] is not None


@given(st.lists(st.floats(0.0, 1.0), max_size=30), st.floats(0.0, 1.0))
def test_it_never_jumps_by_more_than_the_control_was_moved(parts, start):
    football = ov.load_preset("football")
    known, _ = find_parameter(football, GAIN)
    span = known.high - known.low
    preset = football.with_changes({GAIN: known.low + start * span})
    pick_up, before = SoftTakeover(), None
    for part in parts:
        present = preset.values[GAIN]
        value, preset = dialled(preset, part, pick_up)
        if value is not None:
            moved = 1.0 / 64.0 if before is None else max(abs(part - before), 1.0 / 64.0)
            assert abs(value - present) / span <= moved + 1e-9
        before = part


def test_a_control_reaches_both_ends_of_linear_log_and_choice_parameters(football):
    for id in (GAIN, "tactor.frequency_hz", "kinds.goal.height"):
        known, _ = find_parameter(football, id)
        assert scaled_value(known, ScaleParameter(id, 0.0)) == pytest.approx(known.low)
        assert scaled_value(known, ScaleParameter(id, 1.0)) == pytest.approx(known.high)
        known.check(scaled_value(known, ScaleParameter(id, 0.5)))
    known, _ = find_parameter(football, "disk.release")
    assert [scaled_value(known, ScaleParameter("", part)) for part in (0.0, 1.0)] == list(
        known.choices
    )
    known, _ = find_parameter(football, GAIN)
    assert scaled_value(known, ScaleParameter(GAIN, 0.25, -8.0, 0.0)) == -6.0


@pytest.mark.parametrize(
    ("control", "words"),
    [
        (Control("cc", 1, to="tactor.gian_db"), ("cc 1", "tactor.gain_db")),
        (Control("cc", 1, to="kinds.no_such.height"), ("cc 1", "kinds.no_such")),
        (Control("cc", 1, to=GAIN, high=1000.0), ("cc 1", GAIN, "range")),
    ],
)
def test_a_control_without_a_parameter_or_beyond_its_range_is_refused(football, control, words):
    with pytest.raises(ov.InputError) as caught:
        require_parameters((control,), football)
    for word in words:
        assert word in str(caught.value)


def test_valid_controls_are_accepted(football):
    require_parameters((Control("bend"), Control("cc", 7, to="kinds.goal.height")), football)
