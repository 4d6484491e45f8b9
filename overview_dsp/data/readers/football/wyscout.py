"""Wyscout v2 events: the JSON of one match, or a competition's list of events of many matches.

Two shapes of the same events are read: the public data set's list (`eventId` a number, `eventName`
words) and the interface's object (`{"events": [...], "teams": {...}, "players": {...}}`, where
`eventName` is the number). Periods (1H, 2H, E1, E2) restart at 0 and are laid end to end, each as
long as its last event; P, a shoot-out, is left out and noted. Times are exact.

Tags say what happened:

- `goal`: 101 on any event but a keeper's save attempt (9), which carries the tag of the goal it
  didn't prevent; `(pen)` for a penalty (35).
- `own_goal`: 102; the score goes to the other team. The save attempt that follows isn't a goal.
- `near_miss`: a shot (10), free-kick shot (33) or penalty (35) without a goal whose position tag
  lies in the goal's frame or on the post, or that is tagged accurate (on target), unless it was
  blocked (2101); any penalty not scored.
- `foul`: every event 2; `yellow_card` 1702, `red_card` 1701 and 1703 (second yellow).
- `period`: kick-off, each boundary once, the end.

Any other event with the ball is a detail, felt when zoomed (`touches`).

The companion `matches_*.json` beside the file gives names, home team and score (`wyscout_matches`).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.listing import repeated_ids
from overview_dsp.data.readers.football.match import (
    GOALS,
    MAX_PERIOD_S,
    SHOOT_OUT,
    Happening,
    Touch,
    choose,
    has_entry,
    lay_end_to_end,
    match_timeline,
    shoot_out_note,
    short_name,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

PROVENANCE = "events: a Wyscout v2 event file"
SAME_GOAL_S = 10.0
"""Two tags of one team's goal within this time are one goal: no match restarts sooner."""

_FOUL, _FREE_KICK, _SAVE, _SHOT = 2, 3, 9, 10
_FREE_KICK_SHOT, _PENALTY = 33, 35
_GOAL, _OWN_GOAL, _ACCURATE, _BLOCKED = 101, 102, 1801, 2101
_FRAME = frozenset(range(1201, 1210))
_POST = frozenset(range(1217, 1224))
_CARDS = {1701: ("red_card", ""), 1702: ("yellow_card", ""), 1703: ("red_card", "second yellow")}
_PERIODS = {"1H": 1, "2H": 2, "E1": 3, "E2": 4, "P": SHOOT_OUT}
_EVENTS = {
    "duel": 1, "foul": 2, "free kick": 3, "goalkeeper leaving line": 4, "interruption": 5,
    "offside": 6, "others on the ball": 7, "pass": 8, "save attempt": 9, "shot": 10,
}  # fmt: skip
_TOUCHES = {
    1: "duel", 3: "free kick", 4: "goalkeeper", 7: "touch", 8: "pass", 9: "save", 10: "shot",
}  # fmt: skip
_SUB_EVENTS = {"free kick shot": 33, "penalty": 35}


@dataclass(frozen=True)
class _Event:
    """An event, its fields checked."""

    place: str
    id: str
    period: int
    sec: float
    team: str
    player: str
    event: int
    sub_event: int
    tags: frozenset[int]

    @classmethod
    def parse(cls, raw: object, place: str) -> _Event:
        if not isinstance(raw, dict):
            raise InputError(f"{place}: is {shown(raw)}, not an object {{...}}")
        with validation.located(f"{place}: "):
            period = raw.get("matchPeriod")
            if not isinstance(period, str) or period not in _PERIODS:
                raise InputError(
                    f"matchPeriod is {shown(period)}; periods are {', '.join(_PERIODS)}"
                )
            hint = f"it is the time in the period, 0 to {MAX_PERIOD_S:g} s"
            sec = validation.number(raw.get("eventSec"), "eventSec", hint)
            if not 0.0 <= sec <= MAX_PERIOD_S:
                raise InputError(f"eventSec is {sec!r}; {hint}")
            return cls(
                place,
                _id(raw.get("id")),
                _PERIODS[period],
                sec,
                _id(raw.get("teamId")),
                _id(raw.get("playerId")),
                _number(raw, "event", _EVENTS),
                _number(raw, "subEvent", _SUB_EVENTS),
                _tags(raw.get("tags")),
            )


def sniff(source: DataFile) -> bool:
    """Return whether the file is JSON with Wyscout's matchPeriod and eventSec in an early event."""
    if not source.looks_like_json or '"matchPeriod"' not in source.text:
        return False
    return has_entry(_listed(source.json), "matchPeriod", "eventSec")


def matches(source: DataFile) -> list[str]:
    """Return a line on each match of the file."""
    document = source.json
    with validation.located(f"{source.where}: "):
        grouped = _grouped(document)
        known, _ = companions(source, frozenset(grouped))
        return _lines(list(grouped), known)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`); InputError names the file and the event."""
    document = source.json  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        grouped = _grouped(document)
        ids = list(grouped)
        # the companion may be large: it is opened once it is known what is asked of it
        known, notes = companions(source, frozenset(ids))
        chosen = ids[choose(_lines(ids, known), options.match, ids)]
        return _timeline(document, grouped[chosen], known.get(chosen), notes, source.stem)


def decode(
    document: object, match: str | None = None, companion: Companion | None = None, title: str = ""
) -> Timeline:
    """Make a Timeline of one match of a parsed file.

    Parameters
    ----------
    document
        The list of events, or the object that holds it.
    match
        As `LoadOptions.match`; may be None for a file of one match.
    companion
        Names and score of the match, where known.
    title
        The title if no team is named.

    Raises
    ------
    InputError
        An event without a period, time or team; the line names it: `event 123: ...`.
    """
    grouped = _grouped(document)
    ids = list(grouped)
    chosen = ids[choose(_lines(ids, {}), match, ids)]
    return _timeline(document, grouped[chosen], companion, (), title)


def _timeline(
    document: object,
    raws: Sequence[tuple[int, object]],
    companion: Companion | None,
    said: Sequence[str],
    default_title: str,
) -> Timeline:
    events = [_Event.parse(raw, f"event {i}") for i, raw in raws]
    played = [event for event in events if event.period != SHOOT_OUT]
    played.sort(key=lambda event: (event.period, event.sec))
    notes = [*said, *repeated_ids([event.id for event in events])]
    begins, end_s = lay_end_to_end({event.period: event.sec for event in played})
    teams = _teams(document, played, companion, notes)
    players = _players(document)
    happenings: list[Happening] = []
    touches: list[Touch] = []
    for event in played:
        time_s, who = begins[event.period] + event.sec, players.get(event.player, "")
        found = _happened(event)
        if not found and event.event in _TOUCHES:
            what = "shot" if _is_attempt(event) else _TOUCHES[event.event]
            touches.append((time_s, what, who))
        for kind, detail in found:
            team = _team(event, list(teams), needed=kind in GOALS)
            if kind == "own_goal" and team is not None:
                team = 1 - team
            happenings.append(Happening(time_s, kind, team, who, detail, "", event.place))
    happenings = _single_goals(happenings, notes)
    if len(played) < len(events):
        kicks = [e for e in events if e.period == SHOOT_OUT and _is_attempt(e)]
        scored = [(event.team, _GOAL in event.tags) for event in kicks]
        notes.append(f"the shoot-out {shoot_out_note(scored, teams)}")
    return match_timeline(
        list(teams.values()),
        begins,
        end_s,
        happenings,
        PROVENANCE,
        notes,
        default_title=default_title,
        about=[companion.date] if companion else [],
        final=companion.score if companion else None,
        touches=touches,
    )


def _happened(event: _Event) -> list[tuple[str, str]]:
    """Return (kind, detail) of what happens in an event."""
    found: list[tuple[str, str]] = []
    tags, is_penalty = event.tags, event.sub_event == _PENALTY
    if event.event == _FOUL:
        found.append(("foul", ""))
    # a second yellow may be tagged as a yellow and a red card too
    found += [_CARDS[tag] for tag in _CARDS if tag in tags and (tag == 1703 or 1703 not in tags)]
    if _OWN_GOAL in tags:
        found.append(("own_goal", ""))
    elif _GOAL in tags and event.event != _SAVE:
        found.append(("goal", "pen" if is_penalty else ""))
    elif _is_attempt(event):
        if tags & _POST:
            found.append(("near_miss", "on the post"))
        elif _BLOCKED not in tags and (tags & _FRAME or _ACCURATE in tags):
            found.append(("near_miss", "penalty saved" if is_penalty else "saved"))
        elif is_penalty:
            found.append(("near_miss", "penalty missed"))
    return found


def _is_attempt(event: _Event) -> bool:
    return event.event == _SHOT or (
        event.event == _FREE_KICK and event.sub_event in (_FREE_KICK_SHOT, _PENALTY)
    )


def _single_goals(happenings: Sequence[Happening], notes: list[str]) -> list[Happening]:
    """Leave out a goal that repeats one of the same team a moment before (given by time)."""
    kept: list[Happening] = []
    last: dict[int | None, Happening] = {}
    for happening in happenings:
        if happening.kind in GOALS:
            before = last.get(happening.team)
            if before is not None and happening.time_s - before.time_s <= SAME_GOAL_S:
                notes.append(f"{happening.place} repeats the goal of {before.place}: left out")
                continue
            last[happening.team] = happening
        kept.append(happening)
    return kept


def _team(event: _Event, ids: Sequence[str], *, needed: bool) -> int | None:
    if event.team in ids:
        return list(ids).index(event.team)
    if needed:
        raise InputError(
            f"{event.place}: the goal's teamId is {event.team or 'missing'}; the match's teams are "
            f"{' and '.join(ids) or 'not named'}"
        )
    return None


def _teams(
    document: object, played: Sequence[_Event], companion: Companion | None, notes: list[str]
) -> dict[str, str]:
    """Return the names of the two teams by id, the home team first where it is known."""
    seen = list(dict.fromkeys(event.team for event in played if event.team))
    if companion is not None and set(companion.teams) >= set(seen):
        teams = companion.teams
    else:
        teams = dict.fromkeys(seen[:2], "")
        if len(teams) == 2:
            notes.append(
                "the file doesn't say who played at home (matches_*.json beside it would): the "
                "team with the first event comes first"
            )
    listed = document.get("teams") if isinstance(document, dict) else None
    entries = listed if isinstance(listed, dict) else {}
    return {id_: name or _name_of(entries.get(id_)) or f"team {id_}" for id_, name in teams.items()}


def _name_of(entry: object) -> str:
    """Return the name in an entry of an object's `teams`, "" where there is none."""
    inner = entry.get("team", entry) if isinstance(entry, dict) else None
    name = inner.get("name") if isinstance(inner, dict) else None
    return name if isinstance(name, str) else ""


def _players(document: object) -> dict[str, str]:
    """Return what labels call the players, by id; empty where the file doesn't name them."""
    table = document.get("players") if isinstance(document, dict) else None
    listed: list[object] = []
    for entry in table.values() if isinstance(table, dict) else [table]:
        listed += entry if isinstance(entry, list) else []
    found: dict[str, str] = {}
    for entry in listed:
        player = entry.get("player", entry) if isinstance(entry, dict) else None
        if isinstance(player, dict):
            last, short = player.get("lastName"), player.get("shortName")
            # "D.Gray" is the initial and the family name; "Roberto Firmino" a name as known
            known = short.rsplit(".", 1)[-1].strip() if isinstance(short, str) else ""
            name = known or (last if isinstance(last, str) else "")
            found[_id(player.get("wyId"))] = short_name(name)
    return found


def _grouped(document: object) -> dict[str, list[tuple[int, object]]]:
    """Return the events (position from 1, event) by the id of their match."""
    grouped: dict[str, list[tuple[int, object]]] = {}
    for i, raw in enumerate(_listed(document), start=1):
        id_ = _id(raw.get("matchId")) if isinstance(raw, dict) else ""
        # an event that names no match, or isn't one, belongs to the match before it
        if not id_ and grouped:
            id_ = next(reversed(grouped))
        grouped.setdefault(id_, []).append((i, raw))
    return grouped


def _listed(document: object) -> list[object]:
    listed = document.get("events") if isinstance(document, dict) else document
    return listed if isinstance(listed, list) else []


def _lines(ids: Sequence[str], known: dict[str, Companion]) -> list[str]:
    return [
        "  ".join(part for part in (known[id_].line if id_ in known else "", id_) if part)
        or "the match"
        for id_ in ids
    ]


def _id(value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, int | str):
        return ""
    return str(value) if isinstance(value, str) or abs(value) < 10**18 else ""


def _number(raw: dict[str, object], name: str, words: dict[str, int]) -> int:
    """Return the number of an event's kind: `eventId`, or `eventName` as number or words."""
    for value in (raw.get(f"{name}Id"), raw.get(f"{name}Name")):
        if type(value) is int:
            return value
        if isinstance(value, str):
            if value.isascii() and value.isdigit():
                return int(value[:9])
            if value.strip().lower() in words:
                return words[value.strip().lower()]
    return 0


def _tags(value: object) -> frozenset[int]:
    """Return the numbers of the tags; what isn't a list of them is none."""
    listed = value if isinstance(value, list) else []
    numbers = (entry.get("id") if isinstance(entry, dict) else entry for entry in listed)
    return frozenset(n for n in numbers if type(n) is int)


MAX_FILES = 20
"""Most companions that are looked into, by name."""

MAX_MB = 32.0
"""Largest companion that is read, MB; a season's has 5."""

_LABEL_CHARACTERS = 200

# "Leicester City - Liverpool, 2 - 3", "... , 1 - 1 (P)" after a shoot-out
_LABEL = re.compile(r"(?P<home>.+?) - (?P<away>.+?), ?(?P<score>[0-9]+ ?- ?[0-9]+.*)?")


@dataclass(frozen=True)
class Companion:
    """What `matches_*.json` knows of a match.

    Parameters
    ----------
    teams
        Names by id, the home team first; "" where the label names none.
    score
        Goals of the two, extra time included, a shoot-out not; None where it isn't given.
    date
        `2017-09-23`, or "".
    """

    teams: dict[str, str]
    score: tuple[int, int] | None
    date: str

    @property
    def line(self) -> str:
        """What a list of matches says about it."""
        result = f"{self.score[0]}-{self.score[1]}" if self.score else "-"
        names = [name or f"team {id_}" for id_, name in self.teams.items()]
        return "  ".join(part for part in (self.date, f" {result} ".join(names)) if part)


def companions(
    source: DataFile, ids: Collection[str]
) -> tuple[dict[str, Companion], tuple[str, ...]]:
    """Return what the `matches*.json` beside a file know of some matches, by id, and notes."""
    found: dict[str, Companion] = {}
    notes: list[str] = []
    try:
        beside = sorted(p for p in source.folder.glob("matches*.json") if p != source.path)
    except OSError:  # a folder that may be passed through but not listed
        return {}, ()
    for candidate in beside[:MAX_FILES]:
        try:
            found_beside = DataFile.open(candidate, LoadOptions(max_mb=MAX_MB))
            document = found_beside.json if found_beside.looks_like_json else None
        except InputError as error:
            notes.append(f"the names beside it weren't read: {error}")
            continue
        listed = document if isinstance(document, list) else [document]
        for raw in listed:
            companion = _companion(raw)
            if companion is not None and companion[0] in ids:
                found.setdefault(*companion)
    return found, tuple(notes)


def _companion(raw: object) -> tuple[str, Companion] | None:
    if not isinstance(raw, dict) or isinstance(raw.get("wyId"), bool):
        return None
    id_, sides = raw.get("wyId"), raw.get("teamsData")
    if not isinstance(id_, int | str) or not isinstance(sides, dict) or len(sides) != 2:
        return None
    if not all(isinstance(side, dict) for side in sides.values()):
        return None
    ordered = sorted(sides, key=lambda team: sides[team].get("side") != "home")
    label, date = raw.get("label"), raw.get("dateutc")
    # a label is a line; no pattern is tried on megabytes
    named = _LABEL.match(label[:_LABEL_CHARACTERS]) if isinstance(label, str) else None
    names = [named["home"].strip(), named["away"].strip()] if named else ["", ""]
    day = date[:10] if isinstance(date, str) and re.match(r"\d{4}-\d\d-\d\d", date) else ""
    teams = dict(zip((str(team)[:18] for team in ordered), names, strict=True))
    if len(teams) != 2:
        return None
    home, away = (_goals(sides[team]) for team in ordered)
    score = (home, away) if home is not None and away is not None else None
    return shown(id_).strip("'"), Companion(teams, score, day)


def _goals(side: dict[str, object]) -> int | None:
    """Return a team's goals: `scoreET` holds those after extra time, 0 without one."""
    numbers = [n for n in (side.get("score"), side.get("scoreET")) if type(n) is int and n >= 0]
    return max(numbers) if numbers else None
