"""Worker processes on this machine.

The task of a process that dies (out of memory, say) is repeated in a new process. Workers end when
their parent process ends.
"""

from __future__ import annotations

import os
import signal
import threading
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import connection, get_context, parent_process

from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.task import Job, TaskResult, Worker
from overview_dsp.errors import OverviewError, OverviewWarning, warn

MAX_DEATHS = 3  # deaths of processes after which the batch ends
WAITING = 4  # queued tasks per process

_worker: Worker | None = None
_notes: list[str] = []


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
    # the parent shows each warning, once
    warnings.simplefilter("always", OverviewWarning)
    warnings.showwarning = _note  # type: ignore[assignment]
    _worker = Worker(grid)


def _note(message: Warning | str, category: type[Warning], *where: object) -> None:
    if issubclass(category, OverviewWarning):
        _notes.append(str(message))


def _run(jobs: Sequence[Job]) -> tuple[TaskResult, list[str]]:
    assert _worker is not None
    done = _worker.run(jobs)
    notes = list(dict.fromkeys(_notes))
    _notes.clear()
    return done, notes


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
