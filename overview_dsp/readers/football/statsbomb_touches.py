"""Which of StatsBomb's records are touches of the ball, and how their labels begin."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator

from overview_dsp.readers.football.names import short_name
from overview_dsp.readers.football.statsbomb_record import Record

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
    "Shot": "shot",
}


def touch_records(
    records: Iterable[Record], happened: Collection[int], time_of: Callable[[Record], float]
) -> Iterator[tuple[float, str, str]]:
    """Yield (time_s, what, who) of the records that are touches or shots.

    Parameters
    ----------
    records
        Of the periods played.
    happened
        The positions of the records that are events already.
    time_of
        The moment of a record, s.
    """
    for record in records:
        if record.kind in TOUCHES and record.position not in happened:
            yield time_of(record), TOUCHES[record.kind], short_name(record.player)
