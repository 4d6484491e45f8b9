"""openfootball's plain text (Football.TXT): matches with their goals, as people write them.

::

    = World Cup 2022        # in Qatar

    ▪ Final
    Sun Dec 18
       18:00     Argentina    4-2 pen. 3-3 a.e.t. (2-2, 2-0)   France   @ Lusail Iconic Stadium
                   (Lionel Messi 23'(pen.), 108' Ángel Di María 36';
                    Kylian Mbappé 80' (pen.), 81', 118' (pen.))

    (64) Sun Jul/15  18:00   France     4-2 (2-1)   Croatia     @ Luzhniki Stadium, Moscow (UTC+3)
                   [Mandžukić 18' (o.g.) Griezmann 38' (pen.); Perišić 28']

Scores may stand after both teams too (`France v Croatia 4-2 (2-1)`), dates in a line of their own.
It becomes what `openfootball` reads from JSON; goals of one team only are those of the team that
has scored. A file of scores alone is known for what it is, and refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from overview_dsp import validation
from overview_dsp.data.readers.football import openfootball
from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

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


def sniff(source: Source) -> bool:
    """Return whether the file is text of matches with goals in minutes, or of scores alone."""
    if source.head_text is None or source.looks_like_json:
        return False
    document = document_of(source.head_text)
    return _has_goals(document) or _is_a_list_of_scores(source.head_text, document)


def matches(source: Source) -> list[str]:
    """Return a line on each match of the file."""
    with validation.located(f"{source.where}: "):
        return openfootball.lines(_document(source))


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read one match (takes `match`).

    Raises
    ------
    InputError
        Names the file, the match and the goal; a file of scores alone.
    """
    with validation.located(f"{source.where}: "):
        return openfootball.decode(_document(source), options.match, source.stem)


def _document(source: Source) -> dict[str, Any]:
    document = document_of(source.text)
    if not _has_goals(document) and any(sum(_final(match)) for match in document["matches"]):
        raise InputError(
            "openfootball's text with the scores of matches, but no goal in minutes",
            "write the goals below their match, as in (Berg 7', 45+2' Lund 60'(pen.); Firefly "
            "88'); a list of minutes (minute,type,player,team) is read too",
        )
    return document


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
    match["goals1"], match["goals2"] = _goals(one), _goals(two)


def _goals(text: str) -> list[dict[str, Any]]:
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
