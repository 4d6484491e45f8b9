"""StatsBomb open-data event files: the JSON list of one match's events.

Periods 1 to 4 are laid end to end: ordered by (period, timestamp), since StatsBomb's minutes
overlap (period 1 runs on to 47:30 while period 2 restarts at 45:00). A period is as long as its
latest `Half End`, or, with a note, its last event where there is none; what a file lists after the
`Half End` counts as at the period's end, with a note. Period 5, a shoot-out, is left out and noted.

Kinds:

- `goal`: a Shot of outcome Goal, labelled with the running score (`1-0 Parris (pen)`), the team of
  the first Starting XI first.
- `own_goal`: the pair of `Own Goal For` and `Own Goal Against` records, one event at the time of
  `Own Goal For`, whose team gets the score.
- `near_miss`: a Shot that was saved (Saved, Saved to Post, Saved Off Target), hit the post (Post),
  was blocked on the line (Blocked, with a related Block record whose `block.save_block` is true;
  either record may name the other in `related_events`), or missed (Off T, Wayward) from a good
  chance (`statsbomb_xg` of at least `GOOD_CHANCE_XG`).
- `yellow_card`, `red_card` (Red Card and Second Yellow): from `foul_committed.card` and
  `bad_behaviour.card`.
- `foul`: each Foul Committed, one with a card too (both at the same time).
- `period`: kick-off at 0, each boundary between periods once, the end of the match.

The intensity is the crowd-excitement curve of these events (`excitement.py`); the details, felt
when zoomed, are what the players do with the ball (`statsbomb_touches.py`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.readers.events.listing import repeated_ids
from overview_dsp.data.readers.football.match import short_name, touches
from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.data.timeline.model import Event, Timeline
from overview_dsp.errors import InputError, shown

GOOD_CHANCE_XG = 0.10
"""Chance (expected goals) from which a shot that misses is a near miss: one in ten goes in."""

OWN_GOAL_PAIR_US = 10_000_000
"""Furthest apart the two records of one own goal may be where neither names the other, us."""

MAX_OWN_GOALS = 1000
"""Most own goals that are paired (the record is 149)."""

PROVENANCE = "events: a StatsBomb open-data event file"

_SAVED = frozenset({"Saved", "Saved to Post", "Saved Off Target"})
_MISSED = frozenset({"Off T", "Wayward"})
_OUTCOMES = _SAVED | _MISSED | {"Goal", "Post", "Blocked"}
_CARDS = {"Yellow Card": "yellow_card", "Second Yellow": "red_card", "Red Card": "red_card"}
_CARD_PLACES = {"Foul Committed": "foul_committed", "Bad Behaviour": "bad_behaviour"}
_STARTS = {1: "kick-off", 2: "half-time", 3: "extra time", 4: "extra-time half-time"}
_ENDS = {1: "half-time", 2: "full time", 3: "extra-time half-time", 4: "full time"}
_SNIFFED = 50


def sniff(source: Source) -> bool:
    """Return whether the file is a JSON list with period, timestamp and type in an early entry."""
    if not source.looks_like_json or not isinstance(source.json, list):
        return False
    return any(
        isinstance(entry, dict) and {"period", "timestamp", "type"} <= entry.keys()
        for entry in source.json[:_SNIFFED]
    )


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read an event file (takes no options); InputError names the file and the record."""
    document = source.json  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        return decode(document, source.stem)


def decode(document: object, default_title: str = "") -> Timeline:
    """Make a Timeline of a parsed event file.

    Parameters
    ----------
    document
        The JSON list.
    default_title
        The title if the file names no team.

    Raises
    ------
    InputError
        A record lacks something that is needed; the line names it: `event 123 (id ...): ...`.
    """
    if not isinstance(document, list):
        raise InputError(f"the document is {shown(document)}, not a list of events")
    records = [Record.parse(raw, i) for i, raw in enumerate(document, start=1)]
    played = sorted(
        (record for record in records if record.period != SHOOT_OUT),
        key=lambda record: (record.period, record.clock_us),
    )
    return _Match(records, played).timeline(default_title)


class _Match:
    """The records of one match on their way to a Timeline."""

    def __init__(self, records: list[Record], played: list[Record]) -> None:
        self.records = records
        self.played = played
        self.notes: list[str] = []
        self.teams = _teams(records)
        self.score = [0, 0]
        self.starts_us, self.end_us = self._lay_end_to_end()

    def timeline(self, default_title: str) -> Timeline:
        events = [*self._periods()]
        own_goals = self._own_goals()
        on_line = _blocked_on_line(self.played)
        seen: dict[tuple[float, str, str], Record] = {}
        event_records: set[int] = set()
        for record in self.played:
            happened = list(self._kinds(record, own_goals, on_line))
            time_s = self._time_s(record) if happened else 0.0
            event_records |= {record.position} if happened else set()
            for kind, label in happened:
                with validation.located(f"{record.place}: "):
                    event = Event(time_s, kind, label)
                key = (event.time_s, kind, label)
                if key in seen:
                    self.notes.append(f"{record.place} repeats {seen[key].place}: left out")
                else:
                    seen[key] = record
                    events.append(event)
        self._note_shoot_out()
        self.notes += repeated_ids(record.id for record in self.records)
        duration_s = self.end_us / 1e6
        intensity, derived, notes = derive_intensity(events, duration_s)
        return Timeline(
            title=self._title(default_title),
            duration_s=duration_s,
            events=tuple(events),
            intensity=intensity,
            provenance="; ".join(part for part in (PROVENANCE, derived) if part),
            notes=(*self.notes, *notes),
            details=touches(touch_records(self.played, event_records, self._moment_s)),
        )

    def _lay_end_to_end(self) -> tuple[dict[int, int], int]:
        """Return the start of each period played and the end of the last, us."""
        starts: dict[int, int] = {}
        end = 0
        for period in sorted({record.period for record in self.played}):
            clocks = [record.clock_us for record in self.played if record.period == period]
            whistles = [
                record.clock_us
                for record in self.played
                if record.period == period and record.kind == "Half End"
            ]
            if not whistles:
                self.notes.append(
                    f"period {period} has no 'Half End': it ends with its last event here"
                )
            starts[period] = end
            end += max(whistles or clocks)
        if end == 0:
            raise InputError(
                "no time passes in periods 1 to 4, so there is no match to lay out; is the file "
                "complete?"
            )
        return starts, end

    def _time_s(self, record: Record) -> float:
        if self.starts_us[record.period] + record.clock_us > self._end_us(record.period):
            self.notes.append(
                f"{record.place} ({record.kind}) is listed after the end of period "
                f"{record.period}: put at its end"
            )
        return self._moment_s(record)

    def _moment_s(self, record: Record) -> float:
        time_us = self.starts_us[record.period] + record.clock_us
        return min(time_us, self._end_us(record.period)) / 1e6

    def _end_us(self, period: int) -> int:
        following = [start for p, start in self.starts_us.items() if p > period]
        return min([*following, self.end_us])

    def _periods(self) -> Iterator[Event]:
        for period, start_us in self.starts_us.items():
            yield Event(start_us / 1e6, "period", _STARTS[period])
        yield Event(self.end_us / 1e6, "period", _ENDS[max(self.starts_us)])

    def _kinds(
        self, record: Record, own_goals: dict[int, str], on_line: frozenset[int]
    ) -> Iterator[tuple[str, str]]:
        """Yield (kind, label) of what happens in a record, scoring goals on the way."""
        if record.kind == "Shot":
            outcome = record.named("shot", "outcome")
            if outcome is None or outcome not in _OUTCOMES:
                raise record.error(
                    f"shot.outcome.name is {shown(outcome)}; outcomes are "
                    f"{', '.join(sorted(_OUTCOMES))}"
                )
            if outcome == "Goal":
                penalty = " (pen)" if record.named("shot", "type") == "Penalty" else ""
                label = f"{self._scored(record, record.team)} {short_name(record.player)}".rstrip()
                yield "goal", label + penalty
            elif (how := _near_miss(record, outcome, on_line)) is not None:
                spot = "penalty " if record.named("shot", "type") == "Penalty" else ""
                yield "near_miss", ", ".join(part for part in (_who(record), spot + how) if part)
        elif record.position in own_goals:
            team = record.team
            if record.kind == "Own Goal Against":  # alone: its team is the one that suffers
                team = next((other for other in self.teams if other != record.team), "")
            scorer = own_goals[record.position]
            label = f"{self._scored(record, team)} own goal"
            yield "own_goal", f"{label}, {scorer}" if scorer else label
        elif record.kind in _CARD_PLACES:
            if record.kind == "Foul Committed":
                yield "foul", _who(record)
            card = record.named(_CARD_PLACES[record.kind], "card")
            if card is not None:
                if card not in _CARDS:
                    raise record.error(
                        f"{_CARD_PLACES[record.kind]}.card.name is {shown(card)}; cards "
                        f"are {', '.join(_CARDS)}"
                    )
                second = ", second yellow" if card == "Second Yellow" else ""
                yield _CARDS[card], f"{_who(record)}{second}"

    def _scored(self, record: Record, team: str) -> str:
        if team not in self.teams:
            raise record.error(
                f"the goal's team is {shown(team)}; the match's teams are "
                f"{' and '.join(shown(name) for name in self.teams) or 'not named'}"
            )
        self.score[self.teams.index(team)] += 1
        return f"{self.score[0]}-{self.score[1]}"

    def _own_goals(self) -> dict[int, str]:
        """Return who scored each own goal, by the position of the record that stands for it."""
        against = [record for record in self.played if record.kind == "Own Goal Against"]
        if len(against) > MAX_OWN_GOALS:
            raise InputError(
                f"{len(against)} own goals, more than the {MAX_OWN_GOALS} of any match; is it one?"
            )
        scorers: dict[int, str] = {}
        for record in self.played:
            if record.kind == "Own Goal For":
                partner = _partner(record, against)
                if partner is not None:
                    against.remove(partner)
                scorers[record.position] = short_name(partner.player) if partner else ""
        for record in against:
            self.notes.append(
                f"{record.place} is an 'Own Goal Against' without its 'Own Goal For': the goal is "
                "given to the other team"
            )
            scorers[record.position] = short_name(record.player)
        return scorers

    def _note_shoot_out(self) -> None:
        kicks = [r for r in self.records if r.period == SHOOT_OUT and r.kind == "Shot"]
        if any(record.period == SHOOT_OUT for record in self.records):
            scored = [r.team for r in kicks if _scores(r)]
            tally = ", ".join(f"{team} {scored.count(team)}" for team in self.teams)
            self.notes.append(
                f"the shoot-out (period 5) is left out: {len(kicks)} kicks; scored: {tally}"
            )

    def _title(self, default_title: str) -> str:
        if len(self.teams) == 2:
            return f"{self.teams[0]} {self.score[0]}-{self.score[1]} {self.teams[1]}"
        return default_title


def _teams(records: list[Record]) -> list[str]:
    """Return the two teams, the one of the first Starting XI first (StatsBomb's home team)."""
    elevens = [record.team for record in records if record.kind == "Starting XI"]
    others = [record.team for record in records]
    return list(dict.fromkeys(team for team in (*elevens, *others) if team))[:2]


def _who(record: Record) -> str:
    name = short_name(record.player)
    return f"{name} ({record.team})" if name and record.team else name or record.team


def _near_miss(record: Record, outcome: str, on_line: frozenset[int]) -> str | None:
    """Return how a shot nearly went in, None if it didn't come near (rule: module docstring)."""
    if outcome in _SAVED:
        return "saved"
    if outcome == "Post":
        return "on the post"
    if outcome == "Blocked":
        return "blocked on the line" if record.position in on_line else None
    xg = record.section("shot").get("statsbomb_xg")
    if xg is None:  # no estimate, no good chance
        return None
    with validation.located(f"{record.place}: "):
        chance = validation.number(xg, "shot.statsbomb_xg", "it is a probability")
    return "missed" if chance >= GOOD_CHANCE_XG else None


def _blocked_on_line(records: list[Record]) -> frozenset[int]:
    """Return the positions of the shots a Block with `save_block` is related to, either way."""
    blocks = [
        record
        for record in records
        if record.kind == "Block" and record.section("block").get("save_block") is True
    ]
    block_ids = {block.id for block in blocks if block.id}
    named = frozenset(entry for block in blocks for entry in block.related)
    return frozenset(
        record.position
        for record in records
        if record.kind == "Shot" and (record.id in named or record.related & block_ids)
    )


def _partner(own_goal_for: Record, against: list[Record]) -> Record | None:
    """Return the `Own Goal Against` of an `Own Goal For`: the related one, else the nearest."""
    for record in against:
        if record.id in own_goal_for.related or own_goal_for.id in record.related:
            return record
    near = [
        record
        for record in against
        if record.period == own_goal_for.period
        and abs(record.clock_us - own_goal_for.clock_us) <= OWN_GOAL_PAIR_US
    ]
    return min(near, key=lambda record: abs(record.clock_us - own_goal_for.clock_us), default=None)


def _scores(kick: Record) -> bool:
    outcome = kick.section("shot").get("outcome")
    return isinstance(outcome, dict) and outcome.get("name") == "Goal"


SHOOT_OUT = 5
"""The period of a shoot-out; 1 and 2 are halves, 3 and 4 those of extra time."""

_CLOCK = re.compile(r"([0-9]{2}):([0-5][0-9]):([0-5][0-9])(?:\.([0-9]{1,6}))?")


@dataclass(frozen=True)
class Record:
    """An event as StatsBomb lists it.

    Parameters
    ----------
    position
        Place in the file, from 1 (StatsBomb's own `index`).
    raw
        The JSON object.
    id, kind, team, player
        `id`, `type.name`, `team.name`, `player.name`; all but `kind` are "" where missing.
    period
        1 to 5.
    clock_us
        `timestamp`, the time since the period's start, in whole microseconds: sums stay exact.
    """

    position: int
    raw: dict[str, object]
    id: str
    kind: str
    team: str
    player: str
    period: int
    clock_us: int

    @classmethod
    def parse(cls, raw: object, position: int) -> Record:
        """Check what every record needs; InputError names the record."""
        if not isinstance(raw, dict):
            raise InputError(f"event {position}: is {shown(raw)}, not an object {{...}}")
        id_ = raw.get("id")
        id_ = id_ if isinstance(id_, str) else ""
        with validation.located(f"{_place(position, id_)}: "):
            period = raw.get("period")
            if isinstance(period, bool) or not isinstance(period, int):
                raise InputError(f"period is {shown(period)}; periods are 1 to {SHOOT_OUT}")
            if not 1 <= period <= SHOOT_OUT:
                raise InputError(f"period is {shown(period)}; periods are 1 to {SHOOT_OUT}")
            kind = _name(raw, "type")
            if kind is None:
                raise InputError("type.name is missing; it says what the event is, such as 'Shot'")
            clock_us = _clock_us(raw.get("timestamp"))
        return cls(
            position,
            raw,
            id_,
            kind,
            _name(raw, "team") or "",
            _name(raw, "player") or "",
            period,
            clock_us,
        )

    @property
    def place(self) -> str:
        """How an error line or a note names this record."""
        return _place(self.position, self.id)

    def error(self, problem: str) -> InputError:
        """Return the error of this record."""
        return InputError(f"{self.place}: {problem}")

    def section(self, key: str) -> dict[str, object]:
        """Return a part of the record, empty where missing; InputError if it isn't an object."""
        value = self.raw.get(key)
        if value is None:
            return {}
        if not isinstance(value, dict):
            raise self.error(f"{key} is {shown(value)}, not an object {{...}}")
        return value

    def named(self, section: str, key: str) -> str | None:
        """Return `section.key.name`, None where the section has no such key.

        Raises
        ------
        InputError
            The key is there, but without a name.
        """
        part = self.section(section)
        if part.get(key) is None:
            return None
        name = _name(part, key)
        if name is None:
            raise self.error(f"{section}.{key} is {shown(part[key])}; it needs a name")
        return name

    @property
    def related(self) -> frozenset[str]:
        """Ids of related events; what isn't a list of text is none."""
        value = self.raw.get("related_events")
        if not isinstance(value, list):
            return frozenset()
        return frozenset(entry for entry in value if isinstance(entry, str))


def _place(position: int, id_: str) -> str:
    return f"event {position} (id {shown(id_)[1:-1]})" if id_ else f"event {position}"


def _name(table: dict[str, object], key: str) -> str | None:
    part = table.get(key)
    name = part.get("name") if isinstance(part, dict) else None
    return name if isinstance(name, str) and name.strip() else None


def _clock_us(value: object) -> int:
    found = _CLOCK.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        raise InputError(f"timestamp is {shown(value)}; it is the time in the period, hh:mm:ss.sss")
    hours, minutes, seconds = (int(found[i]) for i in (1, 2, 3))
    return (hours * 3600 + minutes * 60 + seconds) * 1_000_000 + int((found[4] or "").ljust(6, "0"))


TOUCHES = {
    "Pass": "pass",
    "Ball Receipt*": "receipt",
    "Carry": "carry",
    "Pressure": "pressure",
    "Ball Recovery": "recovery",
    "Duel": "duel",
    "Dribble": "dribble",
    "Dribbled Past": "dribbled past",
    "Clearance": "clearance",
    "Block": "block",
    "Interception": "interception",
    "Goal Keeper": "goalkeeper",
    "Miscontrol": "miscontrol",
    "Dispossessed": "dispossessed",
    "50/50": "fifty-fifty",
    "Shield": "shield",
    "Shot": "shot",
}


def touch_records(
    records: Iterable[Record], happened: Collection[int], time_of: Callable[[Record], float]
) -> Iterator[tuple[float, str, str]]:
    """Yield (time_s, what, who) of the records that are touches or shots.

    Parameters
    ----------
    records
        Of the periods played.
    happened
        The positions of the records that are events already.
    time_of
        The moment of a record, s.
    """
    for record in records:
        if record.kind in TOUCHES and record.position not in happened:
            yield time_of(record), TOUCHES[record.kind], short_name(record.player)
