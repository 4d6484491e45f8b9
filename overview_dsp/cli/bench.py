"""The command `overview bench`."""

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
        f"Repeats of each measurement.  [default: {SPEED_ROUNDS}; with --live {LIVE_ROUNDS}]",
        type=click.IntRange(1, 1000),
    ),
    live: bool = option("Measure live play: callback times, lost frames, control latency."),
    device: str | None = DEVICE,
    seconds: float | None = option(
        f"Duration of each run of --live, s.  [default: {LIVE_SECONDS:g}]",
        type=click.FloatRange(1.0, 3600.0),
    ),
    as_json: bool = JSON,
) -> None:
    """Measure the speed of the engine on one core: seconds of sound per second.

    --live measures the native and the Python callback, idle and under load; the latency of a tap;
    and processor time and terminal traffic of a session. It plays sounds for 22 minutes by default
    (one minute with --rounds 1 --seconds 6).

    In a clone of the project, python -m tools.bench compares versions in C, Faust, Csound, scipy
    and plain Python.
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
    refuse_options("needs --live; add it", "device", "seconds")
    from overview_dsp.measure.bench.speeds import lines, measure

    announce_compile("disk_alone")
    with progress_bar("measuring") as progress:
        report = measure(rounds or SPEED_ROUNDS, progress)
    show_report(report, lines(report), as_json)


def show_report(report: Any, lines: Iterable[str], as_json: bool) -> None:
    """Print a report with machine and date."""
    from dataclasses import asdict
    from datetime import date

    from overview_dsp.measure.bench.speeds import this_machine

    machine, day = this_machine(), date.today().isoformat()
    figures = {"machine": machine, "date": day, **asdict(report)}
    show(as_json, figures, f"{day}, {machine}", *lines)
