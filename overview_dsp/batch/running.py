"""Run a batch: render the unfinished cases of a grid, then write the manifest."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace

from overview_dsp.batch import manifest
from overview_dsp.batch.grid import Keys, RenderGrid
from overview_dsp.batch.storage import Storage, is_url
from overview_dsp.batch.task import Job, TaskResult
from overview_dsp.batch.workers import Cluster, run_here, run_in_processes
from overview_dsp.data.readers import bundled_timeline
from overview_dsp.design.gestures import pause
from overview_dsp.design.presets.library import load_preset
from overview_dsp.errors import InputError
from overview_dsp.kernels.compiling import is_compiled
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.offline.rendering.many import RenderJob, render_many, usable_cores

TASKS_PER_WORKER = 16
MAX_CASES_PER_TASK = 256
"""Cases per task: few, so that all workers end together; many, so that scheduling is cheap."""

Progress = Callable[[int, int], None]  # receives the numbers of finished cases and of all cases


@dataclass(frozen=True)
class BatchResult:
    """Result of a batch.

    `cases`, `cached`, `rendered`: numbers of all cases, of those that earlier runs finished, and of
        new renders.
    `failed`: index and error of each failed case.
    `manifest`: path or URL of the manifest.
    """

    cases: int
    cached: int
    rendered: int
    failed: tuple[tuple[int, str], ...]
    manifest: str


def run_batch(
    grid: RenderGrid,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> BatchResult:
    """Render the unfinished cases of a grid, then write its manifest.

    A batch that was stopped or killed resumes when it runs again. Files, hashes and manifest don't
    depend on the machine or on the number of runs. Only one run may use an output folder at a time.

    `workers`: processes on this machine; None: one per core; 1: this process.
    `scheduler`: address of a Dask scheduler, whose cluster renders instead.

    InputError or OutputError if the output folder can't be read or written; a case that fails is in
    `failed` instead. OverviewError if workers died repeatedly, or no scheduler answers.
    """
    if not is_url(grid.out):
        # workers of a cluster run in other folders
        grid = replace(grid, out=os.path.abspath(grid.out))
    storage = Storage(grid.out)
    if workers is not None and workers < 1:
        raise InputError(f"workers is {workers}; must be 1 or more")
    if grid.out.startswith("memory://") and (workers != 1 or scheduler is not None):
        raise InputError(f"{grid.out}: other processes can't read it; use workers = 1")
    key_of = Keys(grid).key
    keys = [key_of(grid.case(index)) for index in range(len(grid))]
    storage.clean()
    table, _ = manifest.read_rows(storage)
    finished = manifest.finished_rows(table, storage.sizes(manifest.SOUNDS))
    # equal inputs with two names need one render
    missing = {key: index for index, key in enumerate(keys) if key not in finished}
    cached = sum(key in finished for key in keys)
    failed: list[tuple[int, str]] = []
    if progress:
        progress(cached, len(keys))
    if missing:
        count = cached
        jobs = [(index, key) for key, index in missing.items()]
        try:
            with _runner(grid, workers, scheduler) as (run, at_a_time):
                size = math.ceil(len(jobs) / (at_a_time * TASKS_PER_WORKER))
                size = min(size, MAX_CASES_PER_TASK)
                tasks = [jobs[first : first + size] for first in range(0, len(jobs), size)]
                for done in run(grid, tasks):
                    count += done.finished + len(done.failed)
                    failed += done.failed
                    if progress:
                        progress(min(count, len(keys)), len(keys))
        except BaseException:
            storage.clean()  # deletes incomplete files
            raise
    table, parts = manifest.read_rows(storage)
    finished = manifest.finished_rows(table, storage.sizes(manifest.SOUNDS))
    rows = manifest.rows_of(storage, table, finished, keys)
    storage.put(manifest.MANIFEST, manifest.encode_manifest(grid, table, rows))
    storage.remove(parts)
    storage.clean()
    at = f"{grid.out.rstrip('/')}/{manifest.MANIFEST}"
    rendered = len(missing) - len(failed)
    return BatchResult(len(keys), cached, rendered, tuple(sorted(failed)), at)


Run = Callable[[RenderGrid, Sequence[Sequence[Job]]], Iterator[TaskResult]]


@contextmanager
def _runner(
    grid: RenderGrid, workers: int | None, scheduler: str | None
) -> Iterator[tuple[Run, int]]:
    """Yield the function that runs tasks, and the number of tasks that run at a time."""
    if scheduler is not None:
        with closing(Cluster(scheduler)) as cluster:
            yield cluster.run, cluster.threads
        return
    processes = usable_cores() if workers is None else workers
    if processes == 1:
        yield run_here, 1
        return
    if not (is_compiled() and is_compiled("process_lanes")):
        # compile the kernels once, with a message, before worker processes need them
        voice = RenderJob(bundled_timeline(), load_preset("football"), pause(0.001))
        for _ in render_many([voice] * SIMD_WIDTH, tail="none", threads=1):
            pass
    yield lambda grid, tasks: run_in_processes(grid, tasks, processes), processes
