"""`overview timeline`: what was understood from a file, and its conversion."""

from __future__ import annotations

from pathlib import Path

import click

import overview_dsp as ov
from overview_dsp.cli.common import print_json
from overview_dsp.cli.common import show as show_report
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.reading import READ_KEYS, Reading, open_timeline
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable


@click.group(name="timeline", epilog="Example: overview timeline show match.json")
def command() -> None:
    """Look at a timeline before it is felt, and convert it."""


@cli_command("timeline show match.json --plot match.png --events", group=command)
def show(
    file: str,
    *,
    events: bool = option("List every event."),
    plot: str | None = option(
        "Draw the curve with its events (.png .svg .pdf).", metavar="OUT.png"
    ),
    as_json: bool = JSON,
    reading: Reading,
) -> None:
    """Show how FILE was interpreted: span, unit, events by kind, gaps, notes, and where it is from.

    FILE is any supported file, detected by content, or the bundled match (world-cup-final-2018). A
    file of several matches is listed unless --select chooses one.
    """
    from overview_dsp.data.readers.data_file import LoadOptions
    from overview_dsp.data.readers.registry import list_matches
    from overview_dsp.data.timeline.describe import describe, describe_json

    if plot is not None:
        from overview_dsp.offline.plots.saving import require_picture

        require_picture(plot)
    if reading.select is None and plot is None:
        matches = list_matches(file, LoadOptions(**reading.load_options()))
        if len(matches) > 1:
            _print_matches(file, matches, as_json)
            return
    data = open_timeline(file, reading)
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


@cli_command("timeline convert goals.csv --select 'France Croatia' -o final.json", group=command)
def convert(
    file: str,
    *,
    output: str = option(
        "A native file (.json), or an event list (.csv).", default="timeline.json"
    ),
    as_json: bool = JSON,
    reading: Reading,
) -> None:
    """Write FILE as a native timeline (.json), or its events alone as an event list (.csv).

    Reading the native file back gives the same timeline.
    """
    from overview_dsp.data.readers.events.event_table import save_events
    from overview_dsp.units import span_text

    suffix = Path(output).suffix.lower()
    if suffix not in (".json", ".csv"):
        raise InputError(
            f"{output}: a timeline is written as .json (native) or .csv (its events); choose one"
        )
    require_writable(output)
    data = open_timeline(file, reading)
    (save_events if suffix == ".csv" else ov.save_timeline)(data, output)
    points = len(data.intensity.value) if data.intensity is not None else 0
    kept = 0 if suffix == ".csv" else points
    left = f", {points} points of the curve left behind" if points > kept else ""
    report = {
        "file": output,
        "title": data.title,
        "duration_s": data.duration_s,
        "events": len(data.events),
        "points": kept,
    }
    line = (
        f"{output}: {data.title or '(no title)'}, {span_text(data.duration_s)}, "
        f"{len(data.events)} events, {kept} points{left}"
    )
    show_report(as_json, report, line)


@cli_command("timeline formats", group=command)
def formats(*, as_json: bool = JSON) -> None:
    """List what can be read, in the order in which a file is tried, with the options of each."""
    from overview_dsp.data.readers.formats import formats as known_formats

    listed = [{"name": f.name, "options": sorted(f.options)} for f in known_formats()]
    lines = []
    for known in known_formats():
        options = " ".join(_OPTIONS[name] for name in sorted(known.options))
        lines.append(f"{known.name}{'  [' + options + ']' if options else ''}")
    end = "any of them may be packed (gzip, bzip2, xz, ZIP); files are told by their content"
    show_report(as_json, {"formats": listed}, *lines, end)


_OPTIONS = {
    "value": "--value-column",
    "time": "--time-column",
    "map": "--map",
    "match": "--select",
    **{name: f"--read {key}" for key, (name, _) in READ_KEYS.items()},
}
"""The option for each argument of `load_timeline`."""


def _print_matches(file: str, matches: tuple[str, ...], as_json: bool) -> None:
    width = len(str(len(matches)))
    show_report(
        as_json,
        {"file": file, "matches": list(matches)},
        f"{file}: {len(matches)} matches; choose one with --select",
        *(f"{number:>{width}}  {line}" for number, line in enumerate(matches, start=1)),
    )
