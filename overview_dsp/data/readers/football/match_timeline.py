"""Timeline of a football match from the events of any provider, with running score and labels.

Labels have these forms: `1-0 Parris (pen)`, `0-1 own goal, Mann`, `Friis (Sudbury), saved`. Sources
with minutes instead of exact times add the minute (`2-1 Oscar 90+1'`).
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.timeline.event import GOALS, Event
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import plain_letters
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.toml import load_toml

ACTIONS: dict[str, dict[str, Any]] = load_toml(__file__, "actions.toml")
"""Events in the words of services, by service."""

SHOOT_OUT = 5
"""Number of the period of a shoot-out. 1 and 2 are the halves, 3 and 4 those of extra time."""

START_LABELS = {1: "kick-off", 2: "half-time", 3: "extra time", 4: "extra-time half-time"}

MAX_PERIOD_S = 7200.0
"""Maximum time in a period, s."""

SHOT_WEIGHT = 1.5
"""Weight of a shot; other ball touches have 1. Where both are too close, the shot is shown."""

_RECORDS_CHECKED = 50

TOUCH = "touch"
"""Kind of a touch of the ball; the detail is the action (`shot`, `pass`). Shown in windows only."""


@dataclass(frozen=True)
class MatchEvent:
    """Event of a match.

    `time_s`: time from the start of the timeline, s.
    `kind`: event kind.
    `team`: index of the team, 0 or 1; the team that scores for a goal or own goal. None: unknown.
    `player`: short name of the player.
    `detail`: addition to the label, such as `pen`, `saved` or `second yellow`.
    `minute`: minute as written in the source; "" if the time is exact.
    `location`: position of the record in the file, for notes and error messages.
    """

    time_s: float
    kind: str
    team: int | None = None
    player: str = ""
    detail: str = ""
    minute: str = ""
    location: str = ""

    def label(self, score: str, teams: Sequence[str]) -> str:
        """Return the label; `score` is the running score after a goal, "" if it is unknown."""
        player, detail = self.player, self.detail
        if self.kind == "own_goal":
            label = ", ".join(filter(None, (f"{score} own goal".lstrip(), player)))
        elif self.kind == "goal":
            label = f"{score} {player}".strip()
            label = f"{label} ({detail})".lstrip() if detail else label
        else:
            team = teams[self.team] if self.team is not None and self.team < len(teams) else ""
            label = f"{player} ({team})" if player and team else player or team
            label = ", ".join(filter(None, (label, detail)))
        return f"{label} {self.minute}".strip()


def contains_record(entries: Iterable[object], *keys: str) -> bool:
    """Return whether one of the first entries of a JSON list is an object with these keys."""
    first = itertools.islice(entries, _RECORDS_CHECKED)
    return any(isinstance(entry, dict) and entry.keys() >= {*keys} for entry in first)


def concatenate_periods(lengths: Mapping[int, Any]) -> tuple[dict[int, Any], Any]:
    """Return the start of each period and the end of the last one, in the unit of `lengths`.

    InputError: the total length is 0.
    """
    begins, end = {}, 0
    for period in sorted(lengths):
        begins[period] = end
        end += lengths[period]
    if end <= 0:
        raise InputError("the periods of play have no duration; the file may be incomplete")
    return begins, end


def match_timeline(
    teams: Sequence[str],
    begins_s: Mapping[int, float],
    end_s: float,
    match_events: Collection[MatchEvent],
    provenance: str,
    notes: Sequence[str] = (),
    *,
    default_title: str = "",
    title_parts: Sequence[str] = (),
    final: tuple[int, int] | None = None,
    end_label: str = "",
    known_until_s: float | None = None,
) -> Timeline:
    """Return the timeline of a match: count the score, write the labels, derive the curve.

    `teams`: names, the home team first; fewer than two if they are unknown.
    `begins_s`, `end_s`: start of each period (1 to 4) and end of the match, s.
    `match_events`: events in any order. Those of kind `TOUCH` become the details of the timeline.
    `provenance`: origin of the events.
    `notes`: notes of the reader.
    `default_title`: title if the teams are unknown.
    `title_parts`: additions to the title, such as competition, round and date.
    `final`: final score in the source, without a shoot-out. A note reports a different count of
    goals.
    `end_label`: label of the end. "": "full time", or "end" for a single period.
    `known_until_s`: time until which a match in progress is known, s. None: the match is over.
    """
    known, uncounted = len(teams) >= 2, 0
    score, all_notes = [0, 0], list(notes)
    events = [Event(begin_s, "period", START_LABELS[p]) for p, begin_s in begins_s.items()]
    end_label = end_label or ("full time" if len(begins_s) > 1 else "end")
    events.append(Event(end_s, "period", end_label))
    reach_s = end_s if known_until_s is None else known_until_s
    if known_until_s is not None:
        events = [event for event in events if event.time_s < max(reach_s, 1.0)]
    shown = [one for one in match_events if one.kind != TOUCH]
    seen: dict[tuple[float, str, str], int] = {}
    for one in sorted(shown, key=lambda one: one.time_s):
        if one.kind in GOALS:
            if one.team is None:
                uncounted += 1
            else:
                score[one.team] += 1
        label = one.label(f"{score[0]}-{score[1]}" if known and not uncounted else "", teams)
        key = (one.time_s, one.kind, label)
        seen[key] = seen.get(key, 0) + 1
        if seen[key] > 1:  # equal rows without a name are different events
            label = f"{label} ({seen[key]})".strip()
        with validation.prefix_errors(f"{one.location}: " if one.location else ""):
            side = 0 if one.team is None or one.team > 1 else one.team + 1
            events.append(Event(one.time_s, one.kind, label, side=side))
    counted = None if uncounted else (score[0], score[1])
    if len(teams) == 1 and any(one.kind in GOALS for one in shown):
        all_notes.append(f"only the team {quoted(teams[0])} is named: the score is not counted")
    elif counted is None and known:
        some = "1 goal has" if uncounted == 1 else f"{uncounted} goals have"
        all_notes.append(f"{some} no team: the score is not counted")
    elif final is not None and counted is not None and final != counted:
        all_notes.append(
            f"the file has the final score {final[0]}-{final[1]}, but its goals add up to "
            f"{counted[0]}-{counted[1]}; the final score is used"
        )
    intensity, derived, derived_notes = derive_intensity(events, reach_s)
    title, shown_score = default_title, final or counted
    sides = tuple(teams[:2]) if known and all(teams[:2]) else ()
    if sides:
        result = f"{shown_score[0]}-{shown_score[1]}" if shown_score is not None else "-"
        title = ", ".join([f"{teams[0]} {result} {teams[1]}", *filter(None, title_parts)])
    details: dict[Event, None] = {}
    for one in match_events:
        if one.kind == TOUCH:
            kind, weight = ("shot", SHOT_WEIGHT) if one.detail == "shot" else (TOUCH, 1.0)
            details[Event(one.time_s, kind, f"{one.detail} {one.player}".rstrip(), weight)] = None
    return Timeline(
        title=title,
        duration_s=end_s,
        events=tuple(events),
        intensity=intensity,
        provenance="; ".join(filter(None, (provenance, derived))),
        notes=(*all_notes, *derived_notes),
        details=tuple(details),
        known_until_s=known_until_s,
        sides=sides,
    )


_COUNTED = re.compile(r"^\d+-\d+ | ?\d+(?:\+\d+)?'$| \(\d+\)$")


def label_without_counts(label: str) -> str:
    """Return a label without score, minute and number, which corrections of a match change."""
    return _COUNTED.sub("", label)


def shoot_out_note(kicks: Sequence[tuple[str, bool]], names: Mapping[str, str]) -> str:
    """Return the end of a note about a shoot-out; `kicks` are teams and whether they scored."""
    scored = [team for team, is_goal in kicks if is_goal]
    tally = ", ".join(f"{name} {scored.count(team)}" for team, name in names.items())
    return f"is omitted: {len(kicks)} kicks; scored: {tally}"


def team_index(
    name: str, teams: Sequence[str], location: str, role: str = "team", *, needed: bool = False
) -> int | None:
    """Return the index of a team; None for an empty name, InputError for an unknown one."""
    if not name and not needed:
        return None
    if name not in teams:
        raise InputError(
            f"{location}: the {role} is {quoted(name)}; must be one of the match's teams, "
            f"{' and '.join(quoted(team) for team in teams) or 'which have no names'}"
        )
    return list(teams).index(name)


_PARTICLES = frozenset(
    {"al", "bin", "da", "das", "de", "del", "della", "den", "der", "di", "do", "dos", "du", "el"}
    | {"la", "le", "st.", "ten", "ter", "van", "von"}
)


def short_name(full_name: str) -> str:
    """Return the family name of a player for labels, with its particles (`van Lunteren`).

    Of two names this is the second. Of three or more these are the last two, because full Spanish
    and Portuguese names end with two family names (`Messi Cuccittini`).
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
    is_family = len(names) == 2 and names[0].lower() in _PARTICLES  # a family name alone
    return " ".join(names[-2:] if len(names) > 2 or is_family else names[-1:])


_MAX_MATCHES_SHOWN = 4
_NOT_WORD = re.compile(r"[\W_]+")


def normalize_text(text: str) -> str:
    """Return text for comparison: lower case, no accents, words separated by one space."""
    return _NOT_WORD.sub(" ", plain_letters(text)).strip()


def select_match(lines: Sequence[str], match: str | None, ids: Sequence[str] = ()) -> int:
    """Return the index (from 0) of the match that the user selects.

    `lines`: description of each match: date, teams, score.
    `match`: number of the match (from 1), its id, or words of its description in any order. It may
    be None for a file of one match.
    `ids`: id of each match, if the provider has ids.

    InputError: the match is missing, unknown or ambiguous. The message contains the number of
    matches and the command that lists them.
    """
    listing = "'overview timeline show' lists them"
    if not lines:
        raise InputError("the file has no match; it may be incomplete")
    if match is None:
        if len(lines) == 1:
            return 0
        raise InputError(
            f"the file has {len(lines)} matches; select one with match (--select): its number, 1 "
            f"to {len(lines)}, or words such as {_example(lines[-1])}; {listing}"
        )
    words = normalize_text(match).split()
    if len(words) == 1 and words[0].isascii() and words[0].isdigit():
        if words[0] in ids:
            return list(ids).index(words[0])
        number = int(words[0][:18])
        if 1 <= number <= len(lines):
            return number - 1
        if number < 1000:  # a larger number may be a year
            raise InputError(f"match is {number}; must be 1 to {len(lines)}")
    if not words:
        raise InputError(f"match is {quoted(match)}; must be a number, 1 to {len(lines)}, or words")
    texts = [normalize_text(line) for line in lines]
    # complete words; if there are none, parts of words
    found = [i for i, text in enumerate(texts) if set(words) <= set(text.split())] or [
        i for i, text in enumerate(texts) if all(word in text for word in words)
    ]
    if not found:
        raise InputError(
            f"none of the {len(lines)} matches has {quoted(match)}; select a number, 1 to "
            f"{len(lines)}, or words such as {_example(lines[-1])}; {listing}"
        )
    if len(found) > 1:
        first = [f"{i + 1}: {' '.join(lines[i].split())}" for i in found[:_MAX_MATCHES_SHOWN]]
        if len(found) > len(first):
            first.append(f"and {len(found) - len(first)} more")
        raise InputError(
            f"{len(found)} matches have {quoted(match)} ({'; '.join(first)}); add words, or select "
            "a number"
        )
    return found[0]


def _example(line: str) -> str:
    """Return an example of words that select the match with this description."""
    words = [word for word in normalize_text(line).split() if not word.isdigit()]
    return f"'{' '.join(words[:2])}'" if words else "the date"
