"""What a zoom into a match shows besides its events: touches of the ball, and shots that are none.

`touch`: whatever players do with the ball or about it. `shot`: a shot that is neither a goal nor a
near miss.
"""

from __future__ import annotations

from collections.abc import Iterable

from overview_dsp.timeline.event import Event

SHOT_WEIGHT = 1.5
"""Against 1 of a touch: of two too close to be distinguished, the shot is shown."""


def touches(records: Iterable[tuple[float, str, str]]) -> tuple[Event, ...]:
    """Return the details of a match from (time_s, what, who): what is `shot`, `pass`, `duel` ..."""
    found: dict[tuple[float, str, str], Event] = {}
    for time_s, what, who in records:
        kind = "shot" if what == "shot" else "touch"
        event = Event(
            time_s, kind, f"{what} {who}".rstrip(), SHOT_WEIGHT if kind == "shot" else 1.0
        )
        found.setdefault((time_s, kind, event.label), event)
    return tuple(found.values())
