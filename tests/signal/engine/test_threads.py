"""Who may call what at once, as `Engine` says: several hands' threads and an audio thread."""

from __future__ import annotations

import sys
import threading
import time

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.kernels import layout
from overview_dsp.kernels.control_events import push_control
from overview_dsp.signal.engine import queues
from tests.examples import plain_preset, timeline_of

EVENTS = 6_000  # of each thread: more than a ring holds
BLOCK = 64


@pytest.fixture
def impatient():
    """Threads take turns as often as the interpreter can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.fixture
def engine():
    engine = ov.Engine(plain_preset(), timeline_of())
    engine.prepare(48_000, BLOCK)
    return engine


def angle(writer, number):
    """An event's theta2 says who wrote it and as its how manieth."""
    return (writer * EVENTS + number) * 1e-5


def write(engine, writer, source):
    for number in range(EVENTS):
        engine.control(angle(writer, number), True, None, source)


def write_several(engine, writer, source):
    """Ten at a time, again until they find room."""
    sources = np.full(10, SOURCES.index(source), dtype=np.int8)
    touching, now = np.ones(10, dtype=bool), np.full(10, -1)
    for number in range(0, EVENTS, 10):
        theta2 = angle(writer, np.arange(number, number + 10))
        taken = False
        while not taken:
            try:
                engine.control_all(theta2, touching, now, sources)
                taken = True
            except ov.OverviewError:
                time.sleep(0)


def applied(engine, threads, dropped_first):
    """What an audio thread applied of what threads push; it begins once so many were dropped."""
    for thread in threads:
        thread.start()
    out = np.zeros((BLOCK, 2), dtype=np.float32)
    seen, parts = 0, []
    while any(thread.is_alive() for thread in threads):
        if engine.meters.dropped_events >= dropped_first:
            engine.process(out)
            events, seen = engine.pop_applied(seen)
            parts.append(events)
    engine.process(out)
    parts.append(engine.pop_applied(seen)[0])
    return np.concatenate(parts)


@pytest.mark.filterwarnings("ignore:control event dropped")
@pytest.mark.parametrize(
    ("sources", "dropped_first"),
    [
        (("touch", "serial", "remote"), 100),
        (("serial", "serial", "serial"), 100),  # several writers of one source
        (("osc", "midi", "osc", "midi"), 0),
    ],
)
@pytest.mark.parametrize("push", [push_control, push_control.py_func], ids=["compiled", "plain"])
def test_no_event_is_lost_uncounted_and_each_writers_stay_in_order(
    engine, impatient, monkeypatch, sources, dropped_first, push
):
    monkeypatch.setattr(queues, "push_control", push)
    threads = [
        threading.Thread(
            target=write_several if source == "midi" else write,
            args=(engine, writer, source),
            daemon=True,
        )
        for writer, source in enumerate(sources)
    ]
    events = applied(engine, threads, dropped_first)
    dropped = engine.meters.dropped_events
    assert dropped >= dropped_first
    assert len(events) + dropped == EVENTS * len(sources)
    numbers = np.rint(events["theta2"] * 1e5).astype(int)
    for writer, source in enumerate(sources):
        own = numbers // EVENTS == writer
        assert (np.diff(numbers[own]) > 0).all()
        assert (events["source"][own] == SOURCES.index(source)).all()
        if source == "midi":
            assert own.sum() == EVENTS


@pytest.mark.filterwarnings("ignore:control event dropped")
def test_each_source_counts_and_warns_for_itself(engine):
    for source in ("touch", "midi"):
        for _ in range(layout.RING):
            engine.control(1.0, True, None, source)
        with pytest.warns(ov.OverviewWarning, match=f"of source '{source}' are pending"):
            engine.control(1.0, True, None, source)
    assert engine.meters.dropped_events == 2
    engine.reset()
    assert engine.meters.dropped_events == 0


@pytest.mark.parametrize("first", range(8))
@pytest.mark.parametrize("second", range(8))
def test_no_surface_in_use_is_written_whenever_the_audio_thread_goes_on(
    engine, monkeypatch, first, second
):
    """Two surfaces wait; the audio thread takes each over while a free slot is looked for."""
    out = np.zeros((BLOCK, 2), dtype=np.float32)
    for sample_time in (0, BLOCK):
        engine.set_surface(engine.surface, sample_time)
    looks, acquired = iter(range(1000)), queues.acquired

    def disturbed(i64, at):
        look = next(looks)
        for _ in range((look == first) + (look == second)):
            engine.process(out)
        return acquired(i64, at)

    monkeypatch.setattr(queues, "acquired", disturbed)
    try:
        slot = engine._queues.free_slot()
    except ov.OverviewError:
        return  # asked too early, says so
    i64 = engine.memory.view(np.int64)
    waiting = range(int(i64[layout.HOST_READ]), int(i64[layout.HOST_WRITTEN]))
    used = {int(engine.memory[layout.HOST_VALUE + index]) for index in waiting}
    assert slot not in used | {i64[layout.ACTIVE_SLOT], i64[layout.FADING_SLOT]}


def test_a_slot_faded_from_is_free_once_its_last_chunk_is_over(engine):
    i64 = engine.memory.view(np.int64)
    out = np.zeros((BLOCK, 2), dtype=np.float32)
    engine.set_surface(engine.surface)
    engine.process(out)
    assert (i64[layout.FADING_SLOT], i64[layout.ACTIVE_SLOT]) == (0, 1)
    while i64[layout.FADE_LEFT] > 0:
        assert i64[layout.FADING_SLOT] == 0
        engine.process(out)
    assert i64[layout.FADING_SLOT] == -1
