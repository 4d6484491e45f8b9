"""The finger of mouse and keys: it holds, moves, taps and releases."""

from __future__ import annotations

from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.session.session import Session
from overview_dsp.units import HALF_TURN


class Finger:
    """One finger on an engine's disk.

    Thread: control.

    Attributes
    ----------
    position : float
        Where it holds or held last, 0 to 1.
    holding : bool
        Whether it is down; False again once the engine begins again.
    """

    def __init__(self, session: Session, output: ReconnectingStream) -> None:
        self._engine, self._output = session.engine, output
        self.position = 0.0
        self.holding = False

    def touch(self, position: float) -> None:
        """Hold at `position` (0 to 1): a tap if it wasn't down, else it moves there."""
        self.position = min(max(position, 0.0), 1.0)
        self.holding = True
        if self._output.playing:  # else nobody would take it, and it would be stale
            self._engine.control(self.position * HALF_TURN, True)

    def release(self) -> None:
        """Release: the disk goes on to `position`, then recoils."""
        if self.holding:
            self.holding = False
            self._engine.control(self.position * HALF_TURN, False)

    def tap(self, position: float) -> None:
        """Step to `position` and release at once (paper, figure 6)."""
        self.release()
        self.touch(position)
        self.release()
