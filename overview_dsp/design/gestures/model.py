"""Gestures: timed control events of one or several inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.errors import InputError
from overview_dsp.public import counted

LONGEST_S = 7 * 24 * 3600.0  # longest gesture, s; a longer time is taken for a mistake


SOURCES = ("touch", "twist", "serial", "osc", "midi", "remote")
"""Inputs that may hold the disk; their order decides ties at the same sample."""


@dataclass(frozen=True)
class Change:
    """Parameter or surface change of a recorded take.

    `time_s` is from the gesture's start. `what` is {"set": {id: value}}, {"preset": ...},
    {"window": [start_s, end_s]}, {"timeline": ...} (an update of a live timeline) or
    {"pattern": ...} (an announcement).
    """

    time_s: float
    what: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Gesture:
    """Control events of one input, or of several in a recorded take, in order of time.

    `a + b` plays one gesture after the other.

    Parameters
    ----------
    time_s : float64 (events,)
        Times from the gesture's start, s, >= 0, never decreasing.
    theta2 : float64 (events,)
        Input angle, rad; 0 = start of the timeline, pi = its end.
    touching : bool (events,)
        Whether the input touches the disk.
    duration_s : float
        End of the gesture, s, at or after its last event.
    source : int8 (events,)
        Input, as an index of touch, twist, serial, osc, midi, remote; default: touch.
    changes : tuple
        Parameter and surface changes of a recorded take, each with its time, in order.

    Raises
    ------
    InputError
        Times decrease or are not finite, or arrays have different lengths.

    See Also
    --------
    sweep, tap, pause : Make gestures.

    Examples
    --------
    >>> times, angles = np.array([0.0, 0.5, 1.0]), np.array([0.0, 1.0, 1.0])
    >>> mine = ov.Gesture(times, angles, np.array([True, True, False]), duration_s=1.0)
    >>> (mine + ov.tap(0.8, hold_seconds=0.5)).duration_s
    1.5
    """

    time_s: FloatArray
    theta2: FloatArray
    touching: BoolArray
    duration_s: float
    source: NDArray[np.int8] = None  # type: ignore[assignment]
    changes: tuple[Change, ...] = ()

    def __post_init__(self) -> None:
        time_s = validation.floats(self.time_s, "time_s")
        theta2 = validation.floats(self.theta2, "theta2")
        touching = validation.floats(self.touching, "touching") != 0.0
        duration_s = validation.real(self.duration_s, "duration_s")
        sources: Any = self.source
        source = np.array(np.zeros(len(time_s)) if sources is None else sources, dtype=np.int8)
        if not len(time_s) == len(theta2) == len(touching) == len(source):
            raise InputError("a gesture's time, theta2, touching and source must be equally long")
        if len(time_s) and (not np.isfinite(time_s).all() or time_s[0] < 0.0):
            raise InputError("a gesture's times must be finite and not negative")
        back = np.flatnonzero(np.diff(time_s) < 0.0)
        if len(back):
            first = int(back[0]) + 1
            raise InputError(
                f"the gesture's time goes back at event {first + 1}: "
                f"{time_s[first]:g} s after {time_s[first - 1]:g} s"
            )
        last = float(time_s[-1]) if len(time_s) else 0.0
        if not last <= LONGEST_S or not 0.0 <= duration_s <= LONGEST_S:
            raise InputError(
                f"the gesture's duration {max(last, duration_s):g} s is out of range; "
                f"allowed: 0 to {LONGEST_S:g} s"
            )
        if self.duration_s < last:
            raise InputError(
                f"the gesture's duration {self.duration_s:g} s ends before its last event, "
                f"at {last:g} s"
            )
        arrays = {"time_s": time_s, "theta2": theta2, "touching": touching, "source": source}
        for name, array in arrays.items():
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def __add__(self, other: Gesture) -> Gesture:
        """Return this gesture followed by the other."""
        return joined([self, other])

    def stamps(self, sample_rate: float) -> IntArray:
        """Return the sample nearest to the time of each event.

        Parameters
        ----------
        sample_rate : float
            Hz.

        Returns
        -------
        int64 (events,)
            Samples from the gesture's start.

        Examples
        --------
        >>> ov.tap(0.8, hold_seconds=0.5).stamps(8000)
        array([   0, 4000])
        """
        return np.rint(self.time_s * sample_rate).astype(np.int64)

    def __repr__(self) -> str:
        inputs = " and ".join(SOURCES[i] for i in np.unique(self.source))
        by = f" by {inputs}" if inputs not in ("", SOURCES[0]) else ""
        changes = f", {counted(len(self.changes), 'change')}" if self.changes else ""
        return (
            f"<Gesture: {self.duration_s:g} s, {counted(len(self.time_s), 'control event')}{by}"
            f"{changes}>"
        )


def joined(parts: Sequence[Gesture]) -> Gesture:
    """Return one or more gestures in sequence."""
    starts = list(accumulate((part.duration_s for part in parts), initial=0.0))
    return Gesture(
        np.concatenate([part.time_s + start for part, start in zip(parts, starts, strict=False)]),
        np.concatenate([part.theta2 for part in parts]),
        np.concatenate([part.touching for part in parts]),
        starts[-1],
        np.concatenate([part.source for part in parts]),
        tuple(
            replace(change, time_s=change.time_s + start)
            for part, start in zip(parts, starts, strict=False)
            for change in part.changes
        ),
    )
