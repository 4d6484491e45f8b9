"""One written time into nanoseconds since 1970 (UTC, or the clock of the file where it names none).

Known ways of writing: ISO 8601 and its relatives (`2012-09-19`, `2012/9/19 09:30`,
`2012-09-19T09:30:00.5+02:00`, `20120919T0930`, `2012-09`, `2012`), day or month first
(`19.09.2012`, `9/19/2012 4:00 PM`), names of months (`Sep 19, 2012`, `19-Sep-12`, `Sep 2012`,
`Wed, 19 Sep 2012 09:30:00 GMT`), quarters and months (`2012Q3`, `2012M09`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date

NS = 1_000_000_000
"""Nanoseconds in a second."""

DAY_NS = 86_400 * NS

_EPOCH_DAY = date(1970, 1, 1).toordinal()
_PIVOT = 69
"""Two-digit years from here are in the 1900s, those below in the 2000s (POSIX)."""

_CLOCK = (
    r"(?P<h>\d{1,2}):(?P<min>\d{2})(?::(?P<s>\d{2})(?:[.,](?P<f>\d{1,9})\d*)?)?"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
)
_NAMED_ZONES_MIN = {
    "WET": 0, "WEST": 60, "CET": 60, "CEST": 120, "EET": 120, "EEST": 180,
    "EST": -300, "EDT": -240, "CST": -360, "CDT": -300, "MST": -420, "MDT": -360,
    "PST": -480, "PDT": -420,
}  # fmt: skip
"""Offsets of zones whose letters tell summer from winter."""

_ZONE = rf"(?:\s*(?P<zone>Z|z|UTC|GMT|{'|'.join(_NAMED_ZONES_MIN)}|[+\-−]\d{{2}}(?::?\d{{2}})?))?"
_THEN_CLOCK = rf"(?:(?:,?\s+|[Tt]){_CLOCK}{_ZONE})?"
_WEEKDAY = r"(?:(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*,?\s+)?"
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_MONTH = r"(?P<name>[A-Za-z]{3,9})\.?"

_ISO = re.compile(
    r"(?P<y>\d{4})(?:(?P<sep>[-/.])(?P<m>\d{1,2})(?:(?P=sep)(?P<d>\d{1,2})" + _THEN_CLOCK + ")?)?",
    re.ASCII,
)
_BASIC = re.compile(
    r"(?P<y>\d{4})(?P<m>\d{2})(?P<d>\d{2})"
    r"(?:[Tt ]?(?P<h>\d{2}):?(?P<min>\d{2})(?::?(?P<s>\d{2})(?:[.,](?P<f>\d{1,9})\d*)?)?"
    + _ZONE
    + ")?",
    re.ASCII,
)
_PARTS = re.compile(
    r"(?P<a>\d{1,2})(?P<sep>[-/. ])\s?(?P<b>\d{1,2})(?P=sep)\s?(?P<y>\d{4}|\d{2})" + _THEN_CLOCK,
    re.ASCII,
)
_NAMED = tuple(
    re.compile(_WEEKDAY + body + _THEN_CLOCK, re.ASCII)
    for body in (
        rf"(?P<d>\d{{1,2}})[-/. ]\s?{_MONTH}[-/., ]\s?(?P<y>\d{{4}}|\d{{2}})",
        rf"{_MONTH}[-/ ](?P<d>\d{{1,2}})(?:,\s?|\s|-|/)(?P<y>\d{{4}})",
        rf"(?P<y>\d{{4}})[-/ ]{_MONTH}[-/ ](?P<d>\d{{1,2}})",
        rf"{_MONTH}[-/ ,]\s?(?P<y>\d{{4}}|\d{{2}})",
        rf"(?P<y>\d{{4}})[-/ ]?{_MONTH}",
    )
)
_QUARTER_FIRST = re.compile(r"([Qq][1-4])[-/ ]?(\d{4})", re.ASCII)
_WEEK = re.compile(r"(?P<y>\d{4})[-/ ]?[Ww](?P<w>\d{2})", re.ASCII)
_PERIOD = re.compile(r"(?P<y>\d{4})[-\s]?(?:Q(?P<q>[1-4])|M(?P<m>\d{1,2}))", re.ASCII | re.I)
_YEAR_MONTH = re.compile(r"(?P<y>\d{4})(?P<m>\d{2})", re.ASCII)
CLOCK = re.compile(
    r"(?:(?P<h>\d{1,4}):)?(?P<min>\d{1,2}):(?P<s>\d{1,2})(?:[.,](?P<f>\d{1,9})\d*)?", re.ASCII
)
_DAY_CLOCK = re.compile(rf"(?P<y>){_CLOCK}", re.ASCII)
_YEAR_2000 = (date(2000, 1, 1).toordinal() - _EPOCH_DAY) * DAY_NS


@dataclass(frozen=True)
class Moment:
    """Nanoseconds since 1970, and the offset from UTC in minutes (None: no zone was written)."""

    ns: int
    offset_min: int | None = None


def iso(text: str) -> Moment | None:
    """Year first, with separators or (from the day on) without."""
    found = _ISO.fullmatch(text) or _BASIC.fullmatch(text)
    return None if found is None else _moment(found, found["m"] or "1", found["d"] or "1")


def day_first(text: str) -> Moment | None:
    """`19/9/2012`, `19.09.12 16:00`."""
    found = _PARTS.fullmatch(text)
    return None if found is None else _moment(found, found["b"], found["a"])


def month_first(text: str) -> Moment | None:
    """`9/19/2012`, `09-19-12 4:00 PM`."""
    found = _PARTS.fullmatch(text)
    return None if found is None else _moment(found, found["a"], found["b"])


def month_named(text: str) -> Moment | None:
    """`Sep 19, 2012`, `19-Sep-12`, `September 2012`."""
    for pattern in _NAMED:
        found = pattern.fullmatch(text)
        if found is None:
            continue
        name = found["name"].lower()
        if name[:3] not in _MONTHS:
            return None
        day = found["d"] if "d" in pattern.groupindex else "1"
        return _moment(found, str(_MONTHS.index(name[:3]) + 1), day)
    return None


def period(text: str) -> Moment | None:
    """`2012Q3`, `Q3 2012`, `2012-M09`, `2012-W38`: the beginning of it."""
    week = _WEEK.fullmatch(text)
    if week is not None:
        try:
            monday = date.fromisocalendar(int(week["y"]), int(week["w"]), 1)
        except ValueError:
            return None
        return iso(monday.isoformat())
    found = _PERIOD.fullmatch(_QUARTER_FIRST.sub(r"\2\1", text))
    if found is None:
        return None
    month = int(found["m"]) if found["m"] else 3 * int(found["q"]) - 2
    return _moment(found, str(month), "1")


def clock_seconds(text: str) -> float | None:
    """Seconds of `1:02:03.5` or `62:03`."""
    found = CLOCK.fullmatch(text)
    if found is None or int(found["s"]) >= 60 or (found["h"] and int(found["min"]) >= 60):
        return None
    whole = int(found["h"] or 0) * 3600 + int(found["min"]) * 60 + int(found["s"])
    return whole + int((found["f"] or "0").ljust(9, "0")) / NS


def year_month(text: str) -> Moment | None:
    """`201209`: the beginning of it."""
    found = _YEAR_MONTH.fullmatch(text)
    return None if found is None else _moment(found, found["m"], "1")


def day_clock_seconds(text: str) -> float | None:
    """Seconds since midnight of `8:00`, `18:30:15`, `8:00 PM`."""
    found = _DAY_CLOCK.fullmatch(text)
    if found is None:
        return None
    moment = _moment(found, "1", "1")
    return None if moment is None else (moment.ns - _YEAR_2000) / NS


WAYS: dict[str, Callable[[str], Moment | None]] = {
    "iso": iso,
    "dmy": day_first,
    "mdy": month_first,
    "month names": month_named,
    "quarters, months or weeks": period,
    "yyyymm": year_month,
}
"""Ways of writing a date, by the name shown to a person."""


def _moment(found: re.Match[str], month: str, day: str) -> Moment | None:
    year = int(found["y"] or 2000)
    if len(found["y"]) == 2:
        year += 1900 if year >= _PIVOT else 2000
    try:
        days = date(year, int(month), int(day)).toordinal() - _EPOCH_DAY
    except ValueError:  # the 30th of February, month 13, year 0
        return None
    parts = found.groupdict()
    if not parts.get("h"):
        return Moment(days * DAY_NS)
    hour, minute, second = (int(parts[key] or 0) for key in ("h", "min", "s"))
    half = parts.get("half")
    if half:
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if half in "Pp" else 0)
    if minute >= 60 or second >= 60 or hour > 24 or (hour == 24 and (minute or second)):
        return None
    ns = days * DAY_NS + (hour * 3600 + minute * 60 + second) * NS
    ns += int((parts["f"] or "0").ljust(9, "0"))
    zone = parts.get("zone")
    if not zone:
        return Moment(ns)
    offset = _NAMED_ZONES_MIN.get(zone, 0)
    if zone[0] in "+-−":
        figures = zone[1:].replace(":", "").ljust(4, "0")
        if int(figures[:2]) >= 24 or int(figures[2:]) >= 60:
            return None
        offset = (int(figures[:2]) * 60 + int(figures[2:])) * (1 if zone[0] == "+" else -1)
    return Moment(ns - offset * 60 * NS, offset)
