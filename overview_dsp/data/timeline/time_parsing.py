"""Parsing of written times: dates, clocks, lengths and minutes of a match.

Dates have one of `FORMS`. With a time zone, they are converted to UTC:

| form | written |
|---|---|
| `iso` | `2012-09-19`, `2012/9/19 09:30`, `2012-09-19T09:30:00.5+02:00`, `20120919T0930`, `2012` |
| (`iso` without marks) | `20120919`, `2012091909`, `201209190930`, `20120919093000` |
| `dmy`, `mdy` | `19.09.2012`, `9/19/2012 4:00 PM` |
| `month names` | `Sep 19, 2012`, `19-Sep-12`, `Sep 2012`, `Wed, 19 Sep 2012 09:30:00 GMT` |
| (in other languages) | `19. März 2012`, `1er août 2012`, `19 de enero de 2012`, `3 paź 2012` |
| `quarters, months or weeks` | `2012Q3`, `Q3 2012`, `2012-M09`, `2012-W38`: its beginning |
| `yyyymm` | `201209` |

Names of months are English, German, French, Spanish, Portuguese, Italian, Dutch, Polish, Turkish,
or those of the Nordic languages except Finnish.

`in_line` finds a time in a line of a log (`LINE_FORMS`) and returns it in one of these forms.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta, timezone
from functools import lru_cache
from typing import Any

import numpy as np

from overview_dsp.arrays import IntArray
from overview_dsp.files.toml import load_toml

NS = 1_000_000_000
"""Nanoseconds in a second."""

DAY_NS = 86_400 * NS

Whole = int | IntArray
Numbers = Callable[[int, int], Any]

_PIVOT = 69
"""Two-digit years from here are in the 1900s, those below in the 2000s (POSIX)."""

_NAMES = load_toml(__file__, "months.toml")
MONTHS: list[str] = _NAMES["english"]
"""English names of the months, in lower case."""

_NAMED_ZONES_MIN: dict[str, int] = _NAMES["zones_min"]

# --- parts of patterns, by the names of their groups

_FRACTION = r"(?:[.,](?P<f>\d{0,9})\d*)?"
_CLOCK = (
    rf"(?P<h>\d{{1,2}}):(?P<min>\d{{2}})(?::(?P<s>\d{{2}}){_FRACTION})?"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
)
_OFFSET = r"[+\-−]\d{2}(?::?\d{2})?"
_ZONE = rf"(?:\s*(?P<zone>Z|z|UTC|GMT|{'|'.join(_NAMED_ZONES_MIN)}|{_OFFSET}))?"
_THEN_CLOCK = rf"(?:(?:,?\s+|[Tt]){_CLOCK}{_ZONE})?"
_LETTER = r"[A-Za-zÀ-ž\u0300-\u036f]"
_WEEKDAY = rf"(?:(?P<weekday>{_LETTER}{{2,13}})\.?,?\s+)?"
_MONTH = rf"(?P<name>{_LETTER}{{3,14}})\.?"
_DAY = r"(?P<d>\d{1,2})(?:er|st|nd|rd|th|[ºª])?"
_OF = r"(?:de\s)?"
_YEAR = r"(?P<y>\d{4})"
_YEAR_2 = r"(?P<y>\d{4}|\d{2})"


def _compiled(*patterns: str, flags: int = 0) -> tuple[re.Pattern[str], ...]:
    return tuple(re.compile(pattern, re.ASCII | flags) for pattern in patterns)


def _in_parts(first: str, second: str) -> tuple[re.Pattern[str], ...]:
    return _compiled(
        rf"(?P<{first}>\d{{1,2}})(?P<sep>[-/. ])\s?(?P<{second}>\d{{1,2}})(?P=sep)\s?{_YEAR_2}"
        + _THEN_CLOCK
    )


FORMS: dict[str, tuple[re.Pattern[str], ...]] = {
    "iso": _compiled(
        rf"{_YEAR}(?:(?P<sep>[-/.])(?P<m>\d{{1,2}})(?:(?P=sep)(?P<d>\d{{1,2}}){_THEN_CLOCK})?)?",
        rf"{_YEAR}(?P<m>\d{{2}})(?P<d>\d{{2}})"
        rf"(?:[Tt ]?(?P<h>\d{{2}})(?::?(?P<min>\d{{2}})(?::?(?P<s>\d{{2}}){_FRACTION})?)?{_ZONE})?",
    ),
    "dmy": _in_parts("d", "m"),
    "mdy": _in_parts("m", "d"),
    "month names": _compiled(
        *(
            _WEEKDAY + written + _THEN_CLOCK
            for written in (
                rf"{_DAY}[-/. ]\s?{_OF}{_MONTH}[-/., ]\s?{_OF}{_YEAR_2}",
                rf"{_MONTH}[-/ ]{_DAY}(?:,\s?|\s|-|/){_YEAR}",
                rf"{_YEAR}[-/ ]{_MONTH}[-/ ](?P<d>\d{{1,2}})",
                rf"{_MONTH}[-/ ,]\s?{_OF}{_YEAR_2}",
                rf"{_YEAR}[-/ ]?{_MONTH}",
            )
        )
    ),
    "quarters, months or weeks": _compiled(
        rf"{_YEAR}[-/ ]?W(?P<w>\d{{2}})",
        rf"{_YEAR}[-\s]?(?:Q(?P<q>[1-4])|M(?P<m>\d{{1,2}}))",
        rf"Q(?P<q>[1-4])[-/ ]?{_YEAR}",
        flags=re.IGNORECASE,
    ),
    "yyyymm": _compiled(rf"{_YEAR}(?P<m>\d{{2}})"),
}
"""Patterns of dates by name of the form; the first that matches is used."""

_LINE_CLOCK = r"(?P<h>\d\d):(?P<min>\d\d):(?P<s>\d\d)"
_LINE_MONTH = rf"(?P<name>{'|'.join(name[:3].title() for name in MONTHS)})"
LINE_FORMS = {
    "iso": re.compile(
        r"(?P<y>\d{4})([-/])(?P<m>\d\d)\2(?P<d>\d\d)[T ](?P<h>\d\d):(?P<min>\d\d)(?::(?P<s>\d\d))?"
        r"(?:[.,](?P<f>\d{1,9})\d*)?(?P<zone>Z| ?[+-]\d\d:?\d\d)?",
        re.ASCII,
    ),
    "web": re.compile(
        rf"(?P<d>\d\d)/{_LINE_MONTH}/{_YEAR}:{_LINE_CLOCK} (?P<zone>[+-]\d\d:?\d\d)", re.ASCII
    ),
    "long": re.compile(
        rf"\b{_LINE_MONTH} +(?P<d>\d{{1,2}}) {_LINE_CLOCK}(?:\.\d+)?(?: (?P<letters>[A-Z]{{3,4}}))?"
        rf" {_YEAR}(?: (?P<zone>[+-]\d\d:?\d\d))?",
        re.ASCII,
    ),
    # day and month in the order of the file, which the whole column determines
    "chat": re.compile(
        r"^[^\w\[]?\[?(?P<a>\d{1,2}(?P<sep>[./-])\d{1,2}(?P=sep)(?:\d{4}|\d\d)),? "
        r"(?P<h>\d{1,2}):(?P<min>\d\d)(?::(?P<s>\d\d))?(?:\s?(?P<half>[AaPp])\.?[Mm]\b\.?)?"
        r"(?=\]| -)"
    ),
    "short": re.compile(rf"^{_LINE_MONTH} +(?P<d>\d{{1,2}}) {_LINE_CLOCK}\b", re.ASCII),
}
"""Patterns of times in lines of a log; `short` has no year and gets year 0000."""

_RUNNING = re.compile(
    rf"(?:(?P<h>\d{{1,4}}):(?=\d{{1,2}}:))?(?P<min>\d{{1,6}}):(?P<s>\d{{1,2}}){_FRACTION}", re.ASCII
)
_DAY_CLOCK = re.compile(_CLOCK, re.ASCII)
_UNITS_S = {
    "": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0, "w": 604_800.0, "y": 31_557_600.0
}  # fmt: skip
_LENGTH = re.compile(
    r"(?P<number>[0-9.]+(?:e[+-]?\d+)?)\s*(?P<unit>s|min|h|d|w|y)?", re.IGNORECASE | re.ASCII
)
# 38  38'  38.0  90+3  90'+3'  90 + 3  12:34  45+2:30
_MINUTE = re.compile(
    r"(?P<base>[0-9]{1,3})(?:\.0+|\s*['’′.]?\s*(?:\+\s*(?P<added>[0-9]{1,2})\s*['’′]?)?"
    r"(?::(?P<s>[0-5][0-9](?:\.[0-9]{1,6})?)\s*['’′]?)?)"
)
_LONGEST_MINUTE = 24  # characters, so that no pattern is tried on a long field


@dataclass(frozen=True)
class Moment:
    """Nanoseconds since 1970, and the offset from UTC in minutes (None: no zone was written)."""

    ns: int
    offset_min: int | None = None

    def to_datetime(self) -> datetime:
        """Return the moment to a microsecond, in its zone if known; may raise OverflowError."""
        plain = datetime(1970, 1, 1) + timedelta(microseconds=self.ns // 1000)
        if self.offset_min is None:
            return plain
        zone = timezone(timedelta(minutes=self.offset_min)) if self.offset_min else UTC
        return plain.replace(tzinfo=UTC).astimezone(zone)


def moment(text: str, *forms: str) -> Moment | None:
    """Return the moment of a text in the first matching form, or None."""
    for form in forms:
        for pattern in FORMS[form]:
            found = pattern.fullmatch(text)
            if found is not None:
                built = _built(found, lambda begin, end: int(text[begin:end]))
                if built is not None:
                    seconds, fraction, offset = built
                    return Moment(seconds * NS + fraction, offset)
                break
    return None


def moments(text: str, form: str, cells: Any) -> tuple[Whole, Whole, Whole | None] | None:
    """Return the moments of texts that differ in digits only; None if one is wrong.

    They are seconds since 1970 in UTC, nanoseconds after them, and offsets from UTC in minutes
    (None: no zone was written).

    `text`, `form`: the first text, and the form of all.
    `cells`: all texts. Its `number` returns their numbers between begin and end of digits; its
    `runs` returns `number` for the first text of each run of texts with the same first characters,
    and the lengths of the runs.
    """
    match = next(filter(None, (pattern.fullmatch(text) for pattern in FORMS[form])), None)
    if match is None or "w" in match.re.groupindex:
        return None
    return _built(match, cells.number, cells.runs)


def in_line(line: str, form: str) -> str | None:
    """Return the time in a line of a log as text for `moment`, or None."""
    match = LINE_FORMS[form].search(line)
    if match is None:
        return None
    found = match.groupdict("")
    clock = f"{found['h'].zfill(2)}:{found['min']}:{found['s'] or '00'}"
    if form == "chat":
        return f"{found['a']} {clock}{f' {half}M' if (half := found['half']) else ''}"
    month = found.get("m") or f"{_month(found['name'], False):02}"
    fraction = f".{found['f']}" if found.get("f") else ""
    letters = found.get("letters", "")
    zone = found.get("zone", "").strip() or (letters if letters in _NAMED_ZONES_MIN else "")
    return f"{found.get('y') or '0000'}-{month}-{int(found['d']):02}T{clock}{fraction}{zone}"


def clock_s(text: str) -> float | None:
    """Return the seconds of `1:02:03.5`, `62:03`, `120:30`; None for other texts."""
    found = _RUNNING.fullmatch(text)
    if found is None or int(found["s"]) >= 60 or (found["h"] and int(found["min"]) >= 60):
        return None
    whole = int(found["h"] or 0) * 3600 + int(found["min"]) * 60 + int(found["s"])
    return whole + int((found["f"] or "0").ljust(9, "0")) / NS


def day_clock_s(text: str) -> float | None:
    """Return the seconds since midnight of `8:00`, `18:30:15`, `8:00 PM`."""
    found = _DAY_CLOCK.fullmatch(text)
    clock = found and _clock(found.groupdict(""), lambda name: int(found[name] or 0))
    return (clock[0] * NS + clock[1]) / NS if clock else None


def length_s(text: str) -> float | None:
    """Return the seconds of a length (`90`, `1:30`, `15min`, `2w`); None for other texts."""
    clock = clock_s(text.strip())
    if clock is not None:
        return clock
    found = _LENGTH.fullmatch(text.strip())
    if found is None:
        return None
    try:
        return float(found["number"]) * _UNITS_S[(found["unit"] or "").lower()]
    except ValueError:  # 1.2.3
        return None


def match_minute(text: str) -> tuple[int, int | None, float | None] | None:
    """Return minute, stoppage time and seconds of `38`, `38'`, `90+3`, `45+2'`, `12:34`."""
    written = text.strip()
    found = None if len(written) > _LONGEST_MINUTE else _MINUTE.fullmatch(written)
    if found is None:
        return None
    added, seconds = found["added"], found["s"]
    return (
        int(found["base"]),
        None if added is None else int(added),
        None if seconds is None else float(seconds),
    )


def _built(match: re.Match[str], number: Numbers, runs: Any = None) -> tuple[Any, Any, Any] | None:
    """Return seconds since 1970, nanoseconds and offset of a match, None for a wrong value.

    `number` returns whole numbers, or arrays of them: the arithmetic is that of both.
    """
    found = match.groupdict("")
    dated, lengths = number, None
    if runs is not None and found.get("h"):
        dated, lengths = runs(match.start("h"))  # consecutive texts often share a day

    def part(name: str, default: int = 0, of: Numbers = dated) -> Any:
        return of(*match.span(name)) if found.get(name) else default

    year, month, day = part("y"), part("m", 1), part("d", 1)
    if len(found["y"]) == 2:
        year = year + 2000 - 100 * (year >= _PIVOT)
    if found.get("q"):
        month = 3 * part("q") - 2
    weekday = found.get("weekday")
    if weekday and plain_letters(weekday)[:2] not in _NAMES["weekdays"]:
        return None
    if name := found.get("name"):
        month = _month(name, is_alone=not found.get("d"))
    leap = (year % 4 == 0) & ((year % 100 != 0) | (year % 400 == 0))
    length = 30 + (month + month // 8) % 2 - (month == 2) * (2 - leap)
    clock = _clock(found, lambda name: part(name, 0, number))
    if _any((year < 1) | (month < 1) | (month > 12) | (day < 1) | (day > length)) or clock is None:
        return None
    # days by years that begin in March
    since = year - (month <= 2)
    days = since * 365 + since // 4 - since // 100 + since // 400
    days = days + (153 * ((month + 9) % 12) + 2) // 5 + day - 719_469
    if found.get("w"):
        try:
            monday = date.fromisocalendar(year, number(*match.span("w")), 1)
        except ValueError:  # week 54
            return None
        days = monday.toordinal() - date(1970, 1, 1).toordinal()
    if isinstance(days, np.ndarray) and lengths is not None:
        days = np.repeat(days, lengths)
    seconds, fraction = days * 86_400 + clock[0], clock[1]
    zone = found.get("zone")
    if not zone:
        return seconds, fraction, None
    offset = _NAMED_ZONES_MIN.get(zone, 0)
    if zone[0] in "+-−":
        begin, end = match.span("zone")
        hours, minutes = number(begin + 1, begin + 3), number(end - 2, end) if len(zone) > 3 else 0
        if _any((hours >= 24) | (minutes >= 60)):
            return None
        offset = (hours * 60 + minutes) * (1 if zone[0] == "+" else -1)
    return seconds - offset * 60, fraction, offset


def _any(wrong: Any) -> bool:
    return bool(wrong if isinstance(wrong, bool) else wrong.any())


@lru_cache(maxsize=256)
def _month(name: str, is_alone: bool) -> int:
    """Return the month of a name or its beginning; 0 for another word, or a beginning of several.

    Without a day (`is_alone`) other letters than three or all of a name are a word of something
    else, unless they are English.
    """
    plain = plain_letters(name)
    english = [i for i, full in enumerate(MONTHS, 1) if full.startswith(plain)]
    if len(english) == 1:
        return english[0]
    months = {
        i
        for i, names in enumerate(_NAMES["others"], 1)
        if any(full.startswith(plain) for full in names.split())
        and (not is_alone or plain in names.split() or len(plain) == 3)
    }
    return months.pop() if len(months) == 1 else 0


def plain_letters(name: str) -> str:
    """Return a name in lower case without accents."""
    letters = unicodedata.normalize("NFKD", name.casefold())
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def _clock(found: dict[str, str], part: Callable[[str], Any]) -> tuple[Any, Any] | None:
    """Return the seconds since midnight and nanoseconds, None for an impossible time."""
    hour, minute, second = part("h"), part("min"), part("s")
    half = found.get("half")
    if half:
        if _any((hour < 1) | (hour > 12)):
            return None
        hour = hour % 12 + (12 if half in "Pp" else 0)
    clock = hour * 3600 + minute * 60 + second
    if _any((minute >= 60) | (second >= 60) | (clock > 86_400)):
        return None
    return clock, part("f") * 10 ** (9 - len(found.get("f", "")))
