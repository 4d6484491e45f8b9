"""Wyscout's `matches_*.json`, which names what an event file only numbers.

The companion is optional: one that can't be read is noted, and the match is read without it.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.source import LoadOptions, Source

MAX_FILES = 20
"""Most companions that are looked into, by name."""

MAX_MB = 32.0
"""Largest companion that is read, MB; a season's has 5."""

_LABEL_CHARACTERS = 200

# "Leicester City - Liverpool, 2 - 3", "... , 1 - 1 (P)" after a shoot-out
_LABEL = re.compile(r"(?P<home>.+?) - (?P<away>.+?), ?(?P<score>[0-9]+ ?- ?[0-9]+.*)?")


@dataclass(frozen=True)
class Companion:
    """What `matches_*.json` knows of a match.

    Parameters
    ----------
    teams
        Names by id, the home team first; "" where the label names none.
    score
        Goals of the two, extra time included, a shoot-out not; None where it isn't given.
    date
        `2017-09-23`, or "".
    """

    teams: dict[str, str]
    score: tuple[int, int] | None
    date: str

    @property
    def line(self) -> str:
        """What a list of matches says about it."""
        result = f"{self.score[0]}-{self.score[1]}" if self.score else "-"
        return "  ".join(part for part in (self.date, f" {result} ".join(self.names)) if part)

    @property
    def names(self) -> list[str]:
        """Names, the numbers where there are none."""
        return [name or f"team {id_}" for id_, name in self.teams.items()]


def companions(
    source: Source, ids: Collection[str]
) -> tuple[dict[str, Companion], tuple[str, ...]]:
    """Return what the `matches*.json` beside a file know of some matches, by id, and notes."""
    found: dict[str, Companion] = {}
    notes: list[str] = []
    try:
        beside = sorted(p for p in source.folder.glob("matches*.json") if p != source.path)
    except OSError:  # a folder that may be passed through but not listed
        return {}, ()
    for candidate in beside[:MAX_FILES]:
        try:
            found_beside = Source.open(candidate, LoadOptions(max_mb=MAX_MB))
            document = found_beside.json if found_beside.looks_like_json else None
        except InputError as error:
            notes.append(f"the names beside it weren't read: {error}")
            continue
        listed = document if isinstance(document, list) else [document]
        for raw in listed:
            companion = _companion(raw)
            if companion is not None and companion[0] in ids:
                found.setdefault(*companion)
    return found, tuple(notes)


def _companion(raw: object) -> tuple[str, Companion] | None:
    if not isinstance(raw, dict) or isinstance(raw.get("wyId"), bool):
        return None
    id_, sides = raw.get("wyId"), raw.get("teamsData")
    if not isinstance(id_, int | str) or not isinstance(sides, dict) or len(sides) != 2:
        return None
    if not all(isinstance(side, dict) for side in sides.values()):
        return None
    ordered = sorted(sides, key=lambda team: sides[team].get("side") != "home")
    label = raw.get("label")
    # a label is a line; no pattern is tried on megabytes
    named = _LABEL.match(label[:_LABEL_CHARACTERS]) if isinstance(label, str) else None
    names = [named["home"].strip(), named["away"].strip()] if named else ["", ""]
    goals = [_goals(sides[team]) for team in ordered]
    date = raw.get("dateutc")
    day = date[:10] if isinstance(date, str) and re.match(r"\d{4}-\d\d-\d\d", date) else ""
    with_names = dict(zip((str(team)[:18] for team in ordered), names, strict=True))
    if len(with_names) != 2:
        return None
    score = (goals[0], goals[1]) if goals[0] is not None and goals[1] is not None else None
    return shown(id_).strip("'"), Companion(with_names, score, day)


def _goals(side: dict[str, object]) -> int | None:
    """Return a team's goals: `scoreET` holds those after extra time, 0 without one."""
    regular, extra = side.get("score"), side.get("scoreET")
    numbers = [
        n for n in (regular, extra) if isinstance(n, int) and not isinstance(n, bool) and n >= 0
    ]
    return max(numbers) if numbers else None
