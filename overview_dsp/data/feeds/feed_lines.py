"""Feed format: one JSON object per line, each with one of these keys.

| key | value | optional further keys |
|---|---|---|
| `overview_feed` | 1, the version; in the first line, and again after each restart | `title`, `sides`, `unit`, `start`, `provenance`, `notes`, `percentiles`, `silence_s`, `expected_duration_s`, `layout` |
| `event` | `{"time_s": 786.2, "kind": "goal", "label": "1-0 Parris", "weight": 1.0, "side": 1}` | `id` |
| `detail` | as `event`; shown in windows only | |
| `sample` | `[time_s, value]` or a list of such pairs | |
| `retract` | an `id`, or the time_s, kind and label of an event | |
| `clock` | current time, s: the feed is complete until this time | |
| `gap` | `[start_s, end_s]`: time range without data | `reason` |
| `end` | final duration, s | `title`, `sides`, `provenance`, `notes` |

A line with another key belongs to a later version. Such a line and an invalid line are skipped,
and a message is shown once. The lines after them are read.
"""  # noqa: E501

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.feeds.live_timeline import LiveTimeline, checked_duration
from overview_dsp.data.timeline.event import FIELDS, Event
from overview_dsp.data.timeline.intensity import EXTREMES
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted

VERSION = 1
HEADER = "overview_feed"
KEYS = (HEADER, "event", "detail", "sample", "retract", "clock", "gap", "end")

MAX_LINE_BYTES = 65_536  # maximum length of a line. An event has about 100 bytes
_FURTHER_KEYS = {
    HEADER: {
        "title", "sides", "unit", "start", "provenance", "notes", "percentiles", "silence_s",
        "expected_duration_s", "layout",
    },
    "event": {"id"},
    "gap": {"reason"},
    "end": {"title", "sides", "provenance", "notes"},
}  # fmt: skip

_RENAMED_KEYS = {"expect_s": "expected_duration_s", "map": "layout"}
"""Keys of the header in feeds that were recorded with version 0.1."""

CLOCK_EVERY_S = 30.0
"""Interval of the clock lines in an exported feed, s, shorter than the default `silence_s`."""

MAX_CLOCK_LINES = 1_000
"""Maximum number of clock lines in an exported feed, which limits them for a timeline of years."""

_SCORE = re.compile(r"(?<=\S )\d+[-–]\d+(?= \S)")


def encode_line(line: Mapping[str, Any]) -> str:
    """Return an object as a line of a feed, with its newline."""
    return json.dumps(line, ensure_ascii=False, allow_nan=False) + "\n"


def event_object(event: Event) -> dict[str, Any]:
    """Return an event as an object of the feed; values that are as usual are omitted."""
    usual = {"label": "", "weight": 1.0, "side": 0}
    fields = {name: getattr(event, name) for name in FIELDS}
    return {name: value for name, value in fields.items() if value != usual.get(name)}


class Lines:
    """Splitter of a byte stream into lines; a line above `MAX_LINE_BYTES` is skipped."""

    def __init__(self) -> None:
        self._rest = b""
        self._skips = False
        self.too_long = 0

    def cut(self, data: bytes) -> Iterator[bytes]:
        """Yield the lines that are complete after `data`, without their newlines."""
        *whole, rest = (self._rest + data).split(b"\n")
        self._rest = b""
        for line in whole:
            if self._skips:
                self._skips = False
            elif len(line) > MAX_LINE_BYTES:
                self.too_long += 1
            else:
                yield line
        if self._skips:
            return
        if len(rest) > MAX_LINE_BYTES:
            self.too_long += 1
            self._skips = True
        else:
            self._rest = rest

    def last(self) -> Iterator[bytes]:
        """Yield a last line without a newline, and start again."""
        rest, self._rest = self._rest, b""
        skips, self._skips = self._skips, False
        if rest.strip() and not skips:
            yield rest


def parse_line(line: bytes | str) -> tuple[str, dict[str, Any]]:
    """Return the key of a line and its object; InputError unless it is in the feed format.

    The key is one of `KEYS`, "" for an empty line, `later` for a later version.
    """
    try:
        text = line.decode() if isinstance(line, bytes) else line
        if not text.strip():
            return "", {}
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{_start(line)}: must be one JSON object ({error})") from None
    if not isinstance(document, dict):
        raise InputError(f"{_start(line)}: must be a JSON object {{...}}")
    found = [key for key in KEYS if key in document]
    if not found:
        return "later", document
    if len(found) > 1:
        raise InputError(
            f"{_start(line)}: has both {found[0]} and {found[1]}; write them as two lines"
        )
    key = found[0]
    if key == HEADER:
        document = {_RENAMED_KEYS.get(name, name): value for name, value in document.items()}
    allowed = _FURTHER_KEYS.get(key, set())
    unknown = document.keys() - {key} - allowed
    if unknown:
        raise InputError(
            f"{_start(line)}: unknown key {quoted(min(unknown))} in a line with {key}; allowed: "
            f"{', '.join(sorted(allowed)) or 'no further key'}"
        )
    return key, document


def _start(line: bytes | str) -> str:
    text = line.decode("utf-8", "replace") if isinstance(line, bytes) else line
    return quoted(text.strip()[:60])


def apply_parsed(live: LiveTimeline, key: str, line: Mapping[str, Any]) -> None:
    """Apply a line with one of `KEYS`; InputError if a value is not allowed."""
    value: Any = line[key]
    if key == HEADER:
        _apply_header(live, value, line)
    elif key == "event":
        id_ = line.get("id")
        id_ = None if id_ is None else validation.text(_as_text(id_), "id")
        live.append(events=(event_of(value),), ids=(id_,))
    elif key == "detail":
        live.append(details=(event_of(value),))
    elif key == "sample":
        several = isinstance(value, list) and bool(value) and isinstance(value[0], list)
        live.append(intensity=value if several else (value,))
    elif key == "retract":
        event = _as_text(value)
        live.retract(event if isinstance(event, str) else event_of(event))
    elif key == "clock":
        live.append(clock_s=validation.number(value, "clock"))
    elif key == "gap":
        start_s, end_s = _pair(value, "gap")
        live.gap(start_s, end_s, line.get("reason", ""))
    else:
        final_s = None if value is None else checked_duration(value, "end")
        live.describe(**_description(line))
        live.end(final_s)  # last: whoever sees the end also sees the final title


def _apply_header(live: LiveTimeline, version: object, line: Mapping[str, Any]) -> None:
    if isinstance(version, bool) or version != VERSION:
        raise InputError(
            f"{HEADER} is {quoted(version)}; must be {VERSION}, the version this program reads"
        )
    start = line.get("start")
    if start is not None:
        try:
            start = datetime.fromisoformat(validation.text(start, "start"))
        except ValueError:
            raise InputError(f"start is {quoted(start)}; must be a date in ISO 8601") from None
    percentiles = line.get("percentiles")
    if percentiles is not None:
        percentiles = tuple(_pair(percentiles, "percentiles"))
    live.describe(
        **({} if live.ended else _description(line)),  # a feed sent again keeps the final title
        unit=_text(line, "unit"),
        start=start,
        percentiles=percentiles,
        silence_s=line.get("silence_s"),
    )
    live.suggest(line.get("expected_duration_s"), line.get("layout"))


def _description(line: Mapping[str, Any]) -> dict[str, Any]:
    notes = line.get("notes")
    if notes is not None:
        validation.of_type(notes, list, "notes", "a list of strings")
    texts = {name: _text(line, name) for name in ("title", "provenance")}
    return {**texts, "notes": notes, "sides": line.get("sides")}


def _text(line: Mapping[str, Any], key: str) -> str | None:
    value = line.get(key)
    return None if value is None else validation.text(value, key)


def event_of(value: object) -> Event:
    """Return the Event of a feed's object; InputError if a key is unknown or missing."""
    value = validation.of_type(value, dict, "the event", "a JSON object {...}")
    unknown = value.keys() - {*FIELDS}
    if unknown:
        raise InputError(
            f"the event has the unknown key {quoted(min(unknown))}; allowed: {', '.join(FIELDS)}"
        )
    for key in ("time_s", "kind"):
        if key not in value:
            raise InputError(f"the event has no {key}; time_s and kind are required")
    return Event(**value)


def _as_text(id_: object) -> object:
    """Return an id that is a number as its digits."""
    return str(id_) if type(id_) is int else id_


def _pair(value: object, name: str) -> list[float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InputError(f"{name} is {quoted(value)}; must be a list of two numbers")
    return [validation.number(one, name) for one in value]


def lines_of_timeline(timeline: Timeline) -> Iterator[tuple[float, dict[str, Any]]]:
    """Yield a timeline as the lines of a feed: times, s, ascending, and JSON objects.

    The score in the title is sent with the end only. A curve that was derived from the events is
    not sent, because the receiver derives it.
    """
    periods_first = sorted(timeline.events, key=lambda event: event.kind != "period")
    derived, provenance, notes = derive_intensity(periods_first, timeline.duration_s)
    is_derived = derived is not None and derived == timeline.intensity
    description: dict[str, Any] = {
        "title": timeline.title,
        "provenance": timeline.provenance,
        "notes": list(timeline.notes),
    }
    if is_derived:
        description["provenance"] = timeline.provenance.removesuffix(provenance).removesuffix("; ")
        description["notes"] = [one for one in timeline.notes if one not in notes]
    clock_every_s = max(CLOCK_EVERY_S, timeline.duration_s / MAX_CLOCK_LINES)
    header: dict[str, Any] = {
        HEADER: VERSION,
        "title": _SCORE.sub("-", timeline.title),
        "expected_duration_s": timeline.duration_s,
        "silence_s": 4.0 * clock_every_s,
    }
    if timeline.start is not None:
        header["start"] = timeline.start.isoformat()
    if timeline.sides:
        header["sides"] = list(timeline.sides)
    curve = None if is_derived else timeline.intensity
    if curve is not None:
        header["unit"] = curve.unit
        if curve.percentiles != EXTREMES:
            header["percentiles"] = list(curve.percentiles)
    yield 0.0, header
    lines: list[tuple[float, dict[str, Any]]] = []
    lines += [(event.time_s, {"event": event_object(event)}) for event in timeline.events]
    lines += [(event.time_s, {"detail": event_object(event)}) for event in timeline.details]
    if curve is not None:
        points = zip(curve.time_s[:].tolist(), curve.value.tolist(), strict=True)
        lines += [(point[0], {"sample": list(point)}) for point in points]
    reasons = timeline.gap_reasons or ("",) * len(timeline.gaps)
    for (start, end), reason in zip(timeline.gaps, reasons, strict=True):
        lines.append((end, {"gap": [start, end], **({"reason": reason} if reason else {})}))
    clocks = int(timeline.duration_s // clock_every_s)
    lines += [(n * clock_every_s, {"clock": n * clock_every_s}) for n in range(1, clocks + 1)]
    yield from sorted(lines, key=lambda line: line[0])
    yield timeline.duration_s, {"end": timeline.duration_s, **description}
