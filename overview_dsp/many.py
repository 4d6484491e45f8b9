"""Many voices: each rendered as if alone, on all cores.

A voice takes one thread; the kernel runs without the interpreter's lock. What a voice needs beside
the kernel is kept small: a thread's memory block and the surfaces are used again.
"""

from __future__ import annotations

import itertools
import os
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine import TRACE_COLUMNS, Engine
from overview_dsp.errors import InputError
from overview_dsp.gestures import Gesture
from overview_dsp.meters import Strikes
from overview_dsp.presets.model import Preset
from overview_dsp.rendering import Block, Tail, Trace, blocks, checked_tail, join_strikes
from overview_dsp.sound_file import save_sound
from overview_dsp.surface import Surface
from overview_dsp.surface_cache import SurfaceCache
from overview_dsp.timeline import Timeline

BLOCK = 65536
"""Frames rendered at a time: a second and more, with its trace 5 MB."""

AHEAD = 4
"""Voices a thread that are rendered before their turn: memory stays bounded."""


@dataclass(frozen=True)
class Voice:
    """One of many independent renders: the arguments of `render`."""

    timeline: Timeline
    preset: Preset
    gesture: Gesture
    seed: int = 0


@dataclass(frozen=True, eq=False)
class VoiceResult:
    """A rendered voice.

    Attributes
    ----------
    voice : Voice
    surface : Surface
        What the disk moved on.
    samples : float32 (frames, 2)
        Click, tactor.
    sample_rate : float
        Hz.
    trace : Trace or None
        What the disk did, one value a frame.
    strikes : Strikes
        The events passed.
    """

    voice: Voice
    surface: Surface
    samples: NDArray[np.float32]
    sample_rate: float
    trace: Trace | None
    strikes: Strikes

    def save(self, path: str | os.PathLike[str], subtype: str | None = None) -> None:
        """Write the samples to a sound file; the suffix says the format (WAV, FLAC, ...)."""
        save_sound(path, self.samples, self.sample_rate, subtype)


def voices(
    timelines: Iterable[Timeline],
    presets: Iterable[Preset],
    gestures: Iterable[Gesture],
    seeds: Iterable[int] = (0,),
) -> Iterator[Voice]:
    """Every combination, seeds fastest, then gestures, presets, timelines."""
    for parts in itertools.product(timelines, presets, gestures, seeds):
        yield Voice(*parts)


class VoiceRenderer:
    """Renders voice after voice in one memory block. One thread at a time."""

    def __init__(self, sample_rate: float, surfaces: SurfaceCache) -> None:
        """Nothing is allocated until the first voice."""
        self._rate = sample_rate
        self._surfaces = surfaces
        self._engine: Engine | None = None

    def render(self, voice: Voice, tail: Tail, trace: bool) -> VoiceResult:
        """One voice, with the bits of `render`."""
        surface = self._surfaces.surface(voice.timeline, voice.preset)
        if self._engine is None:
            engine = Engine(voice.preset, voice.timeline, seed=voice.seed, surface=surface)
            engine.prepare(self._rate, BLOCK)
            self._engine = engine
        else:
            engine = self._engine
            engine.restart(voice.preset, voice.timeline, seed=voice.seed, surface=surface)
        done = list(blocks(engine, voice.gesture, tail, trace, block=BLOCK))
        if not done:
            nothing = np.empty((0, 2), np.float32)
            done = [Block(nothing, np.empty((0, len(TRACE_COLUMNS))), engine.take_strikes())]
        if len(done) == 1:
            samples, table, strikes = done[0].samples, done[0].trace, done[0].strikes
        else:
            samples = np.concatenate([block.samples for block in done])
            tables = [block.trace for block in done if block.trace is not None]
            table = np.concatenate(tables) if tables else None
            strikes = join_strikes([block.strikes for block in done])
        kept = Trace(table) if trace and table is not None else None
        return VoiceResult(voice, surface, samples, engine.sample_rate, kept, strikes)


def render_many(
    voices: Iterable[Voice],
    sample_rate: float = 48_000,
    *,
    tail: Tail = "rest",
    trace: bool = False,
    threads: int | None = None,
) -> Iterator[VoiceResult]:
    """Render independent voices, on all cores; results come in the order of the voices.

    Each has the bits of `render` with the same arguments, whatever the others are. Voices are taken
    and rendered as results are asked for, a few ahead, so memory stays bounded.

    Parameters
    ----------
    voices : of `Voice`
        May be endless.
    sample_rate : float
        Hz.
    tail, trace : as in `render`
    threads : int or None
        How many voices at a time; None is one a core.

    Raises
    ------
    InputError
        A tail or a number of threads that isn't one, at once; as `render`, when a voice's result
        is asked for.
    """
    tail = checked_tail(tail)
    if threads is None:
        threads = usable_cores()
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise InputError(f"threads = {threads!r}; it is a whole number from 1, or None: all cores")
    return _rendered(iter(voices), sample_rate, tail, trace, threads)


def _rendered(
    voices: Iterator[Voice], sample_rate: float, tail: Tail, trace: bool, threads: int
) -> Iterator[VoiceResult]:
    surfaces = SurfaceCache()
    own = threading.local()

    def render_one(voice: Voice) -> VoiceResult:
        if not hasattr(own, "renderer"):
            own.renderer = VoiceRenderer(sample_rate, surfaces)
        renderer: VoiceRenderer = own.renderer
        return renderer.render(voice, tail, trace)

    waiting: deque[Future[VoiceResult]] = deque()
    pool = ThreadPoolExecutor(threads, thread_name_prefix="voices")
    try:
        for voice in voices:
            waiting.append(pool.submit(render_one, voice))
            if len(waiting) >= AHEAD * threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def usable_cores() -> int:
    """Cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
