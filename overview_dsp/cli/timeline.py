"""`overview timeline`: what was understood from a file, and its conversion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from overview_dsp.cli.common import print_json
from overview_dsp.cli.options.timeline import open_timeline, timeline_options


@click.group(name="timeline", epilog="Example: overview timeline show match.json")
def command() -> None:
    """Look at a timeline before it is felt, and convert it."""


@command.command(epilog="Example: overview timeline show match.json --plot match.png --events")
@click.argument("file")
@timeline_options
@click.option("--events", is_flag=True, help="List every event.")
@click.option("--plot", metavar="OUT.png", help="Draw the curve with its events (.png .svg .pdf).")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def show(file: str, load: dict[str, Any], events: bool, plot: str | None, as_json: bool) -> None:
    """What was understood from FILE: span, unit, events by kind, gaps, notes, and where it is from.

    FILE is any supported file, detected by content, or the bundled match (world-cup-final-2018). A
    file of several matches is listed unless --match chooses one.
    """
    from overview_dsp.data.readers.registry import list_matches
    from overview_dsp.data.readers.source import LoadOptions
    from overview_dsp.data.timeline.describe import describe, describe_json

    if plot is not None:
        from overview_dsp.offline.plots.saving import require_picture

        require_picture(plot)
    if "match" not in load and plot is None:
        matches = list_matches(file, LoadOptions(**load))
        if len(matches) > 1:
            _print_matches(file, matches, as_json)
            return
    data = open_timeline(file, load)
    if plot is not None:
        from overview_dsp.offline.plots.saving import save_picture
        from overview_dsp.offline.plots.timeline import plot_timeline

        save_picture(plot_timeline(data), plot)
    if as_json:
        print_json({"file": file, "plot": plot, **describe_json(data, events=events)})
        return
    click.echo(describe(data, events=events))
    if plot is not None:
        click.echo(f"{plot}: the curve with its events")


@command.command(epilog="Example: overview timeline convert goals.csv --match 'France Croatia' "
                 "-o final.json")  # fmt: skip
@click.argument("file")
@timeline_options
@click.option("-o", "--out", default="timeline.json", show_default=True,
              help="A native file (.json), or an event list (.csv).")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def convert(file: str, load: dict[str, Any], out: str, as_json: bool) -> None:
    """Write FILE as a native timeline (.json), or its events alone as an event list (.csv).

    Reading the native file back gives the same timeline.
    """
    from overview_dsp.data.readers import save_timeline
    from overview_dsp.data.readers.events.event_table import save_events
    from overview_dsp.errors import InputError
    from overview_dsp.files.atomic import require_writable
    from overview_dsp.units import span_text

    suffix = Path(out).suffix.lower()
    if suffix not in (".json", ".csv"):
        raise InputError(
            f"{out}: a timeline is written as .json (native) or .csv (its events); choose one"
        )
    require_writable(out)
    data = open_timeline(file, load)
    if suffix == ".csv":
        save_events(data, out)
    else:
        save_timeline(data, out)
    points = len(data.intensity.value) if data.intensity is not None else 0
    kept = 0 if suffix == ".csv" else points
    if as_json:
        print_json(
            {
                "file": out,
                "title": data.title,
                "duration_s": data.duration_s,
                "events": len(data.events),
                "points": kept,
            }
        )
        return
    left = f", {points} points of the curve left behind" if points > kept else ""
    click.echo(
        f"{out}: {data.title or '(no title)'}, {span_text(data.duration_s)}, "
        f"{len(data.events)} events, {kept} points{left}"
    )


@command.command(epilog="Example: overview timeline formats")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def formats(as_json: bool) -> None:
    """What can be read, in the order in which a file is tried, and which options each takes."""
    from overview_dsp.data.readers.formats import formats as known_formats

    if as_json:
        listed = [{"name": f.name, "options": sorted(f.options)} for f in known_formats()]
        print_json({"formats": listed})
        return
    for known in known_formats():
        options = "".join(f" --{_OPTIONS.get(name, name)}" for name in sorted(known.options))
        click.echo(f"{known.name}{'  [' + options.strip() + ']' if options else ''}")
    click.echo("any of them may be packed (gzip, bzip2, xz, ZIP); files are told by their content")


_OPTIONS = {"duration_s": "duration", "max_mb": "max-mb"}


def _print_matches(file: str, matches: tuple[str, ...], as_json: bool) -> None:
    if as_json:
        print_json({"file": file, "matches": list(matches)})
        return
    width = len(str(len(matches)))
    click.echo(f"{file}: {len(matches)} matches; choose one with --match")
    for number, line in enumerate(matches, start=1):
        click.echo(f"{number:>{width}}  {line}")
