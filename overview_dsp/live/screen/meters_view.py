"""What sounds and how the output is: torque, levels, callbacks."""

from __future__ import annotations

import math

from rich.text import Text
from textual.widgets import Static

from overview_dsp.live.status import Status
from overview_dsp.units import gain_to_db

BAR = 24
FLOOR_DB = -60.0
HOLD_FALL_DB = 6.0
"""How much a held peak falls at each poll."""


class MetersView(Static):
    """Three bars (torque, click, tactor) and a line about the output."""

    DEFAULT_CSS = "MetersView { height: auto; min-height: 5; }"

    def __init__(self) -> None:
        super().__init__()
        self._held = [FLOOR_DB, FLOOR_DB]
        self._shown = ""

    def show(self, status: Status, here: str, source: str = "") -> None:
        """Write the meters; `here` names what is under the cursor, `source` is the input's line."""
        text = Text()
        part = min(abs(status.torque) / status.full_torque, 1.0)
        text.append("torque ").append(bar(part), "yellow")
        text.append(f" {status.torque * 1e3:+7.3f} mN·m   ").append(here, "bold")
        peaks = ((status.peak_click, status.click_muted), (status.peak_tactor, status.tactor_muted))
        for index, (name, (peak, muted)) in enumerate(
            zip(("click ", "tactor"), peaks, strict=True)
        ):
            level = max(gain_to_db(peak), FLOOR_DB)
            held = self._held[index] = max(level, self._held[index] - HOLD_FALL_DB, FLOOR_DB)
            text.append(f"\n{name} ").append(bar(1.0 - held / FLOOR_DB), "green")
            text.append(f" {level_text(held)}" + ("   muted" if muted else ""))
        text.append(
            f"\n{status.output}, {status.callback} callback, {status.sample_rate:g} Hz, "
            f"{status.block_size} frames, latency {status.latency_s * 1e3:.1f} ms"
        )
        if status.actuator is not None and status.protected is not None:
            text.append(f", {status.actuator.name} {-status.protected.taken_db:.1f} dB")
        faults = status.late + status.underflows + status.dropped
        text.append(
            f"\nDSP load {100.0 * status.load:.1f} %, p99 {1e6 * status.p99_s:.0f} µs, "
            f"max {1e6 * status.longest_s:.0f} µs; {status.late} late, {status.underflows} "
            f"underflows, {status.frames_lost} lost, {status.dropped} dropped",
            "red" if faults else "dim",
        )
        if source:
            text.append(f"\n{source}", "dim")
        if text.plain != self._shown:
            self._shown = text.plain
            self.update(text)


def bar(part: float) -> str:
    """A bar of `BAR` cells, `part` (0 to 1) of it filled."""
    filled = round(part * BAR)
    return "█" * filled + "·" * (BAR - filled)


def level_text(db: float) -> str:
    """A level, or silence at the meter's floor."""
    return "  silent" if db <= FLOOR_DB or math.isinf(db) else f"{db:6.1f} dBFS"
