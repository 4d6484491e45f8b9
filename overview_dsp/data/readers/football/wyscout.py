"""Reader of Wyscout v2 events: JSON of one match, or of the matches of a competition.

Two structures are read. The public data set has a list of events with numbers as `eventId`. The
API has an object (`{"events": [...], "teams": {...}, "players": {...}}`) with numbers as
`eventName`. The clock restarts at 0 in each period (1H, 2H, E1, E2). Periods are concatenated, and
each ends with its last event. Period P, a shoot-out, is omitted, with a note. Times are exact.

The numbers of events and tags determine the event kind:

- `goal`: tag 101, except on a save attempt (9), which has the tag of the goal that follows; `(pen)`
  for a penalty (35).
- `own_goal`: tag 102; the other team scores. A save attempt after it is not a goal.
- `near_miss`: a shot (10), free-kick shot (33) or penalty (35) without a goal. It must have a
  position tag in the goal's frame or on the post, or the tag accurate (on target). It must not be
  blocked (2101). A penalty without a goal is always a near miss.
- `foul`: event 2; `yellow_card`: 1702; `red_card`: 1701, 1703 (second yellow).
- `period`: kick-off, the start of each later period, and the end.

All other events with the ball are touches, shown in windows only.

The companion file `matches_*.json` in the same folder has names, home team and score.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import repeated_ids
from overview_dsp.data.readers.football.match_timeline import (
    ACTIONS,
    MAX_PERIOD_S,
    SHOOT_OUT,
    TOUCH,
    MatchEvent,
    concatenate_periods,
    contains_record,
    match_timeline,
    select_match,
    shoot_out_note,
    short_name,
)
from overview_dsp.data.timeline.event import GOALS
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted

PROVENANCE = "events: a Wyscout v2 event file"
SAME_GOAL_S = 10.0
"""Maximum time between two tags of the same goal, s. No match restarts sooner."""

_FOUL, _FREE_KICK, _SAVE, _SHOT = 2, 3, 9, 10
_FREE_KICK_SHOT, _PENALTY = 33, 35
_GOAL, _OWN_GOAL, _ACCURATE, _BLOCKED = 101, 102, 1801, 2101
_FRAME = frozenset(range(1201, 1210))
_POST = frozenset(range(1217, 1224))
_CARDS = {1701: ("red_card", ""), 1702: ("yellow_card", ""), 1703: ("red_card", "second yellow")}
_EVENT, _MATCH = ("matchPeriod", "eventSec"), ("teamsData", "wyId")
_PERIODS = {"1H": 1, "2H": 2, "E1": 3, "E2": 4, "P": SHOOT_OUT}
_EVENTS: dict[str, int] = ACTIONS["wyscout"]["events"]
_BALL_TOUCHES = {_EVENTS[name]: text for name, text in ACTIONS["wyscout"]["touches"].items()}
_SUB_EVENTS = {"free kick shot": 33, "penalty": 35}


@dataclass(frozen=True)
class _Event:
    """Validated event."""

    location: str
    id: str
    period: int
    sec: float
    team: str
    player: str
    event: int
    sub_event: int
    tags: frozenset[int]

    @classmethod
    def parse(cls, value: object, location: str) -> _Event:
        raw = validation.of_type(value, dict, f"{location}:", "an object {...}")
        with validation.prefix_errors(f"{location}: "):
            period = raw.get("matchPeriod")
            if not isinstance(period, str) or period not in _PERIODS:
                raise InputError(
                    f"matchPeriod is {quoted(period)}; must be one of {', '.join(_PERIODS)}"
                )
            hint = f"must be the time in the period, 0 to {MAX_PERIOD_S:g} s"
            sec = validation.number(raw.get("eventSec"), "eventSec", hint)
            if not 0.0 <= sec <= MAX_PERIOD_S:
                raise InputError(f"eventSec is {sec!r}; {hint}")
            return cls(
                location,
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
    """Return whether the file is JSON of events, or of matches without them, which is an error."""
    text = source.text if source.looks_like_json else ""
    if '"matchPeriod"' not in text and '"teamsData"' not in text:
        return False
    return any(contains_record(_listed(source.json), *keys) for keys in (_EVENT, _MATCH))


def matches(source: DataFile) -> list[str]:
    """Return a description of each match in the file."""
    document = source.json
    grouped = _grouped(document)
    found, _ = companions(source, frozenset(grouped))
    return _lines(list(grouped), found)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`); the InputError contains file and event."""
    document = source.json  # its errors contain the path
    found, companion_notes = companions(source, frozenset(_grouped(document)))
    return decode(document, options.match, found, companion_notes, source.stem)


def decode(
    document: object,
    match: str | None = None,
    found: Mapping[str, Companion] = MappingProxyType({}),
    companion_notes: Sequence[str] = (),
    default_title: str = "",
) -> Timeline:
    """Return the Timeline of one match of a parsed file.

    `document`: list of events, or object that contains it.
    `match`: as `LoadOptions.match`; may be None for a file of one match.
    `found`: names and scores of matches by their ids, if known.
    `companion_notes`: notes about the files of the companions.
    `default_title`: title if the teams have no names.

    InputError: the period, time or team of an event is invalid. The message contains its number:
    `event 123: ...`.
    """
    grouped = _grouped(document)
    ids = list(grouped)
    id_ = ids[select_match(_lines(ids, found), match, ids)]
    companion = found.get(id_)
    events = [_Event.parse(raw, f"event {i}") for i, raw in grouped[id_]]
    played = [event for event in events if event.period != SHOOT_OUT]
    played.sort(key=lambda event: (event.period, event.sec))
    notes = [*companion_notes, *repeated_ids(event.id for event in events)]
    begins, end_s = concatenate_periods({event.period: event.sec for event in played})
    teams = _teams(document, played, companion, notes)
    players = _players(document)
    match_events: list[MatchEvent] = []
    for event in played:
        time_s, player = begins[event.period] + event.sec, players.get(event.player, "")
        kinds = _classify(event)
        if not kinds and event.event in _BALL_TOUCHES:
            kinds = [(TOUCH, "shot" if _is_attempt(event) else _BALL_TOUCHES[event.event])]
        for kind, detail in kinds:
            team = _team(event, list(teams), needed=kind in GOALS)
            if kind == "own_goal" and team is not None:
                team = 1 - team
            match_events.append(MatchEvent(time_s, kind, team, player, detail, "", event.location))
    match_events = _single_goals(match_events, notes)
    if len(played) < len(events):
        kicks = [e for e in events if e.period == SHOOT_OUT and _is_attempt(e)]
        scored = [(event.team, _GOAL in event.tags) for event in kicks]
        notes.append(f"the shoot-out {shoot_out_note(scored, teams)}")
    return match_timeline(
        list(teams.values()),
        begins,
        end_s,
        match_events,
        PROVENANCE,
        notes,
        default_title=default_title,
        title_parts=[companion.date] if companion else [],
        final=companion.score if companion else None,
    )


def _classify(event: _Event) -> list[tuple[str, str]]:
    """Return the event kinds and details of an event."""
    kinds: list[tuple[str, str]] = []
    tags, is_penalty = event.tags, event.sub_event == _PENALTY
    if event.event == _FOUL:
        kinds.append(("foul", ""))
    # a second yellow may also have the tags of a yellow and a red card
    kinds += [_CARDS[tag] for tag in _CARDS if tag in tags and (tag == 1703 or 1703 not in tags)]
    if _OWN_GOAL in tags:
        kinds.append(("own_goal", ""))
    elif _GOAL in tags and event.event != _SAVE:
        kinds.append(("goal", "pen" if is_penalty else ""))
    elif _is_attempt(event):
        if tags & _POST:
            kinds.append(("near_miss", "on the post"))
        elif _BLOCKED not in tags and (tags & _FRAME or _ACCURATE in tags):
            kinds.append(("near_miss", "penalty saved" if is_penalty else "saved"))
        elif is_penalty:
            kinds.append(("near_miss", "penalty missed"))
    return kinds


def _is_attempt(event: _Event) -> bool:
    return event.event == _SHOT or (
        event.event == _FREE_KICK and event.sub_event in (_FREE_KICK_SHOT, _PENALTY)
    )


def _single_goals(match_events: Sequence[MatchEvent], notes: list[str]) -> list[MatchEvent]:
    """Return the events, without each goal up to `SAME_GOAL_S` after another of its team."""
    result: list[MatchEvent] = []
    last: dict[int | None, MatchEvent] = {}
    for event in match_events:
        if event.kind in GOALS:
            earlier = last.get(event.team)
            if earlier is not None and event.time_s - earlier.time_s <= SAME_GOAL_S:
                notes.append(f"{event.location} repeats the goal of {earlier.location}: omitted")
                continue
            last[event.team] = event
        result.append(event)
    return result


def _team(event: _Event, ids: Sequence[str], *, needed: bool) -> int | None:
    if event.team in ids:
        return list(ids).index(event.team)
    if needed:
        raise InputError(
            f"{event.location}: the goal's teamId is {event.team or 'missing'}; must be one of the "
            f"match's teams, {' and '.join(ids) or 'which have no ids'}"
        )
    return None


def _teams(
    document: object, played: Sequence[_Event], companion: Companion | None, notes: list[str]
) -> dict[str, str]:
    """Return the names of the two teams by id, the home team first if it is known."""
    ids = list(dict.fromkeys(event.team for event in played if event.team))
    if companion is not None and set(companion.teams) >= set(ids):
        teams = companion.teams
    else:
        teams = dict.fromkeys(ids[:2], "")
        if len(teams) == 2:
            notes.append(
                "the home team is unknown without matches_*.json in the same folder: the team with "
                "the first event comes first"
            )
    listed = document.get("teams") if isinstance(document, dict) else None
    entries = listed if isinstance(listed, dict) else {}
    return {id_: name or _name_of(entries.get(id_)) or f"team {id_}" for id_, name in teams.items()}


def _name_of(entry: object) -> str:
    """Return the name in an entry of `teams`; "" without one."""
    inner = entry.get("team", entry) if isinstance(entry, dict) else None
    name = inner.get("name") if isinstance(inner, dict) else None
    return name if isinstance(name, str) else ""


def _players(document: object) -> dict[str, str]:
    """Return the short names of the players by id; empty if the file has none."""
    table = document.get("players") if isinstance(document, dict) else None
    listed: list[object] = []
    for entry in table.values() if isinstance(table, dict) else [table]:
        listed += entry if isinstance(entry, list) else []
    found: dict[str, str] = {}
    for entry in listed:
        player = entry.get("player", entry) if isinstance(entry, dict) else None
        if isinstance(player, dict):
            last, short = player.get("lastName"), player.get("shortName")
            # "D.Gray" has an initial, "Roberto Firmino" has none
            name = short.rsplit(".", 1)[-1].strip() if isinstance(short, str) else ""
            name = name or (last if isinstance(last, str) else "")
            found[_id(player.get("wyId"))] = short_name(name)
    return found


def _grouped(document: object) -> dict[str, list[tuple[int, object]]]:
    """Return the events and their numbers from 1, by the id of the match."""
    if contains_record(_listed(document), *_MATCH):
        raise InputError("the matches of Wyscout, without their events; read the file of events")
    grouped: dict[str, list[tuple[int, object]]] = {}
    for i, raw in enumerate(_listed(document), start=1):
        id_ = _id(raw.get("matchId")) if isinstance(raw, dict) else ""
        # an event without a match belongs to the match of the previous event
        if not id_ and grouped:
            id_ = next(reversed(grouped))
        grouped.setdefault(id_, []).append((i, raw))
    return grouped


def _listed(document: object) -> list[object]:
    listed = document.get("events") if isinstance(document, dict) else document
    return listed if isinstance(listed, list) else []


def _lines(ids: Sequence[str], found: Mapping[str, Companion]) -> list[str]:
    lines = ((found[id_].line if id_ in found else "", id_) for id_ in ids)
    return ["  ".join(filter(None, line)) or "the match" for line in lines]


def _id(value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, int | str):
        return ""
    return str(value) if isinstance(value, str) or abs(value) < 10**18 else ""


def _number(raw: dict[str, object], name: str, numbers: dict[str, int]) -> int:
    """Return the number of an event's type: `eventId`, or `eventName` as a number or a name."""
    for value in (raw.get(f"{name}Id"), raw.get(f"{name}Name")):
        if type(value) is int:
            return value
        if isinstance(value, str):
            if value.isascii() and value.isdigit():
                return int(value[:9])
            if value.strip().lower() in numbers:
                return numbers[value.strip().lower()]
    return 0


def _tags(value: object) -> frozenset[int]:
    """Return the numbers of the tags; empty if the value is not a list."""
    listed = value if isinstance(value, list) else []
    numbers = (entry.get("id") if isinstance(entry, dict) else entry for entry in listed)
    return frozenset(n for n in numbers if type(n) is int)


MAX_FILES = 20
"""Maximum number of companion files that are read."""

MAX_MB = 32.0
"""Maximum size of a companion file, MB. That of a season has 5 MB."""

_MAX_LABEL_LENGTH = 200

# "Leicester City - Liverpool, 2 - 3", "... , 1 - 1 (P)" after a shoot-out
_LABEL = re.compile(r"(?P<home>.+?) - (?P<away>.+?), ?(?P<score>[0-9]+ ?- ?[0-9]+.*)?")


@dataclass(frozen=True)
class Companion:
    """Data of a match in `matches_*.json`.

    `teams`: names by id, the home team first; "" if they are missing.
    `score`: final score with extra time and without a shoot-out; None if it is missing.
    `date`: date, such as `2017-09-23`, or "".
    """

    teams: dict[str, str]
    score: tuple[int, int] | None
    date: str

    @property
    def line(self) -> str:
        """Description of the match for display."""
        result = f"{self.score[0]}-{self.score[1]}" if self.score else "-"
        names = [name or f"team {id_}" for id_, name in self.teams.items()]
        return "  ".join(part for part in (self.date, f" {result} ".join(names)) if part)


def companions(
    source: DataFile, ids: Collection[str]
) -> tuple[dict[str, Companion], tuple[str, ...]]:
    """Return the data in `matches*.json` for the matches with these ids, and notes."""
    found: dict[str, Companion] = {}
    notes: list[str] = []
    try:
        paths = sorted(p for p in source.folder.glob("matches*.json") if p != source.path)
    except OSError:  # no permission to list the folder
        return {}, ()
    for path in paths[:MAX_FILES]:
        try:
            candidate = DataFile.open(path, LoadOptions(max_mb=MAX_MB))
            document = candidate.json if candidate.looks_like_json else None
        except InputError as error:
            notes.append(f"the companion file with the names was not read: {error}")
            continue
        for raw in document if isinstance(document, list) else [document]:
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
    # limited, because the pattern is slow on a very long text
    parts = _LABEL.match(label[:_MAX_LABEL_LENGTH]) if isinstance(label, str) else None
    names = [parts["home"].strip(), parts["away"].strip()] if parts else ["", ""]
    day = date[:10] if isinstance(date, str) and re.match(r"\d{4}-\d\d-\d\d", date) else ""
    teams = dict(zip((str(team)[:18] for team in ordered), names, strict=True))
    if len(teams) != 2:
        return None
    home, away = (_goals(sides[team]) for team in ordered)
    score = (home, away) if home is not None and away is not None else None
    return quoted(id_).strip("'"), Companion(teams, score, day)


def _goals(side: dict[str, object]) -> int | None:
    """Return the goals of a team; `scoreET`, 0 without extra time, includes the others."""
    numbers = [n for n in (side.get("score"), side.get("scoreET")) if type(n) is int and n >= 0]
    return max(numbers) if numbers else None
