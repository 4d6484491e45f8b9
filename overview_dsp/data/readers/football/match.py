"""What happened in a match, from any vendor, into a Timeline: scores counted, labels written.

Labels read as those of the StatsBomb reader: `1-0 Parris (pen)`, `0-1 own goal, Mann`,
`Friis (Sudbury), saved`; a source of minutes instead of times adds them (`2-1 Oscar 90+1'`).
"""

from __future__ import annotations

import itertools
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

GOALS = frozenset({"goal", "own_goal"})
"""The kinds that change the score."""

SHOOT_OUT = 5
"""The period of a shoot-out; 1 and 2 are halves, 3 and 4 those of extra time."""

START_LABELS = {1: "kick-off", 2: "half-time", 3: "extra time", 4: "extra-time half-time"}

MAX_PERIOD_S = 7200.0
"""Latest time in a period, s: no half lasts two hours."""

SHOT_WEIGHT = 1.5
"""Against 1 of a touch: of two too close to be distinguished, the shot is shown."""

_SNIFFED = 50

Touch = tuple[float, str, str]
"""Something smaller that is felt when zoomed: time, s, what (`shot`, `pass`, `duel` ...), who."""


@dataclass(frozen=True)
class Happening:
    """One thing that happened in a match.

    Parameters
    ----------
    time_s
        Seconds from the timeline's start.
    kind
        A football kind.
    team
        Index (0, 1) of the team it belongs to; for a goal or own goal the team that gets the
        score. None where it isn't known.
    who
        Short name of the player.
    detail
        What else the label says: `pen`, `saved`, `second yellow`.
    minute
        The minute as the source writes it, "" where the time is exact.
    place
        How a note or an error line names the record.
    """

    time_s: float
    kind: str
    team: int | None = None
    who: str = ""
    detail: str = ""
    minute: str = ""
    place: str = ""

    def label(self, score: str, teams: Sequence[str]) -> str:
        """Return what the event's label says; `score` is that of a goal where it is known."""
        who, detail = self.who, self.detail
        if self.kind == "own_goal":
            words = ", ".join(filter(None, (f"{score} own goal".lstrip(), who)))
        elif self.kind == "goal":
            words = f"{score} {who}".strip()
            words = f"{words} ({detail})".lstrip() if detail else words
        else:
            team = teams[self.team] if self.team is not None and self.team < len(teams) else ""
            words = f"{who} ({team})" if who and team else who or team
            words = ", ".join(filter(None, (words, detail)))
        return f"{words} {self.minute}".strip()


def has_entry(entries: Iterable[object], *keys: str) -> bool:
    """Return whether an early entry of a JSON list is an object with these keys."""
    early = itertools.islice(entries, _SNIFFED)
    return any(isinstance(entry, dict) and entry.keys() >= {*keys} for entry in early)


def lay_end_to_end(lengths: Mapping[int, Any]) -> tuple[dict[int, Any], Any]:
    """Return where each period begins and where the last one ends, in the unit of their lengths.

    Raises
    ------
    InputError
        They have no length.
    """
    begins, end = {}, 0
    for period in sorted(lengths):
        begins[period] = end
        end += lengths[period]
    if end <= 0:
        raise InputError("no time passes in the periods of play; is the file complete?")
    return begins, end


def match_timeline(
    teams: Sequence[str],
    begins_s: Mapping[int, float],
    end_s: float,
    happenings: Iterable[Happening],
    provenance: str,
    notes: Sequence[str] = (),
    *,
    default_title: str = "",
    about: Sequence[str] = (),
    final: tuple[int, int] | None = None,
    touches: Iterable[Touch] = (),
    end_label: str = "",
) -> Timeline:
    """Count the score, write the labels and derive the curve.

    Parameters
    ----------
    teams
        Names, the home team first; fewer than two where they aren't known.
    begins_s, end_s
        Where each period (1 to 4) begins and the match ends, s.
    happenings
        In any order.
    provenance
        Where the events are from.
    notes
        What the reader noticed.
    default_title
        The title if the teams aren't known.
    about
        What the title adds (competition, round, date).
    final
        The score the source states, without a shoot-out; a count that differs is noted.
    touches
        What is felt when zoomed.
    end_label
        What the end of the last period is called; "" is full time, or the end of one period alone.
    """
    known, uncounted = len(teams) >= 2, 0
    score, said = [0, 0], list(notes)
    events = [Event(begin_s, "period", START_LABELS[p]) for p, begin_s in begins_s.items()]
    end_label = end_label or ("full time" if len(begins_s) > 1 else "end")
    events.append(Event(end_s, "period", end_label))
    seen: dict[tuple[float, str, str], int] = {}
    for one in sorted(happenings, key=lambda one: one.time_s):
        if one.kind in GOALS:
            if one.team is None:
                uncounted += 1
            else:
                score[one.team] += 1
        label = one.label(f"{score[0]}-{score[1]}" if known and not uncounted else "", teams)
        key = (one.time_s, one.kind, label)
        seen[key] = seen.get(key, 0) + 1
        if seen[key] > 1:  # two rows of one minute without a name are two events
            label = f"{label} ({seen[key]})".strip()
        with validation.located(f"{one.place}: " if one.place else ""):
            events.append(Event(one.time_s, one.kind, label))
    counted = None if uncounted else (score[0], score[1])
    if counted is None:
        said.append(f"{uncounted} goals name no team of the match: the score isn't counted")
    elif final is not None and final != counted:
        said.append(
            f"the file states {final[0]}-{final[1]} and lists goals for "
            f"{counted[0]}-{counted[1]}; the title has what it states"
        )
    intensity, derived, derived_notes = derive_intensity(events, end_s)
    title, decided = default_title, final or counted
    if known and all(teams[:2]):
        result = f"{decided[0]}-{decided[1]}" if decided is not None else "-"
        title = ", ".join([f"{teams[0]} {result} {teams[1]}", *filter(None, about)])
    details: dict[Event, None] = {}
    for time_s, what, who in touches:
        kind, weight = ("shot", SHOT_WEIGHT) if what == "shot" else ("touch", 1.0)
        details[Event(time_s, kind, f"{what} {who}".rstrip(), weight)] = None
    return Timeline(
        title=title,
        duration_s=end_s,
        events=tuple(events),
        intensity=intensity,
        provenance="; ".join(filter(None, (provenance, derived))),
        notes=(*said, *derived_notes),
        details=tuple(details),
    )


def shoot_out_note(kicks: Sequence[tuple[str, bool]], names: Mapping[str, str]) -> str:
    """Return what is noted of a shoot-out: `kicks` are the team of each and whether it scored."""
    scored = [team for team, is_goal in kicks if is_goal]
    tally = ", ".join(f"{name} {scored.count(team)}" for team, name in names.items())
    return f"is left out: {len(kicks)} kicks; scored: {tally}"


def team_index(
    name: str, teams: Sequence[str], place: str, what: str = "team", *, needed: bool = False
) -> int | None:
    """Return which of the teams a name means, None for no name; InputError for another."""
    if not name and not needed:
        return None
    if name not in teams:
        raise InputError(
            f"{place}: the {what} is {shown(name)}; the match's teams are "
            f"{' and '.join(shown(team) for team in teams) or 'not named'}"
        )
    return list(teams).index(name)


_PARTICLES = frozenset(
    {"al", "bin", "da", "das", "de", "del", "della", "den", "der", "di", "do", "dos", "du", "el"}
    | {"la", "le", "st.", "ten", "ter", "van", "von"}
)


def short_name(full_name: str) -> str:
    """Return what a label calls a player: the family name, with its particles (`van Lunteren`).

    Two names: the second. Three or more: the last two, since full Spanish and Portuguese names
    carry two family names of which the first is the known one (`Messi Cuccittini`).
    """
    names: list[str] = []
    particles: list[str] = []
    for word in full_name.split():
        if names and word.lower() in _PARTICLES:
            particles.append(word)
        else:
            names.append(" ".join([*particles, word]))
            particles = []
    if particles:
        names.append(" ".join(particles))
    return " ".join(names[-2:] if len(names) > 2 else names[-1:])


_SHOWN = 4
_NOT_WORD = re.compile(r"[\W_]+")


def plain(text: str) -> str:
    """Return text for comparing: small letters without accents, words apart by one blank."""
    bare = unicodedata.normalize("NFKD", text.casefold())
    letters = "".join(letter for letter in bare if not unicodedata.combining(letter))
    return _NOT_WORD.sub(" ", letters).strip()


def choose(lines: Sequence[str], match: str | None, ids: Sequence[str] = ()) -> int:
    """Return the position (from 0) of the match that is meant.

    Parameters
    ----------
    lines
        A line on each match: date, teams, score.
    match
        Its number (from 1), its id, or words that only its line has, in any order; None for a
        file of one match.
    ids
        The vendor's number of each match, where there is one.

    Raises
    ------
    InputError
        None of several named, no such match, several fit; the line says how many and how to list
        them.
    """
    listing = "'overview timeline show' lists them"
    if not lines:
        raise InputError("holds no match; is the file complete?")
    if match is None:
        if len(lines) == 1:
            return 0
        raise InputError(
            f"holds {len(lines)} matches; choose one with match (--select): its number, 1 to "
            f"{len(lines)}, or words such as {_example(lines[-1])}; {listing}"
        )
    words = plain(match).split()
    if len(words) == 1 and words[0].isascii() and words[0].isdigit():
        if words[0] in ids:
            return list(ids).index(words[0])
        number = int(words[0][:18])
        if 1 <= number <= len(lines):
            return number - 1
        if number < 1000:  # no year either
            raise InputError(f"there is no match {number}; give a number, 1 to {len(lines)}")
    asked = shown(match)
    if not words:
        raise InputError(f"match is {asked}; give a number, 1 to {len(lines)}, or words")
    texts = [plain(line) for line in lines]
    # whole words first, parts of words if there is none
    found = [i for i, text in enumerate(texts) if set(words) <= set(text.split())] or [
        i for i, text in enumerate(texts) if all(word in text for word in words)
    ]
    if not found:
        raise InputError(
            f"none of the {len(lines)} matches has {asked}; give a number, 1 to {len(lines)}, or "
            f"words such as {_example(lines[-1])}; {listing}"
        )
    if len(found) > 1:
        first = "; ".join(f"{i + 1}: {' '.join(lines[i].split())}" for i in found[:_SHOWN])
        more = f"; and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
        raise InputError(
            f"{len(found)} matches have {asked} ({first}{more}); give more words or its number"
        )
    return found[0]


def _example(line: str) -> str:
    """Return words of a line that a person could type: its longest ones."""
    words = [word for word in plain(line).split() if not word.isdigit()]
    return f"'{' '.join(words[:2])}'" if words else "the date"
