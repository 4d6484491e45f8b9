"""Many voices: each rendered as if alone, side by side and on all cores.

A thread renders as many voices at once as the kernels have lanes, without the interpreter's lock.
What a voice needs beside the kernel is kept small: memory and surfaces are used again.
"""

from __future__ import annotations

import itertools
import math
import os
import threading
from collections import deque
from collections.abc import Iterable, Iterator, Sized
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine.engine import Engine
from overview_dsp.engine.meters import Strikes
from overview_dsp.engine.simd_batch import CHANNELS, EngineBatch
from overview_dsp.errors import InputError
from overview_dsp.files.sound import save_sound
from overview_dsp.gestures import Gesture
from overview_dsp.kernels.layout import TRACE_COLUMNS
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.presets.model import Preset
from overview_dsp.rendering.growable_array import GrowableArray
from overview_dsp.rendering.offline import join_strikes
from overview_dsp.rendering.schedule import GesturePlayer, Tail, checked_tail
from overview_dsp.rendering.trace import Trace
from overview_dsp.surface.cache import SurfaceCache
from overview_dsp.surface.model import Surface
from overview_dsp.timeline import Timeline

BLOCK = 65536
"""Frames of each voice rendered at a time: of eight, with their traces, 42 MB."""

GROUP = 4 * SIMD_WIDTH
"""Voices that a thread renders in one go: a lane that is free early gets another one."""

GROUP_BYTES = 2**28
"""Long voices come in smaller groups: their results wait for each other in memory."""

WAITING = 2
"""Groups a thread that are rendered before their turn: memory stays bounded."""


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


@dataclass(eq=False)
class _Playing:
    """A voice in its lane."""

    number: int
    voice: Voice
    surface: Surface
    play: GesturePlayer
    samples: GrowableArray
    trace: GrowableArray
    strikes: list[Strikes] = field(default_factory=list)


Rendered = VoiceResult | Exception
"""A voice as rendered, or why it can't be."""


class VoiceRenderer:
    """Renders voices side by side in one memory. One thread at a time."""

    def __init__(self, sample_rate: float, surfaces: SurfaceCache) -> None:
        """Nothing is allocated until the first voice."""
        self._rate = sample_rate
        self._surfaces = surfaces
        self._lanes: EngineBatch | None = None
        self._engines: list[Engine | None] = [None] * SIMD_WIDTH

    def render(
        self, voices: Iterable[tuple[int, Voice]], tail: Tail, trace: tuple[str, ...]
    ) -> Iterator[tuple[int, Rendered]]:
        """Render voices, each with the bits of `render`; results come as voices end.

        Each voice has a number, which its result has too; it is taken when a lane is free. `trace`
        names the columns to keep, of `TRACE_COLUMNS`.
        """
        waiting = iter(voices)
        playing: list[_Playing | None] = [None] * SIMD_WIDTH
        while True:
            for lane in range(SIMD_WIDTH):
                while playing[lane] is None:
                    number, voice = next(waiting, (-1, None))
                    if voice is None:
                        break
                    try:
                        started = self._started(lane, number, voice, tail, len(trace))
                    except Exception as error:
                        yield number, error
                        continue
                    if started.play.over:
                        yield number, self._result(lane, started, trace)
                    else:
                        playing[lane] = started
            if not any(playing):
                return
            yield from self._step(playing, trace)

    def _started(self, lane: int, number: int, voice: Voice, tail: Tail, columns: int) -> _Playing:
        surface = self._surfaces.surface(voice.timeline, voice.preset)
        if self._lanes is None:
            self._lanes = EngineBatch(BLOCK)
        engine = self._engines[lane]
        if engine is None:
            engine = Engine(voice.preset, voice.timeline, seed=voice.seed, surface=surface)
            engine.prepare(self._rate, BLOCK, memory=self._lanes.memory(lane))
            self._engines[lane] = engine
        else:
            engine.restart(voice.preset, voice.timeline, seed=voice.seed, surface=surface)
        play = GesturePlayer(engine, voice.gesture, tail, BLOCK)
        return _Playing(
            number,
            voice,
            surface,
            play,
            GrowableArray(CHANNELS, np.float32, play.least),
            GrowableArray(columns, np.float64, play.least if columns else 0),
        )

    def _step(
        self, playing: list[_Playing | None], trace: tuple[str, ...]
    ) -> Iterator[tuple[int, Rendered]]:
        """A block of every voice; those that end with it, or can't go on."""
        assert self._lanes is not None
        frames = BLOCK
        for lane, one in enumerate(playing):
            if one is None:
                continue
            try:
                frames = min(frames, one.play.feed())
            except Exception as error:  # a change in a take that can't be made, say
                playing[lane] = None
                yield one.number, error
        if not any(playing):
            return
        engines = [
            engine if one is not None else None
            for engine, one in zip(self._engines, playing, strict=True)
        ]
        whole = trace == TRACE_COLUMNS
        columns = None if whole else [TRACE_COLUMNS.index(name) for name in trace]
        samples, traces = self._lanes.process(engines, frames, bool(trace))
        for lane, one in enumerate(playing):
            engine = engines[lane]
            if one is None or engine is None:
                continue
            kept = one.play.count(frames)
            one.samples.add(samples[lane, :kept])
            if traces is not None:
                one.trace.add(traces[lane, :kept], columns)
            one.strikes.append(engine.take_strikes())
            if one.play.over:
                playing[lane] = None
                yield one.number, self._result(lane, one, trace)

    def _result(self, lane: int, one: _Playing, trace: tuple[str, ...]) -> VoiceResult:
        engine = self._engines[lane]
        assert engine is not None
        if not one.strikes:
            one.strikes.append(engine.take_strikes())
        return VoiceResult(
            one.voice,
            one.surface,
            one.samples.rows,
            engine.sample_rate,
            Trace(one.trace.rows, trace) if trace else None,
            join_strikes(one.strikes),
        )


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
    most = GROUP
    if isinstance(voices, Sized):
        # few voices: some for each thread
        most = min(most, max(1, math.ceil(len(voices) / threads)))
    frame = CHANNELS * np.dtype(np.float32).itemsize
    if trace:
        frame += len(TRACE_COLUMNS) * np.dtype(np.float64).itemsize
    groups = _groups(voices, most, GROUP_BYTES / (frame * sample_rate))
    return _rendered(groups, sample_rate, tail, trace, threads)


def _groups(voices: Iterable[Voice], most: int, longest_s: float) -> Iterator[list[Voice]]:
    """Voices that one thread renders: up to `most`, fewer if they last longer together."""
    group: list[Voice] = []
    seconds = 0.0
    for voice in voices:
        group.append(voice)
        seconds += voice.gesture.duration_s
        if len(group) >= most or seconds >= longest_s:
            yield group
            group, seconds = [], 0.0
    if group:
        yield group


def _rendered(
    groups: Iterator[list[Voice]], sample_rate: float, tail: Tail, trace: bool, threads: int
) -> Iterator[VoiceResult]:
    surfaces = SurfaceCache()
    own = threading.local()

    def render_group(group: list[Voice]) -> list[Rendered]:
        if not hasattr(own, "renderer"):
            own.renderer = VoiceRenderer(sample_rate, surfaces)
        renderer: VoiceRenderer = own.renderer
        done = dict(renderer.render(enumerate(group), tail, TRACE_COLUMNS if trace else ()))
        return [done[number] for number in range(len(group))]

    def results(future: Future[list[Rendered]]) -> Iterator[VoiceResult]:
        for result in future.result():
            if isinstance(result, Exception):
                raise result
            yield result

    waiting: deque[Future[list[Rendered]]] = deque()
    pool = ThreadPoolExecutor(threads, thread_name_prefix="voices")
    try:
        for group in groups:
            waiting.append(pool.submit(render_group, group))
            if len(waiting) >= WAITING * threads:
                yield from results(waiting.popleft())
        while waiting:
            yield from results(waiting.popleft())
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def usable_cores() -> int:
    """Cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
