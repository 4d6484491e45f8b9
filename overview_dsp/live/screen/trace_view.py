"""Views of the last seconds (torque, tactor envelope, strikes) and of the meters."""

from __future__ import annotations

import math
from collections import deque

from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Static

from overview_dsp.live.screen.timeline_view import BLOCKS
from overview_dsp.live.session.session import Status
from overview_dsp.units import gain_to_db

COLUMN_S = 0.1
DRAWN_EVERY = 3
"""Number of new columns per update, for slow terminal connections."""

FLOOR_DB = -60.0
NAMES = ("torque ", "tactor ", "strikes")
COLOURS = ("yellow", "green", "bright_red")
WIDEST = 400


class TraceView(Widget):
    """Three lines that scroll to the left, with the present on the right."""

    DEFAULT_CSS = "TraceView { height: 3; }"

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[deque[str], ...] = tuple(deque(maxlen=WIDEST) for _ in NAMES)
        self._until = COLUMN_S
        self._torque = self._tactor = 0.0
        self._strikes: int | None = None
        self._new = 0

    def show(self, status: Status) -> None:
        """Add a status to the present column; draw completed columns."""
        self._torque = max(self._torque, abs(status.torque) / status.full_torque)
        self._tactor = max(self._tactor, status.envelope)
        if status.time_s < self._until and self._until - status.time_s <= COLUMN_S:
            return
        self._until = status.time_s + COLUMN_S
        before = status.strikes if self._strikes is None else self._strikes
        strikes = max(0, status.strikes - before)  # a restarted engine counts from 0
        self._rows[0].append(_block(self._torque))
        self._rows[1].append(_block(self._tactor))
        self._rows[2].append(" " if not strikes else "│" if strikes == 1 else "┃")
        self._strikes, self._torque, self._tactor = status.strikes, 0.0, 0.0
        self._new += 1
        if self._new >= DRAWN_EVERY:
            self._new = 0
            width = max(1, self.size.width - len(NAMES[0]) - 1)
            if any(mark != " " for row in self._rows for mark in list(row)[-width - DRAWN_EVERY :]):
                self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return the name and the latest columns of one line."""
        width = self.size.width
        room = max(0, width - len(NAMES[y]) - 1)
        marks = "".join(list(self._rows[y])[-room:]) if room else ""
        text = f"{NAMES[y]} {marks.rjust(room)}"[:width]
        split = min(len(NAMES[y]) + 1, width)
        name = Segment(text[:split], Style(dim=True))
        return Strip([name, Segment(text[split:], Style(color=COLOURS[y]))])


def _block(part: float) -> str:
    """Return a block whose height is the level in dB of a fraction of full scale."""
    level = 1.0 - max(gain_to_db(part), FLOOR_DB) / FLOOR_DB if part > 0.0 else 0.0
    return BLOCKS[round(min(level, 1.0) * (len(BLOCKS) - 1))]


BAR = 24
NARROW = 70
"""Width (cells) below which the position has a row of its own."""

HOLD_FALL_DB = 6.0
"""Fall of a held peak per update."""


class MetersView(Static):
    """Three bars (torque, click, tactor) and lines on the output and the input."""

    DEFAULT_CSS = "MetersView { height: auto; min-height: 5; }"

    def __init__(self) -> None:
        super().__init__()
        self._held = [FLOOR_DB, FLOOR_DB]
        self._shown = ""

    def show(self, status: Status, position: str, source: str = "") -> None:
        """Write the meters, the text of the position and the status of the input."""
        text, stream = Text(), status.stream
        part = min(abs(status.torque) / status.full_torque, 1.0)
        narrow = self.size.width < NARROW
        if narrow:
            text.append(f"{position}\n", "bold")
        text.append("torque ").append(bar(part), "yellow")
        text.append(f" {status.torque * 1e3:+7.3f} mN·m   ")
        if not narrow:
            text.append(position, "bold")
        click, tactor = status.settings.signals
        rows = (("click ", status.peak_click, click), ("tactor", status.peak_tactor, tactor))
        for index, (name, peak, signal) in enumerate(rows):
            level = max(gain_to_db(peak), FLOOR_DB)
            held = self._held[index] = max(level, self._held[index] - HOLD_FALL_DB, FLOOR_DB)
            text.append(f"\n{name} ").append(bar(1.0 - held / FLOOR_DB), "green")
            text.append(f" {level_text(held)}" + ("   muted" if signal.mute else ""))
        text.append(
            f"\n{status.output}, {status.callback} callback, {status.sample_rate:g} Hz, "
            f"{status.block_size} frames, latency {stream.latency_s * 1e3:.1f} ms"
        )
        if status.settings.actuator is not None and status.protected is not None:
            text.append(
                f", {status.settings.actuator.name} {-status.protected.reduction_db:.1f} dB"
            )
        faults = stream.late + stream.underflows + status.dropped
        text.append(
            f"\nDSP load {100.0 * stream.load:.1f} %, p99 {1e6 * stream.p99_s:.0f} µs, "
            f"max {1e6 * stream.longest_s:.0f} µs; {stream.late} late, {stream.underflows} "
            f"underflows, {status.frames_lost} lost, {status.dropped} dropped",
            "red" if faults else "dim",
        )
        if source:
            text.append(f"\n{source}", "dim")
        if text.plain != self._shown:
            self._shown = text.plain
            self.update(text)


def bar(part: float) -> str:
    """Return a bar of `BAR` cells, of which the fraction `part` (0 to 1) is filled."""
    filled = round(part * BAR)
    return "█" * filled + "·" * (BAR - filled)


def level_text(db: float) -> str:
    """Return the text of a level, or of silence at the meter's floor."""
    return "  silent" if db <= FLOOR_DB or math.isinf(db) else f"{db:6.1f} dBFS"
