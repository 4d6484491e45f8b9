"""What happened in a match, from any vendor, into a Timeline: scores counted, labels written.

Labels read as those of the StatsBomb reader: `1-0 Parris (pen)`, `0-1 own goal, Mann`,
`Friis (Sudbury), saved`; a source of minutes instead of times adds them (`2-1 Oscar 90+1'`).
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

GOALS = frozenset({"goal", "own_goal"})
"""The kinds that change the score."""


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


@dataclass(frozen=True)
class MatchEvents:
    """A match as its source lists it, ready to be counted.

    Parameters
    ----------
    teams
        Names, the home team first; fewer than two where they aren't known.
    happenings
        In any order.
    periods
        (time_s, label) of every start and end of a period.
    duration_s
        Length of the timeline, s.
    """

    teams: Sequence[str]
    happenings: Iterable[Happening]
    periods: Sequence[tuple[float, str]]
    duration_s: float

    def timeline(
        self,
        provenance: str,
        notes: Sequence[str] = (),
        *,
        default_title: str = "",
        about: Sequence[str] = (),
        final: tuple[int, int] | None = None,
        details: Sequence[Event] = (),
    ) -> Timeline:
        """Count the score, write the labels and derive the curve.

        Parameters
        ----------
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
        details
            What is felt when zoomed (`touches`).
        """
        score = [0, 0]
        known = len(self.teams) == 2
        said = list(notes)
        events = [Event(time_s, "period", label) for time_s, label in self.periods]
        seen: dict[tuple[float, str, str], int] = {}
        uncounted = 0
        for happening in sorted(self.happenings, key=lambda happening: happening.time_s):
            if happening.kind in GOALS:
                if happening.team is None:
                    uncounted += 1
                else:
                    score[happening.team] += 1
            label = self._label(happening, score if known and not uncounted else None)
            key = (happening.time_s, happening.kind, label)
            seen[key] = seen.get(key, 0) + 1
            if seen[key] > 1:  # two rows of one minute without a name are two events
                label = f"{label} ({seen[key]})".strip()
            with validation.located(f"{happening.place}: " if happening.place else ""):
                events.append(Event(happening.time_s, happening.kind, label))
        if uncounted:
            said.append(f"{uncounted} goals name no team of the match: the score isn't counted")
        counted = (score[0], score[1])
        if final is not None and final != counted and not uncounted:
            said.append(
                f"the file states {final[0]}-{final[1]} and lists goals for "
                f"{counted[0]}-{counted[1]}; the title has what it states"
            )
        intensity, derived, derived_notes = derive_intensity(events, self.duration_s)
        title = default_title
        if known:
            decided = final if final is not None else counted if not uncounted else None
            result = f"{decided[0]}-{decided[1]}" if decided is not None else "-"
            title = ", ".join([f"{self.teams[0]} {result} {self.teams[1]}", *filter(None, about)])
        return Timeline(
            title=title,
            duration_s=self.duration_s,
            events=tuple(events),
            intensity=intensity,
            provenance="; ".join(part for part in (provenance, derived) if part),
            notes=(*said, *derived_notes),
            details=tuple(details),
        )

    def _label(self, happening: Happening, score: Sequence[int] | None) -> str:
        who, detail = happening.who, happening.detail
        if happening.kind in GOALS:
            label = f"{score[0]}-{score[1]}" if score is not None else ""
            if happening.kind == "own_goal":
                label = f"{label} own goal".lstrip()
                label = f"{label}, {who}" if who else label
            else:
                label = f"{label} {who}".strip()
                label = f"{label} ({detail})".lstrip() if detail else label
        else:
            known = happening.team is not None and happening.team < len(self.teams)
            team = self.teams[happening.team or 0] if known else ""
            label = f"{who} ({team})" if who and team else who or team
            label = ", ".join(part for part in (label, detail) if part)
        return f"{label} {happening.minute}".strip()


def team_index(name: str, teams: Sequence[str], place: str) -> int | None:
    """Return which of the two teams a name means, None for no name; InputError for another."""
    if not name:
        return None
    if name not in teams:
        raise InputError(
            f"{place}: the team is {shown(name)}; the match's teams are "
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


SHOT_WEIGHT = 1.5
"""Against 1 of a touch: of two too close to be distinguished, the shot is shown."""


def touches(records: Iterable[tuple[float, str, str]]) -> tuple[Event, ...]:
    """Return the details of a match from (time_s, what, who): what is `shot`, `pass`, `duel` ..."""
    found: dict[tuple[float, str, str], Event] = {}
    for time_s, what, who in records:
        kind = "shot" if what == "shot" else "touch"
        event = Event(
            time_s, kind, f"{what} {who}".rstrip(), SHOT_WEIGHT if kind == "shot" else 1.0
        )
        found.setdefault((time_s, kind, event.label), event)
    return tuple(found.values())


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
    found = _having(lines, words)
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


def _having(lines: Sequence[str], words: Sequence[str]) -> list[int]:
    """Return which lines have all words; whole words first, parts of words if there is none."""
    texts = [plain(line) for line in lines]
    whole = [i for i, text in enumerate(texts) if set(words) <= set(text.split())]
    return whole or [i for i, text in enumerate(texts) if all(word in text for word in words)]


def _example(line: str) -> str:
    """Return words of a line that a person could type: its longest ones."""
    words = [word for word in plain(line).split() if not word.isdigit()]
    return f"'{' '.join(words[:2])}'" if words else "the date"
