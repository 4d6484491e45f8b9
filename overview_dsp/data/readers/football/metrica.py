"""Metrica's raw events (CSV, as in its public sample games): one row an action, one clock.

Columns: Team, Type, Subtype, Period, Start Time [s], End Time [s], From, and others that aren't
needed. A subtype is words joined by hyphens (`HEAD-ON TARGET-GOAL`); `GOAL KICK` is one word of
them and no goal. Times count on through the match, the file's own clock; where a later period
begins before an earlier one ended, periods are laid end to end, with a note.

Kinds:

- `goal`: a SHOT with the word GOAL, `(pen)` if the team's PENALTY was set within `PENALTY_S`.
- `own_goal`: any other action with the word GOAL, unless the other team kicks off after it: the
  team that conceded does.
- `near_miss`: a SHOT with SAVED, or WOODWORK and no goal.
- `foul`: a FAULT RECEIVED, by the other team (the file names who was fouled).
- `yellow_card`, `red_card`: CARD with YELLOW, with RED (a second yellow too).
- `period`: where periods begin and the last action ends.

Any other action with the ball is a detail, felt when zoomed (`touches`).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football.match import SHOOT_OUT, Happening, Touch, match_timeline
from overview_dsp.data.readers.football.minutes import STARTS
from overview_dsp.data.readers.tables.delimited import records
from overview_dsp.data.readers.tables.dialect import headed
from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

PROVENANCE = "events: a Metrica raw-events file"
PENALTY_S = 30.0
"""A shot this long after its team's penalty was set is the penalty."""

SLACK_S = 60.0
"""Rows of two periods may overlap so much before the clock counts as begun anew."""

MAX_S = 86_400.0

_TOUCHES = frozenset(
    {"PASS", "CHALLENGE", "RECOVERY", "BALL LOST", "BALL OUT", "SET PIECE", "SHOT"}
)
_CLOCK_STARTS_S = (0.0, *(60.0 * minute for minute in STARTS.values()))
_NEEDED = ("team", "type", "subtype", "period", "start time [s]")
_NUMBER = re.compile(r"\d{1,9}(\.\d+)?(e[+-]?\d{1,2})?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class _Row:
    place: str
    team: str
    type: str
    words: frozenset[str]
    period: int
    start_s: float
    end_s: float
    player: str


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table with the columns of Metrica's raw events."""
    if source.head_text is None or source.looks_like_json:
        return False
    found = headed(source.head_text)
    return found is not None and set(_NEEDED) <= set(found.header)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a match (takes no options); InputError names file, line and column."""
    text = source.text  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        return decode(text, source.stem)


def decode(text: str, default_title: str = "") -> Timeline:
    """Make a Timeline of the text of a raw-events file.

    Parameters
    ----------
    text
        The file's text.
    default_title
        The title if the file names fewer than two teams.

    Raises
    ------
    InputError
        A period or time that is none; a team that is a third one.
    """
    listed = []
    lines: dict[tuple[str, ...], int] = {}  # rows have no id: they are the same or they aren't
    repeats: list[str] = []
    for line, fields in records(text):
        if not set(_NEEDED) <= fields.keys():
            missing = next(name for name in _NEEDED if name not in fields)
            raise InputError(f"no column '{missing}' in the header; is it Metrica's raw events?")
        first = lines.setdefault(tuple(fields.values()), line)
        if first == line:
            listed.append(_row(fields, line))
        else:
            repeats.append(f"line {line} repeats line {first}")
    played = [row for row in listed if row.period != SHOOT_OUT]
    if not played:
        raise InputError("no actions of play below the header; is the file complete?")
    notes: list[str] = []
    if repeats:
        more = f" and {len(repeats) - 1} more like it" if len(repeats) > 1 else ""
        notes.append(f"{repeats[0]}{more}: left out")
    shift = _shifts(played, notes)
    if len(listed) > len(played):
        notes.append("the shoot-out (period 5) is left out")
    names = list(dict.fromkeys(row.team for row in played if row.team))
    teams = sorted(names, key=lambda name: name.lower() != "home")
    if len(teams) > 2:
        third = next(row for row in played if row.team == names[2])
        raise InputError(
            f"{third.place}, column 'Team': {shown(names[2])} is a third team after "
            f"{shown(names[0])} and {shown(names[1])}; keep one match a file"
        )
    happenings: list[Happening] = []
    touches: list[Touch] = []
    for i, row in enumerate(played):
        kind, team, detail = _happened(i, row, played, teams, notes)
        time_s = row.start_s + shift[row.period]
        if kind:
            happenings.append(Happening(time_s, kind, team, row.player, detail, "", row.place))
        elif row.type in _TOUCHES:
            touches.append((time_s, row.type.lower(), row.player))
    begins = {
        period: min(row.start_s for row in played if row.period == period) + shift[period]
        for period in sorted(shift)
    }
    end_s = max(max(row.start_s, row.end_s) + shift[row.period] for row in played)
    if end_s <= 0.0:
        raise InputError("no time passes: every action is at 0 s; is the file complete?")
    return match_timeline(
        teams,
        begins,
        end_s,
        happenings,
        PROVENANCE,
        notes,
        default_title=default_title,
        touches=touches,
    )


def _row(fields: dict[str, str], line: int) -> _Row:
    period = fields["period"].removesuffix(".0")
    if period not in ("1", "2", "3", "4", "5"):
        raise CellLocation(line, "Period").error(
            fields["period"], f"is no period; periods are 1 to {SHOOT_OUT}"
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
        frozenset(word.strip() for word in fields["subtype"].upper().split("-")),
        int(period),
        start_s,
        _seconds(end, CellLocation(line, "End Time [s]")) if end else start_s,
        player,
    )


def _seconds(text: str, place: CellLocation) -> float:
    hint = f"times are seconds from 0 to {MAX_S:g}, such as 91.56"
    if not _NUMBER.fullmatch(text):
        raise place.error(text, f"isn't a time; {hint}")
    value = float(text)
    if value > MAX_S:
        raise place.error(value, f"is out of range; {hint}")
    return value


def _shifts(played: list[_Row], notes: list[str]) -> dict[int, float]:
    """Return what is added to each period's times: 0 while the clock counts on."""
    shifts: dict[int, float] = {}
    end_s = 0.0
    for period in sorted({row.period for row in played}):
        of_it = [row for row in played if row.period == period]
        begin_s = min(row.start_s for row in of_it)
        shifts[period] = 0.0
        if begin_s < end_s - SLACK_S:
            shifts[period] = end_s - max(at for at in _CLOCK_STARTS_S if at <= begin_s)
            notes.append(
                f"the clock begins anew in period {period}: it is laid after the one before"
            )
        end_s = max(max(row.start_s, row.end_s) for row in of_it) + shifts[period]
    return shifts


def _happened(
    i: int, row: _Row, played: list[_Row], teams: list[str], notes: list[str]
) -> tuple[str, int | None, str]:
    """Return kind, team and detail of what happens in a row; kind is "" for ordinary play."""
    team = teams.index(row.team) if row.team else None
    other = 1 - team if team is not None and len(teams) == 2 else None
    words = row.words
    if row.type == "SHOT" and "GOAL" in words:
        return "goal", team, "pen" if _is_penalty(i, played) else ""
    if "GOAL" in words and row.type in ("BALL OUT", "BALL LOST", "PASS", "CHALLENGE", "RECOVERY"):
        kicker = _kicks_off_after(i, played)
        if kicker is None:
            notes.append(f"{row.place} is a goal without a shot or a kick-off after it: own goal")
        elif kicker != row.team:
            return "goal", team, ""
        return "own_goal", other, ""
    if row.type == "SHOT" and "SAVED" in words:
        return "near_miss", team, "saved"
    if row.type == "SHOT" and "WOODWORK" in words:
        return "near_miss", team, "on the post"
    if row.type == "FAULT RECEIVED":
        return "foul", team, "fouled"
    if row.type == "CARD":
        if "RED" in words or any("SECOND" in word or "RED" in word.split() for word in words):
            second = any("SECOND" in word or "YELLOW" in word for word in words)
            return "red_card", team, "second yellow" if second else ""
        if "YELLOW" in words:
            return "yellow_card", team, ""
        notes.append(f"{row.place}: a card of no colour ({', '.join(sorted(words))}) is left out")
    return "", None, ""


def _is_penalty(i: int, played: list[_Row]) -> bool:
    row = played[i]
    if "PENALTY" in row.words:
        return True
    for before in reversed(played[max(0, i - 20) : i]):
        if before.type == "SET PIECE" and before.team == row.team:
            near = 0.0 <= row.start_s - before.start_s <= PENALTY_S
            return "PENALTY" in before.words and near and before.period == row.period
    return False


def _kicks_off_after(i: int, played: list[_Row]) -> str | None:
    """Return the team that kicks off next in the same period."""
    for later in played[i + 1 :]:
        if (
            later.period == played[i].period
            and later.type == "SET PIECE"
            and ("KICK OFF" in later.words)
        ):
            return later.team
        if later.period != played[i].period or "GOAL" in later.words:
            return None
    return None
