"""The native JSON format: one object that holds a whole Timeline.

::

    {"overview_timeline": 1,                 the format's version, required
     "title": "Home 1-0 Away",               the file's name if left out
     "duration_s": 5640.0,                   required
     "known_until_s": 3780.0,                      up to where it has happened, all if left out
     "start": "2012-09-19T09:30:00-04:00",   calendar moment of time 0, ISO 8601, optional
     "intensity": {"time_s": [0, 5],         } either of these two
                   "value": [0.1, 0.4],      } may be left out
                   "unit": "dB",             unit optional
                   "percentiles": [1, 99]},  what becomes 0 and 1, [0, 100] if left out
     "gaps": [[300.0, 310.0]],               optional
     "gap_reasons": ["lead off"],            why, a text for each gap, optional
     "events": [{"time_s": 786.2, "kind": "goal",
                 "label": "1-0 Parris (pen)", "weight": 1.0}],     label, weight optional
     "details": [{"time_s": 783.9, "kind": "touch"}],   felt when zoomed, as events; optional
     "series": {"per_cent": true},           events of windows are found in the curve, or in the
                                             time_s, value and unit beside per_cent; optional
     "provenance": "where the data are from",                      optional
     "notes": ["what a person should know"]}                       optional

Unknown keys, wrong types, NaN and Infinity are errors that name their place.
"""

from __future__ import annotations

import json
import os
from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.analysis.series_events import Series, WindowRules, rules_of
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.timeline.event import MAX_EVENTS
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.intensity import EXTREMES
from overview_dsp.data.timeline.model import Event, Intensity, Timeline
from overview_dsp.errors import InputError, shown
from overview_dsp.files.atomic import whole_file

VERSION = 1
"""The version of the format this module reads and writes."""

MAX_POINTS = 5_000_000
"""Points of a curve in a native file: about as many as a file that can be read again holds."""

_KEY = "overview_timeline"
_TOP_KEYS = (
    _KEY, "title", "duration_s", "known_until_s", "start", "intensity", "gaps", "gap_reasons",
    "events", "details", "series", "provenance", "notes",
)  # fmt: skip
_INTENSITY_KEYS = ("time_s", "value", "unit", "percentiles")
_SERIES_KEYS = ("per_cent", "time_s", "value", "unit")
_EVENT_KEYS = ("time_s", "kind", "label", "weight")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a JSON object with the key `overview_timeline`."""
    if not source.looks_like_json or f'"{_KEY}"' not in source.text:
        return False
    return isinstance(source.json, dict) and _KEY in source.json


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a native file (takes no options); InputError names the file and the place."""
    document = source.json  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        return decode(document, source.stem)


def decode(document: object, default_title: str = "") -> Timeline:
    """Make a Timeline of a parsed native document.

    Parameters
    ----------
    document
        What `source.parse_json` gives.
    default_title
        The title if the document has none.

    Raises
    ------
    InputError
        An unknown or missing key, a wrong type, a broken invariant; the line names the place,
        such as `events[3].time_s`.
    """
    if isinstance(document, dict) and "until_s" in document:  # the key's name before version 0.2
        document = {("known_until_s" if k == "until_s" else k): v for k, v in document.items()}
    top = _table(document, "the document", _TOP_KEYS, required=(_KEY, "duration_s"))
    version = top[_KEY]
    if isinstance(version, bool) or version != VERSION:
        raise InputError(
            f"{_KEY} is {shown(version)}; this program reads version {VERSION}: "
            "update it, or write the file in that version"
        )
    duration_s = validation.positive(
        top["duration_s"], "duration_s", "a duration is a finite number of seconds above 0"
    )
    timeline = Timeline(
        title=top.get("title", default_title),
        duration_s=duration_s,
        events=_events(top.get("events", []), duration_s),
        details=_events(top.get("details", []), duration_s, "details"),
        intensity=_intensity(top["intensity"]) if "intensity" in top else None,
        gaps=_gaps(top.get("gaps", [])),
        gap_reasons=tuple(_list(top.get("gap_reasons", []), "gap_reasons")),
        provenance=top.get("provenance", ""),
        notes=tuple(_list(top.get("notes", []), "notes")),
        start=_moment(top["start"]) if "start" in top else None,
        known_until_s=top.get("known_until_s"),
    )
    return replace(timeline, rules=_rules(top["series"], timeline)) if "series" in top else timeline


def encode(timeline: Timeline) -> bytes:
    """Return a Timeline as native JSON, UTF-8: one line a top-level key, one line an event.

    Raises
    ------
    InputError
        A curve of more than `MAX_POINTS` points.
    """
    values: dict[str, object] = {
        _KEY: VERSION,
        "title": timeline.title,
        "duration_s": timeline.duration_s,
        "known_until_s": timeline.known_until_s,
        "start": timeline.start.isoformat() if timeline.start is not None else None,
        "provenance": timeline.provenance or None,
        "notes": timeline.notes or None,
        "gaps": timeline.gaps or None,
        "gap_reasons": timeline.gap_reasons or None,
    }
    entries = {key: _json(value) for key, value in values.items() if value is not None}
    for key, events in (("events", timeline.events), ("details", timeline.details)):
        if events:
            entries[key] = "[\n  " + ",\n  ".join(map(_row, events)) + "\n ]"
    if timeline.intensity is not None:
        curve = timeline.intensity
        if curve.count > MAX_POINTS:
            raise InputError(
                f"the curve has {curve.count} points; a native file holds up to {MAX_POINTS}, give "
                "a shorter window"
            )
        scaled = curve.percentiles != EXTREMES
        scale = f', "percentiles": {_json(curve.percentiles)}' if scaled else ""
        entries["intensity"] = _points(curve, f'"unit": {_json(curve.unit)}{scale},\n')
    if isinstance(timeline.rules, WindowRules):
        entries["series"] = _series(timeline.rules, timeline.intensity)
    return ("{" + ",\n ".join(f'"{key}": {body}' for key, body in entries.items()) + "}\n").encode()


def _points(curve: Intensity | Series, first: str) -> str:
    return (
        f'{{{first}  "time_s": {_json(curve.time_s.tolist())},\n'
        f'  "value": {_json(curve.value.tolist())}}}'
    )


def save_timeline(timeline: Timeline, path: str | os.PathLike[str]) -> None:
    """Write a timeline in the native JSON format, whole or not at all.

    Parameters
    ----------
    timeline : Timeline
        What is written.
    path : str or path
        The file.

    Raises
    ------
    InputError
        A curve of too many points for a JSON file, a place that can't be written.
    OutputError
        A full disk.

    Examples
    --------
    >>> ov.save_timeline(match, "match.json")
    >>> ov.load_timeline("match.json") == match
    True
    """
    path = validation.path(path, "a timeline's file")
    validation.instance(timeline, Timeline, "timeline", "ov.load_timeline gives one")
    data = encode(timeline)
    with whole_file(path) as temporary:
        temporary.write_bytes(data)


def _series(rules: WindowRules, curve: Intensity | None) -> str:
    """The series in which a window's events are found: the curve itself where it is that."""
    series = rules.part()
    shared = f'"per_cent": {_json(series.relative)}'
    same = curve is not None and (
        rules.curve is not None
        or (
            np.array_equal(curve.time_s, series.time_s)
            and np.array_equal(curve.value, series.value)
        )
    )
    if same or len(series.value) > MAX_POINTS:
        return f"{{{shared}}}"
    return _points(series, f'{shared}, "unit": {_json(series.unit)},\n')


def _rules(given: object, timeline: Timeline) -> WindowRules:
    table = _table(given, "series", _SERIES_KEYS, required=("per_cent",))
    per_cent = table.pop("per_cent")
    if not isinstance(per_cent, bool):
        raise InputError(f"series.per_cent is {shown(per_cent)}; give true or false")
    with validation.located("series: "):
        curve = _intensity(table) if table else timeline.intensity
        if curve is None:
            raise InputError("there is no intensity that it could be; give time_s and value")
        if curve.last_s > timeline.duration_s:
            raise InputError("it reaches beyond the end of the timeline (duration_s)")
    return rules_of(curve, per_cent, timeline)


def _row(event: Event) -> str:
    return _json({name: getattr(event, name) for name in _EVENT_KEYS})


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _table(
    value: object, place: str, known: tuple[str, ...], required: tuple[str, ...]
) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{place} is {shown(value)}, not an object {{...}}")
    for key in value:
        if key not in known:
            raise InputError(
                f"{place} has an unknown key {shown(key)}; known are {', '.join(known)}"
            )
    for key in required:
        if key not in value:
            raise InputError(f"{place} lacks the key '{key}'; add it")
    return value


def _list(value: object, place: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{place} is {shown(value)}, not a list [...]")
    return value


def _gaps(value: object) -> Gaps:
    gaps: list[tuple[float, float]] = []
    for i, gap in enumerate(_list(value, "gaps")):
        edges = _list(gap, f"gaps[{i}]")
        if len(edges) != 2:
            raise InputError(f"gaps[{i}] has {len(edges)} numbers; a gap is [start_s, end_s]")
        start, end = (validation.number(edge, f"gaps[{i}][{j}]") for j, edge in enumerate(edges))
        gaps.append((start, end))
    return tuple(gaps)


def _moment(value: object) -> datetime:
    text = validation.text(value, "start")
    try:
        return datetime.fromisoformat(text)
    except ValueError as error:
        raise InputError(
            f"start is {shown(value)}, not a date and time; write it as ISO 8601, such as "
            "2012-09-19T09:30:00"
        ) from error


def _events(value: object, duration_s: float, key: str = "events") -> tuple[Event, ...]:
    events: list[Event] = []
    hint = f"times are finite seconds from 0 to duration_s ({duration_s!r})"
    listed = _list(value, key)
    if len(listed) > MAX_EVENTS:
        raise InputError(
            f"{key} has {len(listed)} entries, more than the {MAX_EVENTS} that are read; cut the "
            "file into parts, or make a curve of them"
        )
    for i, entry in enumerate(listed):
        place = f"{key}[{i}]"
        row = _table(entry, place, _EVENT_KEYS, required=("time_s", "kind"))
        time_s = validation.number(row["time_s"], f"{place}.time_s", hint)
        if not 0.0 <= time_s <= duration_s:
            raise InputError(f"{place}.time_s is {time_s!r}, outside the timeline; {hint}")
        events.append(
            Event(
                time_s,
                validation.kind(row["kind"], f"{place}.kind"),
                validation.text(row.get("label", ""), f"{place}.label"),
                validation.positive(row.get("weight", 1.0), f"{place}.weight"),
            )
        )
    return tuple(events)


def _intensity(value: object) -> Intensity:
    table = _table(value, "intensity", _INTENSITY_KEYS, required=("time_s", "value"))
    time_s, value = (
        [
            validation.number(entry, f"intensity.{name}[{i}]")
            for i, entry in enumerate(_list(table[name], f"intensity.{name}"))
        ]
        for name in ("time_s", "value")
    )
    percentiles = _list(table.get("percentiles", list(EXTREMES)), "intensity.percentiles")
    return Intensity(
        np.array(time_s, np.float64),
        np.array(value, np.float64),
        validation.text(table.get("unit", ""), "intensity.unit"),
        tuple(percentiles),
    )
