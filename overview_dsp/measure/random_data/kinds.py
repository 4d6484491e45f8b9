"""Events of any kinds by chance, for presets that are made for no data in particular."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from overview_dsp import validation
from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.errors import InputError

LENGTH_S = 600.0
EVENTS = 30.0
"""So many in the mean: about a match's."""

CLOSE, CLOSE_S = 0.15, (1.0, 12.0)
"""So many events have another one, so soon after them."""


def random_events(kinds: Sequence[str], seed: int) -> Timeline:
    """Make up a timeline of given kinds, equally frequent, some close together, over a curve.

    Parameters
    ----------
    kinds : sequence of str
        One or more.
    seed : int
        The same seed and kinds, the same timeline.

    Returns
    -------
    Timeline
        Of ten minutes; each kind is there.

    Raises
    ------
    InputError
        No kind.

    Examples
    --------
    >>> sorted(ov.measure.random_events(["bell", "drum"], seed=1).kinds())
    ['bell', 'drum']
    """
    kinds = validation.instances(kinds, str, "kinds", "each is a word: ['goal', 'foul']")
    if not kinds:
        raise InputError("no kinds; name one or more")
    rng = validation.random(seed)
    events: list[Event] = []
    for kind in kinds:
        count = 1 + rng.poisson(max(0.0, EVENTS / len(kinds) / (1.0 + CLOSE) - 1.0))
        for at in rng.uniform(5.0, LENGTH_S - 5.0 - CLOSE_S[1], count).tolist():
            events.append(Event(at, kind))
            if rng.random() < CLOSE:
                other = kinds[int(rng.integers(len(kinds)))]
                events.append(Event(at + rng.uniform(*CLOSE_S), other))
    knots = np.linspace(0.0, LENGTH_S, 13)
    curve = Intensity(knots, np.clip(rng.normal(0.4, 0.25, len(knots)), 0.0, 1.0))
    return Timeline(f"random events {seed}", LENGTH_S, tuple(events), curve)
