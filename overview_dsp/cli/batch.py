"""The command `overview batch`."""

from __future__ import annotations

import click

from overview_dsp.cli.common import progress_bar, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.signals import stop_code
from overview_dsp.errors import OverviewError

MAX_SHOWN_FAILURES = 10


@cli_command("batch jobs.toml --workers 2", name="batch")
def command(
    jobs: str,
    *,
    output: str | None = option(),
    workers: int | None = option(type=click.IntRange(1, 1000)),
    scheduler: str | None = option(metavar="ADDRESS"),
    dry_run: bool = option(),
    as_json: bool = JSON,
) -> None:
    """Render the grid of JOBS (a TOML file) to sound files and one manifest.parquet.

    The grid has every combination of timelines, presets, gestures, parameters and seeds. The
    manifest lists their parameters and measurements (felt levels, loudness, length, peaks, hashes).

    A batch that was stopped or killed resumes when it runs again. If a render fails, the others
    continue, and the exit code is 1.
    """
    from overview_dsp.batch import load_jobs, run_batch

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers and --scheduler exclude each other; remove one")
    grid = load_jobs(jobs, output)
    if dry_run:
        report = {"out": grid.out, "cases": len(grid)}
        show(as_json, report, f"{grid.out}: {len(grid)} renders")
        return
    count = 0

    def progress(finished: int, of: int) -> None:
        nonlocal count
        count = finished
        bar(finished / of)

    try:
        with progress_bar(f"rendering {len(grid)}") as bar:
            result = run_batch(grid, workers=workers, scheduler=scheduler, progress=progress)
    except KeyboardInterrupt:
        error = OverviewError(
            f"stopped with {count} of {len(grid)} finished; run the command again to resume"
        )
        error.exit_code = stop_code()
        raise error from None
    failed = [{"index": index, "error": why} for index, why in result.failed]
    before = f", {result.cached} cached" if result.cached else ""
    line = f"{result.manifest}: {result.rendered} rendered{before}"
    show(as_json, {**vars(result), "failed": failed}, line)
    for index, why in result.failed[:MAX_SHOWN_FAILURES]:
        click.echo(f"failed: render {index}: {why}", err=True)
    if result.failed:
        raise OverviewError(
            f"{len(result.failed)} of {result.cases} renders failed (column error of the manifest)"
        )
