"""One record of a StatsBomb event file, its fields checked as they are asked for."""

from __future__ import annotations

import re
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.errors import InputError, shown

SHOOT_OUT = 5
"""The period of a shoot-out; 1 and 2 are halves, 3 and 4 those of extra time."""

_CLOCK = re.compile(r"([0-9]{2}):([0-5][0-9]):([0-5][0-9])(?:\.([0-9]{1,6}))?")


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
        id_ = raw.get("id")
        id_ = id_ if isinstance(id_, str) else ""
        with validation.located(f"{_place(position, id_)}: "):
            period = raw.get("period")
            if isinstance(period, bool) or not isinstance(period, int):
                raise InputError(f"period is {shown(period)}; periods are 1 to {SHOOT_OUT}")
            if not 1 <= period <= SHOOT_OUT:
                raise InputError(f"period is {shown(period)}; periods are 1 to {SHOOT_OUT}")
            kind = _name(raw, "type")
            if kind is None:
                raise InputError("type.name is missing; it says what the event is, such as 'Shot'")
            clock_us = _clock_us(raw.get("timestamp"))
        return cls(
            position,
            raw,
            id_,
            kind,
            _name(raw, "team") or "",
            _name(raw, "player") or "",
            period,
            clock_us,
        )

    @property
    def place(self) -> str:
        """How an error line or a note names this record."""
        return _place(self.position, self.id)

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


def _place(position: int, id_: str) -> str:
    return f"event {position} (id {shown(id_)[1:-1]})" if id_ else f"event {position}"


def _name(table: dict[str, object], key: str) -> str | None:
    part = table.get(key)
    name = part.get("name") if isinstance(part, dict) else None
    return name if isinstance(name, str) and name.strip() else None


def _clock_us(value: object) -> int:
    found = _CLOCK.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        raise InputError(f"timestamp is {shown(value)}; it is the time in the period, hh:mm:ss.sss")
    hours, minutes, seconds = (int(found[i]) for i in (1, 2, 3))
    return (hours * 3600 + minutes * 60 + seconds) * 1_000_000 + int((found[4] or "").ljust(6, "0"))
