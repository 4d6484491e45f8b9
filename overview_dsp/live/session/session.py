"""Session: an engine, its counters, messages for the user, state and status; the pointer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from overview_dsp.devices.messages import Messages
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import StreamMeters
from overview_dsp.signal.actuators.stage import ProtectionReport
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

if TYPE_CHECKING:
    from overview_dsp.live.output.reconnecting_stream import ReconnectingStream

STATES = ("running", "paused", "no input", "starting", "output lost")
"""Names of the states, on the screen and in lines, in JSON and OSC."""


@dataclass(frozen=True)
class SessionState:
    """State of a session; `last_stop` stays while the session runs again."""

    name: str  # one of `STATES`
    reason: str
    last_stop: str = ""  # state and reason, for example "output lost: system disconnected"

    @property
    def text(self) -> str:
        """State and reason, and the last stop if that is another one, for display."""
        text = f"{self.name.capitalize()}: {self.reason}"
        is_past = self.last_stop not in ("", f"{self.name}: {self.reason}")
        return f"{text} (last stop: {self.last_stop})" if is_past else text

    def then(self, name: str, reason: str) -> SessionState:
        """Return the next state."""
        is_stop = name in ("paused", "output lost")
        return SessionState(name, reason, f"{name}: {reason}" if is_stop else self.last_stop)


@dataclass(frozen=True)
class Status:
    """Status of a session at a poll."""

    state: SessionState
    time_s: float  # played
    cursor: float  # position of the disk, 0 to 1
    pointer: float  # position of the pointer, 0 to 1
    touching: bool  # whether an input touches the disk
    torque: float  # N m
    full_torque: float  # the preset's reference torque, N m
    envelope: float  # amplitude of the tactor, linear
    strikes: int  # number so far
    peak_click: float  # highest output sample since the last poll, linear
    peak_tactor: float
    stream: StreamMeters
    frames_lost: int  # in gaps
    dropped: int  # control events
    output: str  # name
    callback: str  # kind
    sample_rate: float  # Hz
    block_size: int  # frames
    settings: OutputSettings
    protected: ProtectionReport | None
    recording: str | None  # path of the take that is recorded
    replay: str | None  # name of the gesture that is replayed, and its pass
    following: str | None  # state of a live timeline
    messages: tuple[str, ...]  # for the user, since the last poll


class Session(Messages):
    """Engine and messages of a live session, which all parts of its player share.

    Thread: control; any thread may call `say`.

    `engine`: prepared engine; it may be restarted during the session.
    """

    def __init__(self, engine: Engine) -> None:
        super().__init__()
        self.engine = engine
        self._played_before_s = 0.0
        self._dropped_before = 0

    @property
    def played_s(self) -> float:
        """Time played since the start of the session, s."""
        return self._played_before_s + self.engine.sample_time / self.engine.sample_rate

    @property
    def dropped_events(self) -> int:
        """Control events dropped since the start of the session."""
        return self._dropped_before + self.engine.meters.dropped_events

    def keep_counts(self) -> None:
        """Keep the engine's counts; call this before the engine restarts and counts from 0."""
        self._played_before_s, self._dropped_before = self.played_s, self.dropped_events


class Pointer:
    """Input of mouse and keys to an engine.

    Thread: control.

    `position`: present or last position of the touch, 0 to 1.
    `touching`: whether the pointer touches; False after the engine restarts.
    `used`: whether the pointer has touched since the engine restarted.
    """

    def __init__(self, session: Session, output: ReconnectingStream) -> None:
        self._engine, self._output = session.engine, output
        self.position = 0.0
        self.touching = self.used = False

    def touch(self, position: float) -> None:
        """Touch at `position` (0 to 1), or move there during a touch."""
        self.position = min(max(position, 0.0), 1.0)
        self.touching = self.used = True
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
