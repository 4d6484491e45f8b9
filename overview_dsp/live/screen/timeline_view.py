"""View of the timeline: lanes, curve, groove with disk and finger, axis; signs and colours.

The curve is the timeline's own, or else the friction; it is bright behind the disk. Two teams have
two lanes; events of a series stand at its curve. The disk sticks where friction is high, and a
spring leads to the finger.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from datetime import timedelta
from itertools import groupby, zip_longest
from typing import Any

import numpy as np
from rich.cells import cell_len
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.series_events import has_values, value_text
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.ticks import KINDS, halves_of, window_ticks
from overview_dsp.errors import printable
from overview_dsp.files.toml import load_toml
from overview_dsp.live.screen import position_report as report
from overview_dsp.live.screen.terminal import has_utf8
from overview_dsp.live.session.player import Player
from overview_dsp.units import clock_text

Cell = tuple[str, str]
"""Character, or text, and name of its colour, with `!` at the end if it is reversed."""

Row = list[Cell]
TABLES: dict[str, Any] = load_toml(__file__, "signs.toml")
MAX_RUN, MARGIN, MIN_HEIGHT = 16, 2, 0.02
"""Longest run of cells that is sent again, cells beside the picture, least height of a curve."""

SCORES_FROM, LANES_FROM = 20, 12
"""Heights of the screen from which goals have their score, and each team its lane."""

PANEL, PANEL_FROM = 38, 112
"""Width of the list of events, and width of the screen from which there is one."""

BLOCKS, NOTCH = " ▁▂▃▄▅▆▇█", "─╲│╱─"
HINTS = (" Drag here with the mouse, or hold → ", " Drag, or hold → ", " Hold → ", "")


class Skin:
    """Signs and colours that a terminal can show."""

    def __init__(self, environment: Mapping[str, str], system: str | None = None) -> None:
        """Choose them by the locale, NO_COLOR, Rich's name of the colours, and COLORFGBG."""
        self.has_utf8 = has_utf8(environment)
        background = environment.get("COLORFGBG", "").rpartition(";")[2]
        name = "light" if background in ("7", "15") else "dark"
        name = "sixteen" if system in ("standard", "windows") else name
        self.name = "none" if "NO_COLOR" in environment else name
        # on an unknown background colours may be invisible: a dark one is drawn instead
        is_known = background or self.name in ("none", "sixteen")
        dark = "ansi-dark" if is_known else "textual-dark"
        self.theme = "ansi-light" if self.name == "light" else dark
        self.ahead = "░" if self.name in ("none", "sixteen") else "█"
        self._styles = {token: Style.parse(text) for token, text in TABLES[self.name].items()}

    def style(self, token: str) -> Style:
        """Return the style of a colour's name."""
        if token not in self._styles:
            self._styles[token] = self._styles[token.rstrip("!")] + Style(reverse=True)
        return self._styles[token]

    def sign(self, kind: str, number: int = 0, side: int = 1) -> Cell:
        """Return the sign of an event by its kind and team, or by the number of its kind."""
        for place, colour in (("above", "first"), ("below", "second")):
            if signs := TABLES[place].get(kind):
                return signs[not self.has_utf8], colour
        others = TABLES["other"]["signs"]
        signs = others[number % len(others)] * 2 + kind[0].upper() + kind[0]
        signs = TABLES["kinds"].get(kind, signs)
        cards = {"yellow_card": "yellow", "red_card": "red"}
        colour = cards.get(kind, ("bold", "first", "second")[side])
        return signs[(side == 2) + (0 if self.has_utf8 else 2)], colour


def cells(*parts: Cell) -> Row:
    """Return texts with their colours as cells; a wide character is followed by an empty one."""
    chars = ((char, token) for text, token in parts for char in printable(text))
    return [one for cell in chars for one in (cell, ("", cell[1]))[: cell_len(cell[0])]]


def shortened(text: str, room: int) -> str:
    """Return as many whole words of a text as there is room for; a part of a first long one."""
    words = printable(text).split()
    if cell_len(" ".join(words)) <= room:
        return " ".join(words)
    while len(words) > 1 and cell_len(" ".join(words)) >= room:
        words.pop()
    return " ".join(words).rstrip(",;:.")[: max(0, room - 1)] + "…" * (room > 0)


def spread(width: int, left: Sequence[Cell], right: Sequence[Cell] = ()) -> Row:
    """Return a row with cells at both ends; the left ones give way."""
    room = max(0, width - 2 - len(right))
    if len(left) > room - bool(right):  # no word is cut
        left = left[: max(0, room - bool(right))]
        left = left[: max((x for x, cell in enumerate(left) if cell[0] == " "), default=len(left))]
    row = [(" ", ""), *left, *[(" ", "")] * (room - len(left)), *right, (" ", "")]
    return row[:width]


class Cells(Widget):
    """Rows of cells."""

    def __init__(self, skin: Skin, **options: Any) -> None:
        super().__init__(**options)
        self.skin = skin
        self.rows: Sequence[Row] = []

    def draw(self, rows: Sequence[Row]) -> None:
        """Show rows; only the cells that differ from those before are drawn."""
        changed = []
        for y, (new, old) in enumerate(zip_longest(rows, self.rows, fillvalue=Row())):
            both = zip_longest(new, old) if new != old else ()
            spans = [x for x, (one, other) in enumerate(both) if one != other]
            changed += [Region(spans[0], y, spans[-1] - spans[0] + 1, 1)] if spans else []
        self.rows = rows
        if changed:
            self.refresh(*changed)

    def render_line(self, y: int) -> Strip:
        """Return a row in its colours."""
        row = self.rows[y] if y < len(self.rows) else []
        pieces = groupby(enumerate(row), key=lambda one: (one[1][1], one[0] // MAX_RUN))
        strip = Strip(
            Segment("".join(cell[0] for _, cell in run), self.skin.style(token))
            for (token, _), run in pieces
        )
        return strip.adjust_cell_length(self.size.width, Style.null())


def has_teams(timeline: Timeline) -> bool:
    """Return whether events have a lane for each of two teams."""
    return bool(timeline.sides) or any(event.side for event in timeline.events)


def is_marked(event: Event, timeline: Timeline) -> bool:
    """Return whether an event has a sign: not as a moment of the axis under a curve."""
    return event.kind not in KINDS or timeline.intensity is None


def visible_events(player: Player) -> Iterator[tuple[Event, int, float]]:
    """Yield the visible events in order, the numbers of their kinds, and their positions."""
    surface, events = player.engine.surface, player.engine.timeline.events
    numbers = {kind: number for number, kind in enumerate(player.timeline.kinds())}
    for index, position in zip(surface.event, surface.position, strict=True):
        if index < len(events):
            yield events[index], numbers.get(events[index].kind, 0), float(position)


class Labels:
    """Signs and names of the events of a window."""

    def __init__(self, player: Player, skin: Skin) -> None:
        self._timeline, self._skin = player.timeline, skin
        shown = [one for one in visible_events(player) if is_marked(one[0], player.timeline)]
        self._numbers = {event.kind: number for event, number, _ in shown}
        self._counts = Counter(event.kind for event, _, _ in shown)
        self._events = [event.moved(event.time_s + player.window[0]) for event, _, _ in shown]
        self._has_days = player.window[1] - player.window[0] > report.DAYS_FROM_S
        self.halves = halves_of(player.timeline.events)
        self._side = 0 if has_teams(player.timeline) else 1

    def named(self, event: Event) -> list[Cell]:
        """Return the sign of an event, a blank, and its text."""
        text = report.event_text(event, self._timeline.sides)
        number, side = self._numbers.get(event.kind, 0), self._side or event.side
        sign = self._skin.sign(event.kind, number, side)
        sign = sign if is_marked(event, self._timeline) else ("─", "")
        return [sign, (" ", ""), (text[:1].upper() + text[1:], "bold")]

    def kinds(self) -> list[tuple[Cell, str]]:
        """Return sign, and name with number of events, of each visible kind."""
        order = [*TABLES["kinds"], *TABLES["above"], *TABLES["below"], *self._counts]
        return [
            (self._skin.sign(kind, self._numbers[kind], self._side), f"{kind} {self._counts[kind]}")
            for kind in sorted(self._counts, key=order.index)
        ]

    def panel(self, event: Event | None, time_s: float, height: int) -> list[Row]:
        """Return the list of events, scrolled to a time, with the event there reversed."""
        room, before = max(1, height - 2), sum(one.time_s <= time_s for one in self._events)
        first = max(0, min(before - room // 2, len(self._events) - room))
        rows = [cells((f"│ Events {len(self._events)}", "bold"))]
        rows += [[("│", "")] for _ in range(height - 1)]
        for row, one in zip(rows[2:], self._events[first : first + room], strict=False):
            minute, _ = report.match_minute(self.halves, one.time_s)
            moment = self._timeline.moment_text(one.time_s).removesuffix(".0").split(" ")
            when = f"{minute}′" if minute else moment[0 if self._has_days else -1]
            sign, blank, (text, _) = self.named(one)
            text = shortened(text, PANEL - 6 - len(when))
            listed = spread(PANEL - 1, cells(sign, blank, (text, "")), cells((when, "")))
            if report.is_same(one, event):
                listed[1:] = (sign[0], f"{sign[1]}!"), *((char, "disk") for char, _ in listed[2:])
            row += listed
        return [row + [(" ", "")] * (PANEL - len(row)) for row in rows]

    def legend(self, width: int) -> Row:
        """Return the visible kinds, as far as there is room, and the signs of the curve."""
        curve = self._timeline.intensity
        unit = "friction" if curve is None else curve.unit
        name = unit if 0 < len(unit) <= len("beats/minute") else "curve"
        name = name if curve is None or has_values(self._timeline) else "crowd"
        ahead = (self._skin.ahead, "ahead"), (" ahead", "")
        right = cells(("█", "passed"), (f" {name}  ", ""), *ahead)
        row: Row = []
        for sign, text in self.kinds():
            entry = cells(sign, (f" {text.replace('_', ' ')}  ", ""))
            row += entry if len(row) + len(entry) + len(right) + 1 <= width else []
        return spread(width, row, right)


class TimelineView(Cells):
    """Window of the timeline, which the mouse touches."""

    def __init__(self, player: Player, skin: Skin) -> None:
        super().__init__(skin)
        self._player = player
        self._drawn: tuple[object, ...] | None = None
        self._pressed: float | None = None
        self.left, self.span = MARGIN, 1

    def column(self, position: float) -> int:
        """Return the column of a position; positions beyond an end (0, 1) are drawn at the end."""
        return self.left + min(max(round(position * (self.span - 1)), 0), self.span - 1)

    def position(self, x: float) -> float:
        """Return the position of a column."""
        return min(max((x - self.left) / max(1, self.span - 1), 0.0), 1.0)

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Touch at the mouse's position."""
        if event.button == 1:
            self.capture_mouse()
            self._pressed = self.position(event.x)
            self._player.touch(self._pressed)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Move the touch to the mouse's position."""
        if self._pressed is not None and self.position(event.x) != self._pressed:
            self._pressed = self.position(event.x)
            self._player.touch(self._pressed)

    def on_mouse_up(self, event: events.MouseUp) -> None:
        """Release."""
        if self._pressed is not None:
            self.release_mouse()
            self._pressed = None
            self._player.release()

    def show(
        self, is_new: bool, disk: float, finger: float | None, held: bool, event: Event | None
    ) -> None:
        """Draw disk and finger, the sign of the event under it, and of a new surface everything."""
        if is_new:
            self._measure()
        notch = NOTCH[round(disk * (len(NOTCH) - 1))]
        at = None if finger is None else self.column(finger)
        drawn = (self.column(disk), notch, at, held, event)
        if is_new or drawn != self._drawn:
            self._drawn = drawn
            self.draw(self._composed(*drawn))

    def _x_at(self, time_s: float) -> int:
        """Return the column of a time of the window."""
        return self.column(float(self._player.active_window.angle_map.position_of(time_s)))

    def _measure(self) -> None:
        """Make the rows without disk and finger, as they are behind the disk and ahead of it."""
        width, height = max(1, self.size.width), max(1, self.size.height)
        timeline, screen = self._player.active_window.window_timeline, self.app.size.height
        teams, places = has_teams(timeline), TABLES["above"] | TABLES["below"]
        self.left = MARGIN if width > 20 else 0
        self.span = max(1, width - 2 * self.left)
        shown = [one for one in visible_events(self._player) if is_marked(one[0], timeline)]
        kinds = Counter(event.kind for event, _, _ in shown)
        on_curve = set() if teams or timeline.intensity is None else places.keys() & kinds.keys()
        scores = int(teams and screen >= SCORES_FROM and height >= 10)
        count = 1 + (teams and screen >= LANES_FROM) if teams or kinds.keys() - on_curve else 0
        lanes = range(scores, scores + (count if height >= 3 else 0))
        self._groove, top = height - 1 - (height >= 4), len(lanes) + 2 * scores
        low = int(height >= 7 and not on_curve.isdisjoint(TABLES["below"]))
        stage = range(top, max(self._groove - low, top))
        self._first = lanes.start if lanes else top
        self._behind: list[Row] = [[(" ", "")] * width for _ in range(height)]
        self._draw_stage(stage, not on_curve.isdisjoint(TABLES["above"]))
        for y in lanes if teams else ():
            self._behind[y][self.left : self.left + self.span] = [("·", "")] * self.span
        for y, side in ((0, 1), (lanes.stop, 2)) if scores else ():
            self._draw_scores(self._behind[y], side)
        self._draw_axis()
        ahead = {(char, "passed"): (char, "ahead") for char in BLOCKS}
        if self.skin.ahead not in BLOCKS:
            ahead = {(char, "passed"): ("░" if char > "▃" else " ", "ahead") for char in BLOCKS}
        self._ahead = [[ahead.get(cell, cell) for cell in row] for row in self._behind]
        self._signs = list[tuple[Event, list[tuple[int, int]]]]()
        self._where = dict[tuple[int, int], Cell]()
        # rare kinds last, over common ones, and events of a team over those of both
        shown.sort(key=lambda one: (one[0].side, -kinds[one[0].kind]))
        for event, number, position in shown:
            x = self.column(position)
            rows = list(lanes[event.side - 1 :][:1] or lanes) if event.side else list(lanes)
            if event.kind in on_curve:
                above = max(self._tops[x - self.left] - 1, min(top, self._groove - 1))
                rows = [above if event.kind in TABLES["above"] else max(stage.stop - 1 + low, 0)]
            sign = self.skin.sign(event.kind, number, event.side if teams else 1)
            self._signs.append((event, [(y, x) for y in rows]))
            self._where.update({(y, x): sign for y in rows})
        for (y, x), sign in self._where.items():
            self._behind[y][x] = self._ahead[y][x] = sign
        for event, where in self._signs:
            curve = timeline.intensity if event.kind in ("highest", "lowest") else None
            if curve is not None and event.kind in on_curve and has_values(timeline):
                value = float(f"{float(curve.at(np.array([event.time_s]))[0]):.4g}")
                text = f"{event.kind.capitalize()} {value_text(value, curve.unit)}"
                self._draw_label(*where[0], cells((text, "bold")))

    def _draw_label(self, y: int, x: int, text: Row) -> None:
        """Write text at the right of a sign, or else at the left, where there is room."""
        for at in (x + 2, x - 1 - len(text)):
            around = "".join(char for char, _ in self._behind[y][max(at, 0) : at + len(text) + 1])
            if self.left <= at <= self.left + self.span - len(text) and not around.strip():
                for rows in (self._behind, self._ahead):
                    rows[y][at : at + len(text)] = text
                return

    def _values(self, times: FloatArray) -> FloatArray:
        """Return the curve, or the friction, at the columns, 0 to 1; NaN without data."""
        timeline, friction = self._player.active_window.window_timeline, self._player.engine.surface
        curve = timeline.intensity
        if curve is None or self.span < 2:
            edges = np.clip((np.arange(self.span) - 0.5) / max(1, self.span - 1), 0.0, 1.0)
            index = (edges * (len(friction.resistance) - 1)).astype(int)
            # logarithmic: the friction of a goal is a hundred times that of the base surface
            value = np.log(np.maximum.reduceat(friction.resistance, index))
        else:
            value = curve.band(times, timeline.gaps)[2].copy()
        until = timeline.known_until_s
        value[times > (math.inf if until is None else until)] = np.nan
        known = value[~np.isnan(value)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        if curve is not None:
            low = 0.0 if 0.0 <= low <= 0.6 * high else low - 0.1 * (high - low)
        return np.clip((value - low) / (high - low if high > low else 1.0), MIN_HEIGHT, 1.0)

    def _draw_stage(self, stage: range, has_signs: bool) -> None:
        """Draw the curve, gaps, and the time up to which there are data."""
        window = self._player.active_window
        value = self._values(window.angle_map.time_at(np.linspace(0.0, 1.0, self.span)))
        known, until = ~np.isnan(value), window.window_timeline.known_until_s
        rows = max(1, len(stage) - has_signs)
        eighths = np.ceil(8.0 * rows * np.where(known, value, 0.0)).astype(int)
        self._tops = np.where(known, stage.stop - 1 - (eighths - 1) // 8, -1).tolist()
        for y in stage:
            levels = np.clip(eighths - 8 * (stage.stop - 1 - y), 0, 8)
            line = [(BLOCKS[level], "passed") for level in levels]
            for x in np.flatnonzero(~known):
                line[x] = "╱" if (x + y) % 4 == 0 else " ", ""
            self._behind[y][self.left : self.left + self.span] = line
        for start_s, end_s in window.window_timeline.gaps if len(stage) > 2 else ():
            first, last = self._x_at(start_s), self._x_at(end_s)
            if last - first > len("no data"):
                self._write(stage.start, (first + last - len("no data")) // 2, "no data")
        self._now = self.left + self.span if until is None else self._x_at(until)
        if until is not None and stage:
            text = f" Now {self._player.timeline.moment_text(until + self._player.window[0])} "
            for y in stage:
                self._behind[y][self._now] = "│", ""
            is_beyond = self._now + 1 + len(text) <= self.left + self.span
            self._write(stage.stop - 1, self._now + 1 if is_beyond else self._now - len(text), text)

    def _write(self, y: int, x: int, text: str) -> None:
        """Write text into a row."""
        self._behind[y][max(x, 0) : max(x, 0) + len(text)] = cells((text, ""))

    def _draw_scores(self, row: Row, side: int) -> None:
        """Draw the score after each goal of a team, at its sign, as far as there is room."""
        start_s, scores = self._player.window[0], report.running_scores(self._player.timeline)
        found = {(goal.time_s - start_s, goal.kind, goal.label): text for goal, text in scores}
        for event, _, position in visible_events(self._player):
            text = found.get((event.time_s, event.kind, event.label), "")
            at = min(max(0, self.column(position) - len(text) // 2), max(0, len(row) - len(text)))
            around = "".join(char for char, _ in row[max(0, at - 1) : at + len(text) + 1])
            if text and event.side == side and not around.strip():
                row[at : at + len(text)] = cells((text, "bold"))

    def _draw_axis(self) -> None:
        """Draw groove and axis; the line of the groove changes at equal times."""
        window, end = self._player.active_window, self.left + self.span
        ticks = [(self._x_at(time_s), text) for time_s, text in self._ticks(self.span // 9 + 1)]
        gaps = [tuple(map(self._x_at, gap)) for gap in window.window_timeline.gaps]
        for x in range(self.left, end):
            line = "─━"[sum(place <= x for place, _ in ticks) % 2]
            line = " " if any(first < x < last for first, last in gaps) else line
            self._behind[self._groove][x] = "·" if x > self._now else line, ""
        uneven = "" if window.angle_map.is_linear or self.span < 60 else " uneven"
        taken = 0
        for place, text in ticks if self._groove + 1 < len(self._behind) else ():
            at = max(place - len(text) // 2, 0)
            if taken <= at <= end - len(uneven) - len(text):
                self._write(-1, at, text)
                taken = at + len(text) + 1
        if taken:
            self._write(-1, end - len(uneven), uneven)

    def _ticks(self, most: int) -> Iterator[tuple[float, str]]:
        """Yield times and texts of at most so many moments of the axis, at equal times."""
        begin, (start_s, end_s) = self._player.timeline.start, self._player.window
        start = None if begin is None else begin + timedelta(seconds=start_s)
        halves = () if begin is not None else halves_of(self._player.timeline.events)
        found = window_ticks(start, start_s, end_s - start_s, halves)
        if halves:
            if start_s == halves[0].begin_s:
                found = Event(0.0, "quarter_hour", "minute 0"), *found
            quarters = tuple(tick for tick in found if tick.kind == "quarter_hour")
            found = quarters if len(quarters) > 2 and len(found) > most else found
            # minute 45 is the beginning of the second half
            minutes = {tick.label.removeprefix("minute ").split(",")[0]: tick for tick in found}
            every = math.ceil(len(minutes) / most)
            for text, tick in [*minutes.items()][::every]:
                yield tick.time_s, text + "′" * (":" not in text)
            return
        every = math.ceil(len(found) / most) or 1
        for tick in found[every - 1 :: every]:
            text = clock_text(start_s + tick.time_s).removesuffix(".0")
            if start is not None:
                moment = start + timedelta(seconds=tick.time_s)
                text = moment.strftime(TABLES["dates"].get(tick.kind, "%H:%M")).removeprefix("0")
            yield tick.time_s, text

    def _composed(
        self, disk: int, notch: str, finger: int | None, held: bool, event: Event | None
    ) -> list[Row]:
        """Return the rows with disk, spring and finger, and before any touch a hint."""
        both = zip(self._behind, self._ahead, strict=True)
        rows = [[*one[: disk + 1], *two[disk + 1 :]] for one, two in both]
        groove, end = rows[self._groove], self.left + self.span
        middle = min(max(disk, self.left + 1), end - 2)
        if finger is not None:
            for y in range(self._first, self._groove):
                line = "╋" if self._tops[finger - self.left] == y else "┃"
                if (y, finger) not in self._where and rows[y][finger][1] != "bold":
                    rows[y][finger] = line if held else "┊", "hand"
            for x in range(min(disk, finger), max(disk, finger)) if held else ():
                groove[x] = "╱╲"[x % 2], "hand"
            groove[finger] = (" ", "hand!") if held else ("○", "hand")
        drawn = list(enumerate(cells((f" {notch} ", "disk")), middle - 1))
        if finger is None:
            hint = next(one for one in HINTS if middle + 3 + len(one) <= end or not one)
            drawn += enumerate(cells((hint, "label")), middle + 3)
        for x, cell in drawn:
            groove[max(x, 0) : max(x, 0) + 1] = [cell]
        start_s = self._player.window[0]
        for one, where in self._signs if event is not None else ():
            if report.is_same(one.moved(one.time_s + start_s), event):
                for y, x in where:
                    rows[y][x] = self._where[y, x][0], f"{self._where[y, x][1]}!"
        return rows
