"""Reader of StatsBomb open-data event files: a JSON list with the events of one match.

Periods 1 to 4 are concatenated. Events are sorted by period and timestamp, because the minutes of
periods overlap: period 1 may end at 47:30, and period 2 starts at 45:00. A period ends with its
last `Half End`; without one, it ends with its last event, and a note is shown. Events after the
`Half End` are moved to it, with a note. Period 5, a shoot-out, is omitted, with a note.

Event kinds:

- `goal`: a Shot with the outcome Goal. The label has the running score (`1-0 Parris (pen)`); the
  team of the first Starting XI comes first.
- `own_goal`: a pair of the records `Own Goal For` and `Own Goal Against`. The event has the time of
  `Own Goal For`, whose team scores.
- `near_miss`: a Shot with one of these outcomes:
  - Saved, Saved to Post, Saved Off Target, or Post
  - Blocked, if a Block record with `block.save_block` is related (a block on the line); either
    record may contain the other in `related_events`
  - Off T or Wayward, if `statsbomb_xg` is at least `GOOD_CHANCE_XG`
- `yellow_card`, `red_card` (Red Card and Second Yellow): from `foul_committed.card` and
  `bad_behaviour.card`.
- `foul`: each Foul Committed, also with a card.
- `period`: kick-off at 0, the start of each later period, and the end of the match.

The players' actions with the ball (`BALL_TOUCHES`) are shown in windows only.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import repeated_ids
from overview_dsp.data.readers.football.match_timeline import (
    ACTIONS,
    SHOOT_OUT,
    TOUCH,
    MatchEvent,
    concatenate_periods,
    contains_record,
    match_timeline,
    shoot_out_note,
    short_name,
    team_index,
)
from overview_dsp.data.readers.tables.delimited import records
from overview_dsp.data.readers.tables.dialect import header_dialect
from overview_dsp.data.readers.tables.table import Column
from overview_dsp.data.readers.tables.time_column import as_number
from overview_dsp.data.timeline.event import GOALS
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted

GOOD_CHANCE_XG = 0.10
"""Minimum probability of a goal (xG) for which a missed shot is a near miss."""

OWN_GOAL_PAIR_US = 10_000_000
"""Maximum time between the two records of an own goal that are not related, us."""

MAX_OWN_GOALS = 1000
"""Maximum number of own goals. The world record is 149."""

PROVENANCE = "events: a StatsBomb open-data event file"

BALL_TOUCHES: dict[str, str] = ACTIONS["statsbomb"]["touches"]
_NEAR_MISSES: dict[str, str] = ACTIONS["statsbomb"]["near_misses"]
_OUTCOMES = sorted({*_NEAR_MISSES, "Goal"})
_CARDS = {"Yellow Card": "yellow_card", "Second Yellow": "red_card", "Red Card": "red_card"}
_CARD_SECTIONS = {"Foul Committed": "foul_committed", "Bad Behaviour": "bad_behaviour"}
_ENDS = {1: "half-time", 2: "full time", 3: "extra-time half-time", 4: "full time"}
_CLOCK = re.compile(r"([0-9]{2}):([0-5][0-9]):([0-5][0-9])(?:\.([0-9]{1,6}))?")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a JSON list of objects with period, timestamp and type."""
    if not source.looks_like_json or not isinstance(source.json, list):
        return False
    return contains_record(source.json, "period", "timestamp", "type")


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read an event file (takes no options); the InputError contains file and record."""
    return decode(source.json, source.stem)


_SIGNS = ("index", "possession", "play_pattern", "related_events", "shot_outcome", "outcome_name")


def sniff_table(source: DataFile) -> bool:
    """Return whether the file is a table with the columns of statsbombpy or mplsoccer."""
    if source.head_text is None or source.looks_like_json:
        return False
    found = header_dialect(source.head_text)
    names = {Column.of(name).name for name in found.header} if found is not None else set()
    kinds = {"type", "type_name"} & names and {"team", "team_name"} & names
    return bool({"period", "timestamp"} <= names and kinds and names & set(_SIGNS))


def read_table(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a table of events (takes no options); the InputError contains file and event."""
    text = source.text
    rows = [{Column.of(k).name: v for k, v in row.items()} for _, row in records(text)]
    matches = list(dict.fromkeys(filter(None, (row.get("match_id") for row in rows))))
    if len(matches) > 1:
        raise InputError(
            f"events of {len(matches)} matches (match_id {', '.join(matches[:3])} ...); keep "
            "the rows of one"
        )
    places = [as_number(row.get("index")) for row in rows]
    if None not in places:
        rows = [row for _, _, row in sorted(zip(places, itertools.count(), rows, strict=False))]
    return decode([_nested(row) for row in rows], source.stem)


def _nested(row: dict[str, str]) -> dict[str, object]:
    """Return the record of an event file from a row with flat columns, those that are read."""

    def cell(*names: str) -> str:
        return next((row[n] for n in names if row.get(n, "").lower() not in _EMPTY), "")

    clock, period = cell("timestamp").removeprefix("0 days "), cell("period")
    if (moment_s := as_number(clock)) is not None and moment_s >= 0:
        minutes, seconds = divmod(moment_s, 60.0)
        clock = f"{int(minutes) // 60:02}:{int(minutes) % 60:02}:{seconds:09.6f}"
    kind = cell("type_name", "type")
    shot: dict[str, object] = {}
    if kind == "Shot":
        shot = {
            "outcome": {"name": cell("shot_outcome", "outcome_name")},
            "type": {"name": cell("shot_type", "sub_type_name")},
        }
        if chance := cell("shot_statsbomb_xg"):
            shot["statsbomb_xg"] = as_number(chance)
    record: dict[str, object] = {
        "id": cell("id"),
        "period": int(float(period)) if as_number(period) is not None else period,
        "timestamp": clock,
        "type": {"name": kind},
        "team": {"name": cell("team_name", "team")},
        "player": {"name": cell("player_name", "player")},
        "related_events": re.findall(r"['\"]([^'\"]+)['\"]", cell("related_events")),
        "shot": shot,
        "block": {"save_block": cell("block_save_block").lower() in ("true", "1", "1.0")},
    }
    for section in _CARD_SECTIONS.values():
        if card := cell(f"{section}_card", f"{section}_card_name"):
            record[section] = {"card": {"name": card}}
    return {key: value for key, value in record.items() if value not in ("", {}, {"name": ""})}


_EMPTY = ("", "nan", "none", "null", "<na>", "nat")


def decode(document: object, default_title: str = "") -> Timeline:
    """Return the Timeline of a parsed event file; `default_title` is used without team names.

    InputError: a record is invalid. The message contains its number and id: `event 123 (id ...):
    ...`.
    """
    listed = validation.of_type(document, list, "the document", "a list of events")
    records = [Record.parse(raw, i) for i, raw in enumerate(listed, start=1)]
    played = sorted(
        (record for record in records if record.period != SHOOT_OUT),
        key=lambda record: (record.period, record.clock_us),
    )
    notes: list[str] = []
    lengths = _lengths_us(played, notes)
    begins, end = concatenate_periods(lengths)
    # the team of the first Starting XI is the home team
    starting = [record for record in records if record.kind == "Starting XI"]
    teams = list(dict.fromkeys(one.team for one in (*starting, *records) if one.team))
    own_goals = _own_goals(played, notes)
    on_line = _blocked_on_line(played)
    match_events: dict[tuple[object, ...], MatchEvent] = {}
    for record in played:
        found = list(_classify(record, own_goals, on_line, teams[:2]))
        if found and record.clock_us > lengths[record.period]:
            notes.append(
                f"{record.location} ({record.kind}) is after the end of period {record.period}: "
                "moved to its end"
            )
        time_s = (begins[record.period] + min(record.clock_us, lengths[record.period])) / 1e6
        if not found and record.kind in BALL_TOUCHES:
            found = [(TOUCH, "", short_name(record.player), BALL_TOUCHES[record.kind])]
        for kind, name, player, detail in found:
            team = teams.index(name) if name else None
            one = MatchEvent(time_s, kind, team, player, detail, "", record.location)
            # goals are never repeats: each one has its own score
            number = record.number if kind in (*GOALS, TOUCH) else 0
            key = (time_s, kind, team, player, detail, number)
            first = match_events.setdefault(key, one)
            if first is not one:
                notes.append(f"{one.location} repeats {first.location}: omitted")
    if any(record.period == SHOOT_OUT for record in records):
        kicks = [r for r in records if r.period == SHOOT_OUT and r.kind == "Shot"]
        scored = [(r.team, _name(r.section("shot"), "outcome") == "Goal") for r in kicks]
        names = {team: team for team in teams[:2]}
        notes.append(f"the shoot-out (period 5) {shoot_out_note(scored, names)}")
    notes += repeated_ids(record.id for record in records)
    return match_timeline(
        (*teams, *[""] * (2 - len(teams))),  # so that goals are counted with one team, too
        {period: begin / 1e6 for period, begin in begins.items()},
        end / 1e6,
        match_events.values(),
        PROVENANCE,
        notes,
        default_title=default_title,
        end_label=_ENDS[max(begins)],
    )


def _lengths_us(played: Sequence[Record], notes: list[str]) -> dict[int, int]:
    """Return the length of each period, us."""
    lengths = {}
    for period in sorted({record.period for record in played}):
        records = [record for record in played if record.period == period]
        half_ends = [record for record in records if record.kind == "Half End"]
        if not half_ends:
            notes.append(f"period {period} has no 'Half End': it ends with its last event")
        lengths[period] = max(record.clock_us for record in half_ends or records)
    return lengths


def _classify(
    record: Record, own_goals: dict[int, str], on_line: frozenset[int], teams: Sequence[str]
) -> Iterator[tuple[str, str, str, str]]:
    """Yield the event kind, team, player and detail of the events in a record."""
    player, team = short_name(record.player), record.team
    if record.kind == "Shot":
        outcome = record.named("shot", "outcome")
        if outcome is None or outcome not in _OUTCOMES:
            raise record.error(
                f"shot.outcome.name is {quoted(outcome)}; must be one of {', '.join(_OUTCOMES)}"
            )
        if outcome != "Goal" and not _is_near(record, outcome, on_line):
            return
        penalty = record.named("shot", "type") == "Penalty"
        if outcome == "Goal":
            team_index(team, teams, record.location, "goal's team", needed=True)
            yield "goal", team, player, "pen" if penalty else ""
        else:
            yield "near_miss", team, player, ("penalty " if penalty else "") + _NEAR_MISSES[outcome]
    elif record.number in own_goals:
        if record.kind == "Own Goal Against":  # the other team scores
            team = next((other for other in teams if other != team), "")
        team_index(team, teams, record.location, "goal's team", needed=True)
        yield "own_goal", team, own_goals[record.number], ""
    elif record.kind in _CARD_SECTIONS:
        if record.kind == "Foul Committed":
            yield "foul", team, player, ""
        card = record.named(_CARD_SECTIONS[record.kind], "card")
        if card is not None:
            if card not in _CARDS:
                raise record.error(
                    f"{_CARD_SECTIONS[record.kind]}.card.name is {quoted(card)}; must be one of "
                    f"{', '.join(_CARDS)}"
                )
            yield _CARDS[card], team, player, "second yellow" if card == "Second Yellow" else ""


def _own_goals(played: Sequence[Record], notes: list[str]) -> dict[int, str]:
    """Return the scorer of each own goal, by the number of its record."""
    against = [record for record in played if record.kind == "Own Goal Against"]
    if len(against) > MAX_OWN_GOALS:
        raise InputError(
            f"the file has {len(against)} own goals; one match must have at most {MAX_OWN_GOALS}"
        )
    scorers: dict[int, str] = {}
    for record in played:
        if record.kind == "Own Goal For":
            partner = _partner(record, against)
            if partner is not None:
                against.remove(partner)
            scorers[record.number] = short_name(partner.player) if partner else ""
    for record in against:
        notes.append(
            f"{record.location} is an 'Own Goal Against' without an 'Own Goal For': the goal "
            "counts for the other team"
        )
        scorers[record.number] = short_name(record.player)
    return scorers


def _is_near(record: Record, outcome: str, on_line: frozenset[int]) -> bool:
    """Return whether a shot is a near miss, by the rules in the module docstring."""
    if outcome == "Blocked":
        return record.number in on_line
    if _NEAR_MISSES[outcome] != "missed":
        return True
    xg = record.section("shot").get("statsbomb_xg")
    if xg is None:
        return False
    with validation.prefix_errors(f"{record.location}: "):
        chance = validation.number(xg, "shot.statsbomb_xg", "must be a probability, 0 to 1")
    return chance >= GOOD_CHANCE_XG


def _blocked_on_line(records: list[Record]) -> frozenset[int]:
    """Return the numbers of the shots that are related to a Block with `save_block`."""
    blocks = [
        record
        for record in records
        if record.kind == "Block" and record.section("block").get("save_block") is True
    ]
    block_ids = {block.id for block in blocks if block.id}
    related_ids = frozenset(id_ for block in blocks for id_ in block.related)
    return frozenset(
        record.number
        for record in records
        if record.kind == "Shot" and (record.id in related_ids or record.related & block_ids)
    )


def _partner(own_goal_for: Record, against: list[Record]) -> Record | None:
    """Return the `Own Goal Against` of an `Own Goal For`: the related or the nearest one."""
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


@dataclass(frozen=True)
class Record:
    """Event in a StatsBomb file.

    `number`: number in the file, from 1 (StatsBomb's `index`).
    `raw`: JSON object.
    `id`, `kind`, `team`, `player`: `id`, `type.name`, `team.name` and `player.name`; "" if missing
    (`kind` is required).
    `period`: period, 1 to 5.
    `clock_us`: time since the start of the period, in whole microseconds, so that sums are exact.
    """

    number: int
    raw: dict[str, object]
    id: str
    kind: str
    team: str
    player: str
    period: int
    clock_us: int

    @classmethod
    def parse(cls, value: object, number: int) -> Record:
        """Return the record of a JSON object; the InputError contains its number."""
        raw = validation.of_type(value, dict, f"event {number}:", "an object {...}")
        id_, period, kind = raw.get("id"), raw.get("period"), _name(raw, "type")
        team, player = _name(raw, "team") or "", _name(raw, "player") or ""
        id_ = id_ if isinstance(id_, str) else ""
        record = cls(number, raw, id_, kind or "", team, player, 0, 0)
        if type(period) is not int or not 1 <= period <= SHOOT_OUT:
            raise record.error(f"period is {quoted(period)}; must be 1 to {SHOOT_OUT}")
        if kind is None:
            raise record.error("type.name is missing; must be the event type, such as 'Shot'")
        written = raw.get("timestamp")
        clock = _CLOCK.fullmatch(written) if isinstance(written, str) else None
        if clock is None:
            raise record.error(
                f"timestamp is {quoted(written)}; must be the time in the period, hh:mm:ss.sss"
            )
        seconds = int(clock[1]) * 3600 + int(clock[2]) * 60 + int(clock[3])
        clock_us = seconds * 1_000_000 + int((clock[4] or "").ljust(6, "0"))
        return replace(record, period=period, clock_us=clock_us)

    @property
    def location(self) -> str:
        """Position in the file, for error messages and notes."""
        id_ = f" (id {quoted(self.id)[1:-1]})" if self.id else ""
        return f"event {self.number}{id_}"

    def error(self, problem: str) -> InputError:
        """Return an InputError with the location of this record."""
        return InputError(f"{self.location}: {problem}")

    def section(self, key: str) -> dict[str, object]:
        """Return an object in the record, empty if it is missing; InputError for other types."""
        value = self.raw.get(key)
        if value is None:
            return {}
        if not isinstance(value, dict):
            raise self.error(f"{key} is {quoted(value)}; must be an object {{...}}")
        return value

    def named(self, section: str, key: str) -> str | None:
        """Return `section.key.name`; None if the section has no such key.

        InputError: the section has the key, but no name in it.
        """
        part = self.section(section)
        if part.get(key) is None:
            return None
        name = _name(part, key)
        if name is None:
            raise self.error(f"{section}.{key} is {quoted(part[key])}; must have a name")
        return name

    @property
    def related(self) -> frozenset[str]:
        """Ids of related events; empty if the value is not a list of texts."""
        value = self.raw.get("related_events")
        if not isinstance(value, list):
            return frozenset()
        return frozenset(entry for entry in value if isinstance(entry, str))


def _name(table: dict[str, object], key: str) -> str | None:
    part = table.get(key)
    name = part.get("name") if isinstance(part, dict) else None
    return name if isinstance(name, str) and name.strip() else None
