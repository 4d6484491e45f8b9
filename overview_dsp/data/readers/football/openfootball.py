"""openfootball: a competition's matches with their goals, as JSON or as plain text.

JSON (football.json, worldcup.json)::

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

Plain text (Football.TXT)::

    = World Cup 2022        # in Qatar

    ▪ Final
    Sun Dec 18
       18:00     Argentina    4-2 pen. 3-3 a.e.t. (2-2, 2-0)   France   @ Lusail Iconic Stadium
                   (Lionel Messi 23'(pen.), 108' Ángel Di María 36';
                    Kylian Mbappé 80' (pen.), 81', 118' (pen.))

    (64) Sun Jul/15  18:00   France     4-2 (2-1)   Croatia     @ Luzhniki Stadium, Moscow (UTC+3)
                   [Mandžukić 18' (o.g.) Griezmann 38' (pen.); Perišić 28']

Scores may stand after both teams too (`France v Croatia 4-2 (2-1)`), dates in a line of their own.
It becomes what is read from JSON; goals of one team only are those of the team that has scored. A
file of scores alone is known for what it is, and refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football.match import (
    Happening,
    choose,
    has_entry,
    match_timeline,
    short_name,
)
from overview_dsp.data.readers.football.minutes import Clock, Minute, check_minute, parse_minute
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
_LONGEST = 400
_SCORE = (
    r"(?:(?P<pen>\d{1,2}-\d{1,2})\s*pen\.?,?\s+)?(?P<score>\d{1,2}-\d{1,2})(?P<aet>\s*a\.?e\.?t\.?)?"
    r"(?:\s*\((?P<before>[\d\s,-]*)\))?(?:,?\s*(?P<pens>\d{1,2}-\d{1,2})\s*pen\.?)?"
)
_PLACE = r"(?:\s+@.*|\s{2,}\(.*)?"
_MATCHES = (
    re.compile(rf"(?P<one>\S.*?)\s+{_SCORE}\s+(?P<two>[^\W\d].*?|\d+\..*?){_PLACE}"),
    re.compile(rf"(?P<one>\S.*?)\s+v\.?\s+(?P<two>\S.*?)\s+{_SCORE}{_PLACE}"),
)
_NUMBER = re.compile(r"\(\d{1,4}\)\s*")
_MONTH = r"(?:Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)[a-z]*"
_DATE = re.compile(
    rf"\[?((?:(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*\.?,?\s+)?"
    rf"(?:{_MONTH}[ /]\d{{1,2}}|\d{{1,2}}[ .]+{_MONTH})(?:,?[ /]\d{{4}})?)\]?(?:\s+|$)"
)
_CLOCK = re.compile(r"\d{1,2}[:.]\d{2}(?:\s+UTC[+-]\d{1,2})?\s+")
_NO_ROUND = re.compile(r"\||@|\s-\s")  # a list of rounds, a match to come
_NO_TEAM = re.compile(r"[:;,=|/\t]")
_GOAL = re.compile(
    r"(\d{1,3})\s*['’]?(?:\s*\+\s*(\d{1,2}))?\s*['’](?:\s*\(\s*(o\.?\s?g\.?|p(?:en)?\.?)\s*\))?"
)

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
        return _text(value if isinstance(value, dict) else {"name": value}, "name").strip()

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
        if any(type(n) is not int or not 0 <= n < 1000 for n in pair):
            return None
        return pair[0], pair[1]

    @property
    def date(self) -> str:
        return _text(self.raw, "date").strip()

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


def sniff(source: DataFile) -> bool:
    """Return whether the file is JSON whose `matches` (or `rounds`) name team1 and team2."""
    if not source.looks_like_json or '"team1"' not in source.text:
        return False
    document = source.json
    return isinstance(document, dict) and has_entry(
        (raw for raw, _, _ in _listed(document)), "team1", "team2"
    )


def sniff_text(source: DataFile) -> bool:
    """Return whether the file is text of matches with goals in minutes, or of scores alone."""
    if source.head_text is None or source.looks_like_json:
        return False
    document = document_of(source.head_text)
    return _has_goals(document) or _is_a_list_of_scores(source.head_text, document)


def matches(source: DataFile) -> list[str]:
    """Return a line on each match of the file."""
    document = _document(source)
    with validation.located(f"{source.where}: "):
        return [match.line for match in _matches(document)]


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`).

    Raises
    ------
    InputError
        Names the file, the match and the goal; a text of scores alone.
    """
    document = _document(source)
    with validation.located(f"{source.where}: "):
        return decode(document, options.match, source.stem)


def _document(source: DataFile) -> object:
    """Return the file as its JSON has it; errors name the file."""
    if source.looks_like_json:
        return source.json
    document = document_of(source.text)
    if not _has_goals(document) and any(sum(_final(match)) for match in document["matches"]):
        raise InputError(
            f"{source.where}: openfootball's text with the scores of matches, but no goal in "
            "minutes",
            "write the goals below their match, as in (Berg 7', 45+2' Lund 60'(pen.); Firefly "
            "88'); a list of minutes (minute,type,player,team) is read too",
        )
    return document


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
    competition = _text(document, "name") if isinstance(document, dict) else ""
    with validation.located(f"{chosen.place}: "):
        return _timeline(chosen, competition, default_title)


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
            short_name(_text(entry, "name")),
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
    given, offset = entry.get("minute"), entry.get("offset")
    if isinstance(given, str):
        minute = parse_minute(given, f"{place}.minute")
    elif type(given) is not int:
        raise InputError(
            f"{place}.minute is {shown(given)}; minutes are whole numbers, such as 38 or 90"
        )
    else:
        minute = Minute(given)
    if offset is not None and offset != 0:
        if isinstance(offset, str) and offset.strip().isascii() and offset.strip().isdigit():
            offset = int(offset.strip()[:18])
        if type(offset) is not int:
            raise InputError(f"{place}.offset is {shown(offset)}, not a number of minutes")
        minute = Minute(minute.base, offset)
    check_minute(minute.base, minute.added, place)
    return minute


def _matches(document: object) -> list[_Match]:
    if not isinstance(document, dict):
        raise InputError(f"the document is {shown(document)}, not an object {{...}}")
    found = []
    for raw, round_name, place in _listed(document):
        if not isinstance(raw, dict):
            raise InputError(f"{place} is {shown(raw)}, not an object {{...}}")
        found.append(_Match(raw, _text(raw, "round", round_name), place))
    return found


def _listed(document: dict[str, object]) -> Iterator[tuple[object, str, str]]:
    """Yield (match, name of its round, place) of all matches."""
    groups: list[tuple[object, str, str]] = [(document.get("matches"), "", "matches")]
    rounds = document.get("rounds")
    for i, entry in enumerate(rounds if isinstance(rounds, list) else []):
        if isinstance(entry, dict):
            groups.append((entry.get("matches"), _text(entry, "name"), f"rounds[{i}].matches"))
    for group, name, place in groups:
        for j, raw in enumerate(group if isinstance(group, list) else []):
            yield raw, name, f"{place}[{j}]"


def _text(table: dict[str, object], key: str, default: str = "") -> str:
    value = table.get(key)
    return value if isinstance(value, str) else default


# --- plain text


def _has_goals(document: dict[str, Any]) -> bool:
    return any(match["goals1"] or match["goals2"] for match in document["matches"])


def _is_a_list_of_scores(text: str, document: dict[str, Any]) -> bool:
    """Distinguish matches under a heading or a date from other lines that hold figures."""
    listed = document["matches"]
    if not any(document["name"] or match["date"] for match in listed):
        return False
    teams = [match[key] for match in listed for key in ("team1", "team2")]
    rest = [line for line in _lines(text) if not _is_about(line)]
    return 2 * len(listed) >= len(rest) and not any(_NO_TEAM.search(team) for team in teams)


def _is_about(line: str) -> bool:
    """Return whether a line is a heading, a date alone or in brackets."""
    dated = _DATE.match(line)
    return line[0] in "=▪»([" or (dated is not None and dated.end() == len(line))


def document_of(text: str) -> dict[str, Any]:
    """Return the text as openfootball's JSON has it."""
    title, round_name, date = "", "", ""
    listed: list[dict[str, Any]] = []
    for line in _lines(text):
        if line.startswith("="):
            title = title or line.strip("= ")
            continue
        if line[0] in "([" and not _NUMBER.match(line) and not _DATE.match(line):
            if listed and not listed[-1]["goals1"] and not listed[-1]["goals2"]:
                _add_goals(listed[-1], line[1:-1])
            continue
        rest = _NUMBER.sub("", line, count=1) if _NUMBER.match(line) else line
        dated = _DATE.match(rest)
        if dated is not None:
            date, rest = dated[1], rest[dated.end() :]
        match = _match(_CLOCK.sub("", rest, count=1) if _CLOCK.match(rest) else rest)
        if match is not None:
            listed.append(match | {"round": round_name, "date": date})
        elif rest and dated is None and not _NO_ROUND.search(rest):
            round_name = rest.strip("▪»*:. ")
    return {"name": title, "matches": listed}


def _lines(text: str) -> Iterator[str]:
    """Lines without comments and blanks; what is in brackets over several as one."""
    waiting = ""
    for whole in text.splitlines():
        line = re.sub(r"(^|\s)#.*", "", whole[:_LONGEST]).strip()
        if waiting:
            line = f"{waiting} {line}"
        if not line:
            continue
        goals = line[0] in "([" and not _NUMBER.match(line) and not _DATE.match(line)
        open_, closed = (sum(map(line.count, marks)) for marks in ("([", ")]"))
        # an empty line ends what is never closed
        waiting = line if goals and open_ > closed and whole.strip() and len(line) < 4000 else ""
        if not waiting:
            yield line


def _match(line: str) -> dict[str, Any] | None:
    found = next(filter(None, (pattern.fullmatch(line) for pattern in _MATCHES)), None)
    if found is None:
        return None
    before = [_pair(part) for part in re.findall(r"\d+-\d+", found["before"] or "")]
    score: dict[str, Any] = {"et" if found["aet"] else "ft": _pair(found["score"])}
    score |= dict(zip(("ft", "ht") if found["aet"] else ("ht",), before, strict=False))
    if found["pen"] or found["pens"]:
        score["p"] = _pair(found["pen"] or found["pens"])
    return {
        "team1": found["one"].strip(),
        "team2": found["two"].strip(),
        "score": score,
        "goals1": [],
        "goals2": [],
    }


def _final(match: dict[str, Any]) -> list[int]:
    """Return the score without a shoot-out."""
    final: list[int] = match["score"].get("et") or match["score"]["ft"]
    return final


def _pair(text: str) -> list[int]:
    return [int(number) for number in text.split("-")]


def _add_goals(match: dict[str, Any], text: str) -> None:
    one, semicolon, two = text.partition(";")
    if not semicolon and _final(match)[0] == 0:
        one, two = "", one
    match["goals1"], match["goals2"] = _goals_in(one), _goals_in(two)


def _goals_in(text: str) -> list[dict[str, Any]]:
    goals: list[dict[str, Any]] = []
    name, end = "", 0
    for found in _GOAL.finditer(text):
        name = text[end : found.start()].strip(" ,-") or name  # the same one has scored again
        end = found.end()
        goal: dict[str, Any] = {"name": name, "minute": int(found[1])}
        if found[2]:
            goal["offset"] = int(found[2])
        if found[3]:
            goal["owngoal" if found[3].startswith("o") else "penalty"] = True
        goals.append(goal)
    return goals
