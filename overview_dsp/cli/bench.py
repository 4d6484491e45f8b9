"""`overview bench`: how fast the engine runs here."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click

from overview_dsp.cli.common import announce_compile, progress_bar, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option, refuse_options
from overview_dsp.cli.options.output import DEVICE
from overview_dsp.live.output.portaudio_library import device_named

SPEED_ROUNDS = 7
LIVE_ROUNDS = 5
LIVE_SECONDS = 60.0


@cli_command("bench --rounds 5", name="bench")
def command(
    *,
    rounds: int | None = option(
        f"Rounds of each row.  [default: {SPEED_ROUNDS}; with --live {LIVE_ROUNDS}]",
        type=click.IntRange(1, 1000),
    ),
    live: bool = option("Play: callback times, frames lost, control latency."),
    device: str | None = DEVICE,
    seconds: float | None = option(
        f"Duration of each run of --live.  [default: {LIVE_SECONDS:g}]",
        type=click.FloatRange(1.0, 3600.0),
    ),
    as_json: bool = JSON,
) -> None:
    """Measure seconds of sound that the engine makes in one second, on one core.

    With --live: how the native and the Python callback hold, idle and under load, how soon a tap
    is answered, and what processor time and terminal traffic a session costs. That takes four runs
    a round and two more, 22 minutes by default (--rounds 1 --seconds 6: one), and sounds.

    In a clone of the project, python -m tools.bench measures the same beside versions in C, Faust,
    Csound, scipy and plain Python, and what a second costs as the work grows.
    """
    if live:
        from overview_dsp.measure.bench.live.table import lines as live_lines
        from overview_dsp.measure.bench.live.table import measure_live

        announce_compile()
        with progress_bar("playing") as progress:
            played = measure_live(
                device_named(device), seconds or LIVE_SECONDS, rounds or LIVE_ROUNDS, progress
            )
        show_report(played, live_lines(played), as_json)
        return
    refuse_options("belongs to --live; add --live", "device", "seconds")
    from overview_dsp.measure.bench.speeds import lines, measure

    announce_compile("disk_alone")
    with progress_bar("measuring") as progress:
        report = measure(rounds or SPEED_ROUNDS, progress)
    show_report(report, lines(report), as_json)


def show_report(report: Any, lines: Iterable[str], as_json: bool) -> None:
    """Show a report with the machine and the day, without which no figure means anything."""
    from dataclasses import asdict
    from datetime import date

    from overview_dsp.measure.bench.speeds import this_machine

    machine, day = this_machine(), date.today().isoformat()
    figures = {"machine": machine, "date": day, **asdict(report)}
    show(as_json, figures, f"{day}, {machine}", *lines)
