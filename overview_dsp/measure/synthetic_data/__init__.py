"""Random timelines like real ones, by seed, for the training and evaluation of an observer.

Each generator draws the data of a file (events of a match, closing prices, heartbeats, loudness of
a crowd). The rules of the readers make a timeline of them.
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
    """Make random timelines with the kinds of a preset.

    They are matches for a preset with goals, hearts for one with premature beats, crowds for one
    with cheers, and shares or weather (by its tags, or both in turn) for one with a highest value.
    For any other preset they have events of all its kinds.

    Parameters
    ----------
    preset : Preset
        Preset of the kinds.
    count : int
        Number of timelines.
    seed : int
        Seed of the first timeline; each further one has the next seed.

    Returns
    -------
    list of Timeline
        Timelines with at least one event each.

    Examples
    --------
    >>> [made.title for made in ov.measure.random_timelines(ov.load_preset("football"), 2, seed=7)]
    ['random match 7', 'random match 8']
    """
    made = generators(preset)
    return [made[i % len(made)](seed + i) for i in range(count)]
