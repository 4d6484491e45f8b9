"""How a session stands, for whoever shows it."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import Protected


@dataclass(frozen=True)
class Status:
    """How a session stands.

    `time_s` played; `cursor` and `finger` 0 to 1; `torque` and the preset's `full_torque`, N m;
    `peak_click` and `peak_tactor` (linear, as the device got them) since the last poll; the
    output's `callbacks`, `late` ones, `underflows`, `frames` and `frames_lost` (gaps of a block and
    more); control events `dropped`; `load` (part of the time that callbacks take) and their times,
    s; what the actuator's protection did (`protected`); the take that grows (`recording`) and the
    one that plays (`replay`); the tactor's `envelope` (linear) and the `strikes` so far; how far a
    timeline that grows has come (`following`); `messages` for the person, new since the last poll.
    """

    time_s: float
    cursor: float
    finger: float
    touching: bool
    torque: float
    full_torque: float
    peak_click: float
    peak_tactor: float
    callbacks: int
    late: int
    underflows: int
    frames: int
    frames_lost: int
    dropped: int
    load: float
    median_s: float
    p99_s: float
    longest_s: float
    latency_s: float
    output: str
    callback: str
    sample_rate: float
    block_size: int
    click_muted: bool
    tactor_muted: bool
    actuator: Actuator | None
    protected: Protected | None
    recording: str | None
    replay: str | None
    envelope: float
    strikes: int
    following: str | None
    messages: tuple[str, ...]
