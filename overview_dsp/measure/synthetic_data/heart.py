"""Random heartbeats with early, missed and other irregular beats.

The rate lies between 55 and 85 beats per minute, varies with breath and at random, and rises in one
to three episodes by a quarter to two thirds. Two of three recordings last 5 to 30 minutes, in which
only unusual beats are events; the third has fewer than 100 beats, and each is an event.
"""

from __future__ import annotations

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.rhythm import NORMAL, Beats
from overview_dsp.data.readers.cardiac.build import Description, heart_timeline
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.timeline import Event, Timeline

LONG_S, SHORT_S = (300.0, 1800.0), (40.0, 68.0)
STEADY = ((NORMAL, 0.8), ("bundle_branch_block", 0.1), ("paced", 0.1))
"""Kinds of the regular beats of a recording, and the shares of recordings with them."""

EARLY = (
    ("premature_atrial", 0.45),
    ("premature_ventricular", 0.40),
    ("premature_nodal", 0.05),
    ("premature_supraventricular", 0.05),
    ("fusion", 0.05),
)
MAX_EARLY_SHARE = 0.08  # largest share of early beats

MISSED, RHYTHMS, FAULTS, FLUTTER = 3.0, 2.0, 2.0, 0.35
"""Mean numbers of missed beats, rhythm changes, quality changes and flutters per recording."""


def random_heart(seed: int) -> Timeline:
    """Generate a recording of a heart.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same heart.

    Returns
    -------
    Timeline
        Timeline with the event kinds of the preset `heart`.

    Examples
    --------
    >>> heart = ov.measure.random_heart(1)
    >>> heart.intensity.unit
    'bpm'
    """
    rng = validation.random(seed)
    length = rng.uniform(*(SHORT_S if seed % 3 == 2 else LONG_S))
    usual = _intervals(rng, length)
    usual = usual[: np.searchsorted(np.cumsum(usual), length) + 10]
    steady = _one_of(rng, STEADY)
    early = rng.random(len(usual)) < rng.uniform(0.0, MAX_EARLY_SHARE)
    early[:10] = False  # the regular interval is known from the beats around it
    missed = np.zeros(len(usual), dtype=bool)
    missed[rng.integers(10, len(usual), rng.poisson(MISSED))] = True
    kinds = [steady] * len(usual)
    interval = usual.copy()
    for i in np.flatnonzero(early).tolist():
        kinds[i] = _one_of(rng, EARLY)
        share = rng.uniform(0.2, 0.5)
        interval[i] = usual[i] * (1.0 - share)
        if i + 1 < len(usual):  # the pause that makes up for it
            interval[i + 1] = usual[i + 1] * (1.0 + share)
    interval[missed & ~early] *= 2.0
    time_s = np.cumsum(interval)
    time_s = time_s[time_s < length]
    others = _others(rng, length)
    beats = Beats(time_s, tuple(kinds[: len(time_s)]), ("",) * len(time_s), annotated=True)
    about = Description(f"random heart {seed}", length, "", ())
    return heart_timeline(about, beats, ((), ()), others, LoadOptions())


def _intervals(rng: np.random.Generator, length: float) -> FloatArray:
    """Return the intervals of a regular rhythm, s, for the largest number of beats."""
    count = int(length * 2.5) + 20
    rate = np.full(count, rng.uniform(55.0, 85.0))
    beat = np.arange(count)
    for _ in range(rng.integers(1, 4)):
        middle, width = rng.uniform(0.0, 0.6 * count), rng.uniform(0.03, 0.12) * count
        rate *= 1.0 + rng.uniform(0.25, 0.65) * np.exp(-(((beat - middle) / width) ** 2))
    breath = 0.03 * np.sin(beat * 2.0 * np.pi / rng.uniform(4.0, 6.0))
    drift = np.cumsum(rng.normal(0.0, 0.002, count))
    return np.asarray(60.0 / rate * np.exp(breath + drift + rng.normal(0.0, 0.012, count)))


def _others(rng: np.random.Generator, length: float) -> list[Event]:
    """Return the annotations that are not beats."""
    found = [
        Event(float(at), kind)
        for kind, rate in (("rhythm", RHYTHMS), ("signal_quality", FAULTS))
        for at in rng.uniform(0.0, length, rng.poisson(rate))
    ]
    for at in rng.uniform(0.1 * length, 0.9 * length, rng.poisson(FLUTTER)).tolist():
        duration = min(rng.uniform(4.0, 20.0), length - at)
        found += [Event(at, "flutter", "begins"), Event(at + duration, "flutter", "ends")]
    return found


def _one_of(rng: np.random.Generator, shares: tuple[tuple[str, float], ...]) -> str:
    names, parts = zip(*shares, strict=True)
    return str(names[int(rng.choice(len(names), p=parts))])
