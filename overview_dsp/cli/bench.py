"""The command `overview bench`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click

from overview_dsp.cli.common import announce_compile, progress_bar, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option

SPEED_ROUNDS = 7


@cli_command("bench --rounds 5", name="bench")
def command(
    *,
    rounds: int = option(type=click.IntRange(1, 1000), default=SPEED_ROUNDS),
    as_json: bool = JSON,
) -> None:
    """Measure the speed of the engine on one core: seconds of sound per second.

    In a clone of the project, python -m tools.bench compares versions in C, Faust, Csound, scipy
    and plain Python; with --live it measures live play.
    """
    from overview_dsp.measure.bench import lines, measure

    announce_compile("disk_alone")
    with progress_bar("measuring") as progress:
        report = measure(rounds, progress)
    show_report(report, lines(report), as_json)


def show_report(report: Any, lines: Iterable[str], as_json: bool) -> None:
    """Print a report with machine and date."""
    from dataclasses import asdict
    from datetime import date

    from overview_dsp.measure.bench import this_machine

    machine, day = this_machine(), date.today().isoformat()
    figures = {"machine": machine, "date": day, **asdict(report)}
    show(as_json, figures, f"{day}, {machine}", *lines)
