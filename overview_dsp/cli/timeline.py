"""The command group `overview timeline`, and reports of the content of a timeline."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from datetime import time, timedelta
from pathlib import Path
from typing import Any

import click
import numpy as np

import overview_dsp as ov
from overview_dsp.cli.common import show as show_report
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.reading import READ_KEYS, Reading, open_timeline, open_timelines
from overview_dsp.data.timeline.model import Event, Timeline
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable
from overview_dsp.units import DAYS_FROM_S, clock_text, span_text


@click.group(name="timeline", epilog="Example: overview timeline show match.json")
def command() -> None:
    """Show how a file is interpreted as a timeline, and convert it."""


@cli_command("timeline show match.json --plot match.png --events", group=command)
def show(
    file: str,
    *,
    events: bool = option(),
    plot: str | None = option(metavar="OUT.png"),
    as_json: bool = JSON,
    reading: Reading,
) -> None:
    """Show how FILE is interpreted: duration, unit, events by kind, gaps, notes and source.

    FILE is any supported file, detected by content, or the bundled match (world-cup-final-2018). If
    it has several matches, they are listed unless --select chooses one.
    """
    from overview_dsp.data.readers.data_file import LoadOptions
    from overview_dsp.data.readers.registry import list_matches

    if plot is not None:
        from overview_dsp.offline.plots.style import require_picture

        require_picture(plot)
    if reading.select is None and plot is None:
        matches = list_matches(file, LoadOptions(**reading.load_options()))
        if len(matches) > 1:
            width = len(str(len(matches)))
            head = f"{file}: {len(matches)} matches; choose one with --select"
            rows = (f"{number:>{width}}  {line}" for number, line in enumerate(matches, 1))
            show_report(as_json, {"file": file, "matches": list(matches)}, head, *rows)
            return
    data = open_timeline(file, reading, lists_notes=True)
    if plot is not None:
        from overview_dsp.offline.plots.style import save_picture
        from overview_dsp.offline.plots.timeline import plot_timeline

        save_picture(plot_timeline(data), plot)
    report = {"file": file, "plot": plot, **describe_json(data, events=events)}
    drawn = [] if plot is None else [f"{plot}: intensity curve with events"]
    show_report(as_json, report, describe(data, events=events), *drawn)


@cli_command("timeline convert goals.csv --select 'France Croatia' -o final.json", group=command)
def convert(
    file: str,
    *,
    output: str = option(default="timeline.json"),
    group: str | None = option(metavar="COLUMN"),
    as_json: bool = JSON,
    reading: Reading,
) -> None:
    """Write FILE as a native timeline (.json), or its events as an event list (.csv)."""
    from overview_dsp.data.readers.events.event_table import save_events

    suffix = Path(output).suffix.lower()
    if suffix not in (".json", ".csv"):
        raise InputError(f"{output}: suffix must be .json (native) or .csv (events)")
    written = {}
    if group is None:
        require_writable(output)
        written[output] = open_timeline(file, reading)
    else:
        for text, one in open_timelines(file, group, reading).items():
            words = re.sub(r"[^\w.-]+", "-", text).strip("-.") or "group"
            path = f"{output.removesuffix(Path(output).suffix)}-{words}"
            names = (f"{path}{number}{suffix}" for number in ("", *range(2, len(written) + 3)))
            written[next(name for name in names if name not in written)] = one
        for path in written:
            require_writable(path)
    reports, lines = [], []
    for path, data in written.items():
        (save_events if suffix == ".csv" else ov.save_timeline)(data, path)
        points = len(data.intensity.value) if data.intensity is not None else 0
        kept = 0 if suffix == ".csv" else points
        omitted = f"; {points} points of the curve are not in it" if points > kept else ""
        counts = {"events": len(data.events), "points": kept}
        title, duration_s = data.title, data.duration_s
        reports.append({"file": path, "title": title, "duration_s": duration_s, **counts})
        lines.append(
            f"{path}: {title or '(no title)'}, {span_text(duration_s)}, "
            f"{len(data.events)} events, {kept} points{omitted}"
        )
    show_report(as_json, reports[0] if group is None else {"files": reports}, *lines)


@cli_command("timeline formats", group=command)
def formats(*, as_json: bool = JSON) -> None:
    """List all readable formats, in the order of detection, with the options of each."""
    from overview_dsp.data.readers.formats import formats as known_formats

    listed = [{"name": f.name, "options": sorted(f.options)} for f in known_formats()]
    lines = []
    for known in known_formats():
        options = " ".join(_OPTIONS[name] for name in sorted(known.options))
        lines.append(f"{known.name}{'  [' + options + ']' if options else ''}")
    end = "files can be compressed (gzip, bzip2, xz, ZIP); formats are detected by content"
    show_report(as_json, {"formats": listed}, *lines, end)


_OPTIONS = {
    "value": "--value-column",
    "time": "--time-column",
    "map": "--map",
    "match": "--select",
    **{name: f"--read {key}" for key, (name, _) in READ_KEYS.items()},
}
"""Option for each argument of `load_timeline`."""


_GAPS_SHOWN = 5


def describe(timeline: Timeline, *, events: bool = False) -> str:
    """Return a report of title, span, start, curve, events, gaps, provenance and notes.

    With `events`, one line per event follows.
    """
    return "\n".join(_lines(timeline, events))


def describe_json(timeline: Timeline, *, events: bool = False) -> dict[str, Any]:
    """Return the report as data for JSON: finite numbers, texts and lists."""
    curve = timeline.intensity
    report: dict[str, Any] = {
        "title": timeline.title,
        "sides": list(timeline.sides),
        "duration_s": timeline.duration_s,
        "start": timeline.start.isoformat() if timeline.start is not None else None,
        "unit": curve.unit if curve is not None else None,
        "points": len(curve.value) if curve is not None else 0,
        "lowest": float(np.min(curve.value)) if curve is not None else None,
        "highest": float(np.max(curve.value)) if curve is not None else None,
        "events": len(timeline.events),
        "kinds": timeline.kinds(),
        "details": _counts(timeline.details),
        "gaps": [list(gap) for gap in timeline.gaps],
        "gap_reasons": list(timeline.gap_reasons),
        "gaps_s": sum(end - start for start, end in timeline.gaps),
        "notes": list(timeline.notes),
        "provenance": timeline.provenance,
    }
    if events:
        report["event_list"] = [asdict(event) for event in timeline.events]
    return report


def _lines(timeline: Timeline, events: bool) -> Iterator[str]:
    yield timeline.title or "(no title)"
    yield f"span     {span_text(timeline.duration_s)} ({timeline.duration_s:.10g} s)"
    if timeline.start is not None:
        end = timeline.start + timedelta(seconds=timeline.duration_s)
        yield f"start    {_moment(timeline, 0.0)}, end {end.isoformat(' ', 'seconds')}"
    curve = timeline.intensity
    if curve is None:
        yield "curve    none"
    else:
        low, high = float(np.min(curve.value)), float(np.max(curve.value))
        unit = curve.unit or "no unit given"
        yield f"curve    {len(curve.value)} points, {low:.6g} to {high:.6g}, {unit}"
    kinds = ", ".join(f"{count} {kind}" for kind, count in timeline.kinds().items())
    yield f"events   {len(timeline.events)}{': ' if kinds else ''}{kinds}"
    if timeline.details:
        counts = ", ".join(f"{n} {kind}" for kind, n in _counts(timeline.details).items())
        yield f"details  {len(timeline.details)}: {counts}; shown in windows"
    yield f"gaps     {_gaps(timeline)}"
    if timeline.provenance:
        yield f"from     {timeline.provenance}"
    for note in timeline.notes:
        yield f"note     {note}"
    if events:
        yield ""
        width = max((len(event.kind) for event in timeline.events), default=0)
        numbers: Counter[str] = Counter()
        for event in timeline.events:
            numbers[event.kind] += 1
            name = f"{event.kind}:{numbers[event.kind]}"
            weight = f"  (weight {event.weight:g})" if event.weight != 1.0 else ""
            at = _moment(timeline, event.time_s)
            yield f"{at:>12}  {name:<{width + 4}}  {event.display_label}{weight}".rstrip()


def _counts(events: tuple[Event, ...]) -> dict[str, int]:
    return dict(Counter(event.kind for event in events))


def _moment(timeline: Timeline, time_s: float) -> str:
    if timeline.start is None:
        return clock_text(time_s)
    moment = timeline.start + timedelta(seconds=time_s)
    whole_days = timeline.duration_s >= 30 * DAYS_FROM_S and moment.time() == time()
    return moment.date().isoformat() if whole_days else moment.isoformat(" ", "seconds")


def _gaps(timeline: Timeline) -> str:
    if not timeline.gaps:
        return "none"
    total = span_text(sum(end - start for start, end in timeline.gaps))
    reasons = timeline.gap_reasons or [""] * len(timeline.gaps)
    shown = list(zip(timeline.gaps, reasons, strict=True))[:_GAPS_SHOWN]
    first = "; ".join(
        f"{_moment(timeline, start)} to {_moment(timeline, end)}{f' ({reason})' if reason else ''}"
        for (start, end), reason in shown
    )
    more = "; ..." if len(timeline.gaps) > _GAPS_SHOWN else ""
    return f"{len(timeline.gaps)}, {total} in all: {first}{more}"
