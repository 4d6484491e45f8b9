"""A crowd by chance: the loudness of a recording of 3 to 12 minutes, with cheers and bursts.

A murmur that wanders by a decibel or two; cheers rise by 7 to 18 LU within a second or two, are
held for 2 to 12 s and die away; bursts (a whistle, a bang) last a few tenths of a second.
"""

from __future__ import annotations

import numpy as np

from overview_dsp import validation
from overview_dsp.data.analysis.loudness import STEPS_PER_S, Steps
from overview_dsp.data.readers.audio.reader import MAPS, timeline_of
from overview_dsp.data.timeline import Timeline

LENGTH_S = (180.0, 720.0)
CHEERS_A_MINUTE, BURSTS_A_MINUTE = 1.1, 1.4
_RATE = 1000
"""Hz of the recording that isn't there: only its power in each step counts."""


def random_crowd(seed: int) -> Timeline:
    """Make up the loudness of a crowd, and find its cheers and bursts.

    Parameters
    ----------
    seed : int
        The same seed, the same crowd.

    Returns
    -------
    Timeline
        Of the kinds of the preset `crowd`.

    Examples
    --------
    >>> crowd = ov.measure.random_crowd(1)
    >>> sorted(crowd.kinds())
    ['burst', 'cheer']
    """
    rng = validation.random(seed)
    length = rng.uniform(*LENGTH_S)
    count = int(length * STEPS_PER_S)
    at_s = np.arange(count) / STEPS_PER_S
    wander = np.cumsum(rng.normal(0.0, 0.15, count))
    # back to the middle within half a minute
    slow = wander - np.convolve(np.pad(wander, 150, mode="edge"), np.full(301, 1 / 301), "valid")
    above = np.zeros(count)
    for start in rng.uniform(2.0, length - 5.0, rng.poisson(CHEERS_A_MINUTE * length / 60.0)):
        rise, hold, fall = rng.uniform(0.5, 2.5), rng.uniform(2.0, 12.0), rng.uniform(2.0, 6.0)
        places = [start, start + rise, start + rise + hold, start + rise + hold + fall]
        height = rng.uniform(7.0, 18.0)
        above = np.maximum(above, np.interp(at_s, places, [0.0, height, 0.9 * height, 0.0]))
    for start in rng.uniform(2.0, length - 5.0, rng.poisson(BURSTS_A_MINUTE * length / 60.0)):
        inside = (at_s >= start) & (at_s < start + rng.uniform(0.2, 0.7))
        above[inside] = np.maximum(above[inside], rng.uniform(14.0, 26.0))
    loudness = rng.uniform(-36.0, -24.0) + slow + rng.normal(0.0, 0.7, count) + above
    samples = np.full(count, _RATE // STEPS_PER_S)
    energy = samples * 10.0 ** (loudness / 10.0)
    steps = Steps(_RATE, int(samples.sum()), energy, samples, (), 0)
    return timeline_of(steps, MAPS[0], f"random crowd {seed}", "random", ())
