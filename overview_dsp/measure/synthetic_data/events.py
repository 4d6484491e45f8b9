"""Random events: a football match, and events of any kinds.

The mean numbers per match (Poisson) are those of StatsBomb's open data as read by this project: 2.7
goals, 20 fouls, 9.5 near misses, 3.8 yellow cards. Own goals (a twelfth of the goals) and red cards
(0.3) are 3 and 2 times as frequent as in real matches, so that an observer has enough to learn.

Difficult cases of real matches are drawn too: goals less than two minutes apart, cards in the
minutes after a goal, shots that rebound, and a foul at the same time as its card.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import crowd_curve
from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.errors import InputError

GOALS, FOULS, NEAR_MISSES, YELLOWS, REDS = 2.7, 20.0, 9.5, 3.8, 0.3
OWN_GOAL = 1.0 / 12.0  # share of goals

CLOSE_GOAL, CLOSE_GOAL_S = 0.15, (20.0, 115.0)
"""Share of goals that another one follows, and range of the time between both."""

CARD_AFTER_GOAL, CARD_AFTER_GOAL_S = 0.2, (5.0, 480.0)
REBOUND, REBOUND_S = 0.2, (2.0, 20.0)
FOUL_WITH_CARD = 0.85
HALF_S = 2700.0
STOPPAGE_S = ((40.0, 260.0), (120.0, 460.0))
"""Shortest and longest stoppage time of the first and of the second half."""


def random_match(seed: int) -> Timeline:
    """Generate a football match with realistic numbers of events, some of them close together.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same match.

    Returns
    -------
    Timeline
        Timeline with the event kinds of the preset `football`, and the curve that readers derive.

    Examples
    --------
    >>> match = ov.measure.random_match(3)
    >>> match.kinds()["period"], 5000.0 < match.duration_s < 6200.0
    (3, True)
    """
    rng = validation.random(seed)
    half = HALF_S + rng.uniform(*STOPPAGE_S[0])
    length = half + HALF_S + rng.uniform(*STOPPAGE_S[1])
    found: list[tuple[float, str]] = []

    def random_times(mean_count: float) -> list[float]:
        return list(rng.uniform(10.0, length - 10.0, rng.poisson(mean_count)).tolist())

    for at in random_times(GOALS):
        found.append((at, "own_goal" if rng.random() < OWN_GOAL else "goal"))
        if rng.random() < CLOSE_GOAL:
            found.append((at + rng.uniform(*CLOSE_GOAL_S), "goal"))
        if rng.random() < CARD_AFTER_GOAL:
            kind = "red_card" if rng.random() < 0.1 else "yellow_card"
            found.append((at + rng.uniform(*CARD_AFTER_GOAL_S), kind))
    found += [(at, "yellow_card") for at in random_times(YELLOWS)]
    found += [(at, "red_card") for at in random_times(REDS)]
    for at in random_times(NEAR_MISSES):
        found.append((at, "near_miss"))
        if rng.random() < REBOUND:
            found.append((at + rng.uniform(*REBOUND_S), "near_miss"))
    cards = [at for at, kind in found if kind.endswith("card")]
    found += [(at, "foul") for at in cards if rng.random() < FOUL_WITH_CARD]
    found += [(at, "foul") for at in random_times(max(0.0, FOULS - FOUL_WITH_CARD * len(cards)))]
    events = [Event(at, "period") for at in (0.0, half, length)]
    events += [Event(at, kind) for at, kind in found if at < length]
    return Timeline(
        title=f"random match {seed}",
        duration_s=length,
        events=tuple(events),
        intensity=crowd_curve(events, length),
    )


EVENTS_LENGTH_S = 600.0
EVENTS = 30.0  # mean number of events, about that of a match

CLOSE, CLOSE_S = 0.15, (1.0, 12.0)
"""Share of events that another one follows, and range of the time between both."""


def random_events(kinds: Sequence[str], seed: int) -> Timeline:
    """Generate a timeline with equally frequent events of the given kinds, some close, and a curve.

    Parameters
    ----------
    kinds : sequence of str
        One or more kinds.
    seed : int
        Random seed; the same seed and kinds give the same timeline.

    Returns
    -------
    Timeline
        Timeline of ten minutes, in which each kind occurs.

    Raises
    ------
    InputError
        No kinds.

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
        for at in rng.uniform(5.0, EVENTS_LENGTH_S - 5.0 - CLOSE_S[1], count).tolist():
            events.append(Event(at, kind))
            if rng.random() < CLOSE:
                other = kinds[int(rng.integers(len(kinds)))]
                events.append(Event(at + rng.uniform(*CLOSE_S), other))
    knots = np.linspace(0.0, EVENTS_LENGTH_S, 13)
    curve = Intensity(knots, np.clip(rng.normal(0.4, 0.25, len(knots)), 0.0, 1.0))
    return Timeline(f"random events {seed}", EVENTS_LENGTH_S, tuple(events), curve)
