"""The hand of mouse and keys: a finger that holds, moves, taps and lets go."""

from __future__ import annotations

from collections.abc import Callable

from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN


class Finger:
    """One finger on an engine's disk.

    Thread: control.

    Attributes
    ----------
    position : float
        Where it holds or held last, 0 to 1.
    holding : bool
        Whether it is down.
    """

    def __init__(self, engine: Engine, heard: Callable[[], bool]) -> None:
        """`heard`: whether an output runs the engine now."""
        self._engine = engine
        self._heard = heard
        self.position = 0.0
        self.holding = False

    def touch(self, position: float) -> None:
        """Hold at `position` (0 to 1): a tap if it wasn't down, else it moves there."""
        self._hold(position)

    def release(self) -> None:
        """Release: the disk goes on to `position`, then recoils."""
        if self.holding:
            self.holding = False
            self._engine.control(self.position * HALF_TURN, False)

    def tap(self, position: float) -> None:
        """A step to `position` that is released at once (paper, figure 6)."""
        if self.holding:
            self.release()
        self._hold(position)
        self.release()

    def forget(self) -> None:
        """It isn't down: the engine has begun anew."""
        self.holding = False

    def _hold(self, position: float) -> None:
        self.position = min(max(position, 0.0), 1.0)
        self.holding = True
        if self._heard():  # else nobody would take it, and it would be stale
            self._engine.control(self.position * HALF_TURN, True)
