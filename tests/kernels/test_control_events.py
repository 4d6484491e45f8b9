"""Control events in the memory block: who holds the disk, when what applies, how values glide."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from overview_dsp.design.gestures import SOURCES
from overview_dsp.kernels import control_events, event_crossing, layout, release
from overview_dsp.signal.engine.queues import ControlQueues


@numba.njit
def apply_one(f64, i64, source, theta2, touching):
    control_events.apply_control(f64, i64, source, theta2, touching)


@numba.njit
def arrive(f64, i64):
    release.arrive(f64, i64)


@numba.njit
def stop_waiting(f64, i64):
    release.stop_waiting(f64, i64)


@numba.njit
def apply_pending(f64, i64):
    control_events.apply_pending(f64, i64)


@numba.njit
def next_event_time(i64):
    return control_events.next_event_time(i64)


@numba.njit
def discard_pending(i64):
    control_events.discard_pending(i64)


@numba.njit
def glide_all(f64, i64):
    return control_events.glide_all(f64, i64)


@numba.njit
def edges_below(f64, i64, slot, edges, position):
    return event_crossing.edges_below(f64, i64, slot, edges, position)


# smaller ones are the start: a test of their own
ANGLES = st.just(0.0) | st.floats(1e-150, math.pi)


class Block:
    """A memory block that has just been reset."""

    def __init__(self):
        self.f64 = np.zeros(layout.TOTAL)
        self.i64 = self.f64.view(np.int64)
        self.i64[layout.HOLDER] = -1
        stop_waiting(self.f64, self.i64)
        self.i64[layout.S_GLIDE] = 8
        self.i64[layout.S_FADE] = 5
        self.queues = ControlQueues(self.f64)

    def apply(self, clock):
        self.i64[layout.CLOCK] = clock
        apply_pending(self.f64, self.i64)

    def applied(self):
        """(sample, source, theta2, touching) of all events in the log."""
        count = self.i64[layout.APPLIED]
        return [
            (
                int(self.i64[layout.APPLIED_TIME + n]),
                int(self.i64[layout.APPLIED_SOURCE + n]),
                float(self.f64[layout.APPLIED_THETA2 + n]),
                int(self.i64[layout.APPLIED_TOUCHING + n]),
            )
            for n in range(count)
        ]


HANDS = st.lists(
    st.tuples(st.sampled_from([0, 1, len(SOURCES) - 1]), ANGLES, st.booleans()),
    max_size=40,
)


def hands(*sources):
    """Each of the sources takes hold, or lets go if it holds on already."""
    return [
        (source, 0.1 + 0.2 * n, sources[:n].count(source) % 2 == 0)
        for n, source in enumerate(sources)
    ]


@example(hands(1, 5, 0, 0, 5, 1), False)
@example(hands(0, 0, 5, 1, 0, 0, 1, 5), False)
@example(hands(0, 1, 1, 0), True)
@given(HANDS, st.booleans())
def test_the_hand_that_touched_last_of_those_that_touch_holds_the_disk(touches, returns):
    block = Block()
    f64, i64 = block.f64, block.i64
    i64[layout.S_RELEASE_RETURNS] = returns
    f64[layout.X] = -layout.CELLS  # nowhere near any target
    touching, theta2_of = [], {}  # in the order in which they took hold
    expected = 0.0
    steps = 0  # takes hold: no smoothing
    for source, theta2, on in touches:
        held = touching[-1:] == [source]
        theta2_of[source] = theta2
        takes = on and source not in touching
        if takes:
            touching.append(source)
            steps += 1
        elif not on and source in touching:
            touching.remove(source)
        f64[layout.SMOOTH_1] = f64[layout.SMOOTH_2] = -1.0
        apply_one(f64, i64, source, theta2, int(on))
        if takes or (held and touching):
            expected = theta2_of[touching[-1]]
        assert i64[layout.HOLDER] == (touching[-1] if touching else -1)
        assert f64[layout.INPUT] == pytest.approx(expected / math.pi * layout.CELLS, rel=1e-15)
        smoothed = f64[layout.INPUT] if takes else -1.0
        assert f64[layout.SMOOTH_1] == f64[layout.SMOOTH_2] == smoothed
        # the disk lies still here: after a release shaft 2 waits for it, with its last target
        assert i64[layout.ENGAGED] == (steps > 0)
        assert i64[layout.WAITING] == (steps > 0 and not touching)
    assert block.applied() == [(0, source, theta2, int(touch)) for source, theta2, touch in touches]


@pytest.mark.parametrize(
    ("given_", "used", "clamped", "rejected"),
    [
        (-1e-9, 0.0, 1, 0),
        (0.0, 0.0, 0, 0),
        (math.pi, math.pi, 0, 0),
        (math.nextafter(math.pi, 4.0), math.pi, 1, 0),
        (math.nan, 1.0, 0, 1),
        (math.inf, 1.0, 0, 1),
        (-math.inf, 1.0, 0, 1),
    ],
)
def test_an_angle_is_kept_in_the_half_turn_and_counted(given_, used, clamped, rejected):
    block = Block()
    apply_one(block.f64, block.i64, 3, 1.0, 1)
    for times in (1, 2):
        apply_one(block.f64, block.i64, 3, given_, 1)
        assert block.f64[layout.SOURCE_THETA2 + 3] == used
        assert block.f64[layout.INPUT] == pytest.approx(used / math.pi * layout.CELLS)
        assert block.i64[layout.M_CLAMPED] == times * clamped
        assert block.i64[layout.M_REJECTED] == times * rejected
    assert block.applied()[-1] == (0, 3, used, 1)


def test_the_log_of_applied_events_keeps_the_latest():
    block = Block()
    block.i64[layout.APPLIED] = layout.APPLIED_LOG + 2
    block.i64[layout.CLOCK] = 77
    apply_one(block.f64, block.i64, 4, 0.5, 1)
    assert block.i64[layout.APPLIED] == layout.APPLIED_LOG + 3
    assert block.i64[layout.APPLIED_TIME + 2] == 77
    assert block.i64[layout.APPLIED_SOURCE + 2] == 4
    assert block.f64[layout.APPLIED_THETA2 + 2] == 0.5
    assert block.i64[layout.APPLIED_TOUCHING + 2] == 1


# --- when what applies ----------------------------------------------------------------------------

FIRST, LAST = SOURCES[0], SOURCES[-1]


def test_events_apply_at_their_sample_in_the_order_of_sources_and_late_ones_are_counted():
    block = Block()
    block.queues.control(1.0, True, 10, LAST)
    block.queues.control(1.5, True, 11, LAST)
    block.queues.control(2.0, True, 10, FIRST)
    block.queues.control(2.5, True, -1, FIRST)  # as soon as possible
    block.queues.control(3.0, True, 12, FIRST)
    last = len(SOURCES) - 1
    assert next_event_time(block.i64) == 10
    block.apply(9)
    assert block.applied() == []
    block.apply(10)
    assert block.applied() == [(10, 0, 2.0, 1), (10, 0, 2.5, 1), (10, last, 1.0, 1)]
    assert block.i64[layout.M_LATE] == 0
    assert next_event_time(block.i64) == 11
    block.apply(14)
    assert block.applied()[3:] == [(14, 0, 3.0, 1), (14, last, 1.5, 1)]
    assert block.i64[layout.M_LATE] == 2
    assert next_event_time(block.i64) == control_events.NEVER
    # sample 0 is one too
    block.queues.control(1.0, True, 0, LAST)
    assert next_event_time(block.i64) == 0
    block.apply(15)
    assert block.i64[layout.M_LATE] == 3


def test_the_rings_begin_again_behind_their_ends():
    block = Block()
    source = 2
    for n in range(3 * layout.RING // 2):
        block.queues.control(n * 1e-4, True, n, SOURCES[source])
        assert next_event_time(block.i64) == n
        block.apply(n)
        assert block.f64[layout.SOURCE_THETA2 + source] == n * 1e-4
    for n in range(3 * layout.HOST_RING // 2):
        block.queues.push([(layout.C_CEILING, float(n))], n)
        assert next_event_time(block.i64) == n
        block.apply(n)
        assert block.f64[layout.TARGET + layout.C_CEILING] == n


def test_a_change_applies_at_its_sample_and_the_sample_is_kept():
    block = Block()
    first = block.queues.push([(layout.C_CEILING, 0.5)], -1)
    second = block.queues.push([(layout.C_GATE, 0.25)], 20)
    block.queues.control(1.0, True, 15, FIRST)
    assert next_event_time(block.i64) == -1
    block.apply(7)
    assert block.queues.applied_at(first) == 7
    assert block.queues.applied_at(second) is None
    assert block.f64[layout.TARGET + layout.C_GATE] == 0.0
    assert next_event_time(block.i64) == 15
    block.apply(19)
    assert next_event_time(block.i64) == 20
    block.apply(22)
    assert block.queues.applied_at(second) == 22
    assert block.f64[layout.TARGET + layout.C_GATE] == 0.25
    assert block.i64[layout.M_LATE] == 1  # changes aren't counted, hands are


def test_what_waits_is_forgotten_and_the_rings_go_on():
    block = Block()
    for source in SOURCES:
        block.queues.control(1.0, True, 5, source)
    block.queues.push([(layout.C_GATE, 0.25)], 5)
    discard_pending(block.i64)
    assert next_event_time(block.i64) == control_events.NEVER
    block.apply(5)
    assert block.applied() == []
    assert block.f64[layout.TARGET + layout.C_GATE] == 0.0
    block.queues.control(1.0, True, 6, LAST)
    assert next_event_time(block.i64) == 6


# --- what a change does ---------------------------------------------------------------------------


@pytest.mark.parametrize("column", [0, layout.C_CEILING, layout.COEFFS - 1])
def test_a_coefficient_glides_smoothly_from_where_it_is_and_arrives_exactly(column):
    block = Block()
    block.f64[column] = 3.0
    block.queues.push([(column, 0.1)], 0)
    block.apply(0)
    values = []
    for left in range(7, -1, -1):
        assert glide_all(block.f64, block.i64) == (left > 0)
        values.append(block.f64[column])
    part = np.arange(1, 8) / 8
    # flat at both ends: 3 u**2 - 2 u**3
    assert values[:-1] == pytest.approx(3.0 - 2.9 * part * part * (3.0 - 2.0 * part), rel=1e-12)
    assert values[-1] == 0.1
    assert glide_all(block.f64, block.i64) == 0
    assert block.f64[column] == 0.1
    others = np.delete(block.f64[: layout.COEFFS], column)
    assert np.all(others == 0.0)


def test_every_coefficient_that_glides_is_counted():
    block = Block()
    block.queues.push([(n, 1.0) for n in range(layout.COEFFS)], 0)
    block.apply(0)
    assert glide_all(block.f64, block.i64) == layout.COEFFS
    # turned back on its way, one glides anew from there
    for _ in range(3):
        glide_all(block.f64, block.i64)
    half = block.f64[layout.C_GATE]
    assert half == 0.5
    block.queues.push([(layout.C_GATE, 0.0)], 0)
    block.apply(4)
    gliding = [glide_all(block.f64, block.i64) for _ in range(4)]
    assert gliding == [layout.COEFFS, layout.COEFFS, layout.COEFFS, 1]
    assert block.f64[layout.C_GATE] == 0.25
    assert block.f64[layout.C_CEILING] == 1.0


@given(st.lists(st.integers(0, 20), max_size=12), st.floats(-1.0, 21.0))
def test_the_edges_below_a_position_are_found_by_bisection(positions, at):
    block = Block()
    slot = layout.SURFACES + layout.SLOT_SIZE
    block.i64[slot + layout.SLOT_EVENTS] = len(positions)
    for edges in (layout.SLOT_LOWER, layout.SLOT_UPPER):
        block.f64[slot + edges :][: len(positions)] = sorted(positions)
        for place in (at, float(round(at))):
            expected = np.searchsorted(sorted(positions), place, side="right")
            assert edges_below(block.f64, block.i64, slot, edges, place) == expected


def test_another_surface_fades_in_with_the_disk_among_its_events():
    block = Block()
    slot = layout.SURFACES + 2 * layout.SLOT_SIZE
    block.i64[slot + layout.SLOT_EVENTS] = 4
    block.f64[slot + layout.SLOT_LOWER :][:4] = [90.0, 190.0, 290.0, 390.0]
    block.f64[slot + layout.SLOT_UPPER :][:4] = [110.0, 210.0, 310.0, 410.0]
    block.i64[layout.ACTIVE_SLOT] = 1
    block.f64[layout.X] = 300.0
    block.queues.push([(layout.COMMAND_SURFACE, 2.0)], 0)
    block.apply(0)
    assert block.i64[layout.FADING_SLOT] == 1
    assert block.i64[layout.ACTIVE_SLOT] == 2
    assert block.i64[layout.FADE_LEFT] == 5
    assert block.i64[layout.NEXT_LOWER] == 3
    assert block.i64[layout.NEXT_UPPER] == 2


def test_commands_are_no_coefficients_and_what_is_neither_does_nothing():
    block = Block()
    block.queues.push([(layout.COMMAND_RELEASE_RETURNS, 1.0)], 0)
    block.apply(0)
    assert block.i64[layout.S_RELEASE_RETURNS] == 1
    block.queues.push([(layout.COMMAND_RELEASE_RETURNS, 0.0)], 0)
    block.apply(0)
    assert block.i64[layout.S_RELEASE_RETURNS] == 0
    before = block.f64[: layout.TOTAL_STATE].tobytes()
    block.queues.push([(layout.COEFFS, 1.0), (-3, 1.0)], 0)
    block.apply(0)
    assert block.f64[: layout.TOTAL_STATE].tobytes() == before


# --- where the clutch's pace begins ---------------------------------------------------------------


@pytest.mark.parametrize("returns", [False, True])
def test_a_touch_and_a_return_begin_at_the_pace_of_a_tap(returns):
    block = Block()
    f64, i64 = block.f64, block.i64
    f64[layout.C_TAP_RATE] = 0.25
    i64[layout.S_RELEASE_RETURNS] = returns
    apply_one(f64, i64, 2, 1.0, 1)
    assert f64[layout.PACE] == 0.25 * layout.CELLS
    f64[layout.PACE] = 3.0
    apply_one(f64, i64, 2, 1.5, 1)
    assert f64[layout.PACE] == 3.0  # a hand that goes on keeps its own
    apply_one(f64, i64, 2, 1.5, 0)
    assert f64[layout.PACE] == 3.0  # and so does the disk on its way to the last target
    arrive(f64, i64)
    assert f64[layout.PACE] == (0.25 * layout.CELLS if returns else 3.0)
    assert i64[layout.ENGAGED] == returns


@pytest.mark.parametrize("returns", [False, True])
@pytest.mark.parametrize("at", [0.0, 0.49, 0.4939, 0.4941, 0.5059, 0.5061, 1.0])
def test_a_release_waits_unless_the_disk_is_at_the_target(at, returns):
    block = Block()
    f64, i64 = block.f64, block.i64
    i64[layout.S_RELEASE_RETURNS] = returns
    i64[layout.S_ARRIVAL] = 120_000
    i64[layout.CLOCK] = 7
    apply_one(f64, i64, 0, math.pi / 2, 1)
    f64[layout.X] = at * layout.CELLS
    apply_one(f64, i64, 0, math.pi / 2, 0)
    arrived = abs(at - 0.5) < 0.006
    assert i64[layout.WAITING] == (not arrived)
    assert i64[layout.ENGAGED] == (not arrived or returns)
    if not arrived:
        assert i64[layout.RELEASE_DUE] == 120_007
        i64[layout.CLOCK] = 120_007
        block.apply(120_007)
        assert i64[layout.WAITING] == 0
        assert i64[layout.ENGAGED] == returns
    assert f64[layout.INPUT] == (0.0 if returns else layout.CELLS / 2)


# --- what is pushed -------------------------------------------------------------------------------


def test_an_event_is_written_as_given_until_the_ring_is_full():
    block = Block()
    f64, i64 = block.f64, block.i64
    source, ring = 3, layout.RING
    for n in range(ring):
        assert control_events.push_control(f64, i64, source, n, 0.5 * n, n % 3 == 0) is True
    at = source * ring + np.arange(ring)
    assert i64[layout.RING_TIME + at].tolist() == list(range(ring))
    assert f64[layout.RING_THETA2 + at].tolist() == [0.5 * n for n in range(ring)]
    assert i64[layout.RING_TOUCHING + at].tolist() == [int(n % 3 == 0) for n in range(ring)]
    before = f64.tobytes()
    assert control_events.push_control(f64, i64, source, ring, 1.0, True) is False
    assert f64.tobytes() == before
    i64[layout.RING_READ + source] = 1  # one is read: one more has room
    assert control_events.push_control(f64, i64, source, ring, 1.0, True) is True
    assert control_events.push_control(f64, i64, source, ring, 1.0, True) is False


@pytest.mark.parametrize("tiny", [5e-324, 2.2e-313, 1e-200])
def test_an_angle_too_small_for_the_arithmetic_is_the_start(tiny):
    block = Block()
    apply_one(block.f64, block.i64, 0, tiny, 1)
    assert block.f64[layout.SOURCE_THETA2] == 0.0
    assert block.f64[layout.INPUT] == block.f64[layout.SMOOTH_2] == 0.0
    assert block.i64[layout.M_CLAMPED] == 0
