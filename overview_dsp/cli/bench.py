"""`overview bench`: how fast the engine runs here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from overview_dsp.cli.common import announce_compile, progress_bar, show
from overview_dsp.live.output.device_names import device_named

SPEED_ROUNDS = 7
LIVE_ROUNDS = 5
LIVE_SECONDS = 60.0
LONGEST_S = 600.0


@click.command(name="bench", epilog="Example: overview bench --rounds 5 --plot speeds.png")
@click.option(
    "--rounds",
    type=click.IntRange(1, 1000),
    help=f"Of each row.  [default: {SPEED_ROUNDS}; with --live {LIVE_ROUNDS}]",
)
@click.option("--live", is_flag=True, help="Play: callback times, frames lost, control latency.")
@click.option("--plot", metavar="FILE", help="Draw the speeds: PNG, SVG or PDF.")
@click.option("--device", help="Output for --live, by name or number.  [default: the system's]")
@click.option(
    "--seconds",
    type=click.FloatRange(1.0, 3600.0),
    help=f"The longest stream; with --live, of each run.  "
    f"[default: {LONGEST_S:g}; with --live {LIVE_SECONDS:g}]",
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(
    rounds: int | None,
    live: bool,
    plot: str | None,
    device: str | None,
    seconds: float | None,
    as_json: bool,
) -> None:
    """Seconds of sound made in one second, on one core, beside other ways to do the same work.

    Versions in C, Faust and Csound are measured in a clone of the project where their compilers
    are installed. Then what a second costs as the work grows, and memory. About five minutes;
    with --seconds 3600, streams of an hour too.

    With --live: how the native and the Python callback hold, idle and under load, how soon a tap
    is answered, and what processor time and terminal traffic a session costs. That takes four runs
    a round and two more, 22 minutes by default (--rounds 1 --seconds 6: one), and sounds.
    """
    if live:
        if plot is not None:
            raise click.UsageError("--plot draws speeds; leave out --live")
        _live(rounds or LIVE_ROUNDS, device, seconds or LIVE_SECONDS, as_json)
        return
    if device is not None:
        raise click.UsageError("--device belongs to --live; add --live")
    _speed(rounds or SPEED_ROUNDS, seconds or LONGEST_S, plot, as_json)


def _speed(rounds: int, longest_s: float, plot: str | None, as_json: bool) -> None:
    from overview_dsp.files.atomic import require_writable
    from overview_dsp.measure.bench.picture import draw
    from overview_dsp.measure.bench.report import lines, measure

    if plot is not None:
        require_writable(plot)
    announce_compile("disk_alone")
    with progress_bar("measuring") as progress:
        report = measure(rounds, longest_s, progress)
    if plot is not None:
        draw(report, plot)
    _show(report, lines, as_json)


def _live(rounds: int, device: str | None, seconds: float, as_json: bool) -> None:
    from overview_dsp.measure.bench.live.table import lines, measure_live

    announce_compile()
    with progress_bar("playing") as progress:
        report = measure_live(device_named(device), seconds, rounds, progress)
    _show(report, lines, as_json)


def _show(report: Any, lines: Callable[[Any], list[str]], as_json: bool) -> None:
    """With the machine and the day, without which no figure means anything."""
    from dataclasses import asdict
    from datetime import date

    from overview_dsp.measure.bench.machine import this_machine

    machine, day = this_machine(), date.today().isoformat()
    figures = {"machine": machine, "date": day, **asdict(report)}
    show(as_json, figures, f"{day}, {machine}", *lines(report))
