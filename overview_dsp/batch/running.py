"""Run a study: what isn't finished yet, anywhere, then the manifest."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

from overview_dsp.batch import manifest
from overview_dsp.batch.cache_keys import Keys
from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.local import run_here, run_in_processes
from overview_dsp.batch.storage import Storage, is_address
from overview_dsp.batch.task import Job, TaskResult
from overview_dsp.data.readers import bundled_timeline
from overview_dsp.design.gestures import pause
from overview_dsp.design.presets.library import load_preset
from overview_dsp.errors import InputError
from overview_dsp.kernels.compiling import is_compiled
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.offline.rendering.many import RenderJob, render_many, usable_cores

TASKS_A_WORKER = 16
MOST_A_TASK = 256
"""Cases of a task: few enough that all workers end together, enough that handing out is cheap."""

Progress = Callable[[int, int], None]
"""Receives how many cases are finished, of how many."""


@dataclass(frozen=True)
class BatchResult:
    """What became of a study.

    Attributes
    ----------
    cases, found, rendered : int
        All; those that were finished before; those that were rendered now.
    failed : tuple of (case, why)
    manifest : str
        The manifest's path or address.
    """

    cases: int
    found: int
    rendered: int
    failed: tuple[tuple[int, str], ...]
    manifest: str


def run_batch(
    study: RenderGrid,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> BatchResult:
    """Render what isn't finished of a study, then write its manifest.

    Stopped or killed at any moment, it goes on where it was when it is run again. Files, hashes and
    manifest are the same wherever and in however many pieces it ran. One run at a time in a place.

    Parameters
    ----------
    study : RenderGrid
    workers : int or None
        Processes of this machine; None is one a core, 1 works in this one.
    scheduler : str or None
        A Dask scheduler's address, to work on its cluster instead.
    progress : callable

    Raises
    ------
    InputError, OutputError
        The place can't be read or written. A case that can't be rendered is in `failed` instead.
    OverviewError
        Workers died again and again, or no scheduler answers.
    """
    if not is_address(study.out):
        # a cluster's workers stand in other folders
        study = replace(study, out=os.path.abspath(study.out))
    place = Storage(study.out)
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}; it is 1 or more")
    if place.of_one_process and (workers != 1 or scheduler is not None):
        raise InputError(f"{study.out}: only one process sees it; use workers = 1")
    keys = _keys(study)
    place.clean()
    table, _ = manifest.read_rows(place)
    finished = manifest.finished_rows(table, place.sizes(manifest.SOUNDS))
    # equal contents under two names are one render
    missing = {key: index for index, key in enumerate(keys) if key not in finished}
    found = sum(key in finished for key in keys)
    failed: list[tuple[int, str]] = []
    if progress:
        progress(found, len(keys))
    if missing:
        count = found
        jobs = [(index, key) for key, index in missing.items()]
        try:
            with _runner(study, workers, scheduler) as (run, at_a_time):
                for done in run(study, _tasks(jobs, at_a_time)):
                    count += done.finished + len(done.failed)
                    failed += done.failed
                    if progress:
                        progress(min(count, len(keys)), len(keys))
        except BaseException:
            place.clean()  # of what was being written
            raise
    table, parts = manifest.read_rows(place)
    finished = manifest.finished_rows(table, place.sizes(manifest.SOUNDS))
    rows = manifest.rows_of(place, table, finished, keys)
    place.put(manifest.MANIFEST, manifest.encode_manifest(study, table, rows))
    # what they hold is in the manifest now
    place.remove(parts)
    place.clean()
    at = f"{study.out.rstrip('/')}/{manifest.MANIFEST}"
    rendered = len(missing) - len(failed)
    return BatchResult(len(keys), found, rendered, tuple(sorted(failed)), at)


def _keys(study: RenderGrid) -> list[str]:
    keys = Keys(study)
    return [keys.key(study.case(index)) for index in range(len(study))]


def _tasks(jobs: Sequence[Job], at_a_time: int) -> list[Sequence[Job]]:
    size = min(max(1, math.ceil(len(jobs) / (at_a_time * TASKS_A_WORKER))), MOST_A_TASK)
    return [jobs[first : first + size] for first in range(0, len(jobs), size)]


Run = Callable[[RenderGrid, Sequence[Sequence[Job]]], Iterator[TaskResult]]


@contextmanager
def _runner(
    study: RenderGrid, workers: int | None, scheduler: str | None
) -> Iterator[tuple[Run, int]]:
    """Where the work is done, and how many tasks at a time."""
    if scheduler is not None:
        from overview_dsp.batch.cluster import Cluster

        cluster = Cluster(scheduler)
        try:
            yield cluster.run, cluster.threads
        finally:
            cluster.close()
        return
    processes = usable_cores() if workers is None else workers
    if processes == 1:
        yield run_here, 1
        return
    _compile()
    yield lambda study, tasks: run_in_processes(study, tasks, processes), processes


def _compile() -> None:
    """Have the kernels compiled once, and said so, before processes need them."""
    if not (is_compiled() and is_compiled("process_lanes")):
        voice = RenderJob(bundled_timeline(), load_preset("football"), pause(0.001))
        for _ in render_many([voice] * SIMD_WIDTH, tail="none", threads=1):
            pass
