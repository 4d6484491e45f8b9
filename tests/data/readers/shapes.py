"""A hundred and more shapes of tables and event lists, generated, each with what is true of it.

Run it (`python -m tests.data.readers.shapes FOLDER`) to write the files and to see what comes of
each.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

FIRST = datetime(2024, 6, 3, 8, 30)
"""The first event: a Monday."""

HAPPENED = (
    (0, "breakfast"), (45, "walk"), (95, "rest"), (130, "walk"), (200, "lunch"), (275, "rest"),
    (390, "walk"), (480, "dinner"),
)  # fmt: skip
"""What happened, minutes after the first."""

ZERO_MIN = 510
"""The time of day of the first event, minutes."""


@dataclass(frozen=True)
class Shape:
    """A file and what is true of it.

    `seconds` and `kinds` are those of its events; `points` of a series; `fix` is what a refusal's
    second line has to say.
    """

    name: str
    data: bytes
    seconds: tuple[float, ...] = ()
    kinds: tuple[str, ...] = ()
    points: int = 0
    duration_s: float | None = None
    fix: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    note: str = ""


def clock(minutes: float) -> str:
    """`8:30` of 510 minutes."""
    return f"{int(minutes) // 60:02d}:{int(minutes) % 60:02d}"


def running(minutes: float) -> str:
    """`0:45:00` of 45 minutes."""
    return f"{int(minutes) // 60}:{int(minutes) % 60:02d}:00"


def moment(minutes: float) -> datetime:
    return FIRST + timedelta(minutes=minutes)


def table(rows: list[list[str]], separator: str = ",", end: str = "\n") -> bytes:
    return (end.join(separator.join(row) for row in rows) + end).encode()


SECONDS = tuple(60.0 * at for at, _ in HAPPENED)
KINDS = tuple(what for _, what in HAPPENED)

WRITTEN: dict[str, tuple[str, Callable[[float], str], float]] = {
    # what: header, how a time is written, what its zero is after the list's, s
    "seconds": ("time", lambda at: f"{60 * at:g}", 0.0),
    "seconds with a unit": ("time (s)", lambda at: f"{60 * at:g}", 0.0),
    "minutes": ("minute", lambda at: f"{at:g}", 0.0),
    "minutes with a unit": ("start (min)", lambda at: f"{at:g}", 0.0),
    "hours": ("time [h]", lambda at: f"{at / 60:.9f}", 0.0),
    "milliseconds": ("start_ms", lambda at: f"{60_000 * at:g}", 0.0),
    "a running clock": ("start", running, 0.0),
    "a time of day": ("time of day", lambda at: clock(ZERO_MIN + at), 0.0),
    "a day's clock with halves": (
        "start", lambda at: f"{moment(at):%I:%M %p}".lstrip("0"), 0.0,
    ),
    "ISO moments": ("date", lambda at: f"{moment(at):%Y-%m-%dT%H:%M:%S}", 0.0),
    "ISO moments in UTC": ("timestamp", lambda at: f"{moment(at):%Y-%m-%dT%H:%M:%SZ}", 0.0),
    "moments with a blank": ("datetime", lambda at: f"{moment(at):%Y-%m-%d %H:%M}", 0.0),
    "moments day first": ("when", lambda at: f"{moment(at):%d.%m.%Y %H:%M}", 0.0),
    "moments with months named": ("date", lambda at: f"{moment(at):%b %d, %Y %H:%M:%S}", 0.0),
    "epoch seconds": ("timestamp", lambda at: f"{1717403400 + 60 * at:.0f}", 0.0),
    "epoch milliseconds": ("ts", lambda at: f"{(1717403400 + 60 * at) * 1000:.0f}", 0.0),
}  # fmt: skip

WORDS = ("event", "what", "kind", "type", "name", "label", "Event Type", "activity")


def quoted(cell: str, separator: str) -> str:
    return f'"{cell}"' if separator in cell else cell


def later(hours: int) -> datetime:
    return FIRST + timedelta(hours=hours)


def event_tables() -> Iterator[Shape]:
    """Every way of writing times under every other name of what happened."""
    separators = (",", ";", "\t", "|")
    for i, (what, (header, written, _)) in enumerate(WRITTEN.items()):
        for k in (i, i + 3):
            word, separator = WORDS[k % len(WORDS)], separators[k % len(separators)]
            rows = [
                [header, word],
                *([quoted(written(at), separator), kind] for at, kind in HAPPENED),
            ]
            yield Shape(
                f"{what} under {header}, {word} ({separator!r})",
                table(rows, separator),
                SECONDS,
                KINDS,
            )


def event_files() -> Iterator[Shape]:
    """What spreadsheets, annotation tools and programs write."""
    plain = [["start", "what"], *([running(at), kind] for at, kind in HAPPENED)]
    body = table(plain)

    def shape(name: str, data: bytes, **more: Any) -> Shape:
        return Shape(name, data, **{"seconds": SECONDS, "kinds": KINDS, **more})

    yield shape("a mark of UTF-8", b"\xef\xbb\xbf" + body)
    yield shape("UTF-16", body.decode().encode("utf-16"))
    yield shape("line ends of Windows", table(plain, ",", "\r\n"))
    yield shape("sep= of a spreadsheet", b"sep=;\r\n" + table(plain, ";", "\r\n"))
    yield shape("comments above", b"# made up\n# for a test\n" + body)
    yield shape("quoted fields", table([[f'"{cell}"' for cell in row] for row in plain]))
    yield shape("empty lines between", body.replace(b"\n", b"\n\n"))
    yield shape("a separator at the end", table([[*row, ""] for row in plain]))
    yield shape("rows out of order", table([plain[0], *plain[:0:-1]]))
    yield shape("upper case", table([["START", "WHAT"], *plain[1:]]))
    yield shape("no header", table(plain[1:]))
    counted = [["#", "Name", "Start", "End", "Length"]]
    counted += [[f"M{i}", kind, running(at), "", ""] for i, (at, kind) in enumerate(HAPPENED)]
    yield shape("REAPER markers", table(counted))
    yield shape(
        "Audacity labels", table([[f"{s:.6f}", f"{s + 9:.6f}", k]
                                  for s, k in zip(SECONDS, KINDS, strict=True)], "\t"),
        duration_s=SECONDS[-1] + 9.0,
    )  # fmt: skip
    yield shape("chapters", b"".join(f"{running(at)} {k}\n".encode() for at, k in HAPPENED))
    yield shape(
        "chapters in brackets",
        b"".join(f"[{running(at)}] - {k}\n".encode() for at, k in HAPPENED),
    )
    cues = "".join(
        f"{i}\n{clock_ms(s)} --> {clock_ms(s + 2)}\n[{k}]\n\n"
        for i, (s, k) in enumerate(zip(SECONDS, KINDS, strict=True), 1)
    )
    yield shape("SubRip cues", cues.encode(), duration_s=SECONDS[-1] + 2.0)
    yield shape(
        "WebVTT cues", ("WEBVTT\n\n" + cues.replace(",", ".")).encode(),
        duration_s=SECONDS[-1] + 2.0,
    )  # fmt: skip
    for name, stamp in (("floating", "%Y%m%dT%H%M%S"), ("in UTC", "%Y%m%dT%H%M%SZ")):
        entries = "".join(
            f"BEGIN:VEVENT\r\nUID:{at}\r\nDTSTART:{moment(at):{stamp}}\r\nCATEGORIES:{kind}\r\n"
            f"SUMMARY:about\r\n  {kind}\r\nEND:VEVENT\r\n"
            for at, kind in HAPPENED
        )
        yield shape(
            f"a calendar, {name}", f"BEGIN:VCALENDAR\r\n{entries}END:VCALENDAR\r\n".encode()
        )
    records = [{"time": 60.0 * at, "event": kind} for at, kind in HAPPENED]
    yield shape("JSON records", json.dumps(records).encode())
    yield shape("JSON records inside", json.dumps({"data": {"events": records}}).encode())
    yield shape("JSON lines", "".join(json.dumps(r) + "\n" for r in records).encode())
    split = [["date", "time", "event"]]
    split += [[f"{moment(at):%Y-%m-%d}", clock(ZERO_MIN + at), kind] for at, kind in HAPPENED]
    yield shape("a date and a clock apart", table(split))
    more = [["id", "time", "event", "weight", "location"]]
    more += [[str(i), f"{60 * at}", k, "2", "home"] for i, (at, k) in enumerate(HAPPENED)]
    yield shape("more columns", table(more))
    twice = [["id", "time", "event"], *([f"{i // 2}", f"{60 * at}", k]
                                        for i, (at, k) in enumerate(HAPPENED))]  # fmt: skip
    yield shape("ids twice", table(twice), note="event ids occur more than once")
    lone = [["time", "event"], *([clock(ZERO_MIN + at), kind] for at, kind in HAPPENED)]
    yield shape(
        "a lone HH:MM", table(lone), seconds=tuple(ZERO_MIN + at for at, _ in HAPPENED),
        note="time='time:hhmm' (--time-column) reads them as hours:minutes",
    )  # fmt: skip
    yield shape("a lone HH:MM, told", table(lone), options={"time": "time:hhmm"})
    teams = [["minute", "event", "player"], *([f"{at}", k, "Ann"] for at, k in HAPPENED)]
    yield shape("minutes of no football", table(teams))
    native = [["time_s", "kind"], *([f"{s}", k] for s, k in zip(SECONDS, KINDS, strict=True))]
    yield shape("the project's own list", table(native))


def clock_ms(seconds: float) -> str:
    whole = int(seconds)
    return f"{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d},000"


VALUES = tuple(20.0 + (7 * i) % 11 for i in range(40))

SERIES: dict[str, tuple[str, Callable[[int], str], float]] = {
    "days": ("date", lambda i: f"{FIRST + timedelta(days=i):%Y-%m-%d}", 86_400.0),
    "days, day first": ("Datum", lambda i: f"{FIRST + timedelta(days=i):%d.%m.%Y}", 86_400.0),
    "hours": ("time", lambda i: f"{later(i):%Y-%m-%d %H:%M}", 3600.0),
    "with an offset": ("time", lambda i: f"{later(i):%Y-%m-%dT%H:%M+02:00}", 3600.0),
    "in summer time": ("time", lambda i: f"{later(i):%Y-%m-%d %H:%M CEST}", 3600.0),
    "seconds": ("seconds", lambda i: f"{i * 0.5:g}", 0.5),
    "time in s": ("time [s]", lambda i: f"{i * 0.5:g}", 0.5),
    "milliseconds": ("t (ms)", lambda i: f"{i * 500}", 0.5),
    "epochs": ("unix", lambda i: f"{1717403400 + 60 * i}", 60.0),
    "the time of day": ("hour", lambda i: clock(300 + 15 * i), 900.0),
    "a running clock": ("elapsed", lambda i: f"0:{i:02d}:00", 60.0),
    "spreadsheet days": ("date", lambda i: f"{45446 + i}", 86_400.0),
    "months": ("month", lambda i: f"{2020 + i // 12}-{i % 12 + 1:02d}", 0.0),
    "years": ("year", lambda i: f"{1980 + i}", 0.0),
    "years under another name": ("season", lambda i: f"{1980 + i}", 0.0),
}  # fmt: skip


def series_tables() -> Iterator[Shape]:
    """Series of forty values, each way of writing times with one or two ways of writing numbers."""
    for i, (what, (header, written, step_s)) in enumerate(SERIES.items()):
        for separator, point in ((",", "."), (";", ","))[: 1 + i % 2]:
            rows = [[header, "temperature (°C)"]]
            rows += [
                [written(k), f"{value:.1f}".replace(".", point)] for k, value in enumerate(VALUES)
            ]
            yield Shape(
                f"a series by {what} ({separator!r})", table(rows, separator), points=len(VALUES),
                duration_s=step_s * (len(VALUES) - 1) or None,
            )  # fmt: skip


def refused_files() -> Iterator[Shape]:
    """What can't be read, and what the second line of the refusal says."""
    values = [f"{value:g}" for value in VALUES]

    def shape(name: str, data: bytes, fix: str) -> Shape:
        return Shape(name, data, fix=fix)

    no_time = "no column is called time, date, start or minute"
    no_words = "no column is called event, what, type, kind, name or label"
    things = [["city", "thing"], ["Bonn", "pen"], ["Rome", "ink"]]
    yield shape("words without times", table(things), no_time)
    yield shape("times and people", table([["time", "person"], ["0:30", "Ann"], ["0:40", "Bob"]]),
                no_words)  # fmt: skip
    yield shape("dates and places", table([["date", "town"], ["2024-06-03", "Bonn"],
                                           ["2024-06-04", "Rome"]]), no_words)  # fmt: skip
    yield shape("times alone", table([["time", "event"], ["0:30", ""], ["0:40", ""]]),
                "no column of numbers besides the times")  # fmt: skip
    yield shape("prose", b"It was a dark and stormy night.\nThe rain fell in torrents.\n",
                "a first row that names the columns")  # fmt: skip
    yield shape("a web page", b"<!DOCTYPE html><html><body>hello</body></html>", "a web page")
    yield shape("XML", b"<?xml version='1.0'?><a><b>1</b></a>", "XML: write the events as CSV")
    yield shape("a spreadsheet", b"\xd0\xcf\x11\xe0" + bytes(600), "save the sheet as CSV")
    yield shape("a PDF", b"%PDF-1.7\n\x00\x01\x02", "a PDF")
    yield shape("a picture", b"\x89PNG\r\n\x1a\n" + bytes(60), "a picture")
    yield shape("a database", b"SQLite format 3\x00" + bytes(60), "a database")
    yield shape("noise", bytes(range(256)) * 4, "nearest: text")
    yield shape("a JSON object", b'{"a": 1, "b": 2}', "a list of records with time and event")
    yield shape("JSON records without times",
                json.dumps([{"city": "Bonn", "thing": "pen"}] * 3).encode(), no_time)  # fmt: skip
    yield shape("JSON records without words",
                json.dumps([{"time": "0:30", "person": "Ann"}] * 3).encode(), no_words)  # fmt: skip
    for header in ("index", "id", "patient", "row"):
        rows = [[header, "level"], *([str(i), value] for i, value in enumerate(values))]
        yield shape(f"a series by {header}", table(rows), "with time (--time-column COLUMN:FORMAT")


def all_shapes() -> list[Shape]:
    """All of them."""
    return [*event_tables(), *event_files(), *series_tables(), *refused_files()]


if __name__ == "__main__":
    from overview_dsp.data.readers import load_timeline
    from overview_dsp.errors import InputError

    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for number, shape in enumerate(all_shapes()):
        path = folder / f"shape-{number:03d}"
        path.write_bytes(shape.data)
        try:
            found: object = load_timeline(path, **shape.options)
        except InputError as error:
            found = error
        print(f"{path.name}  {shape.name}: {found}")
