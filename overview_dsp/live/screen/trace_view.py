"""What is felt, as it goes by: torque, the tactor's envelope and strikes of the last seconds."""

from __future__ import annotations

from collections import deque

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

from overview_dsp.live.screen.timeline_view import BLOCKS
from overview_dsp.live.status import Status
from overview_dsp.units import gain_to_db

COLUMN_S = 0.1
DRAWN_EVERY = 3
"""Columns: a terminal far away gets a third of a second at a time."""

FLOOR_DB = -60.0
NAMES = ("torque ", "tactor ", "strikes")
COLOURS = ("yellow", "green", "bright_red")
WIDEST = 400


class TraceView(Widget):
    """Three lines that move to the left; the present is on the right."""

    DEFAULT_CSS = "TraceView { height: 3; }"

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[deque[str], ...] = tuple(deque(maxlen=WIDEST) for _ in NAMES)
        self._until = COLUMN_S
        self._torque = self._tactor = 0.0
        self._strikes: int | None = None
        self._new = 0

    def show(self, status: Status) -> None:
        """Take in how it stands; draw what is new."""
        self._torque = max(self._torque, abs(status.torque) / status.full_torque)
        self._tactor = max(self._tactor, status.envelope)
        if status.time_s < self._until and self._until - status.time_s <= COLUMN_S:
            return
        self._until = status.time_s + COLUMN_S
        before = status.strikes if self._strikes is None else self._strikes
        struck = max(0, status.strikes - before)  # fewer: the engine has begun anew
        self._rows[0].append(_block(self._torque))
        self._rows[1].append(_block(self._tactor))
        self._rows[2].append(" " if not struck else "│" if struck == 1 else "┃")
        self._strikes, self._torque, self._tactor = status.strikes, 0.0, 0.0
        self._new += 1
        if self._new >= DRAWN_EVERY:
            self._new = 0
            width = max(1, self.size.width - len(NAMES[0]) - 1)
            if any(mark != " " for row in self._rows for mark in list(row)[-width - DRAWN_EVERY :]):
                self.refresh()

    def render_line(self, y: int) -> Strip:
        """The name and the latest columns of one line."""
        width = self.size.width
        room = max(0, width - len(NAMES[y]) - 1)
        marks = "".join(list(self._rows[y])[-room:]) if room else ""
        text = f"{NAMES[y]} {marks.rjust(room)}"[:width]
        split = min(len(NAMES[y]) + 1, width)
        return Strip(
            [
                Segment(text[:split], Style(dim=True)),
                Segment(text[split:], Style(color=COLOURS[y])),
            ]
        )


def _block(part: float) -> str:
    """A column's height: a part of the most, by its level in dB, as it is felt."""
    level = 1.0 - max(gain_to_db(part), FLOOR_DB) / FLOOR_DB if part > 0.0 else 0.0
    return BLOCKS[round(min(level, 1.0) * (len(BLOCKS) - 1))]
