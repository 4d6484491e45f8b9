"""Random realistic timelines by seed, for training and evaluating an observer of a preset.

Each generator draws the content of a file (a match's events, a share's closing prices, a heart's
beats, a crowd's loudness). The rules of the file's reader make a timeline of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import DEFAULT_KIND, Preset
from overview_dsp.measure.synthetic_data.events import random_events, random_match
from overview_dsp.measure.synthetic_data.heart import random_heart
from overview_dsp.measure.synthetic_data.series import random_crowd, random_share, random_weather

__all__ = [
    "random_crowd",
    "random_events",
    "random_heart",
    "random_match",
    "random_share",
    "random_timelines",
    "random_weather",
]

Generator = Callable[[int], Timeline]

_BY_KIND: Mapping[str, Generator] = {
    "goal": random_match,
    "premature": random_heart,
    "cheer": random_crowd,
}
_SERIES = "highest"  # kind of the presets for series
_SERIES_FOR: Mapping[str, Generator] = {"shares": random_share, "weather": random_weather}
"""Generator of a series by a word of `tags.usage`."""


def generators(preset: Preset) -> tuple[Generator, ...]:
    """Return the generators of timelines for a preset, which are used in turn."""
    for kind, generator in _BY_KIND.items():
        if kind in preset.kinds:
            return (generator,)
    if _SERIES in preset.kinds:
        named = [made for word, made in _SERIES_FOR.items() if word in preset.tags.usage]
        return tuple(named or _SERIES_FOR.values())
    own = [kind for kind in preset.kinds if kind != DEFAULT_KIND] or [DEFAULT_KIND]
    return (lambda seed: random_events(own, seed),)


def random_timelines(preset: Preset, count: int, seed: int = 0) -> list[Timeline]:
    """Generate timelines with the event kinds of a preset.

    They are matches for a preset with goals, hearts for one with premature beats, crowds for one
    with cheers, shares and weather (as its tags say, or both in turn) for one with the kind
    `highest`, and random events of all its kinds for any other.

    Parameters
    ----------
    preset : Preset
        Preset with the kinds.
    count : int
        Number of timelines.
    seed : int
        Seed of the first timeline; the others have the next seeds.

    Returns
    -------
    list of Timeline
        Timelines, each with at least one event.

    Examples
    --------
    >>> [made.title for made in ov.measure.random_timelines(ov.load_preset("football"), 2, seed=7)]
    ['random match 7', 'random match 8']
    """
    made = generators(preset)
    return [made[i % len(made)](seed + i) for i in range(count)]
