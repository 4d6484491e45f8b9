"""An event, and events in order.

What the rhythms of WFDB annotation files are called, for who reads a label.

Codes: those of PhysioBank's databases (mitdb, afdb, vfdb, cudb, ltafdb),
https://archive.physionet.org/physiobank/annotations.shtml. A rhythm holds until the next one.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from dataclasses import dataclass

from overview_dsp import validation
from overview_dsp.errors import InputError, shown

KIND = "rhythm"
"""The kind of the events whose labels hold such a code."""

RHYTHMS: dict[str, str] = {
    "N": "normal rhythm",
    "NSR": "normal rhythm",
    "AB": "atrial bigeminy",
    "AFIB": "atrial fibrillation",
    "AFL": "atrial flutter",
    "ASYS": "asystole",
    "B": "ventricular bigeminy",
    "BI": "first-degree heart block",
    "BII": "second-degree heart block",
    "HGEA": "high-grade ventricular ectopic activity",
    "IVR": "idioventricular rhythm",
    "J": "nodal (AV junctional) rhythm",
    "NOD": "nodal (AV junctional) rhythm",
    "NOISE": "noise",
    "P": "paced rhythm",
    "PM": "paced rhythm",
    "PREX": "pre-excitation (Wolff-Parkinson-White)",
    "SBR": "sinus bradycardia",
    "SVTA": "supraventricular tachyarrhythmia",
    "T": "ventricular trigeminy",
    "VER": "ventricular escape rhythm",
    "VF": "ventricular fibrillation",
    "VFIB": "ventricular fibrillation",
    "VFL": "ventricular flutter",
    "VT": "ventricular tachycardia",
}
"""Code, without the bracket that opens it, and its name."""

_CODE = re.compile(r"rhythm \((\w+)\)?")


def rhythm_name(label: str) -> str:
    """Return the name of the rhythm that a label codes, `rhythm (AFIB`; any other as it is.

    A code that is in no table stays, without the bracket that nothing closes.
    """
    found = _CODE.fullmatch(label)
    return label if found is None else RHYTHMS.get(found[1], f"rhythm {found[1]}")


MAX_EVENTS = 500_000
"""Most events of a file: some hundred times what a hand can distinguish, and 400 MB."""


@dataclass(frozen=True)
class Event:
    """Something that happens at one moment.

    Parameters
    ----------
    time_s : float
        Seconds from the timeline's start, finite, >= 0.
    kind : str
        What it is, for a preset to look up: 1 to 64 characters of a-z, 0-9 and _ (`near_miss`).
    label : str
        Words for a person.
    weight : float
        How strong, relative to others of its kind; finite, > 0, 1 = ordinary.

    Raises
    ------
    InputError
        A value outside these ranges; the line begins with the field's name.

    Examples
    --------
    >>> ov.Event(786.2, "goal", "1-0 Parris (pen)").weight
    1.0
    """

    time_s: float
    kind: str
    label: str = ""
    weight: float = 1.0

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

    @property
    def words(self) -> str:
        """The label as a person reads it: a rhythm's name where the data have its code, `(AFIB`."""
        return rhythm_name(self.label) if self.kind == KIND else self.label

    def moved(self, time_s: float) -> Event:
        """Move this event to another time, which is not checked.

        Parameters
        ----------
        time_s : float
            Seconds from the start of the timeline.

        Returns
        -------
        Event
            The same but for its time.

        Examples
        --------
        >>> ov.Event(10.0, "goal").moved(4.0)
        Event(time_s=4.0, kind='goal', label='', weight=1.0)
        """
        event = object.__new__(Event)
        event.__dict__.update(self.__dict__, time_s=time_s)
        return event


def sorted_events(events: object, duration_s: float) -> tuple[Event, ...]:
    """Return events by time, equal times in the order given.

    Raises
    ------
    InputError
        One is after the end, or has the time, kind and label of another.
    """
    if not isinstance(events, tuple | list) or not all(isinstance(e, Event) for e in events):
        raise InputError(f"events is {shown(events)}; give a tuple of Event")
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
                f"the {event.kind} at {event.time_s!r} s with label {shown(event.label)} is "
                "there twice; remove one, or give them different labels"
            )
        seen.add(key)
    return ordered


def cut_events(events: tuple[Event, ...], start: float, end: float) -> tuple[Event, ...]:
    """Return those from `start` to `end`, both included, on a time axis that begins at `start`."""
    first = bisect_left(events, start, key=_time_s)
    stop = bisect_right(events, end, key=_time_s)
    return tuple(event.moved(event.time_s - start) for event in events[first:stop])


def _time_s(event: Event) -> float:
    return event.time_s
