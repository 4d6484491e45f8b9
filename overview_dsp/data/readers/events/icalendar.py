"""Reader of calendars (iCalendar, RFC 5545): each VEVENT is an event at its start.

Its first category is the event kind (without one `event`), its summary the label. Times in UTC or
with a known time zone are converted; floating times and dates are not converted. An entry that
recurs (RRULE) is read once, and a note is shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import (
    DEFAULT_KIND,
    ListDescription,
    ListEntry,
    timeline_of,
)
from overview_dsp.data.timeline import time_parsing
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.public import counted

_PROPERTY = re.compile(r"([A-Za-z0-9-]+)((?:;[^:;=]+=(?:\"[^\"]*\"|[^:;]*))*):(.*)", re.DOTALL)
_ESCAPED = re.compile(r"\\(.)", re.DOTALL)

Entry = dict[str, tuple[str, str, int]]
"""Value, parameters and line of each property of a VEVENT; of repeated ones the first."""


def sniff(source: DataFile) -> bool:
    """Return whether the file begins with BEGIN:VCALENDAR."""
    text = source.head_text
    return text is not None and text.lstrip("\ufeff \r\n").upper().startswith("BEGIN:VCALENDAR")


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a calendar (takes `duration_s`); the InputError contains the line."""
    text = source.text
    found = list(_entries(text))
    entries = [one for one in found if one.get("STATUS", ("",))[0].upper() != "CANCELLED"]
    if not entries:
        raise InputError("the calendar has no events; must contain a VEVENT that isn't cancelled")
    moments = [_moment(entry, "DTSTART") for entry in entries]
    zones = {moment.tzinfo is not None for moment in moments}
    notes = []
    if cancelled := len(found) - len(entries):
        notes.append(f"{counted(cancelled, 'cancelled entry')} left out")
    if len(zones) > 1:
        notes.append("entries without a time zone were read as UTC, because others have one")
    if recurring := sum("RRULE" in entry for entry in entries):
        notes.append(f"{recurring} entries recur; only the first time of each was read")
    listed = [_entry(entry, moment) for entry, moment in zip(entries, moments, strict=True)]
    first = min(moments, key=_seconds)
    if len(zones) > 1 and first.tzinfo is None:
        first = first.replace(tzinfo=UTC)
    if first.tzinfo is not None:  # UTC has no daylight saving time
        first = first.astimezone(UTC)
    provenance, length = "events: a calendar (iCalendar)", options.duration_s
    description = ListDescription(source.stem, provenance, tuple(notes), length, first, True)
    return timeline_of(listed, description)


def _entry(entry: Entry, moment: datetime) -> ListEntry:
    begin = _seconds(moment)
    end = _seconds(_moment(entry, "DTEND")) if "DTEND" in entry else begin
    categories = entry.get("CATEGORIES", ("", "", 0))[0].split(",")
    label = _ESCAPED.sub(lambda m: "\n" if m[1] in "nN" else m[1], entry.get("SUMMARY", ("",))[0])
    return ListEntry(
        begin,
        categories[0].strip() or DEFAULT_KIND,
        " ".join(label.split()),
        f"line {entry['DTSTART'][2]}",
        max(begin, end),
        id=entry.get("UID", ("", "", 0))[0] if "RECURRENCE-ID" not in entry else "",
    )


def _seconds(moment: datetime) -> float:
    """Return seconds since 1970; a floating time counts as UTC."""
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _entries(text: str) -> Iterator[Entry]:
    entry: Entry | None = None
    inside: list[str] = []
    for number, line in _unfolded(text):
        match = _PROPERTY.fullmatch(line)
        if match is None:
            continue
        name, value = match[1].upper(), match[3].strip()
        if name == "BEGIN":
            inside.append(value.upper())
            if value.upper() == "VEVENT":
                entry = {}
        elif name == "END":
            if value.upper() == "VEVENT" and entry is not None:
                if "DTSTART" not in entry:
                    raise InputError(f"line {number}: the VEVENT has no DTSTART; add one")
                yield entry
                entry = None
            if inside:
                inside.pop()
        elif entry is not None and inside and inside[-1] == "VEVENT":
            entry.setdefault(name, (value, match[2], number))


def _unfolded(text: str) -> Iterator[tuple[int, str]]:
    """Yield lines with their numbers; folded lines (RFC 5545, 3.1) are joined."""
    folded, first = "", 0
    for number, line in enumerate(text.lstrip("\ufeff").splitlines(), 1):
        if line[:1] in (" ", "\t"):
            folded += line[1:]
        else:
            if folded:
                yield first, folded
            folded, first = line, number
    if folded:
        yield first, folded


def _moment(entry: Entry, name: str) -> datetime:
    value, parameters, line = entry[name]
    found = time_parsing.moment(value, "iso") if value[:8].isdigit() else None
    if found is None:
        raise InputError(
            f"line {line}, {name}: {quoted(value)} isn't a time; must have the form 20240603, "
            "20240603T093000 or 20240603T093000Z"
        )
    moment = found.to_datetime()
    if moment.tzinfo is not None:
        return moment
    zone = re.search(r';TZID="?([^";:]+)', parameters, re.IGNORECASE)
    if zone is None:
        return moment
    try:
        return moment.replace(tzinfo=ZoneInfo(zone[1]))
    except (ZoneInfoNotFoundError, ValueError, OSError):
        return moment
