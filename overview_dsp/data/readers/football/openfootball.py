"""Reader of openfootball: the matches of a competition with their goals, as JSON or plain text.

JSON (football.json, worldcup.json)::

    {"name": "World Cup 2018", "matches": [
      {"round": "Final", "date": "2018-07-15", "team1": "France", "team2": "Croatia",
       "score": {"ft": [4, 2], "ht": [2, 1]},
       "goals1": [{"name": "Mandžukić", "minute": 18, "owngoal": true}, ...], "goals2": [...]}]}

Older files, which are read too, group matches under `rounds` and have objects as teams. Their
scores are `score1` and `score2`, with the suffixes `et` and `p` for extra time and a shoot-out.
Their `"minute": 90, "offset": 4` is `"90+4"` in newer files.

A goal is in the middle of its minute, so the error is at most 30 s of the match clock. Goals and
own goals in `goals1` count for team 1. `minutes.py` determines the length of the halves. A
shoot-out is omitted, and a note is shown.

Plain text (Football.TXT)::

    = World Cup 2022        # in Qatar

    ▪ Final
    Sun Dec 18
       18:00     Argentina    4-2 pen. 3-3 a.e.t. (2-2, 2-0)   France   @ Lusail Iconic Stadium
                   (Lionel Messi 23'(pen.), 108' Ángel Di María 36';
                    Kylian Mbappé 80' (pen.), 81', 118' (pen.))

    (64) Sun Jul/15  18:00   France     4-2 (2-1)   Croatia     @ Luzhniki Stadium, Moscow (UTC+3)
                   [Mandžukić 18' (o.g.) Griezmann 38' (pen.); Perišić 28']

Scores may follow both teams, too (`France v Croatia 4-2 (2-1)`), and dates may be on a separate
line. The text is converted to the structure of the JSON files. If a match lists goals without a
semicolon, they belong to the team that has scored. A file with scores only is an error.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.football import minutes
from overview_dsp.data.readers.football.match_timeline import (
    MatchEvent,
    contains_record,
    match_timeline,
    select_match,
    short_name,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

PROVENANCE = (
    "goals: an openfootball file, each in the middle of its minute (within 30 s of the match clock)"
)

STOPPAGE_NOTE = (
    "the file has no length of stoppage time: a half lasts 45 minutes, or until its last goal in "
    "stoppage time"
)

_MAX_LINE_LENGTH = 400
_SCORE = (
    r"(?:(?P<pen>\d{1,2}-\d{1,2})\s*pen\.?,?\s+)?(?P<score>\d{1,2}-\d{1,2})(?P<aet>\s*a\.?e\.?t\.?)?"
    r"(?:\s*\((?P<before>[\d\s,-]*)\))?(?:,?\s*(?P<pens>\d{1,2}-\d{1,2})\s*pen\.?)?"
)
_A_SCORE = re.compile(r"\s\d{1,2}-\d")
_VENUE = r"(?:\s+@.*|\s{2,}\(.*)?"
_MATCHES = (
    re.compile(rf"(?P<one>\S.*?)\s+{_SCORE}\s+(?P<two>[^\W\d].*?|\d+\..*?){_VENUE}"),
    re.compile(rf"(?P<one>\S.*?)\s+v\.?\s+(?P<two>\S.*?)\s+{_SCORE}{_VENUE}"),
)
_NUMBER = re.compile(r"\(\d{1,4}\)\s*")
_MONTH = r"(?:Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)[a-z]*"
_DATE = re.compile(
    rf"\[?((?:(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*\.?,?\s+)?"
    rf"(?:{_MONTH}[ /]\d{{1,2}}|\d{{1,2}}[ .]+{_MONTH})(?:,?[ /]\d{{4}})?)\]?(?:\s+|$)"
)
_CLOCK = re.compile(r"\d{1,2}[:.]\d{2}(?:\s+UTC[+-]\d{1,2})?\s+")
_NO_ROUND = re.compile(r"\||@|\s-\s")  # a list of rounds, or a future match
_NO_TEAM = re.compile(r"[:;,=|/\t]")
_GOAL = re.compile(
    r"(\d{1,3})\s*['’]?(?:\s*\+\s*(\d{1,2}))?\s*['’](?:\s*\(\s*(o\.?\s?g\.?|p(?:en)?\.?)\s*\))?"
)

_OBJECT = "an object {...}"
Pair = tuple[int, int]


@dataclass(frozen=True)
class _Match:
    """Match in the file."""

    raw: dict[str, object]
    round: str
    location: str

    def team(self, number: int) -> str:
        """Return the name of team 1 or 2; "" if it is missing."""
        value = self.raw.get(f"team{number}")
        return _text(value if isinstance(value, dict) else {"name": value}, "name").strip()

    def score(self, name: str, old: str) -> Pair | None:
        """Return `score[name]`, or `score1<old>` and `score2<old>`; None if it is missing."""
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
        """Final score without a shoot-out."""
        return self.score("et", "et") or self.score("ft", "")

    @property
    def line(self) -> str:
        """Description of the match for display."""
        final = self.final
        result = f"{final[0]}-{final[1]}" if final else "-"
        teams = f"{self.team(1) or '?'} {result} {self.team(2) or '?'}"
        return "  ".join(part for part in (self.date, teams, self.round) if part)


def sniff(source: DataFile) -> bool:
    """Return whether the file is JSON with matches that have `team1` and `team2`."""
    if not source.looks_like_json or '"team1"' not in source.text:
        return False
    document = source.json
    return isinstance(document, dict) and contains_record(
        (raw for raw, _, _ in _listed(document)), "team1", "team2"
    )


def sniff_text(source: DataFile) -> bool:
    """Return whether the file is a text with matches, with or without goals."""
    if source.head_text is None or source.looks_like_json or not _A_SCORE.search(source.head_text):
        return False
    document = document_of(source.head_text)
    return _has_goals(document) or _is_score_list(source.head_text, document)


def matches(source: DataFile) -> list[str]:
    """Return a description of each match in the file."""
    return [match.line for match in _matches(_document(source))]


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`).

    InputError: the file is invalid or has scores only. The message contains file, match and goal.
    """
    return decode(_document(source), options.match, source.stem)


def _document(source: DataFile) -> object:
    """Return the file in the structure of the JSON files; errors contain the path."""
    if source.looks_like_json:
        return source.json
    document = document_of(source.text)
    if not _has_goals(document) and any(sum(_final(match)) for match in document["matches"]):
        raise InputError(
            "the openfootball file has scores of matches, but no goals with minutes",
            "write the goals below their match, as in (Berg 7', 45+2' Lund 60'(pen.); Firefly "
            "88'), or use a list of minutes (minute,type,player,team)",
        )
    return document


def decode(document: object, match: str | None = None, default_title: str = "") -> Timeline:
    """Return the Timeline of one match of a parsed file.

    `document`: JSON object.
    `match`: as `LoadOptions.match`; may be None for a file of one match.
    `default_title`: title if the file has no teams.

    InputError: the match is unknown or ambiguous, or the minute of a goal is invalid.
    """
    listed = _matches(document)
    selected = listed[select_match([entry.line for entry in listed], match)]
    competition = _text(document, "name") if isinstance(document, dict) else ""
    with validation.prefix_errors(f"{selected.location}: "):
        return _timeline(selected, competition, default_title)


def _timeline(match: _Match, competition: str, default_title: str) -> Timeline:
    goals = [(team, *goal) for team in (0, 1) for goal in _goals(match, team)]
    final = match.final
    if final is None and not goals and match.score("ht", "i") is None:
        raise InputError("the match has neither a score nor goals; select another one")
    extra = match.score("et", "et") is not None
    clock = minutes.Clock.from_minutes(
        [minute for _, minute, _, _ in goals],
        # in older files the result after extra time may be the only one
        extra_time=extra or any(m.added is None and m.base > 90 for _, m, _, _ in goals),
        back_s=minutes.MIDDLE_S,
    )
    match_events = [
        MatchEvent(
            clock.time_s(minute),
            "own_goal" if entry.get("owngoal") is True else "goal",
            team,
            short_name(_text(entry, "name")),
            "pen" if entry.get("penalty") is True else "",
            str(minute),
            location,
        )
        for team, minute, entry, location in goals
    ]
    notes, title_parts = [STOPPAGE_NOTE], [competition, match.round, match.date]
    if not goals and final != (0, 0):
        notes.append("the file has no goals of this match")
        if final is not None:
            title_parts.insert(0, f"final score {final[0]}-{final[1]}")
        final = None
    shoot_out = match.score("p", "p")
    teams = [match.team(1), match.team(2)]
    if shoot_out is not None:
        notes.append(
            f"the shoot-out is omitted: {teams[0]} {shoot_out[0]}, {teams[1]} {shoot_out[1]}"
        )
    return match_timeline(
        teams if all(teams) else [],
        clock.begins_s,
        clock.duration_s,
        match_events,
        PROVENANCE,
        notes,
        default_title=default_title,
        title_parts=title_parts,
        final=final,
    )


def _goals(match: _Match, team: int) -> Iterator[tuple[minutes.Minute, dict[str, object], str]]:
    key = f"goals{team + 1}"
    listed = match.raw.get(key)
    if listed is None:
        return
    for i, entry in enumerate(validation.of_type(listed, list, key, "a list [...]")):
        location = f"{key}[{i}]"
        validation.of_type(entry, dict, location, _OBJECT)
        yield _minute(entry, location), entry, location


def _minute(entry: dict[str, object], location: str) -> minutes.Minute:
    value, offset = entry.get("minute"), entry.get("offset")
    if isinstance(value, str):
        minute = minutes.parse_minute(value, f"{location}.minute")
    else:
        allowed = "a whole number, such as 38 or 90"
        minute = minutes.Minute(validation.of_type(value, int, f"{location}.minute", allowed))
    if offset is not None and offset != 0:
        if isinstance(offset, str) and offset.strip().isascii() and offset.strip().isdigit():
            offset = int(offset.strip()[:18])
        added = validation.of_type(offset, int, f"{location}.offset", "a number of minutes")
        minute = minutes.Minute(minute.base, added)
    minutes.check_minute(minute.base, minute.added, location)
    return minute


def _matches(document: object) -> list[_Match]:
    found = []
    for raw, name, location in _listed(validation.of_type(document, dict, "the document", _OBJECT)):
        match = validation.of_type(raw, dict, location, _OBJECT)
        found.append(_Match(match, _text(match, "round", name), location))
    return found


def _listed(document: dict[str, object]) -> Iterator[tuple[object, str, str]]:
    """Yield each match, the name of its round, and its location."""
    groups: list[tuple[object, str, str]] = [(document.get("matches"), "", "matches")]
    rounds = document.get("rounds")
    for i, entry in enumerate(rounds if isinstance(rounds, list) else []):
        if isinstance(entry, dict):
            groups.append((entry.get("matches"), _text(entry, "name"), f"rounds[{i}].matches"))
    for group, name, location in groups:
        for j, raw in enumerate(group if isinstance(group, list) else []):
            yield raw, name, f"{location}[{j}]"


def _text(table: dict[str, object], key: str, default: str = "") -> str:
    value = table.get(key)
    return value if isinstance(value, str) else default


# --- plain text


def _has_goals(document: dict[str, Any]) -> bool:
    return any(match["goals1"] or match["goals2"] for match in document["matches"])


def _is_score_list(text: str, document: dict[str, Any]) -> bool:
    """Return whether at least half of the lines are matches, below a heading or a date."""
    listed = document["matches"]
    if not any(document["name"] or match["date"] for match in listed):
        return False
    teams = [match[key] for match in listed for key in ("team1", "team2")]
    rest = [line for line in _lines(text) if not _is_heading(line)]
    return 2 * len(listed) >= len(rest) and not any(_NO_TEAM.search(team) for team in teams)


def _is_heading(line: str) -> bool:
    """Return whether a line is a heading, only a date, or in brackets."""
    dated = _DATE.match(line)
    return line[0] in "=▪»([" or (dated is not None and dated.end() == len(line))


def document_of(text: str) -> dict[str, Any]:
    """Return a text in the structure of openfootball's JSON files."""
    title, round_name, date = "", "", ""
    listed: list[dict[str, Any]] = []
    for line in _lines(text):
        if line.startswith("="):
            title = title or line.strip("= ")
            continue
        if line[0] in "([" and not _NUMBER.match(line) and not _DATE.match(line):
            if listed and not listed[-1]["goals1"] and not listed[-1]["goals2"]:
                one, semicolon, two = line[1:-1].partition(";")
                if not semicolon and _final(listed[-1])[0] == 0:
                    one, two = "", one
                listed[-1] |= {"goals1": _goals_in(one), "goals2": _goals_in(two)}
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
    """Yield lines without comments and spaces; brackets over several lines are joined."""
    pending = ""
    for whole in text.splitlines():
        line = re.sub(r"(^|\s)#.*", "", whole[:_MAX_LINE_LENGTH]).strip()
        if pending:
            line = f"{pending} {line}"
        if not line:
            continue
        goals = line[0] in "([" and not _NUMBER.match(line) and not _DATE.match(line)
        open_, closed = (sum(map(line.count, marks)) for marks in ("([", ")]"))
        # an empty line ends a bracket that is not closed
        pending = line if goals and open_ > closed and whole.strip() and len(line) < 4000 else ""
        if not pending:
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
    return list(match["score"].get("et") or match["score"]["ft"])


def _pair(text: str) -> list[int]:
    return [int(number) for number in text.split("-")]


def _goals_in(text: str) -> list[dict[str, Any]]:
    goals: list[dict[str, Any]] = []
    name, end = "", 0
    for found in _GOAL.finditer(text):
        name = text[end : found.start()].strip(" ,-") or name  # without a name: the previous player
        end = found.end()
        goal: dict[str, Any] = {"name": name, "minute": int(found[1])}
        if found[2]:
            goal["offset"] = int(found[2])
        if found[3]:
            goal["owngoal" if found[3].startswith("o") else "penalty"] = True
        goals.append(goal)
    return goals
