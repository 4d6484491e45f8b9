"""Reader of the documents of live football services: API-Football, football-data.org, OpenLigaDB.

| service | document |
|---|---|
| API-Football 3 | `fixtures?id=...`, with events and score; `fixtures/events?fixture=...` |
| football-data.org 4 | `matches/...`, with `goals` and `bookings` |
| OpenLigaDB | `getmatchdata/...`, with goals only |

A match in progress is known until the minute of the document, or until its last event. Events are
in the middle of their minute (`minutes.py`). Services list events twice for a while; one is left
out. Goals that the video referee has withdrawn are `withdrawn_goal`, unless the score counts them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football.match_timeline import (
    ACTIONS,
    MatchEvent,
    contains_record,
    match_timeline,
    select_match,
    short_name,
)
from overview_dsp.data.readers.football.minutes import MIDDLE_S, Clock, Minute, check_minute
from overview_dsp.data.timeline.event import GOALS, WITHDRAWN_GOAL
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, printable, quoted
from overview_dsp.public import counted

_MEANINGS: dict[str, Sequence[str]] = ACTIONS["services"]["meanings"]
"""Event kind and detail by the type and detail of a service, in lower case."""

_NOT_BEGUN = "has not begun; follow its URL (--follow), or read it again later"
_NOT_PLAYED = {
    **dict.fromkeys(("NS", "TBD", "SCHEDULED", "TIMED"), _NOT_BEGUN),
    **dict.fromkeys(("PST", "POSTPONED"), "is postponed; read it again on its new date"),
    **dict.fromkeys(("CANC", "CANCELLED"), "is cancelled; choose another one"),
}
_FINISHED = frozenset(["FT", "AET", "PEN", "ABD", "AWD", "WO", "FINISHED", "AWARDED"])
_EXTRA_TIME = frozenset(["AET", "PEN", "ET", "BT", "P", "EXTRA_TIME", "PENALTY_SHOOTOUT"])
_WITHDRAWN = ("goal cancelled", "goal disallowed")
_REVIEW_MINUTES = 6  # maximum time from a goal until it is withdrawn
_REPEATED_MINUTES = 2  # maximum difference between two entries of one goal
FULL_TIME = 90

Pair = tuple[int, int]


@dataclass(frozen=True)
class _Part:
    """Object of a document, with its location for error messages. Null is a missing key."""

    raw: dict[str, Any]
    location: str

    @classmethod
    def of(cls, raw: object, location: str) -> _Part:
        """Return an object, empty for null; InputError for another type."""
        part = {} if raw is None else raw
        return cls(validation.of_type(part, dict, location, "an object {...}"), location)

    def part(self, key: str) -> _Part:
        """Return an object in this one."""
        return self.of(self.raw.get(key), f"{self.location}.{key}")

    def parts(self, key: str) -> list[_Part] | None:
        """Return a list of objects; None if it is missing."""
        value, location = self.raw.get(key), f"{self.location}.{key}"
        if value is None:
            return None
        listed = validation.of_type(value, list, location, "a list [...]")
        return [self.of(one, f"{location}[{i}]") for i, one in enumerate(listed)]

    def text(self, key: str) -> str:
        """Return a text; "" if it is missing."""
        value = self.raw.get(key)
        return "" if value is None else printable(str(value)).strip()

    def number(self, key: str) -> int | None:
        """Return a whole number, also written as text."""
        value, text = self.raw.get(key), self.text(key)
        if type(value) is str and text.isascii() and text.isdigit():
            return int(text[:18])
        location = f"{self.location}.{key}"
        if value is None:
            return None
        return validation.of_type(value, int, location, "a whole number")

    def pair(self, *keys: str) -> Pair | None:
        """Return the numbers of both teams; None if one is missing."""
        first, second = map(self.number, keys or ("home", "away"))
        return None if first is None or second is None else (first, second)

    def minute(self, base: str, added: str = "") -> Minute | None:
        """Return the minute of these keys; None if it is missing."""
        number, more = self.number(base), self.number(added)
        if number is None:
            return None
        check_minute(number, more, f"{self.location}.{base}")
        return Minute(number, more or None)


@dataclass(frozen=True)
class _Row:
    """Event of a service. `player_id` identifies the player, by name if there is no id."""

    minute: Minute
    kind: str
    team: int | None
    player: str
    player_id: str
    detail: str
    location: str


@dataclass(frozen=True)
class _Match:
    """Match of any service, known until minute `until`; None: finished. No `rows`: scores only."""

    service: str
    id: str
    teams: tuple[str, str]
    title_parts: tuple[str, ...]
    final: Pair | None
    rows: Sequence[_Row] | None
    withdrawn: Sequence[_Row] = ()
    until: Minute | None = None
    not_played: str = ""
    extra_time: bool | None = None
    shoot_out: Pair | None = None
    notes: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """Description of the match for display."""
        result = f"{self.final[0]}-{self.final[1]}" if self.final else "-"
        parts = (*self.title_parts[-1:], f"{self.teams[0]} {result} {self.teams[1]}")
        return "  ".join(filter(None, (*parts, *self.title_parts[:-1])))


def sniff(source: DataFile) -> bool:
    """Return whether the file is a document of one of the services."""
    text = source.text if source.looks_like_json else ""
    if not any(f'"{key}"' in text for key in ("homeTeam", "matchID", "response")):
        return False
    try:
        return bool(_matches(source.json))
    except InputError:  # `read` reports it
        return True


def matches(source: DataFile) -> list[str]:
    """Return a description of each match in the file."""
    return [match.line for match in _matches(source.json)]


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`).

    InputError: it is invalid, reports an error, has scores only, or its match has not begun.
    """
    listed = _matches(source.json)
    ids = [match.id for match in listed]
    return _timeline(listed[select_match([one.line for one in listed], options.match, ids)])


def _timeline(match: _Match) -> Timeline:
    if match.not_played:
        raise InputError(f"the match {match.not_played}")
    if match.rows is None:
        raise InputError(
            f"the document of {match.service} has no events of the match; request the match alone"
        )
    rows, notes = _without_repeats(match)
    known = [] if match.until is None else [match.until]
    clock = Clock.from_minutes(
        [*(row.minute for row in rows), *known], extra_time=match.extra_time, back_s=MIDDLE_S
    )
    events = [
        MatchEvent(
            clock.time_s(row.minute), row.kind, row.team, short_name(row.player), row.detail,
            str(row.minute), row.location,
        )
        for row in rows
    ]  # fmt: skip
    if match.shoot_out is not None:
        notes.append(f"the shoot-out is omitted: {match.shoot_out[0]}-{match.shoot_out[1]}")
    until_s, end_s = None, clock.duration_s
    if match.until is not None:
        until_s = replace(clock, back_s=0.0).time_s(match.until)
        until_s = max([until_s, *(event.time_s for event in events)])
        end_s = max(end_s, until_s + 60.0)  # the end is not known yet
    return match_timeline(
        match.teams if all(match.teams) else [],
        clock.begins_s,
        end_s,
        events,
        f"events: {match.service}, each in the middle of its minute",
        [*match.notes, *notes],
        title_parts=match.title_parts,
        final=match.final,
        known_until_s=until_s,
    )


def _without_repeats(match: _Match) -> tuple[list[_Row], list[str]]:
    """Return the events without repeated ones, withdrawn goals as such, and notes on both."""
    rows = list(match.rows or ())
    repeated: list[_Row] = []
    withdrawn: list[_Row] = []

    def is_counted(row: _Row) -> bool:
        """Return whether the score requires this goal."""
        if row.kind not in GOALS or match.final is None or row.team is None:
            return False
        listed = sum(one.kind in GOALS and one.team == row.team for one in rows)
        return listed <= match.final[row.team]

    for review in match.withdrawn:
        for row in reversed(rows):
            ago = review.minute.on_clock - row.minute.on_clock
            same = row.player_id == review.player_id or "" in (row.player_id, review.player_id)
            if row.kind in GOALS and row.team == review.team and same and ago >= 0:
                if ago <= _REVIEW_MINUTES and not is_counted(row):
                    rows[rows.index(row)] = replace(row, kind=WITHDRAWN_GOAL)
                    withdrawn.append(row)
                break
    for row in rows.copy():
        for other in rows.copy():
            apart = abs(other.minute.on_clock - row.minute.on_clock)
            same = (row.kind, row.team, row.player_id) == (other.kind, other.team, other.player_id)
            is_goal = row.kind in GOALS and match.final is not None
            if row is other or not same or apart > _REPEATED_MINUTES * is_goal:
                continue
            if row in rows and not is_counted(row):
                rows.remove(row)
                repeated.append(row)
    notes = []
    for found, one in ((repeated, "repeated event"), (withdrawn, "withdrawn goal")):
        if found:
            words = ", ".join(f"{row.player} {row.minute}".strip() for row in found)
            notes.append(f"{counted(len(found), one)} not counted: {words}")
    return rows, notes


# --- the services


def _api_match(match: _Part) -> _Match:
    """Return a match of API-Football. A list of events alone has neither teams nor status."""
    fixture, league, teams = match.part("fixture"), match.part("league"), match.part("teams")
    status, listed = fixture.part("status"), match.parts("events")
    sides = [teams.part("home"), teams.part("away")]
    if not teams.raw:
        named = {one.part("team").text("id"): one.part("team") for one in listed or []}
        sides = [*named.values(), *sides][:2]
    rows, withdrawn = _api_rows(listed or [], [side.text("id") for side in sides])
    short, last = status.text("short"), _last(rows)
    is_over = short in _FINISHED if teams.raw else last.base >= FULL_TIME
    note = "the document has no home team and no clock; that of fixtures?id=... has them"
    return _Match(
        "API-Football",
        fixture.text("id"),
        (sides[0].text("name"), sides[1].text("name")),
        (league.text("name"), league.text("round"), fixture.text("date")[:10]),
        match.part("goals").pair(),
        None if listed is None else rows,
        withdrawn,
        until=None if is_over else status.minute("elapsed", "extra") or last,
        not_played=_NOT_PLAYED.get(short, ""),
        extra_time=short in _EXTRA_TIME or None,
        shoot_out=match.part("score").part("penalty").pair(),
        notes=() if teams.raw else (note,),
    )


def _api_rows(events: Iterable[_Part], teams: list[str]) -> tuple[list[_Row], list[_Row]]:
    """Return the events of a match, and the goals that the video referee has withdrawn."""
    rows, withdrawn = [], []
    for event in events:
        kind, detail = event.text("type").lower(), event.text("detail").lower()
        if "shootout" in event.text("comments").lower():
            continue
        minute = event.part("time").minute("elapsed", "extra")
        row = _row(event, minute, f"{kind} {detail}", teams, event.part("player"))
        if kind == "var" and detail.startswith(_WITHDRAWN):
            withdrawn.append(replace(row, kind="goal"))
        elif row.kind:
            rows.append(row)
    return rows, withdrawn


def _data_match(match: _Part) -> _Match:
    """Return a match of football-data.org."""
    home, away, score = match.part("homeTeam"), match.part("awayTeam"), match.part("score")
    teams = [home.text("id"), away.text("id")]
    goals, bookings = match.parts("goals"), match.parts("bookings")
    rows = []
    for what, key, who, listed in (
        ("goal", "type", "scorer", goals),
        ("card", "card", "player", bookings),
    ):
        for one in listed or []:
            minute = one.minute("minute", "injuryTime")
            row = _row(one, minute, f"{what} {one.text(key)}", teams, one.part(who))
            rows += [row] if row.kind else []
    regular, extra = score.part("regularTime").pair(), score.part("extraTime").pair()
    final, shoot_out = score.part("fullTime").pair(), score.part("penalties").pair()
    if regular is not None and shoot_out is not None:  # `fullTime` includes the shoot-out
        more = extra or (0, 0)
        final = regular[0] + more[0], regular[1] + more[1]
    status = match.text("status")
    return _Match(
        "football-data.org",
        match.text("id"),
        (home.text("name"), away.text("name")),
        (match.part("competition").text("name"), match.text("utcDate")[:10]),
        final,
        None if goals is None else rows,
        until=None if status in _FINISHED else match.minute("minute", "injuryTime") or _last(rows),
        not_played=_NOT_PLAYED.get(status, ""),
        extra_time=extra is not None or status in _EXTRA_TIME or None,
        shoot_out=shoot_out,
    )


def _liga_match(match: _Part) -> _Match:
    """Return a match of OpenLigaDB."""
    # the last entry of a score is the corrected one
    goals = {one.pair("scoreTeam1", "scoreTeam2"): one for one in match.parts("goals") or []}
    results = [one.pair("pointsTeam1", "pointsTeam2") for one in match.parts("matchResults") or []]
    rows, score, untimed, is_finished = [], (0, 0), 0, match.raw.get("matchIsFinished") is True
    for reached in sorted(filter(None, goals), key=sum):
        goal, team = goals[reached], "0" if reached[0] > score[0] else "1"
        score = reached
        if (minute := goal.minute("matchMinute")) is None:
            untimed += 1
            continue
        kinds = {"isOwnGoal": "own", "isPenalty": "penalty"}
        kind = next((kinds[key] for key in kinds if goal.raw.get(key) is True), "regular")
        player = _Part({"name": goal.text("goalGetterName")}, goal.location)
        own = replace(goal, raw={"team": {"id": team}})
        rows.append(_row(own, minute, f"goal {kind}", ["0", "1"], player))
    return _Match(
        "OpenLigaDB",
        match.text("matchID"),
        (match.part("team1").text("teamName"), match.part("team2").text("teamName")),
        (match.text("leagueName"), match.part("group").text("groupName"),
         match.text("matchDateTime")[:10]),
        score if goals else max(filter(None, results), key=sum, default=None),
        rows,
        until=None if is_finished else _last(rows, 45 if results else 0),
        not_played="" if goals or results or is_finished else _NOT_BEGUN,
        extra_time=any(one.raw.get("isOvertime") is True for one in goals.values()) or None,
        notes=(f"{counted(untimed, 'goal')} without a minute left out",) if untimed else (),
    )  # fmt: skip


def _matches(document: Any) -> list[_Match]:
    """Return the matches of a document; empty if it is not one of a service."""
    top = document if isinstance(document, dict) else {}
    if isinstance(listed := top.get("response"), list) and top.keys() >= {"get", "errors"}:
        if errors := top["errors"]:
            words = errors.values() if isinstance(errors, dict) else [errors]
            raise InputError(f"API-Football reports {'; '.join(map(quoted, words))}")
        if top["get"] == "fixtures/events" or contains_record(listed, "time", "detail"):
            return [_api_match(_Part({"events": listed}, "response"))]
        if not listed:
            raise InputError("API-Football has no match for this request; check its id")
        return [_api_match(one) for one in _Part(top, "document").parts("response") or []]
    if "matches" in top or "homeTeam" in top:
        listed = top.get("matches", [top])
        if isinstance(listed, list) and contains_record(listed, "homeTeam", "awayTeam", "status"):
            return [_data_match(_Part.of(one, f"matches[{i}]")) for i, one in enumerate(listed)]
    listed = document if isinstance(document, list) else [document]
    if contains_record(listed, "matchID", "team1", "team2"):
        return [_liga_match(_Part.of(one, f"[{i}]")) for i, one in enumerate(listed)]
    return []


def _row(event: _Part, minute: Minute | None, what: str, teams: list[str], player: _Part) -> _Row:
    if minute is None:
        raise InputError(f"{event.location}: the event has no minute")
    kind, detail = _MEANINGS.get(what.lower().replace("_", " "), ("", ""))
    name, team = player.text("name"), event.part("team").text("id")
    index = teams.index(team) if team in teams else None
    return _Row(minute, kind, index, name, player.text("id") or name, detail, event.location)


def _last(rows: Sequence[_Row], least: int = 0) -> Minute:
    """Return the latest minute of the events, at least `least`."""
    return max([Minute(least), *(row.minute for row in rows)], key=lambda one: one.on_clock)
