"""Workers of a Dask cluster (the extra `cluster`).

The scheduler gets the grid once, as the result of a task, which it repeats if the workers that hold
it are lost. A worker reuses its surfaces and memory for all tasks.
"""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

from overview_dsp.batch.cache_keys import PROGRAM
from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.task import Job, TaskResult, Worker
from overview_dsp.errors import OverviewError
from overview_dsp.installation import require_package

MAX_RETRIES = 10  # retries of a task whose worker died
CONNECT_S = 10.0
WAITING = 2000  # tasks that the scheduler holds at a time


@lru_cache(maxsize=4)
def _worker_of(packed: bytes) -> Worker:
    return Worker(pickle.loads(packed))


def _same(packed: bytes) -> bytes:
    return packed


def _run(packed: bytes, program: str, jobs: Sequence[Job]) -> TaskResult:
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
        packed = client.submit(_same, pickle.dumps(grid), pure=False)
        numbers = iter(tasks)

        def more(count: int) -> list[Any]:
            # `retries` count workers that die; a failed case is part of its result
            return [
                client.submit(_run, packed, PROGRAM, jobs, pure=False, retries=MAX_RETRIES)
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
                        f"a worker can't run its task ({type(error).__name__}: {error}); finished "
                        "cases are kept; run the command again"
                    ) from None
                yield done
                future.release()
                waiting.update(more(1))
        finally:
            packed.release()
