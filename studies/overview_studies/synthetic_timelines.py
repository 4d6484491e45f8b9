"""Synthetic timelines for a study, with seeded events of one kind or curves of one shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from overview_dsp import Event, Intensity, Timeline
from overview_dsp.errors import InputError
from overview_studies.counterbalancing import RandomStream
from overview_studies.file_model import SyntheticTimelines

MIN_SPACING = 0.05
"""Minimum distance between events, as a share of the timeline."""

POINTS = 181
BACKGROUND_POINTS = 91

# x and phase are 0 to 1; only + - * and squares, which are bit-identical on all machines
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
    """Return a smooth bump: 1 at `centre`, 0 from a distance of 0.25."""
    part = np.clip(1.0 - np.square((x - centre) / 0.25), 0.0, 1.0)
    return part * part


def make_timelines(synthetic: SyntheticTimelines, seed: int) -> dict[str, tuple[Timeline, str]]:
    """Return each timeline by name, with its event kind or the shape of its curve.

    Raises
    ------
    InputError
        There are neither kinds nor curves, or positions and counts do not fit. The message
        begins with the key.
    """
    if bool(synthetic.kinds) == bool(synthetic.curves):
        raise InputError("stimuli.made: must have either kinds or curves")
    if not 0.0 <= synthetic.positions[0] < synthetic.positions[1] <= 1.0:
        raise InputError("stimuli.made.positions: must be two rising numbers, 0 to 1")
    found: dict[str, tuple[Timeline, str]] = {}
    for what in [*synthetic.kinds, *synthetic.curves]:
        for count in synthetic.counts if synthetic.kinds else [0]:
            for variant in range(1, synthetic.variants + 1):
                name = f"{what}-x{count}" if len(synthetic.counts) > 1 else what
                name = f"{name}-{variant}" if synthetic.variants > 1 else name
                if name in found:
                    raise InputError(f"stimuli.made: {name} occurs twice; remove one")
                stream = RandomStream(seed, "made", what, count, variant)
                timeline = (
                    _with_events(synthetic, what, count, name, stream)
                    if synthetic.kinds
                    else _with_curve(synthetic, what, name, stream)
                )
                found[name] = (timeline, what)
    return found


def _with_events(
    synthetic: SyntheticTimelines, kind: str, count: int, name: str, stream: RandomStream
) -> Timeline:
    low, high = synthetic.positions
    room = high - low - MIN_SPACING * (count - 1)
    if room < 0.0:
        raise InputError(
            f"stimuli.made.counts: {count} events at least {MIN_SPACING:g} apart do not fit into "
            f"positions {low:g} to {high:g}"
        )
    # sorted draws from the free range plus the spacing keep events apart
    drawn = sorted(stream.uniform(0.0, room) for _ in range(count))
    positions = [round(low + at + MIN_SPACING * i, 4) for i, at in enumerate(drawn)]
    events = tuple(Event(position * synthetic.duration_s, kind) for position in positions)
    return Timeline(
        name,
        synthetic.duration_s,
        events,
        _background_curve(synthetic, stream),
        provenance=PROVENANCE,
    )


def _with_curve(
    synthetic: SyntheticTimelines, shape: str, name: str, stream: RandomStream
) -> Timeline:
    x = np.arange(POINTS) / (POINTS - 1)
    level = _SHAPES[shape](x, round(stream.uniform(0.0, 1.0), 4))
    curve = Intensity(x * synthetic.duration_s, level)
    return Timeline(name, synthetic.duration_s, (), curve, provenance=PROVENANCE)


def empty_timeline(synthetic: SyntheticTimelines | None, seed: int, duration_s: float) -> Timeline:
    """Return a timeline without events, for catch trials; `crowd` adds a background curve."""
    curve = (
        _background_curve(synthetic, RandomStream(seed, "nothing"))
        if synthetic is not None
        else None
    )
    flat = Intensity(np.array([0.0, duration_s]), np.zeros(2))
    return Timeline("nothing", duration_s, (), curve or flat, provenance=PROVENANCE)


def _background_curve(synthetic: SyntheticTimelines, stream: RandomStream) -> Intensity | None:
    if not synthetic.crowd:
        return None
    level = [synthetic.crowd * stream.uniform(0.3, 1.0) for _ in range(BACKGROUND_POINTS)]
    times = np.arange(BACKGROUND_POINTS) * (synthetic.duration_s / (BACKGROUND_POINTS - 1))
    return Intensity(np.minimum(times, synthetic.duration_s), np.array(level))


PROVENANCE = "synthetic timeline of a study"
