"""A match's minutes as on the board: where its halves are, and `45+2` for added time."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from overview_dsp.data.timeline.event import Event

_MINUTES = ((0, 45), (45, 90), (90, 105), (105, 120))
_NAMES = ("first half", "second half", "extra time", "extra time, second half")
_SHORT_S = 120.0
"""A half as listed may be shorter than it should by so much."""

_LATE_S = 60.0
"""A match begins so soon on its timeline."""

_KINDS = frozenset({"goal", "own_goal", "near_miss", "yellow_card", "red_card", "foul"})
_LABELS = ("kick-off", "half-time")


@dataclass(frozen=True)
class Half:
    """One half: where it is on the timeline, s, and from and to which minute it goes."""

    begin_s: float
    end_s: float
    first: int
    last: int
    name: str

    @property
    def nominal_s(self) -> float:
        """Where its added time begins, s."""
        return self.begin_s + 60.0 * (self.last - self.first)

    def minute_text(self, minutes: int, begun: bool = False) -> str:
        """Write so many minutes after its beginning as the board does: `62`, `90+3`.

        One more has `begun` where seconds follow: 30 s after minute 45 it is `45+0`, which minute
        45 of the next half isn't.
        """
        minute = self.first + minutes
        added = minute > self.last or (begun and minute == self.last)
        return f"{self.last}+{minute - self.last}" if added else str(minute)


def halves_of(events: Sequence[Event]) -> tuple[Half, ...]:
    """Return the halves of a whole match; none where its events (by time) don't say.

    They lie between its events of the kind `period`: two, three or four, of their full length.
    """
    periods = [event for event in events if event.kind == "period"]
    if not any(e.kind in _KINDS for e in events) and not any(e.label in _LABELS for e in periods):
        return ()  # a school's periods
    edges = sorted({event.time_s for event in periods})
    if not 2 <= len(edges) - 1 <= len(_MINUTES) or edges[0] > _LATE_S:
        return ()
    halves = tuple(
        Half(begin, end, first, last, name)
        for (begin, end), (first, last), name in zip(
            itertools.pairwise(edges), _MINUTES, _NAMES, strict=False
        )
    )
    return halves if all(h.end_s >= h.nominal_s - _SHORT_S for h in halves) else ()
