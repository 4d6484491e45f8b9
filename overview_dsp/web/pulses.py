"""A pulse code for each kind of event: on and off times (ms) for a motor that knows no strength.

The first pulse says how much an event weighs (80 ms: a goal; 35 ms: a card; 14 ms: a foul), those
after it tell kinds of one weight apart. 14 ms is the least that starts a phone's eccentric motor,
40 ms of rest the least that is felt between two pulses.
"""

from __future__ import annotations

from overview_dsp.design.presets.model import Preset

Pulse = tuple[int, ...]

LONG, SHORT, TICK, REST = 80, 35, 14, 40

_CODES: dict[str, Pulse] = {
    "goal": (LONG, REST, SHORT),
    "own_goal": (LONG, REST, SHORT, REST, SHORT),
    "red_card": (SHORT, REST, SHORT),
    "yellow_card": (SHORT,),
    "near_miss": (TICK, REST, TICK),
    "foul": (TICK,),
    "period": (SHORT, REST, TICK),
    "highest": (LONG, REST, SHORT),
    "lowest": (LONG, REST, TICK, REST, TICK),
    "largest_rise": (SHORT, REST, SHORT),
    "largest_fall": (SHORT, REST, TICK, REST, TICK),
    "record_high": (SHORT,),
    "record_low": (SHORT, REST, TICK),
}
# of a preset's heights: above the first it is a long pulse, above the second a short one
_HEAVY, _MIDDLE = 100.0, 25.0


def pulse_of(kind: str, preset: Preset) -> Pulse:
    """The code of a kind; one that isn't known has the pulse of its friction's height."""
    if kind in _CODES:
        return _CODES[kind]
    profile = preset.kinds.get(kind, preset.kinds["default"])
    if profile.height >= _HEAVY:
        return (LONG,)
    return (SHORT,) if profile.height >= _MIDDLE else (TICK,)
