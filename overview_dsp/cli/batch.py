"""`overview batch`: a study's grid of renders, to files with a manifest."""

from __future__ import annotations

import click

from overview_dsp.cli.common import print_json, progress_bar, show
from overview_dsp.cli.stopping import stop_code

SHOWN_FAILURES = 10


@click.command(name="batch", epilog="Example: overview batch jobs.toml --workers 2")
@click.argument("jobs")
@click.option("-o", "--out", help="A folder or an address (s3://...), in place of the file's.")
@click.option(
    "--workers",
    type=click.IntRange(1, 1000),
    help="Processes of this machine.  [default: one a core]",
)
@click.option("--scheduler", metavar="ADDRESS", help="Work on a Dask cluster: tcp://host:8786.")
@click.option("--dry-run", is_flag=True, help="Only say how many renders there are.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(
    jobs: str,
    out: str | None,
    workers: int | None,
    scheduler: str | None,
    dry_run: bool,
    as_json: bool,
) -> None:
    """Render the study of JOBS (a TOML file) to sounds and one manifest.parquet.

    That is every combination of its timelines, presets, gestures, parameters and seeds; the
    manifest has all parameters and measures (felt levels, loudness, length, peaks, hashes).

    Stopped or killed, it goes on where it was when it is called again. A render that fails is
    listed, the others are made; then it ends with 1.
    """
    from overview_dsp.batch import load_study, run_study
    from overview_dsp.errors import OverviewError

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers are of this machine, --scheduler has its own; give one")
    study = load_study(jobs, out)
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
            outcome = run_study(study, workers=workers, scheduler=scheduler, progress=progress)
    except KeyboardInterrupt:
        error = OverviewError(
            f"stopped with {count} of {len(study)} finished; run it again to go on"
        )
        error.exit_code = stop_code()
        raise error from None
    if as_json:
        print_json(
            {
                "cases": outcome.cases,
                "found": outcome.found,
                "rendered": outcome.rendered,
                "failed": [{"index": index, "error": why} for index, why in outcome.failed],
                "manifest": outcome.manifest,
            }
        )
    else:
        before = f", {outcome.found} were there" if outcome.found else ""
        click.echo(f"{outcome.manifest}: {outcome.rendered} rendered{before}")
    for index, why in outcome.failed[:SHOWN_FAILURES]:
        click.echo(f"failed: render {index}: {why}", err=True)
    if outcome.failed:
        count = len(outcome.failed)
        raise OverviewError(
            f"{count} of {outcome.cases} renders failed (column error of the manifest)"
        )
