"""What a timeline holds, checked on construction."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime

from overview_dsp import validation
from overview_dsp.data.timeline.event import Event, sorted_events
from overview_dsp.data.timeline.fine_events import Rules
from overview_dsp.data.timeline.gaps import sorted_gaps, sorted_reasons
from overview_dsp.data.timeline.intensity import Intensity
from overview_dsp.errors import InputError, shown


@dataclass(frozen=True)
class Contents:
    """The fields of a `Timeline`, which says what each is, and its events by kind."""

    title: str
    duration_s: float
    events: tuple[Event, ...] = ()
    intensity: Intensity | None = None
    gaps: tuple[tuple[float, float], ...] = ()
    provenance: str = ""
    notes: tuple[str, ...] = ()
    start: datetime | None = None
    details: tuple[Event, ...] = ()
    gap_reasons: tuple[str, ...] = ()
    rules: Rules | None = field(default=None, compare=False, repr=False)
    signal: Intensity | None = field(default=None, compare=False, repr=False)
    until_s: float | None = None

    def __post_init__(self) -> None:
        validation.text(self.title, "title")
        validation.text(self.provenance, "provenance")
        duration_s = validation.positive(
            self.duration_s, "duration_s", "a duration is a finite number of seconds above 0"
        )
        object.__setattr__(self, "duration_s", duration_s)
        notes = tuple(validation.text(note, f"notes[{i}]") for i, note in enumerate(self.notes))
        object.__setattr__(self, "notes", notes)
        validation.moment(self.start, duration_s)
        object.__setattr__(self, "until_s", validation.until(self.until_s, duration_s))
        object.__setattr__(self, "events", sorted_events(self.events, duration_s))
        with validation.located("details: "):
            object.__setattr__(self, "details", sorted_events(self.details, duration_s))
        gaps = sorted_gaps(self.gaps, duration_s)
        object.__setattr__(self, "gap_reasons", sorted_reasons(self.gap_reasons, self.gaps))
        object.__setattr__(self, "gaps", gaps)
        if self.intensity is not None:
            hint = "give times and values: ov.Intensity(time_s, value, unit)"
            validation.instance(self.intensity, Intensity, "intensity", hint)
        if self.intensity is not None and self.intensity.last_s > duration_s:
            last = self.intensity.count - 1
            raise InputError(
                f"intensity.time_s[{last}] is {self.intensity.last_s!r}, after the "
                f"end of the timeline (duration_s {duration_s!r}); {validation.TIME_HINT}"
            )
        if not self.events and self.intensity is None:
            raise InputError(
                "the timeline has neither events nor an intensity; give one of them or both"
            )

    def kinds(self) -> dict[str, int]:
        """Count the events of each kind.

        Returns
        -------
        dict of str to int
            In order of first appearance.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> match.kinds()["goal"]
        5
        """
        counts: dict[str, int] = {}
        for event in self.events:
            counts[event.kind] = counts.get(event.kind, 0) + 1
        return counts

    def event(self, kind: str, number: int) -> Event:
        """Find the n-th event of a kind.

        Parameters
        ----------
        kind : str
            Of the event.
        number : int
            From 1, in time order.

        Returns
        -------
        Event
            That one.

        Raises
        ------
        InputError
            No event of that kind, or not so many; the line says which and how many there are.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> match.event("goal", 2).time_s > match.event("goal", 1).time_s
        True
        """
        validation.instance(kind, str, "kind", "'goal' is one")
        found = [event for event in self.events if event.kind == kind]
        if not found:
            there = ", ".join(self.kinds()) or "no events at all"
            raise InputError(f"the timeline has no event of kind {shown(kind)}; it has {there}")
        number = validation.whole(number, "number")
        if not 1 <= number <= len(found):
            raise InputError(
                f"there is no {kind} number {shown(number)}; the timeline has {len(found)}: "
                f"give 1 to {len(found)}"
            )
        return found[number - 1]
