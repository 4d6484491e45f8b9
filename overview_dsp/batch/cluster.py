"""A study's work on a Dask cluster (the extra `cluster`).

The study goes to the scheduler once, as a task's result that can be made again when the workers
that hold it are gone. A worker keeps its surfaces and memory from task to task.
"""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

from overview_dsp.batch.cache_keys import PROGRAM
from overview_dsp.batch.extra import library
from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.task import Job, TaskResult, Worker
from overview_dsp.errors import OverviewError

MOST_RETRIES = 10
"""So often a task is given out anew after its worker has died."""

CONNECT_S = 10.0

WAITING = 2000
"""Tasks with the scheduler at a time."""


@lru_cache(maxsize=4)
def _worker_of(packed: bytes) -> Worker:
    # a study of before is let go; its threads' memory with it
    return Worker(pickle.loads(packed))


def _same(packed: bytes) -> bytes:
    return packed


def _run(packed: bytes, program: str, jobs: Sequence[Job]) -> TaskResult:
    if program != PROGRAM:
        raise OverviewError(
            f"a worker has another version of this program or of numba ({PROGRAM}, here "
            f"{program}); install the same everywhere"
        )
    return _worker_of(packed).run(jobs)


class Cluster:
    """A connection to a scheduler."""

    def __init__(self, address: str) -> None:
        """Connect; OverviewError if nothing answers at the address."""
        distributed = library("distributed", "cluster")
        try:
            self._client = distributed.Client(address, set_as_default=False, timeout=CONNECT_S)
        except (OSError, ValueError, TimeoutError) as error:
            raise OverviewError(
                f"{address}: no Dask scheduler answers ({type(error).__name__}); "
                "give its address (tcp://host:8786)"
            ) from None
        self._as_completed = distributed.as_completed

    def close(self) -> None:
        """Let go of the scheduler."""
        self._client.close()

    @property
    def threads(self) -> int:
        """How many tasks run at a time; 1 while there is no worker."""
        threads: int = sum(self._client.nthreads().values())
        return max(1, threads)

    def run(self, study: RenderGrid, tasks: Sequence[Sequence[Job]]) -> Iterator[TaskResult]:
        """Run tasks on the cluster's workers; results come as they are there.

        Raises
        ------
        OverviewError
            A worker can't do its task: its process died again and again, or lacks this program.
        """
        client = self._client
        packed = client.submit(_same, pickle.dumps(study), pure=False)
        numbers = iter(tasks)

        def more(count: int) -> list[Any]:
            # `retries` are for workers that die; what a case does wrong is in its result
            return [
                client.submit(_run, packed, PROGRAM, jobs, pure=False, retries=MOST_RETRIES)
                for jobs in itertools.islice(numbers, count)
            ]

        waiting = self._as_completed(more(WAITING), loop=client.loop)
        try:
            for future in waiting:
                try:
                    done: TaskResult = future.result()
                except OverviewError:
                    raise
                except Exception as error:
                    raise OverviewError(
                        f"a worker can't do its task ({type(error).__name__}: {error}); what is "
                        "finished is kept, run it again"
                    ) from None
                yield done
                future.release()
                waiting.update(more(1))
        finally:
            packed.release()
