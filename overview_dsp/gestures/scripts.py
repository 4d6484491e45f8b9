"""Gestures written down: a sweep, a tap, a rest."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp import validation
from overview_dsp.errors import InputError
from overview_dsp.gestures.model import Gesture
from overview_dsp.units import HALF_TURN

CONTROL_RATE = 200.0
"""Control events a second of a scripted movement."""

ARRIVAL_S = 1.5
"""How long a sweep rests at its end at most: the disk lags the finger and must arrive."""

TAP_S = 3.0
"""How long a tap that has no time of its own holds at most: presets unfold within 2.5 s."""

LONGEST_S = 24 * 3600.0


def _position(value: float, what: str) -> float:
    value = validation.real(value, what)
    if not 0.0 <= value <= 1.0:
        raise InputError(f"{what} {value:g} is out of range; positions are 0 (start) to 1 (end)")
    return value


def _seconds(value: float, what: str, zero: bool = False) -> float:
    value = validation.real(value, what)
    if not (0.0 < value <= LONGEST_S or (zero and value == 0.0)):
        raise InputError(
            f"{what} {value:g} s is out of range; it is more than 0 and up to {LONGEST_S:g} s"
        )
    return value


def sweep(seconds: float, start: float = 0.0, end: float = 1.0) -> Gesture:
    """Touch down at `start`, move steadily to `end` in `seconds`, let go when the disk is there.

    The disk lags the finger; it is waited for, 1.5 s at most.

    Parameters
    ----------
    seconds : float
        How long the movement takes, s.
    start, end : float
        Positions, 0 (start of the timeline) to 1 (its end).

    Returns
    -------
    Gesture
        With 200 control events a second.

    Raises
    ------
    InputError
        A time or a position out of range.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> ov.sweep(4.0).duration_s
    5.5
    >>> backwards = ov.sweep(2.0, start=1.0, end=0.5)
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


def tap(position: float, hold_seconds: float | None = None) -> Gesture:
    """Touch down at a position (a step of theta2), hold, let go.

    How fast the disk unfolds is the preset's.

    Parameters
    ----------
    position : float
        0 (start of the timeline) to 1 (its end).
    hold_seconds : float or None
        How long, s; None is until the disk has arrived, 3 s at most.

    Returns
    -------
    Gesture
        Of two control events.

    Raises
    ------
    InputError
        A time or a position out of range.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> ov.tap(0.8, hold_seconds=1.5).touching
    array([ True, False])
    """
    _position(position, "a tap's position")
    hold = _seconds(TAP_S if hold_seconds is None else hold_seconds, "a tap's hold")
    theta2 = np.full(2, position * HALF_TURN)
    arrives = (1,) if hold_seconds is None else ()
    return Gesture(np.array([0.0, hold]), theta2, np.array([True, False]), hold, on_arrival=arrives)


def pause(seconds: float) -> Gesture:
    """Do nothing: between two gestures, time to recoil.

    Parameters
    ----------
    seconds : float
        How long, s, 0 too.

    Returns
    -------
    Gesture
        Without events.

    Raises
    ------
    InputError
        A time out of range.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> (ov.sweep(1.0) + ov.pause(2.0) + ov.tap(0.5, 1.0)).duration_s
    5.5
    """
    _seconds(seconds, "a rest", zero=True)
    return Gesture(np.empty(0), np.empty(0), np.empty(0, dtype=bool), float(seconds))
