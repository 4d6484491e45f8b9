"""Random movements of mixed pace, with pauses and short returns."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.gestures.scripts import CONTROL_RATE
from overview_dsp.units import HALF_TURN

SWEEP_S = (1.5, 6.0)  # duration of a steady movement of the mean pace, s; its logarithm is uniform
PACE_CHANGE = 0.6  # standard deviation of the logarithm of the pace of a segment
SEGMENT_S = (0.25, 0.9)
PAUSE_SHARE, PAUSE_S = 0.15, (0.15, 0.8)
RETURN_SHARE, RETURN_BY = 0.12, (0.03, 0.15)
"""Shares of segments that pause or return; distance of a return as a share of the timeline."""

SMOOTHED_S = 0.2  # length of the Hann window that smooths the pace, s


def random_movement(seed: int) -> Gesture:
    """Make a random movement of mixed pace over the whole timeline.

    It touches at the start, changes its pace at random, pauses, returns by up to 15 % of the
    timeline, and releases at the end.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same movement.

    Returns
    -------
    Gesture
        Gesture with 200 control events per second.

    Examples
    --------
    >>> movement = ov.measure.random_movement(2)
    >>> movement.theta2[0], bool(movement.theta2[-1] == np.pi)
    (np.float64(0.0), True)
    """
    rng = validation.random(seed)
    mean_pace = 1.0 / math.exp(rng.uniform(*np.log(SWEEP_S)))
    smoothing = np.hanning(round(SMOOTHED_S * CONTROL_RATE) + 2)[1:-1]
    paces: list[FloatArray] = []
    position = 0.0
    while position < 1.0:
        pace = mean_pace * math.exp(rng.normal(0.0, PACE_CHANGE))
        seconds = rng.uniform(*SEGMENT_S)
        chance = rng.random()
        if chance < PAUSE_SHARE:
            pace, seconds = 0.0, rng.uniform(*PAUSE_S)
        elif chance < PAUSE_SHARE + RETURN_SHARE:
            seconds = min(rng.uniform(*RETURN_BY), 0.8 * position) / pace
            pace = -pace
        steps = round(seconds * CONTROL_RATE)
        paces.append(np.full(steps, pace))
        position += pace * steps / CONTROL_RATE
    smoothed = np.convolve(np.concatenate(paces), smoothing / smoothing.sum())
    positions = np.maximum(np.concatenate([[0.0], np.cumsum(smoothed) / CONTROL_RATE]), 0.0)
    end = int(np.argmax(positions >= 1.0 - 1e-9))
    positions = np.append(positions[:end], [1.0, 1.0])
    time_s = np.append(np.arange(end + 1), end) / CONTROL_RATE
    touching = np.ones(end + 2, dtype=bool)
    touching[-1] = False
    return Gesture(time_s, positions * HALF_TURN, touching, float(time_s[-1]))
