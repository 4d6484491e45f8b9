"""`overview export`: a gesture baked to the haptic formats of phones and controllers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from overview_dsp.cli.actuator_option import actuator_option, calibrated, told
from overview_dsp.cli.common import (
    announce_compile,
    part_of,
    print_json,
    progress_bar,
    window_options,
)
from overview_dsp.cli.timeline_options import (
    open_timeline,
    preset_for,
    preset_option,
    timeline_options,
)
from overview_dsp.gestures.spec import FORMS

FORMAT_NAMES = ("ahap", "haptic", "hjif", "android", "wav4")
DRIVEN = "wav4"
"""The format that an actuator is driven by."""

_SUFFIXES = {"android": ".json", "wav4": ".wav"}


@click.command(
    name="export",
    epilog="Example: overview export match.json --gesture sweep:4 --to ahap -o match.ahap",
)
@click.argument("timeline")
@preset_option
@click.option("--gesture", default="sweep:4", show_default=True, help=FORMS + "; + joins parts.")
@click.option(
    "--to",
    "formats",
    required=True,
    multiple=True,
    type=click.Choice(FORMAT_NAMES),
    help="The format; may be given several times.",
)
@click.option("-o", "--out", help="Of one format: its file. Of several: a name without suffix.")
@click.option(
    "--points",
    default=50.0,
    show_default=True,
    type=click.FloatRange(1.0, 1000.0),
    help="Amplitude points to spend, a second.",
)
@click.option("--tail", default="rest", show_default=True, help="rest, none, or seconds.")
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@actuator_option
@window_options
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(
    timeline: str,
    preset: str | None,
    gesture: str,
    formats: tuple[str, ...],
    out: str | None,
    points: float,
    tail: str,
    seed: int,
    actuator: str | None,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    load: dict[str, Any],
    as_json: bool,
) -> None:
    """Bake a gesture over TIMELINE to a haptic clip, and say how near it is to what was felt.

    An actuator is driven by wav4 alone: the other formats hold how strong it is to feel, and the
    device that plays them makes its drive.
    """
    from overview_dsp.actuators.stage import protected_report
    from overview_dsp.errors import InputError
    from overview_dsp.export import export
    from overview_dsp.gestures import parse_gesture
    from overview_dsp.presets import load_preset
    from overview_dsp.rendering import render, tail_of

    data = open_timeline(timeline, load)
    part = part_of(data, window, zoom_to)
    if part is not None:
        data = data.window(*part)
    chosen = load_preset(preset_for(data, preset))
    movement, rest = parse_gesture(gesture), tail_of(tail)
    driven = calibrated(actuator)
    if driven is not None and DRIVEN not in formats:
        raise InputError(
            f"--actuator {actuator} changes {DRIVEN} alone, which is not among the formats: add "
            f"--to {DRIVEN}, or leave it out"
        )
    announce_compile(*(("drive_block",) if driven else ()))
    with progress_bar("rendering") as tell:
        result = render(data, chosen, movement, seed=seed, tail=rest, actuator=driven)
        tell(1.0)
    reports: list[dict[str, Any]] = []
    for to in dict.fromkeys(formats):
        done = export(result, to, _place(out, to, len(set(formats)) > 1), points)
        report: dict[str, Any] = {"format": to, "files": [str(path) for path in done.files]}
        if done.error is not None:
            report |= {
                "points": done.points,
                "transients": done.transients,
                "median_error_db": round(done.error.median_db, 2),
                "largest_error_db": round(done.error.largest_db, 2),
                "within_step_percent": round(done.error.within_percent, 1),
            }
        else:
            report["actuator"] = protected_report(driven, result.protected)
        reports.append(report)
    if as_json:
        print_json(reports)
        return
    for report in reports:
        files = " and ".join(report["files"])
        if "points" not in report:
            click.echo(f"{files}: four channels, clicks on 1 and 2, vibration on 3 and 4")
            if driven and result.protected:
                click.echo(told(driven, result.protected))
            continue
        click.echo(
            f"{files}: {report['points']} points, {report['transients']} strikes; against the "
            f"rendered envelope {report['median_error_db']:.1f} dB (median), "
            f"{report['within_step_percent']:.0f} % of the clip within a step of 2.3 dB"
        )


def _place(out: str | None, to: str, several: bool) -> Path:
    suffix = _SUFFIXES.get(to, f".{to}")
    if out is None:
        return Path(f"out{suffix}")
    if several:
        return Path(out).with_name(Path(out).name + suffix)
    return Path(out)
