"""openfootball JSON (football.json, worldcup.json): a competition's matches with their goals.

::

    {"name": "World Cup 2018", "matches": [
      {"round": "Final", "date": "2018-07-15", "team1": "France", "team2": "Croatia",
       "score": {"ft": [4, 2], "ht": [2, 1]},
       "goals1": [{"name": "Mandžukić", "minute": 18, "owngoal": true}, ...], "goals2": [...]}]}

Older files group matches under `rounds`, give teams as objects with a name and scores as `score1`,
`score2` (with `et` and `p` behind for extra time and a shoot-out); newer ones write `"90+4"` where
older ones have `"minute": 90, "offset": 4`. All are read.

A goal is placed in the middle of its minute: true to 30 s of the match clock. Goals in `goals1`
count for team 1, own goals too. Halves last as `minutes.py` says. A shoot-out is left out and
noted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.data.readers.football.match import (
    Happening,
    choose,
    match_timeline,
    short_name,
)
from overview_dsp.data.readers.football.minutes import Clock, Minute, check_minute, parse_minute
from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

PROVENANCE = (
    "goals: an openfootball file, each in the middle of its minute (true to 30 s of the match "
    "clock)"
)

STOPPAGE_NOTE = (
    "the file doesn't give the length of stoppage time: a half lasts 45 minutes here, or until its "
    "last goal in stoppage time"
)

_MIDDLE_S = 30.0
_SNIFFED = 50
Pair = tuple[int, int]


@dataclass(frozen=True)
class _Match:
    """A match as listed."""

    raw: dict[str, object]
    round: str
    place: str

    def team(self, number: int) -> str:
        """Return a team's name, "" where missing."""
        value = self.raw.get(f"team{number}")
        if isinstance(value, dict):
            value = value.get("name")
        return value.strip() if isinstance(value, str) else ""

    def score(self, name: str, old: str) -> Pair | None:
        """Return a score: `score[name]`, or `score1<old>` and `score2<old>`; None where missing."""
        score = self.raw.get("score")
        if isinstance(score, dict):
            pair = score.get(name)
        elif isinstance(score, list) and name == "ft":
            pair = score
        else:
            pair = [self.raw.get(f"score{number}{old}") for number in (1, 2)]
        if not isinstance(pair, list) or len(pair) != 2:
            return None
        if any(isinstance(n, bool) or not isinstance(n, int) or not 0 <= n < 1000 for n in pair):
            return None
        return pair[0], pair[1]

    @property
    def date(self) -> str:
        value = self.raw.get("date")
        return value.strip() if isinstance(value, str) else ""

    @property
    def final(self) -> Pair | None:
        """The score without a shoot-out."""
        return self.score("et", "et") or self.score("ft", "")

    @property
    def line(self) -> str:
        """What a list of matches says about it."""
        final = self.final
        result = f"{final[0]}-{final[1]}" if final else "-"
        teams = f"{self.team(1) or '?'} {result} {self.team(2) or '?'}"
        return "  ".join(part for part in (self.date, teams, self.round) if part)


def sniff(source: Source) -> bool:
    """Return whether the file is JSON whose `matches` (or `rounds`) name team1 and team2."""
    if not source.looks_like_json or '"team1"' not in source.text:
        return False
    if not isinstance(source.json, dict):
        return False
    return any(
        isinstance(raw, dict) and {"team1", "team2"} <= raw.keys()
        for raw, _, _ in _listed(source.json, _SNIFFED)
    )


def matches(source: Source) -> list[str]:
    """Return a line on each match of the file."""
    document = source.json
    with validation.located(f"{source.where}: "):
        return lines(document)


def lines(document: object) -> list[str]:
    """Return a line on each match of a parsed file."""
    return [match.line for match in _matches(document)]


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`); InputError names the file, the match and the goal."""
    document = source.json  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        return decode(document, options.match, source.stem)


def decode(document: object, match: str | None = None, default_title: str = "") -> Timeline:
    """Make a Timeline of one match of a parsed file.

    Parameters
    ----------
    document
        The JSON object.
    match
        As `LoadOptions.match`; may be None for a file of one match.
    default_title
        The title if the file names no teams.

    Raises
    ------
    InputError
        No or several such matches; a goal without a minute, or with one no match has.
    """
    listed = _matches(document)
    chosen = listed[choose([entry.line for entry in listed], match)]
    name = document.get("name") if isinstance(document, dict) else None
    with validation.located(f"{chosen.place}: "):
        return _timeline(chosen, name if isinstance(name, str) else "", default_title)


def _timeline(match: _Match, competition: str, default_title: str) -> Timeline:
    goals = [(team, *goal) for team in (0, 1) for goal in _goals(match, team)]
    final = match.final
    if final is None and not goals and match.score("ht", "i") is None:
        raise InputError("has neither a score nor goals: it isn't played yet; choose another")
    extra = match.score("et", "et") is not None
    clock = Clock.laid(
        [minute for _, minute, _, _ in goals],
        # an older file may give a result after extra time as its only one
        extra_time=extra or any(m.added is None and m.base > 90 for _, m, _, _ in goals),
        back_s=_MIDDLE_S,
    )
    happenings = [
        Happening(
            clock.time_s(minute),
            "own_goal" if entry.get("owngoal") is True else "goal",
            team,
            short_name(_name(entry)),
            "pen" if entry.get("penalty") is True else "",
            str(minute),
            place,
        )
        for team, minute, entry, place in goals
    ]
    notes, about = [STOPPAGE_NOTE], [competition, match.round, match.date]
    if not goals and final != (0, 0):
        notes.append("the file lists no goals of this match")
        if final is not None:
            about.insert(0, f"final score {final[0]}-{final[1]}")
        final = None
    shoot_out = match.score("p", "p")
    teams = [match.team(1), match.team(2)]
    if shoot_out is not None:
        notes.append(
            f"the shoot-out is left out: {teams[0]} {shoot_out[0]}, {teams[1]} {shoot_out[1]}"
        )
    return match_timeline(
        teams if all(teams) else [],
        clock.begins_s,
        clock.duration_s,
        happenings,
        PROVENANCE,
        notes,
        default_title=default_title,
        about=about,
        final=final,
    )


def _goals(match: _Match, team: int) -> Iterator[tuple[Minute, dict[str, object], str]]:
    key = f"goals{team + 1}"
    listed = match.raw.get(key)
    if listed is None:
        return
    if not isinstance(listed, list):
        raise InputError(f"{key} is {shown(listed)}, not a list [...]")
    for i, entry in enumerate(listed):
        place = f"{key}[{i}]"
        if not isinstance(entry, dict):
            raise InputError(f"{place} is {shown(entry)}, not an object {{...}}")
        yield _minute(entry, place), entry, place


def _minute(entry: dict[str, object], place: str) -> Minute:
    given = entry.get("minute")
    offset = entry.get("offset")
    if isinstance(given, str):
        minute = parse_minute(given, f"{place}.minute")
    elif isinstance(given, bool) or not isinstance(given, int):
        raise InputError(
            f"{place}.minute is {shown(given)}; minutes are whole numbers, such as 38 or 90"
        )
    else:
        minute = Minute(given)
    if offset is not None and offset != 0:
        if isinstance(offset, str) and offset.strip().isascii() and offset.strip().isdigit():
            offset = int(offset.strip()[:18])
        if isinstance(offset, bool) or not isinstance(offset, int):
            raise InputError(f"{place}.offset is {shown(offset)}, not a number of minutes")
        minute = Minute(minute.base, offset)
    check_minute(minute.base, minute.added, place)
    return minute


def _name(entry: dict[str, object]) -> str:
    name = entry.get("name")
    return name if isinstance(name, str) else ""


def _matches(document: object) -> list[_Match]:
    if not isinstance(document, dict):
        raise InputError(f"the document is {shown(document)}, not an object {{...}}")
    found = []
    for raw, round_name, place in _listed(document):
        if not isinstance(raw, dict):
            raise InputError(f"{place} is {shown(raw)}, not an object {{...}}")
        own = raw.get("round")
        found.append(_Match(raw, own if isinstance(own, str) else round_name, place))
    return found


def _listed(document: dict[str, object], limit: int | None = None) -> list[tuple[object, str, str]]:
    """Return (match, name of its round, place) of all matches, or the first few."""
    found: list[tuple[object, str, str]] = []
    groups: list[tuple[object, str, str]] = [(document.get("matches"), "", "matches")]
    rounds = document.get("rounds")
    for i, entry in enumerate(rounds if isinstance(rounds, list) else []):
        if isinstance(entry, dict):
            name = entry.get("name")
            place = f"rounds[{i}].matches"
            groups.append((entry.get("matches"), name if isinstance(name, str) else "", place))
    for group, name, place in groups:
        for j, raw in enumerate(group if isinstance(group, list) else []):
            found.append((raw, name, f"{place}[{j}]"))
            if len(found) == limit:
                return found
    return found
