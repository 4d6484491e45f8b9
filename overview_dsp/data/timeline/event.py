"""Events, sorted events, and names of the heart rhythms in labels.

Rhythm codes are those of PhysioBank's databases (mitdb, afdb, vfdb, cudb, ltafdb),
https://archive.physionet.org/physiobank/annotations.shtml. A rhythm lasts until the next one.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from overview_dsp import validation
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.toml import load_toml

KIND = "rhythm"  # kind of events whose labels contain a rhythm code
HEART_CODES: dict[str, dict[str, Any]] = load_toml(__file__, "heart_codes.toml")
"""Codes of rhythms, beats and other annotations of heart recordings, from `heart_codes.toml`."""

RHYTHMS: dict[str, str] = HEART_CODES["rhythms"]
"""Names of rhythm codes, without the opening bracket."""

_CODE = re.compile(r"rhythm \((\w+)\)?")


MAX_EVENTS = 500_000  # maximum number of events of a file: they take 400 MB

FIELDS = ("time_s", "kind", "label", "weight", "side")
"""Names of the values of an event, in files and tables."""

GOALS = frozenset({"goal", "own_goal"})
"""Event kinds that change the score."""

MARK = "mark"  # kind of the marks that a user sets
WITHDRAWN_GOAL = "withdrawn_goal"  # kind of a goal that does not count, at its position


@dataclass(frozen=True)
class Event:
    """An event at one moment of a timeline.

    Parameters
    ----------
    time_s : float
        Seconds from the timeline's start, finite, >= 0.
    kind : str
        Event kind, defined by a preset: 1 to 64 characters of a-z, 0-9 and _ (`near_miss`).
    label : str
        Text for display.
    weight : float
        Strength relative to other events of the kind; finite, > 0, 1 = ordinary.
    side : int
        Team of the event, 1 or 2, or 0 without one; of a goal or own goal, the team that scores.
        Touch and sound do not depend on it.

    Raises
    ------
    InputError
        A value out of range; the message begins with the name of the field.

    Examples
    --------
    >>> ov.Event(786.2, "goal", "1-0 Parris (pen)").weight
    1.0
    """

    time_s: float
    kind: str
    label: str = ""
    weight: float = 1.0
    side: int = 0

    def __post_init__(self) -> None:
        time_s = validation.number(self.time_s, "time_s", validation.TIME_HINT)
        if time_s < 0.0:
            raise InputError(f"time_s is {time_s!r}, before the start; {validation.TIME_HINT}")
        object.__setattr__(self, "time_s", time_s)
        validation.kind(self.kind)
        validation.text(self.label, "label")
        weight = validation.positive(
            self.weight, "weight", "a weight is a finite number above 0, 1 = ordinary"
        )
        object.__setattr__(self, "weight", weight)
        object.__setattr__(self, "side", validation.whole(self.side, "side", 0, 2))

    @property
    def display_label(self) -> str:
        """Label for display: the name of a rhythm instead of its code, `(AFIB`."""
        found = _CODE.fullmatch(self.label) if self.kind == KIND else None
        # unknown codes are kept without the opening bracket
        return self.label if found is None else RHYTHMS.get(found[1], f"rhythm {found[1]}")

    def moved(self, time_s: float) -> Event:
        """Return this event at another time, which is not validated.

        Parameters
        ----------
        time_s : float
            Seconds from the start of the timeline.

        Returns
        -------
        Event
            The event at that time.

        Examples
        --------
        >>> ov.Event(10.0, "goal").moved(4.0)
        Event(time_s=4.0, kind='goal', label='', weight=1.0, side=0)
        """
        event = object.__new__(Event)
        event.__dict__.update(self.__dict__, time_s=time_s)
        return event


def sorted_events(events: object, duration_s: float) -> tuple[Event, ...]:
    """Return events sorted by time; events of equal time keep their order.

    InputError for an event after the end, or one with time, kind and label of another.
    """
    if not isinstance(events, tuple | list) or not all(isinstance(e, Event) for e in events):
        raise InputError(f"events is {quoted(events)}; give a tuple of Event")
    ordered: tuple[Event, ...] = tuple(sorted(events, key=lambda event: event.time_s))
    if ordered and ordered[-1].time_s > duration_s:
        late = ordered[-1]
        raise InputError(
            f"the {late.kind} at {late.time_s!r} s is after the end of the timeline "
            f"(duration_s {duration_s!r}); {validation.TIME_HINT}"
        )
    seen: set[tuple[float, str, str]] = set()
    for event in ordered:
        key = (event.time_s, event.kind, event.label)
        if key in seen:
            raise InputError(
                f"the {event.kind} at {event.time_s!r} s with label {quoted(event.label)} "
                "is repeated; remove one, or give them different labels"
            )
        seen.add(key)
    return ordered


def checked_sides(sides: object) -> tuple[str, ...]:
    """Return the names of both teams, or (); InputError for other values."""
    names = sides if isinstance(sides, tuple | list) else (None,)
    if len(names) not in (0, 2) or not all(isinstance(name, str) and name for name in names):
        raise InputError(f"sides is {quoted(sides)}; give the names of two teams, or none")
    return tuple(validation.text(name, "sides") for name in names)


def score_of(events: Iterable[Event]) -> tuple[int, int] | None:
    """Return the goals of both sides; None without sides, or with a goal of an unknown side."""
    events = tuple(events)
    scored = [event.side for event in events if event.kind in GOALS]
    if 0 in scored or not any(event.side for event in events):
        return None
    return scored.count(1), scored.count(2)


def cut_events(events: tuple[Event, ...], start: float, end: float) -> tuple[Event, ...]:
    """Return the events from `start` to `end`, inclusive, on a time axis that begins at `start`."""
    first = bisect_left(events, start, key=attrgetter("time_s"))
    stop = bisect_right(events, end, key=attrgetter("time_s"))
    return tuple(event.moved(event.time_s - start) for event in events[first:stop])
