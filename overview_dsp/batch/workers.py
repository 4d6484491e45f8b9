"""Worker processes on this machine, and workers of a Dask cluster (the extra `cluster`).

The task of a process that dies (out of memory, say) is repeated in a new process. Workers end when
their parent process ends.

A scheduler gets the grid once, as the result of a task, which it repeats if the workers that hold
it are lost. A worker of a cluster reuses its surfaces and memory for all tasks.
"""

from __future__ import annotations

import itertools
import os
import pickle
import signal
import threading
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache
from multiprocessing import connection, get_context, parent_process
from typing import Any

from overview_dsp.batch.grid import PROGRAM, RenderGrid
from overview_dsp.batch.task import Job, TaskResult, Worker
from overview_dsp.errors import OverviewError, OverviewWarning, warn
from overview_dsp.installation import require_package

MAX_DEATHS = 3  # deaths of processes after which the batch ends
WAITING = 4  # queued tasks per process

_worker: Worker | None = None


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    connection.wait([parent.sentinel])
    os._exit(1)


def _begin(grid: RenderGrid) -> None:
    global _worker
    # the parent handles Ctrl-C
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _worker = Worker(grid)


def _run(jobs: Sequence[Job]) -> tuple[TaskResult, list[str]]:
    assert _worker is not None
    # the parent shows each warning, once
    with warnings.catch_warnings(record=True, action="always") as caught:
        done = _worker.run(jobs)
    notes = (str(one.message) for one in caught if issubclass(one.category, OverviewWarning))
    return done, list(dict.fromkeys(notes))


def run_here(grid: RenderGrid, tasks: Sequence[Sequence[Job]]) -> Iterator[TaskResult]:
    """Run tasks in this process, one after another, and yield their results."""
    worker = Worker(grid)
    for jobs in tasks:
        yield worker.run(jobs)


def run_in_processes(
    grid: RenderGrid, tasks: Sequence[Sequence[Job]], processes: int
) -> Iterator[TaskResult]:
    """Run tasks in `processes` processes, and yield each result; OverviewError if these died."""
    left = dict(enumerate(tasks))
    deaths = 0
    warned: set[str] = set()
    while left:
        try:
            for number, (done, notes) in _run_once(grid, dict(left), processes):
                del left[number]
                for note in notes:
                    if note not in warned:
                        warn(note)
                warned.update(notes)
                yield done
        except BrokenProcessPool:
            deaths += 1
            if deaths >= MAX_DEATHS:
                raise OverviewError(
                    f"processes died {deaths} times (out of memory?); finished cases are kept; "
                    "run the command again with fewer --workers"
                ) from None


def _run_once(
    grid: RenderGrid, left: dict[int, Sequence[Job]], processes: int
) -> Iterator[tuple[int, tuple[TaskResult, list[str]]]]:
    pool = ProcessPoolExecutor(
        min(processes, len(left)),
        # not forked: threads of libraries would be lost
        mp_context=get_context("spawn"),
        initializer=_begin,
        initargs=(grid,),
    )
    waiting: dict[Future[tuple[TaskResult, list[str]]], int] = {}
    numbers = iter(list(left))
    try:
        while True:
            for number in numbers:
                waiting[pool.submit(_run, left[number])] = number
                if len(waiting) >= WAITING * processes:
                    break
            if not waiting:
                break
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                yield waiting.pop(future), future.result()
    except BaseException:
        _end(pool)
        raise
    pool.shutdown()


def _end(pool: ProcessPoolExecutor) -> None:
    """Stop at once; the next run repeats unfinished cases."""
    for process in list((pool._processes or {}).values()):
        process.terminate()
    pool.shutdown(wait=True, cancel_futures=True)


MAX_RETRIES = 10  # retries of a task whose worker died
CONNECT_S = 10.0
MAX_SCHEDULED = 2000  # tasks that the scheduler holds at a time


@lru_cache(maxsize=4)
def _worker_of(packed: bytes) -> Worker:
    return Worker(pickle.loads(packed))


def _run_remote(packed: bytes, program: str, jobs: Sequence[Job]) -> TaskResult:
    if program != PROGRAM:
        raise OverviewError(
            f"a worker has another version of this program or of numba ({PROGRAM}; this machine: "
            f"{program}); install the same version on all machines"
        )
    return _worker_of(packed).run(jobs)


class Cluster:
    """Connection to a scheduler."""

    def __init__(self, address: str) -> None:
        """Connect to the scheduler at `address`; OverviewError if nothing answers there."""
        distributed = require_package("distributed", "a cluster", "cluster")
        try:
            self._client = distributed.Client(address, set_as_default=False, timeout=CONNECT_S)
        except (OSError, ValueError, TimeoutError) as error:
            raise OverviewError(
                f"{address}: no Dask scheduler answers ({type(error).__name__}); "
                "give its address (tcp://host:8786)"
            ) from None
        self._as_completed = distributed.as_completed

    def close(self) -> None:
        """Disconnect from the scheduler."""
        self._client.close()

    @property
    def threads(self) -> int:
        """Number of tasks that run at a time; 1 while there is no worker."""
        threads: int = sum(self._client.nthreads().values())
        return max(1, threads)

    def run(self, grid: RenderGrid, tasks: Sequence[Sequence[Job]]) -> Iterator[TaskResult]:
        """Run tasks on the workers of the cluster, and yield each result when it is finished.

        OverviewError if a worker can't run its task: its process died repeatedly, or lacks this
        program.
        """
        client = self._client
        packed = client.submit(bytes, pickle.dumps(grid), pure=False)
        numbers = iter(tasks)

        def more(count: int) -> list[Any]:
            # `retries` count workers that die; a failed case is part of its result
            return [
                client.submit(_run_remote, packed, PROGRAM, jobs, pure=False, retries=MAX_RETRIES)
                for jobs in itertools.islice(numbers, count)
            ]

        waiting = self._as_completed(more(MAX_SCHEDULED), loop=client.loop)
        try:
            for future in waiting:
                try:
                    done: TaskResult = future.result()
                except OverviewError:
                    raise
                except Exception as error:
                    raise OverviewError(
                        f"a worker can't run its task ({type(error).__name__}: {error}); finished "
                        "cases are kept; run the command again"
                    ) from None
                yield done
                future.release()
                waiting.update(more(1))
        finally:
            packed.release()
