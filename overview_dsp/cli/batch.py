"""`overview batch`: a study's grid of renders, to files with a manifest."""

from __future__ import annotations

import click

from overview_dsp.cli.common import progress_bar, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.signals import stop_code
from overview_dsp.errors import OverviewError

SHOWN_FAILURES = 10


@cli_command("batch jobs.toml --workers 2", name="batch")
def command(
    jobs: str,
    *,
    output: str | None = option("Folder or address (s3://...), in place of the file's."),
    workers: int | None = option(
        "Processes of this machine.  [default: one per core]", type=click.IntRange(1, 1000)
    ),
    scheduler: str | None = option("Work on a Dask cluster: tcp://host:8786.", metavar="ADDRESS"),
    dry_run: bool = option("Only report how many renders there are."),
    as_json: bool = JSON,
) -> None:
    """Render the study of JOBS (a TOML file) to sounds and one manifest.parquet.

    That is every combination of its timelines, presets, gestures, parameters and seeds; the
    manifest has all parameters and measures (felt levels, loudness, length, peaks, hashes).

    Stopped or killed, it goes on where it was when it is called again. A render that fails is
    listed, the others are made; then it ends with 1.
    """
    from overview_dsp.batch import load_jobs, run_batch

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers are of this machine, --scheduler has its own; give one")
    study = load_jobs(jobs, output)
    if dry_run:
        report = {"out": study.out, "cases": len(study)}
        show(as_json, report, f"{study.out}: {len(study)} renders")
        return
    count = 0

    def progress(finished: int, of: int) -> None:
        nonlocal count
        count = finished
        bar(finished / of)

    try:
        with progress_bar(f"rendering {len(study)}") as bar:
            outcome = run_batch(study, workers=workers, scheduler=scheduler, progress=progress)
    except KeyboardInterrupt:
        error = OverviewError(
            f"stopped with {count} of {len(study)} finished; run it again to go on"
        )
        error.exit_code = stop_code()
        raise error from None
    report = {
        "cases": outcome.cases,
        "found": outcome.found,
        "rendered": outcome.rendered,
        "failed": [{"index": index, "error": why} for index, why in outcome.failed],
        "manifest": outcome.manifest,
    }
    before = f", {outcome.found} were there" if outcome.found else ""
    show(as_json, report, f"{outcome.manifest}: {outcome.rendered} rendered{before}")
    for index, why in outcome.failed[:SHOWN_FAILURES]:
        click.echo(f"failed: render {index}: {why}", err=True)
    if outcome.failed:
        count = len(outcome.failed)
        raise OverviewError(
            f"{count} of {outcome.cases} renders failed (column error of the manifest)"
        )
