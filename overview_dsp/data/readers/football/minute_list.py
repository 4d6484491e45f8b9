"""Lists of minutes as CSV: what happened in a match, or the goals of many matches.

::

    minute,type,player,team
    18,own goal,Mandžukić,Croatia
    45+2,yellow card,Kanté,France
    90+3',goal,Pogba,France

    date,home_team,away_team,team,scorer,minute,own_goal,penalty
    2018-07-15,France,Croatia,France,Mario Mandžukić,18,TRUE,FALSE
    2018-07-15,France,Croatia,Croatia,Ivan Perišić,28,FALSE,FALSE

Columns are known by many names (`COLUMNS`), in any order, and others are ignored; fields are
separated by commas, semicolons, tabs or bars. `type` in any common words (`Goal`, `own goal`,
`SavedShot`, `Second Yellow`, `Card` with another column that says `red`) becomes a football kind;
what is none of them (substitutions, corners, passes) is left out and counted in a note.

- A list with seconds (`12:34`, or columns minute and second) is exact, minutes counting from 0.
- A list of bare minutes doesn't say whether its first minute is called 0 or 1: an event is placed
  at its minute times 60 s, within 60 s of the truth either way. A list of goals (a column of
  scorers and no column of types) counts from 1: a goal is placed in the middle of its minute.
- Halves last as `minutes.py` says; rows such as `47:30,half-time` give their ends.
- In a list of goals, `team` is the one that gets the score. In a list of types an own goal's team
  is that of its player, and the score goes to the other (noted).
- Rows of several matches (by date, home and away team, or a number of the match) need `match`.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football.match import (
    GOALS,
    SHOOT_OUT,
    Happening,
    choose,
    match_timeline,
    plain,
    short_name,
    team_index,
)
from overview_dsp.data.readers.football.minute_words import meaning, words_of
from overview_dsp.data.readers.football.minutes import (
    ENDS,
    Clock,
    Minute,
    check_minute,
    parse_minute,
)
from overview_dsp.data.readers.tables.delimited import records
from overview_dsp.data.readers.tables.dialect import headed
from overview_dsp.data.readers.tables.table import MAX_COLUMNS, CellLocation
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

COLUMNS: dict[str, tuple[str, ...]] = {
    "minute": (
        "minute", "min", "mins", "minutes", "match minute", "minute label", "time elapsed",
    ),
    "clock": ("time", "clock", "match time", "game time", "game clock"),
    "added": (
        "added", "added time", "added minutes", "offset", "extra", "extra minute", "minute extra",
        "time extra", "extra min", "stoppage", "stoppage time", "injury time", "minute stoppage",
    ),
    "second": ("second", "sec", "seconds", "secs"),
    "period": ("period", "half", "period id", "match period", "game period", "period name"),
    "kind": (
        "type", "event", "kind", "event type", "type name", "event name", "incident",
        "incident type", "action", "action type", "result", "outcome", "what", "category",
    ),
    "details": (
        "detail", "details", "outcome", "result", "card", "card type", "subtype", "sub type",
        "outcome type", "shot outcome", "event detail", "goal type", "situation", "description",
        "qualifier",
    ),
    "player": ("player", "player name", "scorer", "name", "goalscorer", "goal scorer", "athlete"),
    "team": ("team", "team name", "club", "side", "squad", "h a", "for team", "scoring team"),
    "home": ("home team", "home", "h team", "hometeam", "home team name", "home club", "team1"),
    "away": ("away team", "away", "a team", "awayteam", "away team name", "away club", "team2"),
    "date": ("date", "match date", "matchdate", "game date", "utc date", "kickoff"),
    "match": ("match id", "matchid", "game id", "gameid", "match", "game", "fixture", "fixture id"),
    "own": ("own goal", "owngoal", "own", "is own goal", "og"),
    "penalty": ("penalty", "pen", "is penalty"),
    "label": ("label", "text", "comment", "note", "commentary"),
}  # fmt: skip
"""What columns are called: names as compared, without case, signs and accents."""

PROVENANCE_GOALS = (
    "goals: a CSV list of goals, each in the middle of its minute (true to 30 s of the match clock)"
)
PROVENANCE_MINUTES = (
    "events: a CSV list of minutes, each at its minute times 60 s (true to 60 s of the match clock)"
)
PROVENANCE_SECONDS = "events: a CSV list with minutes and seconds of the match clock"

STOPPAGE_NOTE = (
    "the list doesn't give the length of stoppage time: a half lasts 45 minutes here, or until its "
    "last listed minute of stoppage time"
)

_MIDDLE_S = 30.0
_SNIFFED = 50
_ANYONES = ("", "period", "half_end", "match_end")  # other things start and end too
_FOOTBALL = re.compile(
    r"substitut|^sub$|corner|offside|throw in|free kick|goal kick|penalty|\bvar\b|tackle|assist"
)
_YES = frozenset({"true", "t", "1", "1.0", "yes", "y", "x", "og", "pen", "p"})
_NO = frozenset({"", "false", "f", "0", "0.0", "no", "n", "na", "nan", "none", "null", "-"})
_NONE = frozenset({"", "na", "n/a", "nan", "none", "null", "-"})
_PERIODS: dict[int | None, tuple[str, ...]] = {
    1: ("1", "1h", "h1", "first half", "1st half", "first", "1st", "firsthalf", "p1", "ht1"),
    2: ("2", "2h", "h2", "second half", "2nd half", "second", "2nd", "secondhalf", "p2", "ht2"),
    3: (
        "3", "e1", "et1", "1et", "extra time 1", "extra time first half", "p3", "extra time",
        "first period of extra time",
    ),
    4: (
        "4", "e2", "et2", "2et", "extra time 2", "extra time second half", "p4",
        "second period of extra time",
    ),
    5: (
        "5", "p", "pso", "so", "penalties", "penalty shootout", "shootout", "shoot out", "pens",
        "penalty shoot out",
    ),
    None: ("pre match", "prematch", "post game", "postgame", "full time", "14", "10", "16"),
}  # fmt: skip
_HOME = frozenset({"h", "home", "1"})
_AWAY = frozenset({"a", "away", "2"})


@dataclass(frozen=True)
class _Row:
    """One row: its line, its fields by what they are (keys of `COLUMNS`)."""

    line: int
    fields: dict[str, str]
    details: str
    headers: dict[str, str]

    @property
    def place(self) -> str:
        return str(CellLocation(self.line))

    def at(self, what: str) -> CellLocation:
        """Return the location of the field that is `what`."""
        return CellLocation(self.line, self.headers.get(what, what))

    def get(self, what: str) -> str:
        value = self.fields.get(what, "")
        return "" if value.lower() in _NONE else value

    def flag(self, what: str) -> bool:
        value = self.fields.get(what, "").lower()
        if value in _YES or value in _NO:
            return value in _YES
        raise self.at(what).error(value, "is no flag; write TRUE or FALSE")

    @property
    def match(self) -> tuple[str, str, str, str]:
        return self.get("date"), self.get("home"), self.get("away"), self.get("match")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table with minutes and with kinds of events or scorers."""
    if source.head_text is None or source.looks_like_json:
        return False
    found = headed(source.head_text)
    if found is None or "time_s" in found.header or len(found.header) > MAX_COLUMNS:
        return False
    columns = _columns(found.header)
    timed = columns.get("minute") or columns.get("clock")
    if timed is None:
        return False
    if "minute" in columns and any("scorer" in name for name in columns.get("player", [])):
        return True
    # other tables have minutes, types and teams too: football's own words must stand beside them
    return "kind" in columns and _speaks_football(source.head_text, columns, timed[0])


def matches(source: DataFile) -> list[str]:
    """Return a line on each match of the file."""
    text = source.text
    with validation.located(f"{source.where}: "):
        return _lines(_grouped(_rows(text)))


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`); InputError names file and line."""
    text = source.text  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        return decode(text, options.match, source.stem)


def decode(text: str, match: str | None = None, default_title: str = "") -> Timeline:
    """Make a Timeline of one match of a list.

    Parameters
    ----------
    text
        The file's text.
    match
        As `LoadOptions.match`; may be None for a list of one match.
    default_title
        The title if the list names fewer than two teams.

    Raises
    ------
    InputError
        No or several such matches; a row whose minute is none or whose team is a third one.
    """
    grouped = _grouped(_rows(text))
    lines = _lines(grouped)
    ids = [key[3] for key in grouped]
    chosen = list(grouped)[choose(lines, match, ids if any(ids) else ())]
    return _timeline(grouped[chosen], default_title)


def _timeline(rows: Sequence[_Row], default_title: str) -> Timeline:
    goals_only = not any("kind" in row.fields for row in rows)
    entries: list[tuple[_Row, Minute, str, str]] = []
    ends: dict[int, Minute] = {}
    left_out: Counter[str] = Counter()
    kicks = 0
    for row in rows:
        kind, detail = _meaning(row, goals_only)
        if not row.get("minute") and not row.get("clock"):
            if kind:
                raise row.at("minute" if "minute" in row.headers else "clock").missing(
                    "write a minute, such as 38 or 90+3, or remove the row"
                )
            continue
        if detail == "shoot-out":
            kicks += 1
            continue
        if not kind:
            left_out[words_of(row.get("kind")) or "no type"] += 1
            continue
        minute = _minute(row)
        if minute.period == SHOOT_OUT:
            kicks += 1
        elif kind in ("half_end", "match_end"):
            period = _ended(minute, kind)
            if period not in ends or minute.on_clock > ends[period].on_clock:
                ends[period] = minute
        elif kind != "period":
            entries.append((row, minute, kind, detail))
    if not entries and not ends:
        raise InputError(
            "no goal, card, foul or near miss in it; name them in a column such as type"
        )
    minutes = [minute for _, minute, _, _ in entries]
    if goals_only:
        clock = Clock.laid(
            minutes, extra_time=any(m.base > 90 for m in minutes) or None, back_s=_MIDDLE_S
        )
        provenance = PROVENANCE_GOALS
    else:
        clock = Clock.laid(minutes, ends=ends)
        exact = any(minute.seconds is not None for minute in minutes)
        provenance = PROVENANCE_SECONDS if exact else PROVENANCE_MINUTES
    teams = _teams(rows)
    happenings = [_happening(*entry, clock, teams, goals_only) for entry in entries]
    notes = []
    if set(clock.lengths_s) - set(ends):
        notes.append(STOPPAGE_NOTE)
    if kicks:
        notes.append(f"the shoot-out is left out: {kicks} rows")
    if left_out:
        most = left_out.most_common(6)
        words = ", ".join(f"{count} {shown(name)[1:-1]}" for name, count in most)
        more = ", ..." if len(left_out) > len(most) else ""
        notes.append(f"left out, no football kind: {words}{more}")
    if not goals_only and any(kind == "own_goal" for _, _, kind, _ in entries):
        notes.append(
            "own goals: the team listed is taken as the player's, the score goes to the other"
        )
    return match_timeline(
        teams,
        clock.begins_s,
        clock.duration_s,
        happenings,
        provenance,
        notes,
        default_title=default_title,
        about=[rows[0].get("date")],
    )


def _meaning(row: _Row, goals_only: bool) -> tuple[str, str]:
    own = "own" in row.fields and row.flag("own")
    penalty = "penalty" in row.fields and row.flag("penalty")
    if goals_only:
        return ("own_goal", "") if own else ("goal", "pen" if penalty else "")
    return meaning(words_of(row.get("kind")), row.details, own=own, penalty=penalty)


def _happening(
    row: _Row, minute: Minute, kind: str, detail: str, clock: Clock, teams: list[str], by_team: bool
) -> Happening:
    """Return what a row says; `by_team`: whether a goal's team is the one that gets the score."""
    team = team_index(_team_name(row), teams, row.place)
    if kind == "own_goal" and not by_team and team is not None:
        team = 1 - team if len(teams) == 2 else None
    who = short_name(row.get("player"))
    if not who and kind in GOALS:
        who = row.get("label")
    elif not who:
        detail = detail or row.get("label")
    written = str(minute) if minute.seconds is None else ""
    return Happening(clock.time_s(minute), kind, team, who, detail, written, row.place)


def _team_name(row: _Row) -> str:
    """Return the team of a row; `home` and `away` mean those the row names."""
    name, home, away = row.get("team"), row.get("home"), row.get("away")
    if home and away and name not in (home, away):
        return home if name.lower() in _HOME else away if name.lower() in _AWAY else name
    return name


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
    listed: list[_Row] = []
    columns: dict[str, list[str]] | None = None
    headers: dict[str, str] = {}
    for line, fields in records(text):
        if columns is None:
            columns = _columns(list(fields))
            headers = {what: names[0] for what, names in columns.items()}
        values = {what: fields[names[0]] for what, names in columns.items()}
        details = " ".join(
            words_of(fields[name])
            for name in columns.get("details", [])
            if fields[name] and fields[name].lower() not in _NONE
        )
        listed.append(_Row(line, values, details, headers))
    if not listed:
        raise InputError("no rows below the header; add one for each event")
    return listed


def _columns(header: Sequence[str]) -> dict[str, list[str]]:
    """Return the columns of the header by what they are; each column is one thing."""
    names = {name: plain(name.replace("_", " ")).replace(" ", "") for name in header if name}
    columns: dict[str, list[str]] = {}
    taken: set[str] = set()
    for what, known in COLUMNS.items():
        for alias in known:
            for name, compared in names.items():
                same = compared == alias.replace(" ", "")
                if same and name not in taken and (what not in columns or what == "details"):
                    columns.setdefault(what, []).append(name)
                    taken.add(name)
    return columns


def _grouped(listed: Sequence[_Row]) -> dict[tuple[str, str, str, str], list[_Row]]:
    """Return the rows by the match they describe, in order of first appearance."""
    grouped: dict[tuple[str, str, str, str], list[_Row]] = {}
    for row in listed:
        grouped.setdefault(row.match, []).append(row)
    return grouped


def _lines(grouped: dict[tuple[str, str, str, str], list[_Row]]) -> list[str]:
    lines = []
    for (date, home, away, number), of_it in grouped.items():
        teams = f" {_result(of_it)} ".join([home, away] if home or away else _teams(of_it))
        lines.append("  ".join(part for part in (date, teams, number) if part) or "the match")
    return lines


def _result(of_it: Sequence[_Row]) -> str:
    """Return the score of a list of goals, whose team is the one that gets it; else a dash."""
    counts = [0, 0]
    for row in of_it:
        sides = (row.get("home"), row.get("away"))
        if "kind" in row.fields or row.get("team") not in sides:
            return "-"
        counts[sides.index(row.get("team"))] += 1
    return f"{counts[0]}-{counts[1]}"


def _minute(row: _Row) -> Minute:
    place = row.at("minute" if row.get("minute") else "clock")
    minute = parse_minute(row.get("minute") or row.get("clock"), place)
    for what in ("added", "second"):
        value = row.get(what)
        if not value:
            continue
        number = re.fullmatch(r"\+?([0-9]{1,3})(\.[0-9]{1,6})?", value)
        if number is None or (what == "added" and number[2] and float(number[2]) != 0.0):
            raise row.at(what).error(value, "isn't a number of minutes or seconds")
        if what == "added":
            if minute.added is None and (int(number[1]) or minute.base in ENDS.values()):
                added = int(number[1])
                minute = replace(minute, added=added or None)
        else:
            seconds = float(number[1] + (number[2] or ""))
            if seconds >= 60.0:
                raise row.at(what).error(seconds, "is out of range; seconds are 0 to 60")
            minute = replace(minute, seconds=seconds)
    check_minute(minute.base, minute.added, place)
    period = row.get("period")
    return replace(minute, period=_period(period, row.at("period"))) if period else minute


def _period(text: str, place: CellLocation) -> int | None:
    words = re.sub(r" 0$", "", words_of(text))  # 1.0, as a table of numbers writes it
    for number, known in _PERIODS.items():
        if words in known:
            return number
    raise place.error(text, "is no period; write 1, 2, 3 or 4 (extra time), or 5 (shoot-out)")


def _ended(minute: Minute, kind: str) -> int:
    """Return the period that a whistle ends."""
    if minute.period in (1, 2, 3, 4):
        return minute.period
    if kind == "half_end" and minute.base < ENDS[2]:
        return 1
    if minute.base < ENDS[3]:
        return 2
    return 3 if kind == "half_end" and minute.base < ENDS[4] else 4


def _speaks_football(head: str, columns: dict[str, list[str]], timed: str) -> bool:
    """Return whether early rows have minutes and, in words, football kinds.

    Beside a team or a player one such row will do; without them half of the rows have to.
    """
    whole = head[: head.rfind("\n") + 1] or head
    sides = "team" in columns or "player" in columns
    bare = sides or "minute" in columns  # numbers under `time` alone are seconds
    known = other = 0
    try:
        for _, fields in itertools.islice(records(whole), _SNIFFED):
            kind = words_of(fields[columns["kind"][0]])
            details = " ".join(words_of(fields[name]) for name in columns.get("details", []))
            told = meaning(kind, details, own=False, penalty=False)[0] not in _ANYONES
            if told and sides and _is_minute(fields[timed]):
                return True
            known += (told or bool(_FOOTBALL.search(kind))) and _is_minute(fields[timed], bare)
            other += not told
    except InputError:  # the reader that claims the file says where it is broken
        return False
    return known > 0 and 2 * known >= known + other


def _is_minute(text: str, bare: bool = True) -> bool:
    if not bare and text.strip().replace(".", "", 1).isdigit():
        return False
    try:
        parse_minute(text, "")
    except InputError:
        return False
    return True
