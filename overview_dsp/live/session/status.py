"""Status of a session, for display."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import StreamMeters
from overview_dsp.signal.actuators.stage import ProtectionReport


@dataclass(frozen=True)
class Status:
    """Status of a session at a poll.

    Parameters
    ----------
    time_s
        Time played, s.
    cursor, pointer
        Positions of the disk and of the pointer, 0 to 1.
    touching
        Whether an input touches the disk.
    torque, full_torque
        Torque, and the preset's reference torque, N·m.
    envelope, strikes
        Amplitude of the tactor (linear), and the number of strikes so far.
    peak_click, peak_tactor
        Highest output samples (linear) since the last poll.
    stream, frames_lost, dropped
        Meters of the stream, frames lost in gaps, and control events dropped.
    output, callback, sample_rate, block_size, settings
        Name of the output, kind of callback, rate (Hz), block (frames), and settings.
    protected
        Report of the actuator's protection.
    recording, replay, following
        Take that is recorded, gesture that is replayed, state of a live timeline.
    messages
        Messages for the user since the last poll.
    """

    time_s: float
    cursor: float
    pointer: float
    touching: bool
    torque: float
    full_torque: float
    envelope: float
    strikes: int
    peak_click: float
    peak_tactor: float
    stream: StreamMeters
    frames_lost: int
    dropped: int
    output: str
    callback: str
    sample_rate: float
    block_size: int
    settings: OutputSettings
    protected: ProtectionReport | None
    recording: str | None
    replay: str | None
    following: str | None
    messages: tuple[str, ...]
