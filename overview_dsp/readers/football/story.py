"""What happened in a match, from any vendor, into a Timeline: scores counted, labels written.

Labels read as those of the StatsBomb reader: `1-0 Parris (pen)`, `0-1 own goal, Mann`,
`Friis (Sudbury), saved`; a source of minutes instead of times adds them (`2-1 Oscar 90+1'`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.analysis.crowd_excitement import derive_intensity
from overview_dsp.errors import InputError, shown
from overview_dsp.timeline.model import Event, Timeline

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
