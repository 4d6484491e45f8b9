"""Reader of Metrica's raw events (CSV, as in its public sample games), one row per action.

The columns used are Team, Type, Subtype, Period, Start Time [s], End Time [s] and From. A subtype
is a list of terms joined by hyphens (`HEAD-ON TARGET-GOAL`); `GOAL KICK` is one term and not a
goal. One clock runs through the match. If a period starts before the end of the previous one, it
is placed after that one, and a note is shown.

Event kinds:

- `goal`: a SHOT with the term GOAL; `(pen)` if the team had a PENALTY up to `PENALTY_S` before.
- `own_goal`: any other action with the term GOAL, if the team of the action kicks off after it.
- `near_miss`: a SHOT with SAVED, or with WOODWORK and without GOAL.
- `foul`: a FAULT RECEIVED; the row has the fouled player.
- `yellow_card`, `red_card`: a CARD with YELLOW or RED (red for a second yellow, too).
- `period`: the start of each period and the end of the last action.

All other actions with the ball are touches, shown in windows only.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football.match_timeline import (
    SHOOT_OUT,
    TOUCH,
    MatchEvent,
    match_timeline,
)
from overview_dsp.data.readers.football.minutes import STARTS
from overview_dsp.data.readers.tables.delimited import records
from overview_dsp.data.readers.tables.dialect import header_dialect
from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted

PROVENANCE = "events: a Metrica raw-events file"
PENALTY_S = 30.0
"""Maximum time from a team's penalty to the shot, s."""

SLACK_S = 60.0
"""Maximum overlap of two periods, s. If it is longer, the clock has restarted."""

MAX_S = 86_400.0

_BALL_TOUCHES = frozenset(
    {"PASS", "CHALLENGE", "RECOVERY", "BALL LOST", "BALL OUT", "SET PIECE", "SHOT"}
)
_CLOCK_STARTS_S = (0.0, *(60.0 * minute for minute in STARTS.values()))
_NEEDED = ("team", "type", "subtype", "period", "start time [s]")
_NUMBER = re.compile(r"\d{1,9}(\.\d+)?(e[+-]?\d{1,2})?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class _Row:
    location: str
    team: str
    type: str
    terms: frozenset[str]
    period: int
    start_s: float
    end_s: float
    player: str


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table with the columns of Metrica's raw events."""
    if source.head_text is None or source.looks_like_json:
        return False
    found = header_dialect(source.head_text)
    return found is not None and set(_NEEDED) <= set(found.header)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a match (takes no options); the InputError contains file, line and column."""
    return decode(source.text, source.stem)


def decode(text: str, default_title: str = "") -> Timeline:
    """Return the Timeline of a raw-events file; `default_title` is used without team names.

    InputError: a period or time is invalid, or there is a third team.
    """
    listed = []
    lines: dict[tuple[str, ...], int] = {}  # rows have no id, so equal rows are repeats
    repeats: list[str] = []
    for line, fields in records(text):
        if not set(_NEEDED) <= fields.keys():
            missing = next(name for name in _NEEDED if name not in fields)
            raise InputError(
                f"the header has no column '{missing}'; the file must have Metrica's raw events"
            )
        first = lines.setdefault(tuple(fields.values()), line)
        if first == line:
            listed.append(_row(fields, line))
        else:
            repeats.append(f"line {line} repeats line {first}")
    played = [row for row in listed if row.period != SHOOT_OUT]
    if not played:
        raise InputError("the file has no actions below the header; it may be incomplete")
    notes: list[str] = []
    if repeats:
        more = f", and {len(repeats) - 1} more rows are repeats" if len(repeats) > 1 else ""
        notes.append(f"{repeats[0]}{more}: omitted")
    shift = _shifts(played, notes)
    if len(listed) > len(played):
        notes.append("the shoot-out (period 5) is omitted")
    names = list(dict.fromkeys(row.team for row in played if row.team))
    teams = sorted(names, key=lambda name: name.lower() != "home")
    if len(teams) > 2:
        third = next(row for row in played if row.team == names[2])
        raise InputError(
            f"{third.location}, column 'Team': {quoted(names[2])} is a third team after "
            f"{quoted(names[0])} and {quoted(names[1])}; the file must have one match"
        )
    match_events: list[MatchEvent] = []
    for i, row in enumerate(played):
        kind, team, detail = _classify(i, row, played, teams, notes)
        time_s = row.start_s + shift[row.period]
        if kind:
            match_events.append(
                MatchEvent(time_s, kind, team, row.player, detail, "", row.location)
            )
    begins = {
        period: min(row.start_s for row in played if row.period == period) + shift[period]
        for period in sorted(shift)
    }
    end_s = max(max(row.start_s, row.end_s) + shift[row.period] for row in played)
    if end_s <= 0.0:
        raise InputError("all actions are at 0 s; the file may be incomplete")
    return match_timeline(
        teams, begins, end_s, match_events, PROVENANCE, notes, default_title=default_title
    )


def _row(fields: dict[str, str], line: int) -> _Row:
    period = fields["period"].removesuffix(".0")
    if period not in ("1", "2", "3", "4", "5"):
        raise CellLocation(line, "Period").error(
            fields["period"], f"is not a period; periods must be 1 to {SHOOT_OUT}"
        )
    start_s = _seconds(fields["start time [s]"], CellLocation(line, "Start Time [s]"))
    end, player = (
        "" if fields.get(name, "").lower() == "nan" else fields.get(name, "")
        for name in ("end time [s]", "from")
    )
    return _Row(
        f"line {line}",
        fields["team"],
        fields["type"].upper(),
        frozenset(term.strip() for term in fields["subtype"].upper().split("-")),
        int(period),
        start_s,
        _seconds(end, CellLocation(line, "End Time [s]")) if end else start_s,
        player,
    )


def _seconds(text: str, location: CellLocation) -> float:
    hint = f"times must be 0 to {MAX_S:g} s, such as 91.56"
    if not _NUMBER.fullmatch(text):
        raise location.error(text, f"isn't a time; {hint}")
    value = float(text)
    if value > MAX_S:
        raise location.error(value, f"is out of range; {hint}")
    return value


def _shifts(played: list[_Row], notes: list[str]) -> dict[int, float]:
    """Return the offset of each period's times, s; 0 unless the clock has restarted."""
    shifts: dict[int, float] = {}
    end_s = 0.0
    for period in sorted({row.period for row in played}):
        rows = [row for row in played if row.period == period]
        begin_s = min(row.start_s for row in rows)
        shifts[period] = 0.0
        if begin_s < end_s - SLACK_S:
            shifts[period] = end_s - max(start for start in _CLOCK_STARTS_S if start <= begin_s)
            notes.append(
                f"the clock restarts in period {period}: it is placed after the previous period"
            )
        end_s = max(max(row.start_s, row.end_s) for row in rows) + shifts[period]
    return shifts


def _classify(
    i: int, row: _Row, played: list[_Row], teams: list[str], notes: list[str]
) -> tuple[str, int | None, str]:
    """Return the event kind, team and detail of a row; the kind is "" for ordinary play."""
    team = teams.index(row.team) if row.team else None
    other = 1 - team if team is not None and len(teams) == 2 else None
    terms = row.terms
    if row.type == "SHOT" and "GOAL" in terms:
        return "goal", team, "pen" if _is_penalty(i, played) else ""
    if "GOAL" in terms and row.type in ("BALL OUT", "BALL LOST", "PASS", "CHALLENGE", "RECOVERY"):
        kicker = _next_kick_off(i, played)
        if kicker is None:
            notes.append(
                f"{row.location} is a goal without a shot or a following kick-off: own goal"
            )
        elif kicker != row.team:
            return "goal", team, ""
        return "own_goal", other, ""
    if row.type == "SHOT" and "SAVED" in terms:
        return "near_miss", team, "saved"
    if row.type == "SHOT" and "WOODWORK" in terms:
        return "near_miss", team, "on the post"
    if row.type == "FAULT RECEIVED":
        return "foul", team, "fouled"
    if row.type == "CARD":
        if "RED" in terms or any("SECOND" in term or "RED" in term.split() for term in terms):
            second = any("SECOND" in term or "YELLOW" in term for term in terms)
            return "red_card", team, "second yellow" if second else ""
        if "YELLOW" in terms:
            return "yellow_card", team, ""
        notes.append(
            f"{row.location}: a card without a colour ({', '.join(sorted(terms))}) is omitted"
        )
    return (TOUCH, None, row.type.lower()) if row.type in _BALL_TOUCHES else ("", None, "")


def _is_penalty(i: int, played: list[_Row]) -> bool:
    row = played[i]
    if "PENALTY" in row.terms:
        return True
    for earlier in reversed(played[max(0, i - 20) : i]):
        if earlier.type == "SET PIECE" and earlier.team == row.team:
            near = 0.0 <= row.start_s - earlier.start_s <= PENALTY_S
            return "PENALTY" in earlier.terms and near and earlier.period == row.period
    return False


def _next_kick_off(i: int, played: list[_Row]) -> str | None:
    """Return the team that kicks off next in the same period, before another goal."""
    for later in played[i + 1 :]:
        if later.period != played[i].period:
            return None
        if later.type == "SET PIECE" and "KICK OFF" in later.terms:
            return later.team
        if "GOAL" in later.terms:
            return None
    return None
