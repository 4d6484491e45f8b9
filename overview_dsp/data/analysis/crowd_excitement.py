"""Excitement of a crowd, derived from football events, like the curve of the paper's figure 4.

Each event raises the curve before it and lets it fall more slowly after it. Event i, at t_i, of
amplitude a_i, contributes ::

    c_i(t) = a_i * exp((t - t_i) / rise)     before it
    c_i(t) = a_i * exp(-(t - t_i) / fall)    after it

and contributions combine like independent causes, over an ambient floor ::

    excitement(t) = 1 - (1 - ambient) * prod_i (1 - c_i(t))

so the curve stays within [ambient, 1] and no event hides another. An event of weight w counts as
w equal events: a_i = 1 - (1 - a_kind)^w.

The formula and its constants are this project's own: figure 4 shows only the shape.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType

import numpy as np

from overview_dsp.data.timeline.model import Event, Intensity

AMPLITUDES: Mapping[str, float] = MappingProxyType(
    {
        "goal": 0.90,
        "own_goal": 0.85,
        "red_card": 0.60,
        "near_miss": 0.40,
        "yellow_card": 0.25,
        "period": 0.15,
        "foul": 0.12,
    }
)
"""Height of each football kind in an otherwise silent stadium: a goal nearly fills the scale."""

FOOTBALL_KINDS = frozenset(AMPLITUDES)  # the kinds of the bundled football preset
RISE_S = 30.0  # time constant before an event, s: an attack builds up within a minute
FALL_S = 120.0  # time constant after an event, s: the singing after a goal lasts some minutes
AMBIENT = 0.06  # value without any event
STEP_S = 5.0
"""Spacing of the curve's points, s: a sixth of the rise; event times are points as well."""

MAX_DURATION_S = 86_400.0
"""Longest timeline that gets a curve, s (a day): an event would be too short in a longer one."""

MAX_EVENTS = 5_000  # most events that get a curve: some thirty times those of a match
UNIT = "crowd excitement 0..1, derived from the events"

PROVENANCE = "intensity: crowd-excitement formula applied to the events, not a recording"


def crowd_curve(events: Iterable[Event], duration_s: float) -> Intensity:
    """Return the excitement curve of football events (other kinds contribute nothing).

    Events may be in any order, at 0 to `duration_s`. The curve has values from `AMBIENT` to 1 at
    every `STEP_S`, at the end, and at each event.
    """
    counted = [event for event in events if event.kind in AMPLITUDES]
    grid = np.arange(0.0, duration_s, STEP_S)
    time_s = np.unique(np.concatenate((grid, [event.time_s for event in counted], [duration_s])))
    quiet = np.full(time_s.shape, 1.0 - AMBIENT)
    for event in counted:
        # Python floats: a huge weight overflows to infinity (amplitude 1) without a warning
        amplitude = -math.expm1(event.weight * math.log1p(-AMPLITUDES[event.kind]))
        since = time_s - event.time_s
        quiet *= 1.0 - amplitude * np.exp(np.where(since < 0.0, since / RISE_S, -since / FALL_S))
    return Intensity(time_s, 1.0 - quiet, UNIT)


def derive_intensity(
    events: Iterable[Event], duration_s: float
) -> tuple[Intensity | None, str, tuple[str, ...]]:
    """Return the curve (or None), its provenance and notes.

    There is no curve without football events. For a timeline longer than `MAX_DURATION_S` or with
    more than `MAX_EVENTS` events, there is a note instead.
    """
    counted = [event for event in events if event.kind in FOOTBALL_KINDS]
    if not counted:
        return None, "", ()
    if duration_s > MAX_DURATION_S or len(counted) > MAX_EVENTS:
        note = (
            f"no crowd-excitement curve was derived: that is for up to {MAX_DURATION_S:g} s and "
            f"{MAX_EVENTS} events"
        )
        return None, "", (note,)
    return crowd_curve(counted, duration_s), PROVENANCE, ()
