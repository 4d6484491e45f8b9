"""Status of a session, for whoever shows it."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import StreamMeters
from overview_dsp.signal.actuators.stage import ProtectionReport


@dataclass(frozen=True)
class Status:
    """Status of a session, as of a poll.

    `time_s` played; `cursor` and `finger` 0 to 1; `torque` and the preset's `full_torque`, N m; the
    tactor's `envelope` (linear) and the `strikes` so far; `peak_click` and `peak_tactor` (linear,
    as the device got them) since the last poll; the meters of its `stream` and the `frames_lost`
    (gaps of a block and more); control events `dropped`; name, callback and `settings` of the
    `output`; what the actuator's protection did (`protected`); the take that grows (`recording`)
    and the one that plays (`replay`); how far a timeline that grows has come (`following`);
    `messages` for the user, new since the last poll.
    """

    time_s: float
    cursor: float
    finger: float
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
