"""Gestures written down: a sweep, a tap, a rest."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.gestures.model import Gesture
from overview_dsp.units import HALF_TURN

CONTROL_RATE = 200.0
"""Control events a second of a scripted movement."""

ARRIVAL_S = 1.5
"""How long a sweep rests at its end at most: the disk lags the finger and must arrive."""

LONGEST_S = 24 * 3600.0


def _position(value: float, what: str) -> float:
    if not 0.0 <= value <= 1.0:
        raise InputError(f"{what} {value:g} is out of range; positions are 0 (start) to 1 (end)")
    return float(value)


def _seconds(value: float, what: str, zero: bool = False) -> float:
    if not (0.0 < value <= LONGEST_S or (zero and value == 0.0)):
        raise InputError(
            f"{what} {value:g} s is out of range; it is more than 0 and up to {LONGEST_S:g} s"
        )
    return float(value)


def sweep(seconds: float, start: float = 0.0, end: float = 1.0) -> Gesture:
    """Touch down at `start`, move steadily to `end` in `seconds`, let go when the disk is there.

    The disk lags the finger; it is waited for, 1.5 s at most.

    Positions are 0 (start of the timeline) to 1 (its end).
    """
    _seconds(seconds, "a sweep's duration")
    _position(start, "a sweep's start")
    _position(end, "a sweep's end")
    steps = max(1, math.ceil(seconds * CONTROL_RATE))
    part = np.arange(steps + 1) / steps
    place = start + (end - start) * part
    time_s = np.append(seconds * part, seconds + ARRIVAL_S)
    theta2 = np.append(place, place[-1]) * HALF_TURN
    touching = np.ones(steps + 2, dtype=bool)
    touching[-1] = False
    return Gesture(time_s, theta2, touching, float(time_s[-1]), on_arrival=(steps + 1,))


def tap(position: float, hold_seconds: float = 1.0) -> Gesture:
    """Touch down at `position` (a step of theta2), hold, let go."""
    _position(position, "a tap's position")
    _seconds(hold_seconds, "a tap's hold")
    theta2 = np.full(2, position * HALF_TURN)
    return Gesture(
        np.array([0.0, hold_seconds]), theta2, np.array([True, False]), float(hold_seconds)
    )


def pause(seconds: float) -> Gesture:
    """Nothing for `seconds`: between two gestures, time to recoil."""
    _seconds(seconds, "a rest", zero=True)
    return Gesture(np.empty(0), np.empty(0), np.empty(0, dtype=bool), float(seconds))
