"""Movement by chance: they speed up, hesitate, go back a little and on again."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.gestures.scripts import CONTROL_RATE
from overview_dsp.units import HALF_TURN

SWEEP_S = (1.5, 6.0)
"""How long a hand of steady pace would take, s; the logarithm is uniform."""

PACE_CHANGE = 0.6
"""Standard deviation of the pace's logarithm from one stretch to the next."""

STRETCH_S = (0.25, 0.9)
HESITATES, HESITATES_S = 0.15, (0.15, 0.8)
GOES_BACK, GOES_BACK_BY = 0.12, (0.03, 0.15)
"""Of the stretches; how far, as a part of the timeline."""

SMOOTHED_S = 0.2
"""A hand has no corners: the pace is a Hann window's mean over so long."""


def random_movement(seed: int) -> Gesture:
    """Make up a hand's way over the whole timeline, of mixed pace.

    It touches down at the start, speeds up and slows down by chance, hesitates, goes back by up to
    15 % of the timeline and on again, and lets go at the end when the disk is there.

    Parameters
    ----------
    seed : int
        The same seed, the same hand.

    Returns
    -------
    Gesture
        With 200 control events a second.

    Examples
    --------
    >>> hand = ov.measure.random_movement(2)
    >>> hand.theta2[0], bool(hand.theta2[-1] == np.pi)
    (np.float64(0.0), True)
    """
    rng = validation.random(seed)
    usual = 1.0 / math.exp(rng.uniform(*np.log(SWEEP_S)))
    smoothing = np.hanning(round(SMOOTHED_S * CONTROL_RATE) + 2)[1:-1]
    paces: list[NDArray[np.float64]] = []
    place = 0.0
    while place < 1.0:
        pace = usual * math.exp(rng.normal(0.0, PACE_CHANGE))
        seconds = rng.uniform(*STRETCH_S)
        way = rng.random()
        if way < HESITATES:
            pace, seconds = 0.0, rng.uniform(*HESITATES_S)
        elif way < HESITATES + GOES_BACK:
            seconds = min(rng.uniform(*GOES_BACK_BY), 0.8 * place) / pace
            pace = -pace
        steps = round(seconds * CONTROL_RATE)
        paces.append(np.full(steps, pace))
        place += pace * steps / CONTROL_RATE
    course = np.convolve(np.concatenate(paces), smoothing / smoothing.sum())
    places = np.maximum(np.concatenate([[0.0], np.cumsum(course) / CONTROL_RATE]), 0.0)
    end = int(np.argmax(places >= 1.0 - 1e-9))
    places = np.append(places[:end], [1.0, 1.0])
    time_s = np.append(np.arange(end + 1), end) / CONTROL_RATE
    touching = np.ones(end + 2, dtype=bool)
    touching[-1] = False
    return Gesture(time_s, places * HALF_TURN, touching, float(time_s[-1]))
