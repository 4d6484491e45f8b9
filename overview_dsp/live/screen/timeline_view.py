"""View of the timeline in the terminal: friction, events, input, disk and axis.

The disk sticks where friction is high, so its cursor lags behind the input. The shaft between the
two is drawn (the paper's pseudo-haptic effect).
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status
from overview_dsp.units import clock_text

BLOCKS = " ▁▂▃▄▅▆▇█"
MARKS = "▲◆●■✚★◇○"
COLOURS = ("green", "yellow", "cyan", "magenta", "red", "blue", "white")
NOW = "┊"
"""Mark of the time up to which a live timeline has data."""

STRETCHED = "═"
"""Mark on the axis where the angle map separates close events."""

AXIS_ROWS, INPUT_ROWS, EVENT_ROWS = 1, 1, 1
MARK_EVERY = 2
"""Updates between two marks of the disk's column, a colourful line that is slow to send."""


class TimelineView(Widget):
    """Window of the timeline, which the mouse touches."""

    DEFAULT_CSS = "TimelineView { height: 1fr; min-height: 5; }"

    def __init__(self, player: Player) -> None:
        super().__init__()
        self._player = player
        self._cursor = self._input = 0.0
        self._touching = False
        self._mark = self._updates = 0
        self._now: int | None = None
        self._stretched: list[tuple[int, int]] = []
        self._drawn: tuple[object, int, int] | None = None
        self._pressed: float | None = None

    # --- the mouse ------------------------------------------------------------------------------

    def _position(self, x: float) -> float:
        return min(max(x / max(1, self.size.width - 1), 0.0), 1.0)

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Touch at the mouse's position."""
        if event.button != 1:
            return
        self.capture_mouse()
        self._pressed = self._position(event.x)
        self._player.touch(self._pressed)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Move the touch to the mouse's position."""
        if self._pressed is not None and self._position(event.x) != self._pressed:
            self._pressed = self._position(event.x)
            self._player.touch(self._pressed)

    def on_mouse_up(self, event: events.MouseUp) -> None:
        """Release."""
        if self._pressed is None:
            return
        self.release_mouse()
        self._pressed = None
        self._player.release()

    # --- the picture ----------------------------------------------------------------------------

    def show(self, status: Status) -> None:
        """Draw the parts that have changed."""
        width = self.size.width
        now = (column(status.cursor, width), column(status.pointer, width), status.touching)
        surface = (self._player.engine.surface, self.size.width, self.size.height)
        before = (column(self._cursor, width), column(self._input, width), self._touching)
        self._cursor, self._input = status.cursor, status.pointer
        self._touching = status.touching
        self._updates += 1
        if self._drawn is None or surface != self._drawn:
            self._measure()
            self._mark = now[0]
            self._drawn = surface
            self.refresh()
            return
        if self._mark != now[0] and self._updates % MARK_EVERY == 0:
            self._refresh_line(3, self._mark, now[0])
            self._mark = now[0]
        if now != before:
            self._refresh_line(2, *now[:2], *before[:2])

    def _refresh_line(self, from_bottom: int, *columns: int) -> None:
        """Draw a line, counted from the bottom, from the first to the last of the columns."""
        first, last = min(columns), max(columns)
        self.refresh(Region(first, max(0, self.size.height - from_bottom), last - first + 1, 1))

    def _measure(self) -> None:
        """Find the height of each column of the surface, and its event mark."""
        width = max(1, self.size.width)
        surface = self._player.engine.surface
        # a column covers the positions that the mouse in it is rounded from
        positions = np.clip((np.arange(width + 1) - 0.5) / max(1, width - 1), 0.0, 1.0)
        friction = surface.resistance
        edges = (positions * (len(friction) - 1)).astype(int)
        columns = np.array(
            [friction[low : max(high, low + 1)].max() for low, high in pairwise(edges)]
        )
        # logarithmic heights: the friction of a goal is a hundred times that of the base surface
        low, high = math.log(friction.min()), math.log(friction.max())
        self._heights = (np.log(columns) - low) / max(high - low, 1e-9)
        self._marks: dict[int, tuple[str, str]] = {}
        for position, kind in zip(surface.position, surface.kind, strict=True):
            mark = (MARKS[kind % len(MARKS)], COLOURS[kind % len(COLOURS)])
            self._marks[column(float(position), width)] = mark
        until = self._player.active_window.window_timeline.known_until_s
        angle_map = self._player.active_window.angle_map
        self._now = None if until is None else column(float(angle_map.position_of(until)), width)
        self._stretched = [
            (column(first, width), column(last, width)) for first, last in angle_map.stretched()
        ]

    def render_line(self, y: int) -> Strip:
        """Return a line: events, friction columns, input and disk, or axis."""
        width, height = self.size.width, self.size.height
        if self._drawn is None or len(self._heights) != width:
            return Strip.blank(width, Style.null())
        rows = height - AXIS_ROWS - INPUT_ROWS - EVENT_ROWS
        if y == 0:
            return Strip(self._event_line(width)).simplify()
        if y == height - 1:
            return Strip([Segment(self._axis(width), Style(dim=True))])
        if y == height - 2:
            return Strip(self._input_line(width))
        return Strip(self._column_line(width, rows, rows - y)).simplify()

    def _event_line(self, width: int) -> list[Segment]:
        return [
            Segment(self._marks[x][0], Style(color=self._marks[x][1], bold=True))
            if x in self._marks
            else Segment(" ", Style.null())
            for x in range(width)
        ]

    def _column_line(self, width: int, rows: int, row: int) -> list[Segment]:
        """Return row `row` of the friction columns; row 0, the lowest, marks the disk's column."""
        parts = np.clip(self._heights * rows - row, 0.0, 1.0)
        line = []
        for x in range(width):
            block = BLOCKS[round(float(parts[x]) * (len(BLOCKS) - 1))]
            colour = self._marks[x][1] if x in self._marks else "bright_black"
            if x == self._now and block == " ":
                line.append(Segment(NOW, Style(color="bright_white")))
            elif x == self._mark and row == 0:
                line.append(Segment("│" if block == " " else block, Style(color="bright_white")))
            else:
                line.append(Segment(block, Style(color=colour)))
        return line

    def _input_line(self, width: int) -> list[Segment]:
        """Return the line of disk, shaft and input."""
        cursor, pointer = column(self._cursor, width), column(self._input, width)
        cells = [" "] * width
        if self._touching:
            for x in range(min(cursor, pointer), max(cursor, pointer) + 1):
                cells[x] = "~"
            cells[pointer] = "▼"
        cells[cursor] = "◉"
        return [Segment("".join(cells), Style(color="bright_white", bold=True))]

    def _axis(self, width: int) -> str:
        start, end = self._player.window
        angle_map = self._player.active_window.angle_map
        cells = [" "] * width
        if self._now is not None:
            first = max(0, min(self._now, width - len("now")))
            cells[first : first + len("now")] = "now"
        count = max(1, width // 16)
        for i in range(count + 1):
            time_s = (end - start) * i / count
            text = time_text(self._player, start + time_s)
            position = float(angle_map.position_of(time_s))
            at = min(round(position * (width - 1)), width - len(text))
            at = max(0, at - len(text) // 2) if 0 < i < count else max(0, at)
            if not "".join(cells[max(0, at - 1) : at + len(text) + 1]).strip():
                cells[at : at + len(text)] = text
        for first, last in self._stretched:
            for x in range(first, last + 1):
                cells[x] = STRETCHED if cells[x] == " " else cells[x]
        return "".join(cells[:width])


def column(position: float, width: int) -> int:
    """Return the column of a position (0 to 1); positions beyond an end are drawn at the end."""
    return min(max(round(position * (width - 1)), 0), max(width - 1, 0))


def time_text(player: Player, time_s: float) -> str:
    """Return a time as clock time, or as a date if the timeline has a start date."""
    from datetime import timedelta

    start = player.timeline.start
    if start is None:
        return clock_text(time_s)
    moment = start + timedelta(seconds=time_s)
    long = player.window[1] - player.window[0] > 3 * 86_400
    return moment.strftime("%Y-%m-%d" if long else "%m-%d %H:%M")


def marks(player: Player) -> list[tuple[str, str, str]]:
    """Return mark, colour and kind of the visible events, in the order of the marks."""
    surface = player.engine.surface
    events = player.active_window.window_timeline.events
    kinds = {
        int(kind): events[event].kind
        for kind, event in zip(surface.kind, surface.event, strict=True)
        if event < len(events)
    }
    return [
        (MARKS[kind % len(MARKS)], COLOURS[kind % len(COLOURS)], kinds[kind].replace("_", " "))
        for kind in sorted(kinds)
    ]
