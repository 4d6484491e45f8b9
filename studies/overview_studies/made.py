"""Timelines made for a study: events of one kind at seeded places, or curves of one shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from overview_dsp import Event, Intensity, Timeline
from overview_dsp.errors import InputError
from overview_studies.file_model import Made
from overview_studies.orders import Seeded

APART = 0.05
"""Events of one timeline are at least so far from each other, as a part of it."""

POINTS = 181
CROWD_POINTS = 91

# x is 0 to 1, phase 0 to 1; only + - * and the square: the same bits on every machine
_SHAPES: dict[str, Callable[[NDArray[np.float64], float], NDArray[np.float64]]] = {
    "rise": lambda x, phase: 0.1 + 0.8 * x * (1.0 - phase * (1.0 - x)),
    "fall": lambda x, phase: 0.9 - 0.8 * x * (1.0 - phase * (1.0 - x)),
    "peak": lambda x, phase: 0.1 + 0.8 * _bump(x, 0.3 + 0.4 * phase),
    "dip": lambda x, phase: 0.9 - 0.8 * _bump(x, 0.3 + 0.4 * phase),
    "wave": lambda x, phase: (
        0.1 + 0.8 * (_bump(x, 0.2 + 0.1 * phase) + _bump(x, 0.8 - 0.1 * phase))
    ),
    "steady": lambda x, phase: np.full_like(x, 0.3 + 0.4 * phase),
}


def _bump(x: NDArray[np.float64], centre: float) -> NDArray[np.float64]:
    """1 at `centre`, 0 a quarter beside it, smooth."""
    part = np.clip(1.0 - np.square((x - centre) / 0.25), 0.0, 1.0)
    return part * part


def made_timelines(made: Made, seed: int) -> dict[str, tuple[Timeline, str]]:
    """Each timeline by its name, and what it is: its events' kind, or its curve's shape.

    Raises
    ------
    InputError
        Neither kinds nor curves; places or counts that don't fit. The message begins with the key.
    """
    if bool(made.kinds) == bool(made.curves):
        raise InputError("stimuli.made: has either kinds or curves")
    if not 0.0 <= made.places[0] < made.places[1] <= 1.0:
        raise InputError("stimuli.made.places: from and to, 0 to 1, rising")
    found: dict[str, tuple[Timeline, str]] = {}
    for what in [*made.kinds, *made.curves]:
        for count in made.counts if made.kinds else [0]:
            for variant in range(1, made.variants + 1):
                name = f"{what}-x{count}" if len(made.counts) > 1 else what
                name = f"{name}-{variant}" if made.variants > 1 else name
                if name in found:
                    raise InputError(f"stimuli.made: {name} is there twice; leave it in once")
                chance = Seeded(seed, "made", what, count, variant)
                timeline = (
                    _with_events(made, what, count, name, chance)
                    if made.kinds
                    else _with_curve(made, what, name, chance)
                )
                found[name] = (timeline, what)
    return found


def _with_events(made: Made, kind: str, count: int, name: str, chance: Seeded) -> Timeline:
    low, high = made.places
    room = high - low - APART * (count - 1)
    if room < 0.0:
        raise InputError(
            f"stimuli.made.counts: {count} events at least {APART:g} apart don't fit into places "
            f"{low:g} to {high:g}"
        )
    # apart by construction: sorted draws from what is left, moved on by what lies between
    drawn = sorted(chance.uniform(0.0, room) for _ in range(count))
    places = [round(low + at + APART * i, 4) for i, at in enumerate(drawn)]
    events = tuple(Event(place * made.duration_s, kind) for place in places)
    return Timeline(name, made.duration_s, events, _crowd(made, chance), provenance=_FROM)


def _with_curve(made: Made, shape: str, name: str, chance: Seeded) -> Timeline:
    x = np.arange(POINTS) / (POINTS - 1)
    level = _SHAPES[shape](x, round(chance.uniform(0.0, 1.0), 4))
    curve = Intensity(x * made.duration_s, level)
    return Timeline(name, made.duration_s, (), curve, provenance=_FROM)


def nothing(made: Made | None, seed: int, duration_s: float) -> Timeline:
    """A timeline on which nothing happens, for catch trials; with a crowd where the others have."""
    curve = _crowd(made, Seeded(seed, "nothing")) if made is not None else None
    flat = Intensity(np.array([0.0, duration_s]), np.zeros(2))
    return Timeline("nothing", duration_s, (), curve or flat, provenance=_FROM)


def _crowd(made: Made, chance: Seeded) -> Intensity | None:
    if not made.crowd:
        return None
    level = [made.crowd * chance.uniform(0.3, 1.0) for _ in range(CROWD_POINTS)]
    times = np.arange(CROWD_POINTS) * (made.duration_s / (CROWD_POINTS - 1))
    return Intensity(np.minimum(times, made.duration_s), np.array(level))


_FROM = "made for a study by its seed"
