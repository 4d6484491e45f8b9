"""`python -m tools.bench`: the engine compared with C, Faust, Csound, scipy and plain Python."""

from __future__ import annotations

import click

from overview_dsp.cli.bench import SPEED_ROUNDS, show_report
from overview_dsp.cli.common import announce_compile, progress_bar
from overview_dsp.errors import OverviewError
from overview_dsp.files.atomic import require_writable
from tools.bench.picture import draw
from tools.bench.report import lines, measure


@click.command(epilog="Example: python -m tools.bench --rounds 5 --plot speeds.png")
@click.option("--rounds", type=click.IntRange(1, 1000), default=SPEED_ROUNDS, show_default=True,
              help="Rounds of each row.")  # fmt: skip
@click.option("--seconds", type=click.FloatRange(1.0, 3600.0), default=600.0, show_default=True,
              help="Duration of the longest stream.")  # fmt: skip
@click.option("--plot", metavar="FILE", help="Draw the speeds: PNG, SVG or PDF.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(rounds: int, seconds: float, plot: str | None, as_json: bool) -> None:
    """Measure seconds of sound made in one second, on one core, compared with other programs.

    Versions in C, Faust and Csound are measured where their compilers are installed. Then this
    measures the cost of a second as the work grows, and memory. It takes about five minutes; with
    --seconds 3600 it also measures streams of an hour.
    """
    try:
        if plot is not None:
            require_writable(plot)
        announce_compile("disk_alone")
        with progress_bar("measuring") as progress:
            report = measure(rounds, seconds, progress)
        if plot is not None:
            draw(report, plot)
    except OverviewError as error:
        raise click.ClickException(str(error)) from error
    show_report(report, lines(report), as_json)


if __name__ == "__main__":
    command(prog_name="python -m tools.bench")
