"""A study's work in processes of this machine.

A process that dies (out of memory, say) takes its task with it: the task is given to a new one.
Processes end with the one that started them, however that ends.
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
from overview_dsp.errors import OverviewError, OverviewWarning

MOST_DEATHS = 3
"""So often a task may lose its process before the study gives up."""

WAITING = 4
"""Tasks a process that are handed out before their turn."""

_worker: Worker | None = None
_notes: list[str] = []


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    connection.wait([parent.sentinel])
    os._exit(1)


def _begin(study: RenderGrid) -> None:
    global _worker
    # Ctrl-C is the parent's to answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    # notes are the parent's to show, once
    warnings.simplefilter("always", OverviewWarning)
    warnings.showwarning = _note  # type: ignore[assignment]
    _worker = Worker(study)


def _note(message: Warning | str, category: type[Warning], *where: object) -> None:
    if issubclass(category, OverviewWarning):
        _notes.append(str(message))


def _run(jobs: Sequence[Job]) -> tuple[TaskResult, list[str]]:
    assert _worker is not None
    done = _worker.run(jobs)
    notes = list(dict.fromkeys(_notes))
    _notes.clear()
    return done, notes


def run_here(study: RenderGrid, tasks: Sequence[Sequence[Job]]) -> Iterator[TaskResult]:
    """Run tasks in this process, one after another."""
    worker = Worker(study)
    for jobs in tasks:
        yield worker.run(jobs)


def run_in_processes(
    study: RenderGrid, tasks: Sequence[Sequence[Job]], processes: int
) -> Iterator[TaskResult]:
    """Run tasks in `processes` processes; results come as they are there.

    Raises
    ------
    OverviewError
        A task's process died again and again.
    """
    left = dict(enumerate(tasks))
    deaths = 0
    warned: set[str] = set()
    while left:
        try:
            for number, (done, notes) in _run_once(study, dict(left), processes):
                del left[number]
                for note in notes:
                    if note not in warned:
                        warnings.warn(note, OverviewWarning, stacklevel=2)
                warned.update(notes)
                yield done
        except BrokenProcessPool:
            deaths += 1
            if deaths >= MOST_DEATHS:
                raise OverviewError(
                    f"processes died {deaths} times (out of memory?); what is finished is kept, "
                    "run it again with fewer --workers"
                ) from None


def _run_once(
    study: RenderGrid, left: dict[int, Sequence[Job]], processes: int
) -> Iterator[tuple[int, tuple[TaskResult, list[str]]]]:
    pool = ProcessPoolExecutor(
        min(processes, len(left)),
        # not forked: threads of libraries don't survive that
        mp_context=get_context("spawn"),
        initializer=_begin,
        initargs=(study,),
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
    """Stop at once: what isn't finished will be done again."""
    for process in list((pool._processes or {}).values()):
        process.terminate()
    pool.shutdown(wait=True, cancel_futures=True)
