"""Pointer of mouse and keys, which touches, moves, taps and releases."""

from __future__ import annotations

from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.session.session import Session
from overview_dsp.units import HALF_TURN


class Pointer:
    """Input of mouse and keys to an engine.

    Thread: control.

    Attributes
    ----------
    position : float
        Present or last position of its touch, 0 to 1.
    touching : bool
        Whether it touches; False after the engine restarts.
    """

    def __init__(self, session: Session, output: ReconnectingStream) -> None:
        self._engine, self._output = session.engine, output
        self.position = 0.0
        self.touching = False

    def touch(self, position: float) -> None:
        """Touch at `position` (0 to 1), or move there during a touch."""
        self.position = min(max(position, 0.0), 1.0)
        self.touching = True
        if self._output.playing:  # without an output the event would be applied too late
            self._engine.control(self.position * HALF_TURN, True)

    def release(self) -> None:
        """Release: the disk arrives at `position`, then it recoils."""
        if self.touching:
            self.force_release()

    def force_release(self) -> None:
        """Release the engine, also where `touching` is False already."""
        self.touching = False
        self._engine.control(self.position * HALF_TURN, False)

    def tap(self, position: float) -> None:
        """Step to `position` and release at once (paper, figure 6)."""
        self.release()
        self.touch(position)
        self.release()
