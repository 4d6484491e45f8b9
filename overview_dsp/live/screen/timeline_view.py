"""View of the timeline in the terminal: friction, events, input, disk and axis.

Events of two teams have two lanes, the first team's above. Signs, or letters in ASCII, tell kind
and team without colour; an event of no team is in both lanes.

The disk sticks where friction is high, so its cursor lags behind the input. The shaft between the
two is drawn (the paper's pseudo-haptic effect).
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual import events
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.errors import printable
from overview_dsp.live.screen.position_report import running_scores
from overview_dsp.live.screen.terminal import has_utf8
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status
from overview_dsp.units import clock_text

BLOCKS = " ▁▂▃▄▅▆▇█"
MARKS = "▲◆●■✚★◇○"
COLOURS = ("green", "yellow", "cyan", "magenta", "red", "blue", "white")
TEAM_MARKS = {
    "goal": "●○Gg", "own_goal": "⊗⊗Oo", "withdrawn_goal": "⊖⊖Ww", "near_miss": "▲△Nn",
    "yellow_card": "■□Yy", "red_card": "▰▱Rr", "foul": "××xx", "period": "││||",
}  # fmt: skip
"""Marks of both teams by kind, and their letters in ASCII."""

OTHER_MARKS = "◆✚★◇"
TEAM_COLOURS = ("white", "color(75)", "color(212)")
"""Colours of events of no team and of the two teams: white, blue and pink."""

CARD_COLOURS = {"yellow_card": "color(221)", "red_card": "color(203)"}
SCORES_FROM, LANES_FROM = 20, 12
"""Heights of the screen from which goals have their score, and each team its lane."""

LEAST_WITH_SCORES = 8
"""Height of the view below which goals have no score."""

NOW = "┊"
"""Mark of the time up to which a live timeline has data."""

STRETCHED = "═"
"""Mark on the axis where the angle map separates close events."""

AXIS_ROWS, INPUT_ROWS = 1, 1
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
        self._drawn: tuple[object, ...] | None = None
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
        surface = (self._player.engine.surface, self.size, self.app.size)
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
        height, teams = self.app.size.height, has_teams(self._player.timeline)
        lanes = [dict[int, tuple[str, str]]() for _ in range(1 + (teams and height >= LANES_FROM))]
        # events of a team last, over those of both
        for event, kind, position in sorted(
            _visible_events(self._player), key=lambda one: one[0].side
        ):
            own = lanes[event.side - 1 :][:1] if event.side else []
            for lane in own or lanes:
                lane[column(position, width)] = mark_of(event.kind, kind, event.side, teams)
        self._marks = {x: mark for lane in lanes for x, mark in lane.items()}
        self._top = [_lane_line(lane, width, teams) for lane in lanes]
        if teams and height >= SCORES_FROM and self.size.height >= LEAST_WITH_SCORES:
            self._top = [self._score_line(1, width), *self._top, self._score_line(2, width)]
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
        rows = height - AXIS_ROWS - INPUT_ROWS - len(self._top)
        if y < len(self._top):
            return Strip(self._top[y]).simplify()
        if y == height - 1:
            return Strip([Segment(self._axis(width), Style(dim=True))])
        if y == height - 2:
            return Strip(self._input_line(width))
        return Strip(self._column_line(width, rows, height - 3 - y)).simplify()

    def _score_line(self, side: int, width: int) -> list[Segment]:
        """Return the score after each goal of a team, at its mark, as far as there is room."""
        start_s, scores = self._player.window[0], running_scores(self._player.timeline)
        found = {(goal.time_s - start_s, goal.kind, goal.label): text for goal, text in scores}
        cells = [" "] * width
        for event, _, position in _visible_events(self._player):
            text = found.get((event.time_s, event.kind, event.label), "")
            at = min(max(0, column(position, width) - len(text) // 2), max(0, width - len(text)))
            around = cells[max(0, at - 1) : at + len(text) + 1]
            if text and event.side == side and not "".join(around).strip():
                cells[at : at + len(text)] = text
        return [Segment("".join(cells[:width]), Style(bold=True))]

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


def has_teams(timeline: Timeline) -> bool:
    """Return whether events have a lane for each of two teams."""
    return bool(timeline.sides) or any(event.side for event in timeline.events)


def _visible_events(player: Player) -> Iterator[tuple[Event, int, float]]:
    """Yield the visible events in order, the numbers of their kinds, and their positions."""
    surface, events = player.engine.surface, player.engine.timeline.events
    for index, kind, position in zip(surface.event, surface.kind, surface.position, strict=True):
        if index < len(events):
            yield events[index], int(kind), float(position)


def mark_of(kind: str, number: int, side: int, teams: bool) -> tuple[str, str]:
    """Return mark and colour of an event, by its kind and team, or the number of its kind."""
    if not teams:
        return MARKS[number % len(MARKS)], COLOURS[number % len(COLOURS)]
    others = OTHER_MARKS[number % len(OTHER_MARKS)] * 2 + kind[0].upper() + kind[0]
    found = TEAM_MARKS.get(kind, others)
    mark = found[(side == 2) + (0 if has_utf8(os.environ) else 2)]
    return mark, CARD_COLOURS.get(kind, TEAM_COLOURS[side])


def _lane_line(lane: dict[int, tuple[str, str]], width: int, teams: bool) -> list[Segment]:
    blank = ("·", "bright_black") if teams else (" ", "default")
    cells = (lane.get(x, blank) for x in range(width))
    return [Segment(mark, Style(color=colour, bold=mark != blank[0])) for mark, colour in cells]


def marks(player: Player) -> list[tuple[str, str, str]]:
    """Return mark (of the first team), colour and kind of the visible events, in their order."""
    teams = has_teams(player.timeline)
    kinds = {number: event.kind for event, number, _ in _visible_events(player)}
    return [
        (*mark_of(kinds[number], number, 0, teams), kinds[number].replace("_", " "))
        for number in sorted(kinds)
    ]


def title_text(timeline: Timeline) -> Text:
    """Return the title, in which the names of the teams are the key to their marks."""
    title = printable(timeline.title)
    if not timeline.sides:
        return Text(title)
    (first, second), is_utf8 = map(printable, timeline.sides), has_utf8(os.environ)
    before, _, rest = title.partition(first)
    between, found, after = rest.partition(second)
    if not found:
        before, between, after = "", " ", f" {title}"
    names = (f"● {first}", f"{second} ○") if is_utf8 else (first.upper(), second.lower())
    return Text.assemble(
        before, (names[0], TEAM_COLOURS[1]), between, (names[1], TEAM_COLOURS[2]), after
    )
