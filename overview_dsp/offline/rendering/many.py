"""Parallel rendering of many independent jobs on all cores.

Each thread renders as many jobs at once as the kernels have lanes, without the GIL.
Memory and surfaces are reused to keep the overhead small.
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
from typing import Generic, Literal, overload

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import SampleArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.growable_array import GrowableArray
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.sound import SavableSound
from overview_dsp.kernels.layout import SIGNALS, TRACE_COLUMNS
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.offline.rendering.offline import join_strikes
from overview_dsp.offline.rendering.schedule import GesturePlayer, Tail, checked_tail
from overview_dsp.offline.rendering.trace import Trace, Traced
from overview_dsp.public import counted, short
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.memory_reader import Strikes
from overview_dsp.signal.engine.simd_batch import EngineBatch
from overview_dsp.signal.surface.cache import SurfaceCache
from overview_dsp.signal.surface.model import Surface

BLOCK = 65536  # frames of each job per step: 42 MB for eight jobs with traces
GROUP = 4 * SIMD_WIDTH  # jobs per group of a thread; a free lane starts the next job of the group
GROUP_BYTES = 2**28  # highest size of a group's results; long jobs have smaller groups
WAITING = 2  # groups per thread that are rendered in advance, which bounds the memory


@dataclass(frozen=True)
class RenderJob:
    """Arguments of one of many independent renders.

    Parameters
    ----------
    timeline : Timeline
        Data to render.
    preset : Preset
        Parameters of feel and sound.
    gesture : Gesture
        Movement of the input.
    seed : int
        Seed of the texture noise.

    Examples
    --------
    >>> ov.RenderJob(match, football, ov.tap(0.8), seed=3).seed
    3
    """

    timeline: Timeline
    preset: Preset
    gesture: Gesture
    seed: int = 0

    def __repr__(self) -> str:
        return (
            f"<RenderJob: {short(self.preset.name)} on {short(self.timeline.title)}, "
            f"a gesture of {self.gesture.duration_s:g} s, seed {self.seed}>"
        )


@dataclass(frozen=True, eq=False)
class RenderedJob(SavableSound, Generic[Traced]):
    """A rendered job.

    Attributes
    ----------
    job : RenderJob
        The job.
    surface : Surface
        Surface of the render.
    samples : float32 (frames, 2)
        Click, tactor; linear, full scale is 1.
    sample_rate : float
        Hz.
    trace : Trace or None
        Trace of the disk; None if rendered with `trace=False`.
    strikes : Strikes
        The events passed.

    See Also
    --------
    render_many : Render jobs.

    Examples
    --------
    >>> jobs = [ov.RenderJob(match, football, ov.tap(0.5))]
    >>> (rendered,) = ov.render_many(jobs, sample_rate=8000, trace=True)
    >>> rendered.trace.cursor.max() > 0.4
    np.True_
    """

    job: RenderJob
    surface: Surface
    samples: SampleArray
    sample_rate: float
    trace: Traced
    strikes: Strikes

    def __repr__(self) -> str:
        seconds = len(self.samples) / self.sample_rate
        return (
            f"<RenderedJob: {seconds:.3f} s at {self.sample_rate:g} Hz, "
            f"{counted(len(self.strikes), 'strike')}, {short(self.job.preset.name)} on "
            f"{short(self.job.timeline.title)}, seed {self.job.seed}>"
        )


def render_jobs(
    timelines: Iterable[Timeline],
    presets: Iterable[Preset],
    gestures: Iterable[Gesture],
    seeds: Iterable[int] = (0,),
) -> Iterator[RenderJob]:
    """Yield a job for each combination, with seeds varying fastest, then gestures and presets.

    Parameters
    ----------
    timelines : iterable of Timeline
        Data to render.
    presets : iterable of Preset
        Parameters of feel and sound.
    gestures : iterable of Gesture
        Movement of the input.
    seeds : iterable of int
        Seeds of the texture noise.

    Yields
    ------
    RenderJob
        Job of a combination.

    Examples
    --------
    >>> jobs = ov.render_jobs([match], [football], [ov.tap(0.8), ov.sweep(2.0)], seeds=range(50))
    >>> len(list(jobs))
    100
    """
    if not isinstance(seeds, Iterable):
        raise InputError(f"seeds is {quoted(seeds)}; must be whole numbers, such as range(8)")
    parts = (
        validation.instances(timelines, Timeline, "timelines", "ov.load_timeline gives one"),
        validation.instances(presets, Preset, "presets", "ov.load_preset gives one"),
        validation.instances(gestures, Gesture, "gestures", "ov.sweep makes one"),
    )
    for timeline, preset, gesture, seed in itertools.product(*parts, seeds):
        yield RenderJob(timeline, preset, gesture, validation.whole(seed, "a seed"))


JobOutcome = RenderedJob[Trace | None] | Exception  # rendered job, or its error


@dataclass(eq=False)
class _Playing:
    """Job in a lane."""

    number: int
    job: RenderJob
    surface: Surface
    engine: Engine
    play: GesturePlayer
    samples: GrowableArray
    trace: GrowableArray
    strikes: list[Strikes] = field(default_factory=list)
    logged: int = 0
    """Frames whose strikes are still in the engine's log, which is read rarely for speed."""

    def read_log(self) -> None:
        """Read the strikes from the engine's log."""
        self.strikes.append(self.engine.pop_strikes())
        self.logged = 0

    def result(self, trace: tuple[str, ...]) -> RenderedJob[Trace | None]:
        """Return the rendered job with the given columns of the trace."""
        self.read_log()
        return RenderedJob(
            self.job,
            self.surface,
            self.samples.rows,
            self.engine.sample_rate,
            Trace(self.trace.rows, trace) if trace else None,
            join_strikes(self.strikes),
        )


class VoiceRenderer(threading.local):
    """Renders jobs in the lanes of one memory. Thread: any; each has a memory of its own."""

    def __init__(self, sample_rate: float, surfaces: SurfaceCache) -> None:
        """Allocate nothing until a thread's first job; threads share the surfaces."""
        self._rate = sample_rate
        self._surfaces = surfaces
        self._lanes: EngineBatch | None = None
        self._engines: list[Engine | None] = [None] * SIMD_WIDTH

    def render(
        self, jobs: Iterable[tuple[int, RenderJob]], tail: Tail, trace: tuple[str, ...]
    ) -> Iterator[tuple[int, JobOutcome]]:
        """Render jobs, bit-identical to `render`, and yield results as jobs end.

        Each job has a number, which is returned with its result. `trace`
        names the columns to return, from `TRACE_COLUMNS`.
        """
        waiting = iter(jobs)
        playing: dict[int, _Playing] = {}
        while True:
            for lane in range(SIMD_WIDTH):
                while lane not in playing:
                    number, job = next(waiting, (-1, None))
                    if job is None:
                        break
                    try:
                        started = self._started(lane, number, job, tail, len(trace))
                    except Exception as error:
                        yield number, error
                        continue
                    if started.play.over:
                        yield number, started.result(trace)
                    else:
                        playing[lane] = started
            if not playing:
                return
            yield from self._step(playing, trace)

    def _started(
        self, lane: int, number: int, job: RenderJob, tail: Tail, columns: int
    ) -> _Playing:
        surface = self._surfaces.surface(job.timeline, job.preset)
        if self._lanes is None:
            self._lanes = EngineBatch(BLOCK)
        engine = self._engines[lane]
        if engine is None:
            engine = Engine(job.preset, job.timeline, seed=job.seed, surface=surface)
            engine.prepare(self._rate, BLOCK, memory=self._lanes.memory(lane))
            self._engines[lane] = engine
        else:
            engine.restart(job.preset, job.timeline, seed=job.seed, surface=surface)
        play = GesturePlayer(engine, job.gesture, tail, BLOCK)
        samples = GrowableArray(SIGNALS, np.float32, play.least)
        table = GrowableArray(columns, np.float64, play.least if columns else 0)
        return _Playing(number, job, surface, engine, play, samples, table)

    def _step(
        self, playing: dict[int, _Playing], trace: tuple[str, ...]
    ) -> Iterator[tuple[int, JobOutcome]]:
        """Render a block of all jobs; yield those that end or fail."""
        assert self._lanes is not None
        frames = BLOCK
        for lane, one in list(playing.items()):
            try:
                frames = min(frames, one.play.feed())
            except Exception as error:  # for example an invalid change in a take
                del playing[lane]
                yield one.number, error
        if not playing:
            return
        for one in playing.values():
            if one.logged + frames > BLOCK:
                one.read_log()
        engines = [playing[lane].engine if lane in playing else None for lane in range(SIMD_WIDTH)]
        samples, traces = self._lanes.process(engines, frames, bool(trace))
        whole = trace == TRACE_COLUMNS
        columns = None if whole else [TRACE_COLUMNS.index(name) for name in trace]
        for lane, one in sorted(playing.items()):
            kept = one.play.count(frames)
            one.samples.add(samples[lane, :kept])
            if traces is not None:
                one.trace.add(traces[lane, :kept], columns)
            one.logged += frames
            # strikes must be read before the surface changes
            if one.job.gesture.changes:
                one.read_log()
            if one.play.over:
                del playing[lane]
                yield one.number, one.result(trace)


# fmt: off
@overload
def render_many(
    jobs: Iterable[RenderJob], sample_rate: float = ..., *, tail: Tail = ...,
    trace: Literal[False] = ..., threads: int | None = ...,
) -> Iterator[RenderedJob[None]]: ...
@overload
def render_many(
    jobs: Iterable[RenderJob], sample_rate: float = ..., *, tail: Tail = ...,
    trace: Literal[True], threads: int | None = ...,
) -> Iterator[RenderedJob[Trace]]: ...
@overload
def render_many(
    jobs: Iterable[RenderJob], sample_rate: float = ..., *, tail: Tail = ...,
    trace: bool, threads: int | None = ...,
) -> Iterator[RenderedJob[Trace | None]]: ...
# fmt: on
def render_many(
    jobs: Iterable[RenderJob],
    sample_rate: float = 48_000,
    *,
    tail: Tail = "rest",
    trace: bool = False,
    threads: int | None = None,
) -> Iterator[RenderedJob[Trace | None]]:
    """Render independent jobs on all cores and yield results in the order of the jobs.

    Results are bit-identical to `render` with the same arguments. Jobs are read
    and rendered on demand, a few in advance, so memory stays bounded.

    Parameters
    ----------
    jobs : iterable of RenderJob
        Jobs, possibly infinitely many.
    sample_rate : float
        Hz.
    tail : {"rest", "none"} or float
        As in `render`.
    trace : bool
        Whether to return traces.
    threads : int or None
        Number of threads; None is one per core.

    Returns
    -------
    iterator of RenderedJob
        One result per job.

    Raises
    ------
    InputError
        The tail or number of threads is invalid; or as in `render`, when a result is requested.

    Examples
    --------
    >>> jobs = ov.render_jobs([match], [football], [ov.tap(0.8, 0.1)], seeds=range(3))
    >>> [len(rendered.samples) for rendered in ov.render_many(jobs, 8000, tail="none")]
    [801, 801, 801]
    """
    tail = checked_tail(tail)
    if threads is None:
        threads = usable_cores()
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise InputError(f"threads is {threads!r}; must be 1 or more, or None for all cores")
    most = GROUP
    if isinstance(jobs, Sized):
        # with few jobs, each thread gets some
        most = min(most, max(1, math.ceil(len(jobs) / threads)))
    frame = SIGNALS * np.dtype(np.float32).itemsize
    if trace:
        frame += len(TRACE_COLUMNS) * np.dtype(np.float64).itemsize
    groups = _groups(jobs, most, GROUP_BYTES / (frame * sample_rate))
    return _rendered(groups, sample_rate, tail, trace, threads)


def _groups(jobs: Iterable[RenderJob], most: int, longest_s: float) -> Iterator[list[RenderJob]]:
    """Yield groups of up to `most` jobs with a total duration of about `longest_s`."""
    group: list[RenderJob] = []
    seconds = 0.0
    for job in jobs:
        group.append(job)
        seconds += job.gesture.duration_s
        if len(group) >= most or seconds >= longest_s:
            yield group
            group, seconds = [], 0.0
    if group:
        yield group


def _rendered(
    groups: Iterator[list[RenderJob]], sample_rate: float, tail: Tail, trace: bool, threads: int
) -> Iterator[RenderedJob[Trace | None]]:
    renderer = VoiceRenderer(sample_rate, SurfaceCache())

    def render_group(group: list[RenderJob]) -> list[JobOutcome]:
        done = dict(renderer.render(enumerate(group), tail, TRACE_COLUMNS if trace else ()))
        return [done[number] for number in range(len(group))]

    def results(future: Future[list[JobOutcome]]) -> Iterator[RenderedJob[Trace | None]]:
        for result in future.result():
            if isinstance(result, Exception):
                raise result
            yield result

    waiting: deque[Future[list[JobOutcome]]] = deque()
    pool = ThreadPoolExecutor(threads, thread_name_prefix="jobs")
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
    """Return the number of cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
