"""Reader of CSV lists with match minutes: the events of a match, or the goals of many matches.

::

    minute,type,player,team
    18,own goal,Mandžukić,Croatia
    45+2,yellow card,Kanté,France
    90+3',goal,Pogba,France

    date,home_team,away_team,team,scorer,minute,own_goal,penalty
    2018-07-15,France,Croatia,France,Mario Mandžukić,18,TRUE,FALSE
    2018-07-15,France,Croatia,Croatia,Ivan Perišić,28,FALSE,FALSE

`COLUMNS` lists the accepted names of the columns, which may be in any order. Other columns are
ignored. Commas, semicolons, tabs or bars separate the fields. `type`, or else the first column
with such texts, is converted to a football event kind (`Goal`, `own goal`, `SavedShot`, `Gelbe
Karte`, `GOAL! Jones scores`, or `Card` with `red` in another column), by `vocabulary.py`. Rows of
other types, such as substitutions, corners and passes, are omitted and counted in a note.

- A list with seconds (`12:34`, or columns minute and second) has exact times from 0.
- A list of minutes only may count from 0 or from 1. An event is at its minute times 60 s, so the
  error is at most 60 s. A list of goals (with a column of scorers and without types) counts from 1,
  and a goal is in the middle of its minute.
- `minutes.py` determines the length of the halves; rows such as `47:30,half-time` set their ends.
- In a list of goals, `team` is the team that scores. In a list of types, the team of an own goal
  is that of the player; the other team scores, and a note is shown.
- A list of several matches (by date, teams, or id of the match) requires the option `match`.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football.match_timeline import (
    SHOOT_OUT,
    MatchEvent,
    match_timeline,
    normalize_text,
    select_match,
    short_name,
    team_index,
)
from overview_dsp.data.readers.football.minutes import (
    ENDS,
    MIDDLE_S,
    Clock,
    Minute,
    check_minute,
    parse_minute,
)
from overview_dsp.data.readers.football.vocabulary import has, is_sentence, meaning, normalize_terms
from overview_dsp.data.readers.tables import column_names
from overview_dsp.data.readers.tables.delimited import records
from overview_dsp.data.readers.tables.dialect import header_dialect
from overview_dsp.data.readers.tables.table import MAX_COLUMNS, CellLocation
from overview_dsp.data.timeline.event import GOALS
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted

COLUMNS: dict[str, list[str]] = column_names.MINUTE_LIST
"""Accepted column names, in lower case and without punctuation and accents."""

PROVENANCE_GOALS = (
    "goals: a CSV list of goals, each in the middle of its minute (within 30 s of the match clock)"
)
PROVENANCE_MINUTES = (
    "events: a CSV list of minutes, each at its minute times 60 s (within 60 s of the match clock)"
)
PROVENANCE_SECONDS = "events: a CSV list with minutes and seconds of the match clock"

STOPPAGE_NOTE = (
    "the list has no length of stoppage time: a half lasts 45 minutes, or until its last listed "
    "minute of stoppage time"
)

_ROWS_CHECKED = 50
_PERIOD_KINDS = ("period", "half_end", "match_end")  # other tables have starts and ends, too
_NOT_SPECIFIC = ("", *_PERIOD_KINDS)
_COLOURS = frozenset({"red", "yellow", "p", "pen", "g", "second yellow card"})
_YES = frozenset({"true", "t", "1", "1.0", "yes", "y", "x", "og", "pen", "p"})
_NO = frozenset({"", "false", "f", "0", "0.0", "no", "n", "na", "nan", "none", "null", "-"})
_NONE = frozenset({"", "na", "n/a", "nan", "none", "null", "-"})
_PERIODS = {
    int(key) if key.isdigit() else None: names
    for key, names in column_names.MINUTE_LIST_PERIODS.items()
}
_HOME = frozenset({"h", "home", "1"})
_AWAY = frozenset({"a", "away", "2"})


@dataclass(frozen=True)
class _Row:
    """Row of a list: its line, and its fields by their keys in `COLUMNS`."""

    line: int
    fields: dict[str, str]
    details: str
    headers: dict[str, str]

    @property
    def location(self) -> str:
        return str(CellLocation(self.line))

    def location_of(self, key: str) -> CellLocation:
        """Return the location of a field."""
        return CellLocation(self.line, self.headers.get(key, key))

    def get(self, key: str) -> str:
        value = self.fields.get(key, "")
        return "" if value.lower() in _NONE else value

    def flag(self, key: str) -> bool:
        value = self.fields.get(key, "").lower()
        if value in _YES or value in _NO:
            return value in _YES
        raise self.location_of(key).error(value, "must be TRUE or FALSE")

    @property
    def match(self) -> tuple[str, str, str, str]:
        return self.get("date"), self.get("home"), self.get("away"), self.get("match")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table with minutes, and with football events or scorers."""
    if source.head_text is None or source.looks_like_json or source.options.time is not None:
        return False  # a requested format of times is that of other tables
    found = header_dialect(source.head_text)
    if found is None or "time_s" in found.header or len(found.header) > MAX_COLUMNS:
        return False
    columns = _columns(found.header)
    timed = columns.get("minute") or columns.get("clock")
    if timed is None:
        return False
    if "minute" in columns and any("scorer" in name for name in columns.get("player", [])):
        return True
    # other tables have minutes, types and teams, too
    return _has_football_kinds(source.head_text, columns, timed[0])


def matches(source: DataFile) -> list[str]:
    """Return a description of each match in the file."""
    return _lines(_grouped(_rows(source.text)))


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`); the InputError contains file and line."""
    return decode(source.text, options.match, source.stem)


def decode(text: str, match: str | None = None, default_title: str = "") -> Timeline:
    """Return the Timeline of one match of a list.

    `text`: text of the file.
    `match`: as `LoadOptions.match`; may be None for a list of one match.
    `default_title`: title if the list has fewer than two teams.

    InputError: the match is unknown or ambiguous, a minute is invalid, or there is a third team.
    """
    grouped = _grouped(_rows(text))
    lines = _lines(grouped)
    ids = [key[3] for key in grouped]
    rows = list(grouped.values())[select_match(lines, match, ids if any(ids) else ())]
    goals_only = not any("kind" in row.fields for row in rows)
    entries: list[tuple[_Row, Minute, str, str]] = []
    ends: dict[int, Minute] = {}
    omitted: Counter[str] = Counter()
    kicks = 0
    for row in rows:
        kind, detail = _meaning(row, goals_only)
        if not row.get("minute") and not row.get("clock"):
            if kind:
                raise row.location_of("minute" if "minute" in row.headers else "clock").missing(
                    "write a minute, such as 38 or 90+3, or remove the row"
                )
            continue
        if detail == "shoot-out":
            kicks += 1
            continue
        if not kind:
            omitted[row.get("kind") or "no type"] += 1
            continue
        minute = _minute(row)
        if minute.period == SHOOT_OUT:
            kicks += 1
        elif kind in ("half_end", "match_end"):
            period = _ended_period(minute, kind)
            if period not in ends or minute.on_clock > ends[period].on_clock:
                ends[period] = minute
        elif kind != "period":
            entries.append((row, minute, kind, detail))
    if not entries and not ends:
        raise InputError(
            "the list has no goal, card, foul or near miss; write them in a column such as type"
        )
    minutes = [minute for _, minute, _, _ in entries]
    if goals_only:
        clock = Clock.from_minutes(
            minutes, extra_time=any(m.base > 90 for m in minutes) or None, back_s=MIDDLE_S
        )
        provenance = PROVENANCE_GOALS
    else:
        clock = Clock.from_minutes(minutes, ends=ends)
        exact = any(minute.seconds is not None for minute in minutes)
        provenance = PROVENANCE_SECONDS if exact else PROVENANCE_MINUTES
    headers = rows[0].headers
    timed = headers.get("minute") or headers["clock"]
    provenance += (
        f"; column {quoted(timed)} (minutes of the match; time='{timed}:s' (--time-column) reads "
        "seconds)"
    )
    teams = _teams(rows)
    match_events = [_match_event(*entry, clock, teams, goals_only) for entry in entries]
    notes = []
    if set(clock.lengths_s) - set(ends):
        notes.append(STOPPAGE_NOTE)
    if kicks:
        notes.append(f"the shoot-out is omitted: {kicks} rows")
    if omitted:
        most = omitted.most_common(6)
        counts = ", ".join(f"{count} {quoted(name)[1:-1]}" for name, count in most)
        more = ", ..." if len(omitted) > len(most) else ""
        notes.append(f"omitted, not a football event kind: {counts}{more}")
    if not goals_only and any(kind == "own_goal" for _, _, kind, _ in entries):
        notes.append("own goals: the team in the list is that of the player; the other team scores")
    return match_timeline(
        teams,
        clock.begins_s,
        clock.duration_s,
        match_events,
        provenance,
        notes,
        default_title=default_title,
        title_parts=[rows[0].get("date")],
    )


def _meaning(row: _Row, goals_only: bool) -> tuple[str, str]:
    own = "own" in row.fields and row.flag("own")
    penalty = "penalty" in row.fields and row.flag("penalty")
    if goals_only:
        return ("own_goal", "") if own else ("goal", "pen" if penalty else "")
    return meaning(normalize_terms(row.get("kind")), row.details, own=own, penalty=penalty)


def _match_event(
    row: _Row, minute: Minute, kind: str, detail: str, clock: Clock, teams: list[str], scores: bool
) -> MatchEvent:
    """Return the event of a row; `scores`: the team of an own goal is the one that scores."""
    name, home, away = row.get("team"), row.get("home"), row.get("away")
    if home and away and name not in (home, away):  # the column has `home` and `away`
        name = home if name.lower() in _HOME else away if name.lower() in _AWAY else name
    team = team_index(name, teams, row.location)
    if kind == "own_goal" and not scores and team is not None:
        team = 1 - team if len(teams) == 2 else None
    player = short_name(row.get("player"))
    text = row.get("label") or (row.get("kind") if is_sentence(row.get("kind")) else "")
    if not player and kind in GOALS:
        player, detail = text, detail if row.get("label") else ""
    elif not player:
        detail = text or detail
    written = str(minute) if minute.seconds is None else ""
    return MatchEvent(clock.time_s(minute), kind, team, player, detail, written, row.location)


def _teams(rows_: Sequence[_Row]) -> list[str]:
    home = next((row.get("home") for row in rows_ if row.get("home")), "")
    away = next((row.get("away") for row in rows_ if row.get("away")), "")
    if home and away and home != away:
        return [home, away]
    names = list(dict.fromkeys(row.get("team") for row in rows_ if row.get("team")))
    if {name.lower() for name in names} <= _HOME | _AWAY and len(names) <= 2:
        names.sort(key=lambda name: name.lower() in _AWAY)
    return names[:2]


def _rows(text: str) -> list[_Row]:
    found = list(records(text))
    if not found:
        raise InputError("the list has no rows below the header; add one row per event")
    rows = [fields for _, fields in found]
    columns = _with_kinds(_columns(list(rows[0])), rows[:_ROWS_CHECKED])
    headers = {key: names[0] for key, names in columns.items()}
    listed = []
    for line, fields in found:
        values = {key: fields[name] for key, name in headers.items()}
        details = " ".join(
            normalize_terms(fields[name], True)
            for name in columns.get("details", [])
            if fields[name] and fields[name].lower() not in _NONE
        )
        listed.append(_Row(line, values, details, headers))
    return listed


def _with_kinds(
    columns: dict[str, list[str]], rows: Sequence[dict[str, str]]
) -> dict[str, list[str]]:
    """Return the columns, with the first that has football events as `kind` if none is named so.

    Most of its different texts must be football terms, and one more specific than a colour.
    """
    if "kind" in columns or any("scorer" in name for name in columns.get("player", [])):
        return columns
    texts = {key: names for key, names in columns.items() if key in ("label", "details")}
    named = {names[0] for key, names in columns.items() if key not in texts}
    for name in rows[0] if rows else ():
        cells = [kind for fields in rows if (kind := normalize_terms(fields[name]))]
        football = [kind for kind in cells if _is_specific(kind) or has("football", kind)]
        others = [k for k in cells if meaning(k, "", own=False, penalty=False)[0] in _PERIOD_KINDS]
        is_clear = any(_is_specific(kind) and kind not in _COLOURS for kind in football)
        if name not in named and is_clear and 2 * len({*football, *others}) > len({*cells}):
            kept = {key: names for key, names in columns.items() if names != [name]}
            return {**kept, "kind": [name]}
    return columns


def _columns(header: Sequence[str]) -> dict[str, list[str]]:
    """Return the columns of the header by their keys in `COLUMNS`."""
    names: dict[str, list[str]] = {}
    for name in filter(None, dict.fromkeys(header)):
        normalized = normalize_text(name.replace("_", " ")).replace(" ", "")
        names.setdefault(normalized, []).append(name)
    columns: dict[str, list[str]] = {}
    used: set[str] = set()
    for key, aliases in COLUMNS.items():
        for alias in aliases:
            for name in names.get(alias.replace(" ", ""), ()):
                if name not in used and (key not in columns or key == "details"):
                    columns.setdefault(key, []).append(name)
                    used.add(name)
    return columns


def _grouped(listed: Sequence[_Row]) -> dict[tuple[str, str, str, str], list[_Row]]:
    """Return the rows by match, in order of their first rows."""
    grouped: dict[tuple[str, str, str, str], list[_Row]] = {}
    for row in listed:
        grouped.setdefault(row.match, []).append(row)
    return grouped


def _lines(grouped: dict[tuple[str, str, str, str], list[_Row]]) -> list[str]:
    lines = []
    for (date, home, away, id_), rows in grouped.items():
        teams = f" {_result(rows)} ".join([home, away] if home or away else _teams(rows))
        lines.append("  ".join(part for part in (date, teams, id_) if part) or "the match")
    return lines


def _result(rows: Sequence[_Row]) -> str:
    """Return the score of a match in a list of goals; a dash for a list of types."""
    counts = [0, 0]
    for row in rows:
        sides = (row.get("home"), row.get("away"))
        if "kind" in row.fields or row.get("team") not in sides:
            return "-"
        counts[sides.index(row.get("team"))] += 1
    return f"{counts[0]}-{counts[1]}"


def _minute(row: _Row) -> Minute:
    location = row.location_of("minute" if row.get("minute") else "clock")
    minute = parse_minute(row.get("minute") or row.get("clock"), location)
    for key in ("added", "second"):
        value = row.get(key)
        if not value:
            continue
        number = re.fullmatch(r"\+?([0-9]{1,3})(\.[0-9]{1,6})?", value)
        if number is None or (key == "added" and number[2] and float(number[2]) != 0.0):
            raise row.location_of(key).error(value, "isn't a number of minutes or seconds")
        if key == "added":
            if minute.added is None and (int(number[1]) or minute.base in ENDS.values()):
                added = int(number[1])
                minute = replace(minute, added=added or None)
        else:
            seconds = float(number[1] + (number[2] or ""))
            if seconds >= 60.0:
                raise row.location_of(key).error(
                    seconds, "is out of range; seconds must be 0 to 60"
                )
            minute = replace(minute, seconds=seconds)
    check_minute(minute.base, minute.added, location)
    period = row.get("period")
    return replace(minute, period=_period(period, row.location_of("period"))) if period else minute


def _period(text: str, location: CellLocation) -> int | None:
    normalized = re.sub(r" 0$", "", normalize_terms(text))  # "1.0" in tables of numbers
    for number, names in _PERIODS.items():
        if normalized in names:
            return number
    raise location.error(
        text, "is not a period; must be 1, 2, 3 or 4 (extra time), or 5 (shoot-out)"
    )


def _ended_period(minute: Minute, kind: str) -> int:
    """Return the period that this end of a half or match ends."""
    if minute.period in (1, 2, 3, 4):
        return minute.period
    if kind == "half_end" and minute.base < ENDS[2]:
        return 1
    if minute.base < ENDS[3]:
        return 2
    return 3 if kind == "half_end" and minute.base < ENDS[4] else 4


def _has_football_kinds(head: str, columns: dict[str, list[str]], timed: str) -> bool:
    """Return whether the first rows have minutes and football event kinds.

    With a column of teams or players, or stoppage time (45+2), one such row is enough; else half
    of the rows must have them, a quarter under `minute`.
    """
    complete = head[: head.rfind("\n") + 1] or head
    has_sides = "team" in columns or "player" in columns
    allows_numbers = has_sides or "minute" in columns  # else numbers under `time` are seconds
    football = other = 0
    has_stoppage = False
    try:
        rows = [fields for _, fields in itertools.islice(records(complete), _ROWS_CHECKED)]
        found = _with_kinds(columns, rows)
        if "kind" not in found:
            return False
        for fields in rows:
            kind = normalize_terms(fields[found["kind"][0]])
            names = found.get("details", [])
            details = " ".join(normalize_terms(fields[name], True) for name in names)
            specific = _is_specific(kind, details)
            if specific and has_sides and "kind" in columns and _is_minute(fields[timed]):
                return True
            has_stoppage |= "+" in fields[timed] and _is_minute(fields[timed])
            is_football = specific or has("football", kind)
            football += is_football and _is_minute(fields[timed], allows_numbers)
            other += not specific
    except InputError:  # the reader reports the error
        return False
    most = 3 * football if "minute" in columns and "kind" in columns else football
    return football > 0 and (has_stoppage or most >= other)


def _is_specific(kind: str, details: str = "") -> bool:
    return meaning(kind, details, own=False, penalty=False)[0] not in _NOT_SPECIFIC


def _is_minute(text: str, allows_numbers: bool = True) -> bool:
    if not allows_numbers and text.strip().replace(".", "", 1).isdigit():
        return False
    try:
        parse_minute(text, "")
    except InputError:
        return False
    return True
