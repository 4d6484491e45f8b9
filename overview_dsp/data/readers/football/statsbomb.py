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

The details, felt when zoomed, are what the players do with the ball (`TOUCHES`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.listing import repeated_ids
from overview_dsp.data.readers.football.match import (
    GOALS,
    SHOOT_OUT,
    Happening,
    Touch,
    has_entry,
    lay_end_to_end,
    match_timeline,
    shoot_out_note,
    short_name,
    team_index,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

GOOD_CHANCE_XG = 0.10
"""Chance (expected goals) from which a shot that misses is a near miss: one in ten goes in."""

OWN_GOAL_PAIR_US = 10_000_000
"""Furthest apart the two records of one own goal may be where neither names the other, us."""

MAX_OWN_GOALS = 1000
"""Most own goals that are paired (the record is 149)."""

PROVENANCE = "events: a StatsBomb open-data event file"

TOUCHES = {
    "Ball Receipt*": "receipt", "Ball Recovery": "recovery", "Goal Keeper": "goalkeeper",
    "50/50": "fifty-fifty", "Pass": "pass", "Carry": "carry", "Pressure": "pressure",
    "Duel": "duel", "Dribble": "dribble", "Dribbled Past": "dribbled past", "Block": "block",
    "Clearance": "clearance", "Interception": "interception", "Miscontrol": "miscontrol",
    "Dispossessed": "dispossessed", "Shield": "shield", "Shot": "shot",
}  # fmt: skip

_NEAR_MISSES = {
    **dict.fromkeys(("Saved", "Saved to Post", "Saved Off Target"), "saved"),
    "Post": "on the post",
    "Blocked": "blocked on the line",
    **dict.fromkeys(("Off T", "Wayward"), "missed"),
}
_OUTCOMES = sorted({*_NEAR_MISSES, "Goal"})
_CARDS = {"Yellow Card": "yellow_card", "Second Yellow": "red_card", "Red Card": "red_card"}
_CARD_PLACES = {"Foul Committed": "foul_committed", "Bad Behaviour": "bad_behaviour"}
_ENDS = {1: "half-time", 2: "full time", 3: "extra-time half-time", 4: "full time"}
_CLOCK = re.compile(r"([0-9]{2}):([0-5][0-9]):([0-5][0-9])(?:\.([0-9]{1,6}))?")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a JSON list with period, timestamp and type in an early entry."""
    if not source.looks_like_json or not isinstance(source.json, list):
        return False
    return has_entry(source.json, "period", "timestamp", "type")


def read(source: DataFile, options: LoadOptions) -> Timeline:
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
    notes: list[str] = []
    lengths = _lengths_us(played, notes)
    begins, end = lay_end_to_end(lengths)
    teams = _teams(records)
    own_goals = _own_goals(played, notes)
    on_line = _blocked_on_line(played)
    happenings: dict[tuple[object, ...], Happening] = {}
    touches: list[Touch] = []
    for record in played:
        found = list(_kinds(record, own_goals, on_line, teams[:2]))
        if found and record.clock_us > lengths[record.period]:
            notes.append(
                f"{record.place} ({record.kind}) is listed after the end of period "
                f"{record.period}: put at its end"
            )
        time_s = (begins[record.period] + min(record.clock_us, lengths[record.period])) / 1e6
        if not found and record.kind in TOUCHES:
            touches.append((time_s, TOUCHES[record.kind], short_name(record.player)))
        for kind, name, who, detail in found:
            team = teams.index(name) if name else None
            one = Happening(time_s, kind, team, who, detail, "", record.place)
            # each goal has its own score
            key = (time_s, kind, team, who, detail, record.position if kind in GOALS else 0)
            first = happenings.setdefault(key, one)
            if first is not one:
                notes.append(f"{one.place} repeats {first.place}: left out")
    if any(record.period == SHOOT_OUT for record in records):
        kicks = [r for r in records if r.period == SHOOT_OUT and r.kind == "Shot"]
        scored = [(r.team, _name(r.section("shot"), "outcome") == "Goal") for r in kicks]
        names = {team: team for team in teams[:2]}
        notes.append(f"the shoot-out (period 5) {shoot_out_note(scored, names)}")
    notes += repeated_ids(record.id for record in records)
    return match_timeline(
        (*teams, *[""] * (2 - len(teams))),  # the score of one team is counted too
        {period: begin / 1e6 for period, begin in begins.items()},
        end / 1e6,
        happenings.values(),
        PROVENANCE,
        notes,
        default_title=default_title,
        touches=touches,
        end_label=_ENDS[max(begins)],
    )


def _lengths_us(played: Sequence[Record], notes: list[str]) -> dict[int, int]:
    """Return how long each period is, us."""
    lengths = {}
    for period in sorted({record.period for record in played}):
        of_it = [record for record in played if record.period == period]
        whistles = [record for record in of_it if record.kind == "Half End"]
        if not whistles:
            notes.append(f"period {period} has no 'Half End': it ends with its last event here")
        lengths[period] = max(record.clock_us for record in whistles or of_it)
    return lengths


def _kinds(
    record: Record, own_goals: dict[int, str], on_line: frozenset[int], teams: Sequence[str]
) -> Iterator[tuple[str, str, str, str]]:
    """Yield (kind, team, who, detail) of what happens in a record."""
    who, team = short_name(record.player), record.team
    if record.kind == "Shot":
        outcome = record.named("shot", "outcome")
        if outcome is None or outcome not in _OUTCOMES:
            raise record.error(
                f"shot.outcome.name is {shown(outcome)}; outcomes are {', '.join(_OUTCOMES)}"
            )
        if outcome != "Goal" and not _is_near(record, outcome, on_line):
            return
        penalty = record.named("shot", "type") == "Penalty"
        if outcome == "Goal":
            team_index(team, teams, record.place, "goal's team", needed=True)
            yield "goal", team, who, "pen" if penalty else ""
        else:
            yield "near_miss", team, who, ("penalty " if penalty else "") + _NEAR_MISSES[outcome]
    elif record.position in own_goals:
        if record.kind == "Own Goal Against":  # alone: its team is the one that suffers
            team = next((other for other in teams if other != team), "")
        team_index(team, teams, record.place, "goal's team", needed=True)
        yield "own_goal", team, own_goals[record.position], ""
    elif record.kind in _CARD_PLACES:
        if record.kind == "Foul Committed":
            yield "foul", team, who, ""
        card = record.named(_CARD_PLACES[record.kind], "card")
        if card is not None:
            if card not in _CARDS:
                raise record.error(
                    f"{_CARD_PLACES[record.kind]}.card.name is {shown(card)}; cards "
                    f"are {', '.join(_CARDS)}"
                )
            yield _CARDS[card], team, who, "second yellow" if card == "Second Yellow" else ""


def _own_goals(played: Sequence[Record], notes: list[str]) -> dict[int, str]:
    """Return who scored each own goal, by the position of the record that stands for it."""
    against = [record for record in played if record.kind == "Own Goal Against"]
    if len(against) > MAX_OWN_GOALS:
        raise InputError(
            f"{len(against)} own goals, more than the {MAX_OWN_GOALS} of any match; is it one?"
        )
    scorers: dict[int, str] = {}
    for record in played:
        if record.kind == "Own Goal For":
            partner = _partner(record, against)
            if partner is not None:
                against.remove(partner)
            scorers[record.position] = short_name(partner.player) if partner else ""
    for record in against:
        notes.append(
            f"{record.place} is an 'Own Goal Against' without its 'Own Goal For': the goal is "
            "given to the other team"
        )
        scorers[record.position] = short_name(record.player)
    return scorers


def _teams(records: Sequence[Record]) -> list[str]:
    """Return all teams, the one of the first Starting XI first (StatsBomb's home team)."""
    elevens = [record.team for record in records if record.kind == "Starting XI"]
    others = [record.team for record in records]
    return list(dict.fromkeys(team for team in (*elevens, *others) if team))


def _is_near(record: Record, outcome: str, on_line: frozenset[int]) -> bool:
    """Return whether a shot nearly went in (rule: module docstring)."""
    if outcome == "Blocked":
        return record.position in on_line
    if _NEAR_MISSES[outcome] != "missed":
        return True
    xg = record.section("shot").get("statsbomb_xg")
    if xg is None:  # no estimate, no good chance
        return False
    with validation.located(f"{record.place}: "):
        chance = validation.number(xg, "shot.statsbomb_xg", "it is a probability")
    return chance >= GOOD_CHANCE_XG


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
        id_, period, kind = raw.get("id"), raw.get("period"), _name(raw, "type")
        team, player = _name(raw, "team") or "", _name(raw, "player") or ""
        id_ = id_ if isinstance(id_, str) else ""
        record = cls(position, raw, id_, kind or "", team, player, 0, 0)
        if type(period) is not int or not 1 <= period <= SHOOT_OUT:
            raise record.error(f"period is {shown(period)}; periods are 1 to {SHOOT_OUT}")
        if kind is None:
            raise record.error("type.name is missing; it says what the event is, such as 'Shot'")
        written = raw.get("timestamp")
        found = _CLOCK.fullmatch(written) if isinstance(written, str) else None
        if found is None:
            raise record.error(
                f"timestamp is {shown(written)}; it is the time in the period, hh:mm:ss.sss"
            )
        seconds = int(found[1]) * 3600 + int(found[2]) * 60 + int(found[3])
        clock_us = seconds * 1_000_000 + int((found[4] or "").ljust(6, "0"))
        return replace(record, period=period, clock_us=clock_us)

    @property
    def place(self) -> str:
        """How an error line or a note names this record."""
        named = f" (id {shown(self.id)[1:-1]})" if self.id else ""
        return f"event {self.position}{named}"

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


def _name(table: dict[str, object], key: str) -> str | None:
    part = table.get(key)
    name = part.get("name") if isinstance(part, dict) else None
    return name if isinstance(name, str) and name.strip() else None
