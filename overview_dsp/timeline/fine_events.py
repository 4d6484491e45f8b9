"""Which of the small things a window shows: as many as a hand can distinguish in it."""

from __future__ import annotations

from bisect import bisect_left, insort

from overview_dsp.timeline.event import Event

APART = 0.0018
"""Part of the surface between two events that can be felt apart, a third of a degree: it takes a
slow look, of ten degrees a second, 30 ms."""

MOST = 500
"""A window that holds more details than this shows none: they would be nothing but a roughness."""


def shown_details(
    details: tuple[Event, ...], events: tuple[Event, ...], duration_s: float
) -> tuple[Event, ...]:
    """Return those of the details that can be distinguished from the events and from each other.

    The heaviest are taken first, the earlier ones of equal weight before the later ones. None if
    there are more than `MOST`.
    """
    if not 0 < len(details) <= MOST:
        return ()
    apart = APART * duration_s
    taken = [event.time_s for event in events]
    shown: list[Event] = []
    for detail in sorted(details, key=lambda event: -event.weight):
        at = bisect_left(taken, detail.time_s)
        near = taken[max(0, at - 1) : at + 1]
        if all(abs(other - detail.time_s) >= apart for other in near):
            insort(taken, detail.time_s)
            shown.append(detail)
    return tuple(shown)
