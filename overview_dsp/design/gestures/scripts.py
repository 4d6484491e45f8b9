"""Scripted gestures: a sweep, a tap, a pause, and models of a human arm."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.design.gestures.model import Gesture
from overview_dsp.errors import InputError
from overview_dsp.units import HALF_TURN

CONTROL_RATE = 200.0  # control events a second of a scripted movement
TAP_S = 0.05  # default duration of a tap, s; the disk arrives however short it is
LONGEST_S = 24 * 3600.0
ARM_REST_S = 0.1  # time from the end of an arm's movement to its release, s
FLICK_S = 0.3
SCRUB_S = 4.8
APPROACH_S, APPROACH_REST_S = 0.6, 0.6
"""Time in which a scrubbing finger moves to its first turning point, and time it rests there, s."""

FASTEST_SCRUB_HZ = 20.0  # highest scrubbing frequency: ten control events per period


def _position(value: float, what: str) -> float:
    value = validation.real(value, what)
    if not 0.0 <= value <= 1.0:
        raise InputError(f"{what} {value:g} is out of range; positions are 0 (start) to 1 (end)")
    return value


def _up_to(
    value: float, what: str, highest: float = LONGEST_S, unit: str = " s", zero: bool = False
) -> float:
    value = validation.real(value, what)
    if not (0.0 < value <= highest or (zero and value == 0.0)):
        allowed = f"allowed: more than 0 and up to {highest:g}{unit}"
        raise InputError(f"{what} {value:g}{unit} is out of range; {allowed}")
    return value


def sweep(seconds: float, start: float = 0.0, end: float = 1.0) -> Gesture:
    """Touch at `start`, move steadily to `end` in `seconds`, release.

    The disk lags the finger; shaft 2 stays engaged until it has arrived.

    Parameters
    ----------
    seconds : float
        Duration of the movement, s.
    start, end : float
        Positions, 0 (start of the timeline) to 1 (its end).

    Returns
    -------
    Gesture
        Gesture with 200 control events per second.

    Raises
    ------
    InputError
        A time or a position is out of range.

    Examples
    --------
    >>> ov.sweep(4.0).duration_s
    4.0
    >>> backwards = ov.sweep(2.0, start=1.0, end=0.5)
    """
    _up_to(seconds, "a sweep's duration")
    _position(start, "a sweep's start")
    _position(end, "a sweep's end")
    part = _parts(seconds)
    return _released(seconds * part, start + (end - start) * part, float(seconds))


def tap(position: float, hold_seconds: float | None = None) -> Gesture:
    """Touch at a position (a step of theta2), hold, release.

    The disk arrives there before it recoils, however short the touch. Its speed depends on the
    preset.

    Parameters
    ----------
    position : float
        0 (start of the timeline) to 1 (its end).
    hold_seconds : float or None
        Duration of the touch, s; None: 0.05 s.

    Returns
    -------
    Gesture
        Gesture of two control events.

    Raises
    ------
    InputError
        A time or a position is out of range.

    Examples
    --------
    >>> ov.tap(0.8, hold_seconds=1.5).touching
    array([ True, False])
    """
    _position(position, "a tap's position")
    hold = _up_to(TAP_S if hold_seconds is None else hold_seconds, "a tap's hold")
    theta2 = np.full(2, position * HALF_TURN)
    return Gesture(np.array([0.0, hold]), theta2, np.array([True, False]), hold)


def pause(seconds: float) -> Gesture:
    """Wait between two gestures, so that the disk can recoil.

    Parameters
    ----------
    seconds : float
        Duration, s; 0 is allowed.

    Returns
    -------
    Gesture
        Gesture without events.

    Raises
    ------
    InputError
        The time is out of range.

    Examples
    --------
    >>> (ov.sweep(1.0) + ov.pause(2.0) + ov.tap(0.5, 1.0)).duration_s
    4.0
    """
    _up_to(seconds, "a rest", zero=True)
    return Gesture(np.empty(0), np.empty(0), np.empty(0, dtype=bool), float(seconds))


def arm(seconds: float, rest_s: float = ARM_REST_S) -> Gesture:
    """Move as a human arm does over the whole timeline, rest, release.

    The position follows a minimum-jerk curve (Flash and Hogan 1985): the finger speeds up, is
    fastest in the middle (1.9 times the mean speed) and slows down. The release does not wait for
    the disk. This is a model: it has no tremor and no corrections.

    Parameters
    ----------
    seconds : float
        Duration of the movement, s.
    rest_s : float
        Time from the end of the movement to the release, s; 0 is allowed.

    Returns
    -------
    Gesture
        Gesture with 200 control events per second.

    Raises
    ------
    InputError
        A time is out of range.

    See Also
    --------
    sweep : Moves steadily and waits for the disk.
    flick, scrub : Other movements of an arm.

    Examples
    --------
    >>> ov.arm(2.0).duration_s
    2.1
    """
    _up_to(seconds, "the duration of an arm's movement")
    _up_to(rest_s, "the rest of an arm", zero=True)
    part = _parts(seconds)
    return _released(seconds * part, _minimum_jerk(part), seconds + rest_s)


def flick(seconds: float = FLICK_S) -> Gesture:
    """Swipe over the whole timeline in a fraction of a second and release.

    This is the minimum-jerk movement of `arm`, released 0.1 s after it stops.

    Parameters
    ----------
    seconds : float
        Duration of the movement, s.

    Returns
    -------
    Gesture
        Gesture with 200 control events per second.

    Raises
    ------
    InputError
        The time is out of range.

    Examples
    --------
    >>> ov.flick().duration_s, ov.flick(0.15).duration_s
    (0.4, 0.25)
    """
    _up_to(seconds, "the duration of a flick")
    return arm(seconds)


def scrub(position: float, width: float, hz: float, seconds: float = SCRUB_S) -> Gesture:
    """Move back and forth over a position, as a finger does that examines it, then release.

    The finger approaches `position - width` in 0.6 s, rests there for 0.6 s and then oscillates
    between `position - width` and `position + width`, within the timeline.

    Parameters
    ----------
    position : float
        Centre, 0 (start of the timeline) to 1 (its end).
    width : float
        Largest distance from the centre, as a share of the timeline, more than 0 and up to 1.
    hz : float
        Periods per second, more than 0 and up to 20.
    seconds : float
        Duration of the oscillation, s.

    Returns
    -------
    Gesture
        Gesture with 200 control events per second.

    Raises
    ------
    InputError
        A number is out of range.

    Examples
    --------
    >>> gesture = ov.scrub(0.5, 0.02, 2.0, seconds=3.0)
    >>> round(gesture.duration_s, 3), (gesture.theta2.max() / np.pi).round(3)
    (4.2, np.float64(0.52))
    """
    position = _position(position, "the position of scrubbing")
    width = _up_to(width, "the width of scrubbing", 1.0, "")
    hz = _up_to(hz, "the frequency of scrubbing", FASTEST_SCRUB_HZ, " Hz")
    _up_to(seconds, "the duration of scrubbing")
    approach, wave_s = _parts(APPROACH_S), seconds * _parts(seconds)
    wave = position - width * np.cos(2.0 * np.pi * hz * wave_s)
    positions = [max(position - width, 0.0) * _minimum_jerk(approach), np.clip(wave, 0.0, 1.0)]
    time_s = np.append(APPROACH_S * approach, APPROACH_S + APPROACH_REST_S + wave_s)
    return _released(time_s, np.concatenate(positions), float(time_s[-1]))


def _parts(seconds: float) -> FloatArray:
    """Return parts of a movement, 0 to 1, at the control rate."""
    steps = max(1, math.ceil(seconds * CONTROL_RATE))
    return np.arange(steps + 1) / steps


def _minimum_jerk(part: FloatArray) -> FloatArray:
    """Return the positions of a minimum-jerk movement from 0 to 1 at parts of its time."""
    # the polynomial passes 1 by a rounding error
    return np.asarray(np.minimum(part**3 * (10.0 - part * (15.0 - 6.0 * part)), 1.0))


def _released(time_s: FloatArray, position_at: FloatArray, release_s: float) -> Gesture:
    """Return the gesture of a finger that touches at these positions and then releases."""
    touching = np.ones(len(time_s) + 1, dtype=bool)
    touching[-1] = False
    theta2 = np.append(position_at, position_at[-1]) * HALF_TURN
    return Gesture(np.append(time_s, release_s), theta2, touching, release_s)
