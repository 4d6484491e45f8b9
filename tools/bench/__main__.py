"""`python -m tools.bench`: the engine compared with C, Faust, Csound, scipy and plain Python.

`--live` measures live play instead: callback times, lost frames, control latency, sessions.
"""

from __future__ import annotations

import sys

import click

from overview_dsp.cli.bench import SPEED_ROUNDS, show_report
from overview_dsp.cli.common import announce_compile, progress_bar
from overview_dsp.errors import OverviewError
from overview_dsp.files.atomic import require_writable
from overview_dsp.live.output.portaudio_library import device_named
from tools.bench.live.table import lines as live_lines
from tools.bench.live.table import measure_live
from tools.bench.picture import draw
from tools.bench.report import lines, measure

LIVE_ROUNDS, LIVE_SECONDS = 5, 60.0
LONGEST_STREAM_S = 600.0


@click.command(epilog="Example: python -m tools.bench --rounds 5 --plot speeds.png")
@click.option(
    "--rounds",
    type=click.IntRange(1, 1000),
    help=f"Rounds of each row.  [default: {SPEED_ROUNDS}; with --live {LIVE_ROUNDS}]",
)
@click.option(
    "--seconds",
    type=click.FloatRange(1.0, 3600.0),
    help="Duration of the longest stream, or of each run of --live.  "
    f"[default: {LONGEST_STREAM_S:g}; with --live {LIVE_SECONDS:g}]",
)
@click.option("--live", is_flag=True, help="Measure live play on an output.")
@click.option("--device", help="Output of --live: name or number of overview devices.")
@click.option("--plot", metavar="FILE", help="Draw the speeds: PNG, SVG or PDF.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(
    rounds: int | None,
    seconds: float | None,
    live: bool,
    device: str | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Measure seconds of sound made in one second, on one core, compared with other programs.

    Versions in C, Faust and Csound are measured where their compilers are installed. Then this
    measures the cost of a second as the work grows, and memory. It takes about five minutes; with
    --seconds 3600 it also measures streams of an hour.

    --live measures the native and the Python callback, idle and under load; the latency of a tap;
    and processor time and terminal traffic of a session. It plays sounds for 22 minutes by default
    (one minute with --rounds 1 --seconds 6).
    """
    if (live and plot is not None) or (device is not None and not live):
        raise click.UsageError("--device belongs to --live, and --plot does not")
    try:
        if live:
            announce_compile()
            with progress_bar("playing") as progress:
                played = measure_live(
                    device_named(device), seconds or LIVE_SECONDS, rounds or LIVE_ROUNDS, progress
                )
            show_report(played, live_lines(played), as_json)
            return
        if plot is not None:
            require_writable(plot)
        announce_compile("disk_alone")
        with progress_bar("measuring") as progress:
            report = measure(rounds or SPEED_ROUNDS, seconds or LONGEST_STREAM_S, progress)
        if plot is not None:
            draw(report, plot)
    except OverviewError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    show_report(report, lines(report), as_json)


if __name__ == "__main__":
    command(prog_name="python -m tools.bench")
