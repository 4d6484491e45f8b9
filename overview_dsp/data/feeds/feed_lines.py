"""The feed format: JSON, one object a line, each with one of these keys.

| key | value | beside it |
|---|---|---|
| `overview_feed` | 1, the format's version; the first line, and again after a new start | `title`, `unit`, `start`, `provenance`, `notes`, `percentiles`, `silence_s`, `expect_s`, `map` |
| `event` | `{"time_s": 786.2, "kind": "goal", "label": "1-0 Parris", "weight": 1.0}` | `id` |
| `detail` | the same: felt in windows | |
| `sample` | `[time_s, value]` or a list of these | |
| `retract` | an `id`, or an event's time_s, kind and label | |
| `clock` | what time it is, s: all up to then was told | |
| `gap` | `[start_s, end_s]`: nothing is known | `reason` |
| `end` | how long it was, s | `title`, `provenance`, `notes` |

A line with another key is of a later version: it is passed over, and said once. A line that is
broken is passed over too, and said; what comes after it isn't lost.
"""  # noqa: E501

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.intensity import EXTREMES
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

VERSION = 1
HEADER = "overview_feed"
KEYS = (HEADER, "event", "detail", "sample", "retract", "clock", "gap", "end")

MAX_LINE_BYTES = 65_536
"""A longer line is no line of a feed: an event has some hundred bytes."""

_EVENT_KEYS = frozenset({"time_s", "kind", "label", "weight"})
_BESIDE = {
    HEADER: {
        "title", "unit", "start", "provenance", "notes", "percentiles", "silence_s", "expect_s",
        "map",
    },
    "event": {"id"},
    "gap": {"reason"},
    "end": {"title", "provenance", "notes"},
}  # fmt: skip

CLOCK_EVERY_S = 30.0
"""A recorded feed tells its clock so often, s, well within what counts as silence; but in ..."""

MOST_CLOCKS = 1_000
"""... no more than so many lines, of a timeline of years."""

_SCORE = re.compile(r"(?<=\S )\d+[-–]\d+(?= \S)")


def encode_line(what: Mapping[str, Any]) -> str:
    """Return an object as a line of a feed, with its end."""
    return json.dumps(what, ensure_ascii=False, allow_nan=False) + "\n"


def event_object(event: Event) -> dict[str, Any]:
    """Return an event as the feed has it: a label of nothing and a weight of 1 are left out."""
    written: dict[str, Any] = {"time_s": event.time_s, "kind": event.kind}
    if event.label:
        written["label"] = event.label
    if event.weight != 1.0:
        written["weight"] = event.weight
    return written


class Lines:
    """Bytes as they come, cut into lines; a line that is too long is passed over as a whole."""

    def __init__(self) -> None:
        self._rest = b""
        self._passing = False
        self.too_long = 0

    def cut(self, data: bytes) -> Iterator[bytes]:
        """Yield the lines that are whole by now, without their ends."""
        *whole, rest = (self._rest + data).split(b"\n")
        self._rest = b""
        for line in whole:
            if self._passing:
                self._passing = False
            elif len(line) > MAX_LINE_BYTES:
                self.too_long += 1
            else:
                yield line
        if self._passing:
            return
        if len(rest) > MAX_LINE_BYTES:
            self.too_long += 1
            self._passing = True
        else:
            self._rest = rest

    def last(self) -> Iterator[bytes]:
        """Yield a last line that had no end; the next data begin a line."""
        rest, self._rest = self._rest, b""
        passing, self._passing = self._passing, False
        if rest.strip() and not passing:
            yield rest


def take_line(live: LiveTimeline, line: bytes | str) -> str:
    """Do to a timeline what a line of a feed says.

    Returns
    -------
    str
        Which of `KEYS` it was; "" for an empty line, `later` for one of a later version.

    Raises
    ------
    InputError
        It isn't a line of a feed, or says what can't be; nothing is changed.
    """
    try:
        text = line.decode() if isinstance(line, bytes) else line
        if not text.strip():
            return ""
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{_start(line)}: not one JSON object a line ({error})") from None
    if not isinstance(document, dict):
        raise InputError(f"{_start(line)}: not an object {{...}}")
    found = [key for key in KEYS if key in document]
    if not found:
        return "later"
    if len(found) > 1:
        raise InputError(f"{_start(line)}: has both {found[0]} and {found[1]}; write two lines")
    key = found[0]
    more = document.keys() - {key} - _BESIDE.get(key, set())
    if more:
        raise InputError(f"{_start(line)}: {key} has no {shown(min(more))} beside it")
    _take(live, key, document[key], document)
    return key


def _start(line: bytes | str) -> str:
    text = line.decode("utf-8", "replace") if isinstance(line, bytes) else line
    return shown(text.strip()[:60])


def _take(live: LiveTimeline, key: str, value: object, line: Mapping[str, Any]) -> None:
    """Do what a line with one of `KEYS` says."""
    if key == HEADER:
        _take_header(live, value, line)
    elif key == "event":
        given = line.get("id")
        name = None if given is None else validation.text(_as_text(given), "id")
        live.append(events=(event_of(value),), ids=(name,))
    elif key == "detail":
        live.append(details=(event_of(value),))
    elif key == "sample":
        several = isinstance(value, list) and bool(value) and isinstance(value[0], list)
        live.append(intensity=value if several else (value,))  # type: ignore[arg-type]  # checked there
    elif key == "retract":
        what = _as_text(value)
        live.retract(what if isinstance(what, str) else event_of(what))
    elif key == "clock":
        live.append(clock_s=validation.number(value, "clock"))
    elif key == "gap":
        start_s, end_s = _pair(value, "gap")
        live.gap(start_s, end_s, line.get("reason", ""))
    else:
        words = _words(line)
        live.end(None if value is None else validation.number(value, "end"))
        live.describe(**words)


def _take_header(live: LiveTimeline, version: object, line: Mapping[str, Any]) -> None:
    if isinstance(version, bool) or version != VERSION:
        raise InputError(f"{HEADER} is {shown(version)}; this program follows version {VERSION}")
    start = line.get("start")
    if start is not None:
        try:
            start = datetime.fromisoformat(validation.text(start, "start"))
        except ValueError:
            raise InputError(f"start is {shown(start)}; write it as ISO 8601") from None
    percentiles = line.get("percentiles")
    if percentiles is not None:
        percentiles = tuple(_pair(percentiles, "percentiles"))
    live.describe(
        **_words(line),
        unit=_text(line, "unit"),
        start=start,
        percentiles=percentiles,
        silence_s=line.get("silence_s"),
    )
    live.suggest(line.get("expect_s"), line.get("map"))


def _words(line: Mapping[str, Any]) -> dict[str, Any]:
    notes = line.get("notes")
    if notes is not None and not isinstance(notes, list):
        raise InputError(f"notes is {shown(notes)}, not a list")
    return {"title": _text(line, "title"), "provenance": _text(line, "provenance"), "notes": notes}


def _text(line: Mapping[str, Any], key: str) -> str | None:
    value = line.get(key)
    return None if value is None else validation.text(value, key)


def event_of(value: object) -> Event:
    """Return the event that an object of a feed means; InputError names what is wrong."""
    if not isinstance(value, dict):
        raise InputError(f"an event is {shown(value)}, not an object")
    more = value.keys() - _EVENT_KEYS
    if more:
        raise InputError(f"an event has no {shown(min(more))}; it has time_s, kind, label, weight")
    for key in ("time_s", "kind"):
        if key not in value:
            raise InputError(f"an event lacks {key}")
    return Event(**value)


def _as_text(name: object) -> object:
    """An id that is written as a number is the same as its digits."""
    return str(name) if type(name) is int else name


def _pair(value: object, what: str) -> list[float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InputError(f"{what} is {shown(value)}; it is a list of two numbers")
    return [validation.number(one, what) for one in value]


def feed_of(timeline: Timeline) -> Iterator[tuple[float, dict[str, Any]]]:
    """Tell a timeline as a feed.

    The score in the title comes with the end. A curve that was derived from the events isn't told,
    as whoever follows derives it.

    Parameters
    ----------
    timeline
        What is told.

    Yields
    ------
    time_s, line
        When it is told, ascending, and an object of `feed_lines`.
    """
    periods_first = sorted(timeline.events, key=lambda event: event.kind != "period")
    derived, provenance, notes = derive_intensity(periods_first, timeline.duration_s)
    is_derived = derived is not None and derived == timeline.intensity
    words: dict[str, Any] = {
        "title": timeline.title,
        "provenance": timeline.provenance,
        "notes": list(timeline.notes),
    }
    if is_derived:
        words["provenance"] = timeline.provenance.removesuffix(provenance).removesuffix("; ")
        words["notes"] = [one for one in timeline.notes if one not in notes]
    clock_every_s = max(CLOCK_EVERY_S, timeline.duration_s / MOST_CLOCKS)
    header: dict[str, Any] = {
        HEADER: VERSION,
        "title": _SCORE.sub("-", timeline.title),
        "expect_s": timeline.duration_s,
        "silence_s": 4.0 * clock_every_s,
    }
    if timeline.start is not None:
        header["start"] = timeline.start.isoformat()
    curve = None if is_derived else timeline.intensity
    if curve is not None:
        header["unit"] = curve.unit
        if curve.percentiles != EXTREMES:
            header["percentiles"] = list(curve.percentiles)
    yield 0.0, header
    told: list[tuple[float, dict[str, Any]]] = []
    told += [(event.time_s, {"event": event_object(event)}) for event in timeline.events]
    told += [(event.time_s, {"detail": event_object(event)}) for event in timeline.details]
    if curve is not None:
        points = zip(curve.time_s[:].tolist(), curve.value.tolist(), strict=True)
        told += [(point[0], {"sample": list(point)}) for point in points]
    reasons = timeline.gap_reasons or ("",) * len(timeline.gaps)
    for (start, end), reason in zip(timeline.gaps, reasons, strict=True):
        told.append((end, {"gap": [start, end], **({"reason": reason} if reason else {})}))
    clocks = int(timeline.duration_s // clock_every_s)
    told += [(n * clock_every_s, {"clock": n * clock_every_s}) for n in range(1, clocks + 1)]
    told.sort(key=lambda one: one[0])
    yield from told
    yield timeline.duration_s, {"end": timeline.duration_s, **words}
