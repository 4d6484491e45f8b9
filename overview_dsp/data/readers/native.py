"""Native JSON format: one object that contains a Timeline.

::

    {"overview_timeline": 1,                 version of the format, required
     "title": "Home 1-0 Away",               name of the file if left out
     "sides": ["Home", "Away"],              teams 1 and 2, optional
     "duration_s": 5640.0,                   required
     "known_until_s": 3780.0,               end of the known part of a growing timeline, optional
     "start": "2012-09-19T09:30:00-04:00",   calendar moment of time 0, ISO 8601, optional
     "intensity": {"time_s": [0, 5],         } required without events
                   "value": [0.1, 0.4],      }
                   "unit": "dB",             unit optional
                   "percentiles": [1, 99]},  become 0 and 1; default [0, 100]
     "gaps": [[300.0, 310.0]],               optional
     "gap_reasons": ["lead off"],            reason of each gap, optional
     "events": [{"time_s": 786.2, "kind": "goal",
                 "label": "1-0 Parris (pen)", "weight": 1.0, "side": 1}],   the last three optional
     "details": [{"time_s": 783.9, "kind": "touch"}],   shown in windows, optional
     "series": {"per_cent": true},           series for finding events of windows: the curve, or
                                             else time_s, value and unit; optional
     "provenance": "where the data are from",                      optional
     "notes": ["messages for the user"]}                       optional

Unknown keys, wrong types, NaN and Infinity are errors with their location.
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
from overview_dsp.data.timeline.event import FIELDS, MAX_EVENTS
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.intensity import EXTREMES
from overview_dsp.data.timeline.model import Event, Intensity, Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.atomic import write_file

VERSION = 1
"""Version of the format."""

MAX_POINTS = 5_000_000
"""Maximum number of points of a curve, so that the file can be read again."""

_KEY = "overview_timeline"
_TOP_KEYS = (
    _KEY, "title", "sides", "duration_s", "known_until_s", "start", "intensity", "gaps",
    "gap_reasons", "events", "details", "series", "provenance", "notes",
)  # fmt: skip
_INTENSITY_KEYS = ("time_s", "value", "unit", "percentiles")
_SERIES_KEYS = ("per_cent", "time_s", "value", "unit")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a JSON object with the key `overview_timeline`."""
    if not source.looks_like_json or f'"{_KEY}"' not in source.text:
        return False
    return isinstance(source.json, dict) and _KEY in source.json


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a native file (without options); InputError names the file and the location."""
    return decode(source.json, source.stem)


def decode(document: object, default_title: str = "") -> Timeline:
    """Return the Timeline of a parsed native document.

    `document`: parsed JSON.
    `default_title`: title for a document without one.

    InputError: an unknown or missing key, a wrong type, a value out of range; the message has the
    location, such as `events[3].time_s`.
    """
    if isinstance(document, dict) and "until_s" in document:  # the key's name before version 0.2
        document = {("known_until_s" if k == "until_s" else k): v for k, v in document.items()}
    top = _object(document, "the document", _TOP_KEYS, required=(_KEY, "duration_s"))
    version = top[_KEY]
    if isinstance(version, bool) or version != VERSION:
        raise InputError(
            f"{_KEY} is {quoted(version)}; this program reads version {VERSION}: "
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
        sides=tuple(_list(top.get("sides", []), "sides")),
    )
    return replace(timeline, rules=_rules(top["series"], timeline)) if "series" in top else timeline


def encode(timeline: Timeline) -> bytes:
    """Return a Timeline as native JSON in UTF-8, with one line per top-level key and per event.

    InputError: a curve of more than `MAX_POINTS` points.
    """
    values: dict[str, object] = {
        _KEY: VERSION,
        "title": timeline.title,
        "sides": timeline.sides or None,
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
            rows = (
                {name: getattr(event, name) for name in FIELDS if name != "side" or event.side}
                for event in events
            )
            entries[key] = "[\n  " + ",\n  ".join(map(_json, rows)) + "\n ]"
    if timeline.intensity is not None:
        curve = timeline.intensity
        if curve.count > MAX_POINTS:
            raise InputError(
                f"the curve has {curve.count} points; a native file has at most {MAX_POINTS}: give "
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
        Timeline to write.
    path : str or path
        File name.

    Raises
    ------
    InputError
        A curve with too many points, or a path that can't be written.
    OutputError
        The disk is full.

    Examples
    --------
    >>> ov.save_timeline(match, "match.json")
    >>> ov.load_timeline("match.json") == match
    True
    """
    path = validation.path(path, "a timeline's file")
    validation.instance(timeline, Timeline, "timeline", "ov.load_timeline gives one")
    write_file(path, encode(timeline))


def _series(rules: WindowRules, curve: Intensity | None) -> str:
    """Return the series in which events of windows are found, without values if it is the curve."""
    series = rules.window_series()
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


def _rules(value: object, timeline: Timeline) -> WindowRules:
    table = _object(value, "series", _SERIES_KEYS, required=("per_cent",))
    per_cent = table.pop("per_cent")
    if not isinstance(per_cent, bool):
        raise InputError(f"series.per_cent is {quoted(per_cent)}; give true or false")
    with validation.prefix_errors("series: "):
        curve = _intensity(table) if table else timeline.intensity
        if curve is None:
            raise InputError("there is no intensity; give time_s and value")
        if curve.last_s > timeline.duration_s:
            raise InputError("it reaches beyond the end of the timeline (duration_s)")
    return rules_of(curve, per_cent, timeline)


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _object(
    value: object, location: str, known: tuple[str, ...], required: tuple[str, ...]
) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{location} is {quoted(value)}, not an object {{...}}")
    for key in value:
        if key not in known:
            raise InputError(
                f"{location} has an unknown key {quoted(key)}; known are {', '.join(known)}"
            )
    for key in required:
        if key not in value:
            raise InputError(f"{location} lacks the key '{key}'; add it")
    return value


def _list(value: object, location: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{location} is {quoted(value)}, not a list [...]")
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
            f"start is {quoted(value)}, not a date and time; write it as ISO 8601, such as "
            "2012-09-19T09:30:00"
        ) from error


def _events(value: object, duration_s: float, key: str = "events") -> tuple[Event, ...]:
    events: list[Event] = []
    hint = f"times are finite seconds from 0 to duration_s ({duration_s!r})"
    listed = _list(value, key)
    if len(listed) > MAX_EVENTS:
        raise InputError(
            f"{key} has {len(listed)} entries, at most {MAX_EVENTS} are allowed; split the "
            "file, or write a curve instead"
        )
    for i, entry in enumerate(listed):
        location = f"{key}[{i}]"
        row = _object(entry, location, FIELDS, required=("time_s", "kind"))
        time_s = validation.number(row["time_s"], f"{location}.time_s", hint)
        if not 0.0 <= time_s <= duration_s:
            raise InputError(f"{location}.time_s is {time_s!r}, outside the timeline; {hint}")
        events.append(
            Event(
                time_s,
                validation.kind(row["kind"], f"{location}.kind"),
                validation.text(row.get("label", ""), f"{location}.label"),
                validation.positive(row.get("weight", 1.0), f"{location}.weight"),
                validation.whole(row.get("side", 0), f"{location}.side", 0, 2),
            )
        )
    return tuple(events)


def _intensity(value: object) -> Intensity:
    table = _object(value, "intensity", _INTENSITY_KEYS, required=("time_s", "value"))
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
