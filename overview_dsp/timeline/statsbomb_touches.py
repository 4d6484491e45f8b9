"""What a zoom into a match shows besides its events: what the players do with the ball.

`touch`: passes, receipts, carries, dribbles, duels, recoveries, clearances, blocks, saves, pressure
on the ball. `shot`: a shot that is no event of its own (neither a goal nor a near miss).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from overview_dsp.timeline.event import Event
from overview_dsp.timeline.names import short_name
from overview_dsp.timeline.statsbomb_record import Record

TOUCHES = {
    "Pass": "pass",
    "Ball Receipt*": "receipt",
    "Carry": "carry",
    "Pressure": "pressure",
    "Ball Recovery": "recovery",
    "Duel": "duel",
    "Dribble": "dribble",
    "Dribbled Past": "dribbled past",
    "Clearance": "clearance",
    "Block": "block",
    "Interception": "interception",
    "Goal Keeper": "goalkeeper",
    "Miscontrol": "miscontrol",
    "Dispossessed": "dispossessed",
    "50/50": "fifty-fifty",
    "Shield": "shield",
}
"""Record kinds that are touches, and how their labels begin."""

SHOT_WEIGHT = 1.5
"""Against 1 of a touch: of two too close to be told apart, the shot is shown."""


def touches(
    records: Iterable[Record], happened: Collection[int], time_of: Callable[[Record], float]
) -> tuple[Event, ...]:
    """Return the details of a match.

    Parameters
    ----------
    records
        Of the periods played.
    happened
        The positions of the records that are events already.
    time_of
        The moment of a record, s.
    """
    found: dict[tuple[float, str, str], Event] = {}
    for record in records:
        shot = record.kind == "Shot"
        if record.position in happened or not (shot or record.kind in TOUCHES):
            continue
        what = "shot" if shot else TOUCHES[record.kind]
        label = f"{what} {short_name(record.player)}".rstrip()
        kind = "shot" if shot else "touch"
        event = Event(time_of(record), kind, label, SHOT_WEIGHT if shot else 1.0)
        found.setdefault((event.time_s, kind, label), event)
    return tuple(found.values())
