"""The rings between the control thread and the audio thread: capacity, order, free slots."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.kernels import layout
from overview_dsp.kernels.control_events import push_control
from overview_dsp.signal.engine import queues as engine_queues
from overview_dsp.signal.engine.queues import ControlQueues, stamp_of

RINGS = range(len(SOURCES))


def block():
    memory = np.zeros(layout.TOTAL)
    return ControlQueues(memory), memory, memory.view(np.int64)


def passed(words, events):
    """Let each ring have had so many events, all read by now."""
    for ring in RINGS:
        words[layout.RING_WRITTEN + ring] = words[layout.RING_READ + ring] = events + 100 * ring


def waiting(memory, words, ring):
    """(stamp, theta2, touching) of the events that wait in a ring, in order."""
    first, end = words[layout.RING_READ + ring], words[layout.RING_WRITTEN + ring]
    at = ring * layout.RING + np.arange(first, end) % layout.RING
    return list(
        zip(
            words[layout.RING_TIME + at].tolist(),
            memory[layout.RING_THETA2 + at].tolist(),
            words[layout.RING_TOUCHING + at].tolist(),
            strict=True,
        )
    )


EVENTS = st.lists(
    st.tuples(
        st.floats(0.0, 3.0), st.booleans(), st.integers(0, 1000), st.integers(0, len(SOURCES) - 1)
    ),
    max_size=30,
)


@given(EVENTS, st.sampled_from([0, layout.RING - 3]))
def test_events_wait_in_the_ring_of_their_source_pushed_one_by_one_or_all_at_once(events, before):
    expected = [
        [(stamp, theta2, int(touches)) for theta2, touches, stamp, source in events if source == n]
        for n in RINGS
    ]
    for all_at_once in (False, True):
        queues, memory, words = block()
        passed(words, before)
        if all_at_once:
            theta2, touches, stamps, sources = zip(*events, strict=True) if events else [()] * 4
            queues.control_all(
                np.array(theta2, float),
                np.array(touches, bool),
                np.array(stamps, np.int64),
                np.array(sources, np.int8),
            )
        else:
            for theta2, touches, stamp, source in events:
                queues.control(theta2, touches, stamp, SOURCES[source])
        assert [waiting(memory, words, ring) for ring in RINGS] == expected


@pytest.mark.parametrize("ring", RINGS)
def test_each_ring_takes_as_many_events_as_it_has_places_and_counts_what_it_drops(ring):
    queues, memory, words = block()
    passed(words, layout.RING)
    words[layout.RING_WRITTEN + ring] += layout.RING - 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        queues.control(1.0, True, 5, SOURCES[ring])
    assert queues.dropped == 0
    assert waiting(memory, words, ring)[-1] == (5, 1.0, 1)
    with pytest.warns(ov.OverviewWarning, match=SOURCES[ring]):
        queues.control(2.0, True, 6, SOURCES[ring])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        queues.control(3.0, True, 7, SOURCES[ring])
    assert queues.dropped == 2
    assert waiting(memory, words, ring)[-1] == (5, 1.0, 1)
    queues.clear()
    assert queues.dropped == 0
    with pytest.warns(ov.OverviewWarning, match=SOURCES[ring]):
        queues.control(4.0, True, 8, SOURCES[ring])


def test_no_event_is_compiled_for_anew_whatever_its_numbers_are(monkeypatch):
    compiled = push_control.compiled
    monkeypatch.setattr(engine_queues, "push_control", compiled)
    queues, _, _ = block()
    for theta2, touching in ((1, 1), (1.0, True), (np.float32(1.0), np.bool_(False))):
        queues.control(theta2, touching, 5, SOURCES[0])
    assert len(compiled.signatures) == 1


def many(count, *sources):
    """`count` events of the first source, one of each other."""
    of = np.array([sources[0]] * count + [*sources[1:]], np.int8)
    return np.full(len(of), 1.0), np.ones(len(of), bool), np.zeros(len(of), np.int64), of


@pytest.mark.parametrize("ring", RINGS)
def test_events_pushed_together_fit_all_or_none_is_taken(ring):
    queues, memory, words = block()
    passed(words, 7)
    queues.control_all(*many(10, ring))
    with pytest.raises(ov.OverviewError, match=f"{layout.RING - 9} control events.*10 are pending"):
        queues.control_all(*many(layout.RING - 9, ring, (ring + 1) % len(SOURCES)))
    assert [len(waiting(memory, words, n)) for n in RINGS] == [10 * (n == ring) for n in RINGS]
    queues.control_all(*many(layout.RING - 10, ring))
    assert len(waiting(memory, words, ring)) == layout.RING


@pytest.mark.parametrize("source", [-1, len(SOURCES)])
def test_an_index_that_names_no_source_is_refused(source):
    queues, memory, words = block()
    with pytest.raises(ov.InputError, match="indices of touch"):
        queues.control_all(*many(2, 1, source))
    assert all(waiting(memory, words, ring) == [] for ring in RINGS)


def test_a_source_that_is_unknown_is_refused_and_the_known_ones_are_named():
    with pytest.raises(ov.InputError, match="'foot'; must be one of touch, twist, "):
        block()[0].control(1.0, True, 0, "foot")


# --- parameters and surfaces ----------------------------------------------------------------------


def test_changes_that_belong_together_fit_all_or_none_is_taken():
    queues, _, words = block()
    words[layout.HOST_WRITTEN] = words[layout.HOST_READ] = 5
    queues.push([(layout.C_GATE, 0.0)] * (layout.HOST_RING - 2), 0)
    queues.require_capacity(2)
    for refused in (
        queues.require_capacity,
        lambda count: queues.push([(layout.C_GATE, 0.0)] * count, 0),
    ):
        with pytest.raises(ov.OverviewError, match=f"{layout.HOST_RING - 2} parameter changes"):
            refused(3)
    assert words[layout.HOST_WRITTEN] == layout.HOST_RING + 3
    queues.push([(layout.C_GATE, 0.0)] * 2, 0)


def test_a_changes_number_says_when_it_was_applied_until_its_place_is_used_again():
    queues, _, words = block()
    words[layout.HOST_WRITTEN] = words[layout.HOST_READ] = layout.HOST_RING - 1
    numbers = [queues.push([(layout.C_GATE, 0.0), (layout.C_RISE, 0.0)], 40 + n) for n in (0, 1)]
    assert np.diff(numbers) == 2
    words[layout.HOST_READ] = numbers[1]
    assert queues.applied_at(numbers[0]) == 40
    assert queues.applied_at(numbers[1]) is None
    words[layout.HOST_READ] += 1
    assert queues.applied_at(numbers[1]) == 41
    words[layout.HOST_WRITTEN] = words[layout.HOST_READ] = numbers[1] + layout.HOST_RING
    assert queues.applied_at(numbers[1]) == 41
    words[layout.HOST_WRITTEN] += 1
    with pytest.raises(ov.OverviewError, match="faster than they are recorded"):
        queues.applied_at(numbers[1])


@pytest.mark.parametrize("active", range(layout.SLOTS))
@pytest.mark.parametrize("fading", range(-1, layout.SLOTS))
def test_the_free_slot_neither_sounds_nor_fades_nor_waits(active, fading):
    queues, memory, words = block()
    words[layout.ACTIVE_SLOT], words[layout.FADING_SLOT] = active, fading
    # what was applied already, and a coefficient, name no slot
    words[layout.HOST_WRITTEN] = words[layout.HOST_READ] = layout.HOST_RING - 1
    words[layout.HOST_WHAT : layout.HOST_WHAT + layout.HOST_RING] = layout.COMMAND_SURFACE
    memory[layout.HOST_VALUE : layout.HOST_VALUE + layout.HOST_RING] = 1.0
    queues.push([(layout.C_GATE, 0.0), (layout.C_GATE, 1.0), (layout.C_GATE, 2.0)], 0)
    free = set(range(layout.SLOTS)) - {active, fading}
    while free:
        slot = queues.free_slot()
        assert slot in free
        free.remove(slot)
        queues.push([(layout.COMMAND_SURFACE, float(slot))], 0)
    with pytest.raises(ov.OverviewError, match="two surfaces are pending or fading"):
        queues.free_slot()


# --- stamps ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("sample_time", "stamp"), [(None, -1), (0, 0), (7, 7), (7.9, 7)])
def test_a_stamp_is_a_sample_or_as_soon_as_possible(sample_time, stamp):
    assert stamp_of(sample_time) == stamp


@pytest.mark.parametrize("sample_time", [-1, -0.5, math.nan, math.inf, -math.inf])
def test_what_is_no_sample_is_no_stamp(sample_time):
    with pytest.raises(ov.InputError, match="sample_time"):
        stamp_of(sample_time)
