from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys

import pytest

import overview_dsp as ov
from overview_dsp.batch import run_batch
from tests.batch.grids import CASES, JOBS, grid_in, hashes, jobs_file
from tests.cli.running import environment, overview, refused

DASK_WORKER = (sys.executable, "-m", "distributed.cli.dask_worker")
distributed = pytest.importorskip("distributed", reason="needs the extra cluster")
pytestmark = [
    pytest.mark.filterwarnings("ignore:preset 'heart' has no"),
    # of the library's own clean-up
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


@pytest.fixture
def cluster():
    """A scheduler with two workers in this process."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, processes=False, dashboard_address=None
    ) as local:
        yield local.scheduler_address


def test_a_cluster_makes_the_same_files_as_one_process(cluster, tmp_path):
    (tmp_path / "one").mkdir()
    outcome = run_batch(grid_in(tmp_path), scheduler=cluster)
    assert (outcome.rendered, outcome.failed) == (CASES, ())
    assert run_batch(grid_in(tmp_path), scheduler=cluster).cached == CASES
    run_batch(grid_in(tmp_path / "one"), workers=1)
    assert hashes(tmp_path / "study") == hashes(tmp_path / "one" / "study")


def test_a_folder_that_is_deleted_and_made_again_is_no_trouble_to_running_workers(
    cluster, tmp_path
):
    (tmp_path / "one").mkdir()
    run_batch(grid_in(tmp_path / "one"), workers=1)
    whole = hashes(tmp_path / "one" / "study")
    for _ in range(2):
        outcome = run_batch(grid_in(tmp_path), scheduler=cluster)
        assert (outcome.rendered, outcome.failed) == (CASES, ())
        assert hashes(tmp_path / "study") == whole
        shutil.rmtree(tmp_path / "study")
    (tmp_path / "study").mkdir()
    assert run_batch(grid_in(tmp_path), scheduler=cluster).failed == ()
    assert hashes(tmp_path / "study") == whole


def test_an_output_folder_that_is_deleted_repeatedly_is_completed_by_the_next_run(
    cluster, tmp_path
):
    """Whatever becomes of a run meanwhile, the next one finishes the same study."""
    (tmp_path / "one").mkdir()
    run_batch(grid_in(tmp_path / "one"), workers=1)

    def vanish(finished, of):
        if finished % 7 == 3:
            shutil.rmtree(tmp_path / "study", ignore_errors=True)

    for _ in range(3):
        with contextlib.suppress(ov.OverviewError):
            run_batch(grid_in(tmp_path), scheduler=cluster, progress=vanish)
    assert run_batch(grid_in(tmp_path), scheduler=cluster).failed == ()
    assert hashes(tmp_path / "study") == hashes(tmp_path / "one" / "study")


def test_the_command_works_on_a_cluster(cluster, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    jobs_file(tmp_path, JOBS.replace("seeds = 3", "seeds = 1"))
    outcome = overview("batch", "jobs.toml", "--scheduler", cluster)
    assert outcome.code == 0, outcome
    assert f"{CASES // 3} rendered" in outcome.out


def test_an_error_of_the_storage_reaches_the_caller(cluster, tmp_path, monkeypatch):
    from overview_dsp.batch.storage import Storage

    def full(self, name, data):
        raise ov.OutputError("the disk is full")

    monkeypatch.setattr(Storage, "put", full)
    with pytest.raises(ov.OutputError, match="disk is full"):
        run_batch(grid_in(tmp_path), scheduler=cluster)


def test_workers_of_another_version_are_refused(cluster, tmp_path, monkeypatch):
    from overview_dsp.batch import workers as room

    real = room._run_remote

    def other(packed, program, jobs):
        return real(packed, "0.0.0+other", jobs)

    monkeypatch.setattr(room, "_run_remote", other)
    with pytest.raises(ov.OverviewError, match="another version"):
        run_batch(grid_in(tmp_path), scheduler=cluster)


def test_an_address_where_nothing_answers_is_an_error_of_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("overview_dsp.batch.workers.CONNECT_S", 0.5)
    jobs_file(tmp_path)
    refused(overview("batch", "jobs.toml", "--scheduler", "tcp://127.0.0.1:9"), "scheduler", code=1)


@pytest.mark.skipif(os.name != "posix", reason="sends SIGKILL")
def test_a_worker_killed_half_way_changes_no_byte(tmp_path):
    text = JOBS.replace("seeds = 3", "seeds = 25").replace("0.05", "0.5")
    (tmp_path / "one").mkdir()
    with distributed.LocalCluster(n_workers=0, processes=True, dashboard_address=None) as scheduler:
        address = scheduler.scheduler_address
        workers = [
            subprocess.Popen(
                [*DASK_WORKER, address, "--nthreads", "1", "--no-nanny", "--no-dashboard"],
                env=environment(),
                cwd=tmp_path,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            for _ in range(2)
        ]
        killed = []

        def tell(finished, of):
            if not killed and finished > 0:
                killed.append(finished)
                workers[0].send_signal(signal.SIGKILL)

        try:
            with distributed.Client(address, set_as_default=False) as client:
                client.wait_for_workers(2, timeout=60)
            outcome = run_batch(grid_in(tmp_path, text), scheduler=address, progress=tell)
        finally:
            for worker in workers:
                worker.kill()
                worker.wait()
    assert killed
    assert killed[0] < outcome.cases
    assert outcome.failed == ()
    assert outcome.rendered == CASES // 3 * 25
    run_batch(grid_in(tmp_path / "one", text), workers=1)
    assert hashes(tmp_path / "study") == hashes(tmp_path / "one" / "study")
