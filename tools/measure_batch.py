"""What a study costs: stimuli a second here, and a Dask scheduler's time for a task.

python tools/measure_batch.py [--count 10000] [--workers 2] [--cluster-workers 100] [--tasks 5000]
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from pathlib import Path

JOBS = """
out = "study"
timelines = ["world-cup-final-2018"]
gestures = ["tap:0.3:0.5", "tap:0.5:0.5", "tap:0.7:0.5", "tap:0.9:0.5", "tap:1:0.5"]
seeds = {seeds}
tail = "none"
[parameters]
"tactor.gain_db" = {{from = -12.0, to = 0.0, steps = 10}}
"kinds.goal.height" = {{from = 2.0, to = 32.0, steps = 10, scale = "log"}}
"""


def cpu_s() -> float:
    """Processor time of this process and those that have ended, s."""
    of = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in of)


def stimuli(count: int, workers: int) -> None:
    """Half-second stimuli with their manifest, by processes of this machine."""
    from overview_dsp.batch import load_jobs, run_batch

    with tempfile.TemporaryDirectory() as folder:
        jobs = Path(folder) / "jobs.toml"
        jobs.write_text(JOBS.format(seeds=max(1, count // 500)))
        started, used = time.perf_counter(), cpu_s()
        outcome = run_batch(load_jobs(jobs), workers=workers)
        taken, used = time.perf_counter() - started, cpu_s() - used
        assert not outcome.failed
        each = 1e3 * used / outcome.rendered
        print(
            f"{outcome.rendered} stimuli of 0.5 s with manifest, {workers} processes: "
            f"{taken:.1f} s; "
            f"{used:.1f} s of processor time, {each:.2f} ms each; load {os.getloadavg()[0]:.1f}"
        )


def nothing(number: int) -> int:
    """A task that costs nothing."""
    return number


def scheduling(workers: int, tasks: int) -> None:
    """A scheduler's time for a task, with workers in this process."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=False,
            dashboard_address=None,
            # they share one process: each would take its whole memory for its own
            memory_limit=0,
        ) as cluster,
        Client(cluster) as client,
    ):
        client.gather(client.map(nothing, range(workers), pure=False))
        started, used = time.perf_counter(), cpu_s()
        client.gather(client.map(nothing, range(tasks), pure=False))
        taken, used = time.perf_counter() - started, cpu_s() - used
    print(
        f"{tasks} empty tasks, {workers} workers in one process: {1e3 * taken / tasks:.2f} ms a "
        f"task ({1e3 * used / tasks:.2f} ms of processor time)"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--cluster-workers", type=int, default=100)
    parser.add_argument("--tasks", type=int, default=5_000)
    given = parser.parse_args()
    stimuli(given.count, given.workers)
    scheduling(given.cluster_workers, given.tasks)
