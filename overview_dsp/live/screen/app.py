"""Terminal application: keys, mouse and commands control the player, whose status is displayed."""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property, partial
from typing import Any, ClassVar

from textual.app import App, ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.command import Hit, Hits
from textual.containers import Horizontal, ScrollableContainer, Vertical
from textual.events import Key
from textual.screen import ModalScreen, Screen
from textual.system_commands import SystemCommandsProvider
from textual.widgets import Static

from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import OverviewError, printable
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen import timeline_view as view
from overview_dsp.live.screen.key_actions import KeyActions, figures_text, help_text, latencies_ms
from overview_dsp.live.screen.position_report import PositionReport, finger_position, match_minute
from overview_dsp.live.screen.terminal import has_hung_up, nonblocking_driver
from overview_dsp.live.session.command_forms import FORMS
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status
from overview_dsp.units import gain_to_db

POLLS_PER_SECOND, VIEW_EVERY = 30, 3
"""Polls per second, and number of polls between two updates of the view."""

MESSAGE_S, FAULTS_EVERY_S, FULL_HEIGHT = 10.0, 60.0, 20
"""Time of a message; least time between two on late blocks, which cover a small screen's state;
height from which there are large figures, legend and signals."""

COLUMN_S, DRAWN_EVERY, MAX_COLUMNS = 0.1, 3, 400
"""Torque and vibration: time of a column, columns per update, and number that is kept."""

STEP_DB, STEPS, NAME_WIDTH, LEVEL_WIDTH = 6.0, 7, 10, 30
"""Step and number of heights of a column; widths of a signal's name and of its level."""

BESIDE_FIGURES = 14
"""Column of the texts beside large figures."""

_SCORE, _NUMBER = re.compile(r"(\d+) to (\d+)"), re.compile(r"(-?[\d.]+)(?: (.*))?")


def title(timeline: Timeline, skin: view.Skin) -> list[view.Cell]:
    """Return the title, in which the names of the teams are the key to their signs."""
    text = printable(timeline.title)
    if not timeline.sides:
        return [(text, "bold")]
    first, second = map(printable, timeline.sides)
    before, _, rest = text.partition(first)
    between, found, after = rest.partition(second)
    if not found:
        before, between, after = "", " ", f" {text}"
    names = (f"● {first}", f"{second} ○") if skin.has_utf8 else (first.upper(), second.lower())
    teams = [(names[0], "first"), (between, "bold"), (names[1], "second")]
    return [(before, "bold"), *teams, (after, "")]


def readout(
    texts: Sequence[str], event: view.Row, note: str, has_figures: bool, full: bool, width: int
) -> list[view.Row]:
    """Return the rows with value, moment, event and note, with large figures or without."""
    moment, end, value = texts
    score, number = _SCORE.fullmatch(value), _NUMBER.fullmatch(value)
    parts, large = [(value, "bold")], 0
    if score is not None:
        parts, large = [(score[1], "first"), ("-", "bold"), (score[2], "second")], 3
    elif number is not None:
        parts, large = [(number[1], "bold"), (f" {view.shortened(number[2] or '', 16)}", "")], 1
    when = view.cells((moment, "bold"), (f", {end}" if end else "", ""))
    if not full:
        row = [*view.cells(*parts, ("  " if value else "", "")), *when]
        return [row, event or view.cells((view.shortened(note, width - 2), ""))]
    tall: list[view.Row] = [view.cells(*parts), [], []]
    if has_figures and large:
        glyphs = [
            (view.TABLES["figures"][one], token) for text, token in parts[:large] for one in text
        ]
        tall = [view.cells(*((f"{rows[y]} ", token) for rows, token in glyphs)) for y in range(3)]
        tall[2] += view.cells(*parts[large:])
    at = max(BESIDE_FIGURES, *(len(row) + 2 for row in tall)) if value else 0
    beside = when, event, view.cells((view.shortened(note, width - at - 2), ""))
    return [row + view.cells((" " * (at - len(row)), "")) + one for row, one in zip(tall, beside)]  # noqa: B905


class Trace:
    """Torque and vibration of the last seconds, the newest at the right."""

    def __init__(self) -> None:
        self._past = [deque([0.0] * MAX_COLUMNS, maxlen=MAX_COLUMNS) for _ in range(2)]
        self._until, self._peaks, self._new = COLUMN_S, [0.0, 0.0], 0

    def add(self, status: Status) -> bool:
        """Add a status to the present column; return whether it is time to draw."""
        now = abs(status.torque) / status.full_torque, status.envelope
        self._peaks = list(map(max, self._peaks, now))
        if status.time_s < self._until and self._until - status.time_s <= COLUMN_S:
            return False
        for past, peak in zip(self._past, self._peaks, strict=True):
            past.append(peak)
        self._until, self._peaks = status.time_s + COLUMN_S, [0.0, 0.0]
        self._new = (self._new + 1) % DRAWN_EVERY
        return self._new == 0

    def rows(self, status: Status, hz: float, width: int) -> list[view.Row]:
        """Return the two rows, with the present level of each."""
        (no_clicks, no_tactor), rows = (one.mute for one in status.settings.signals), []
        words = f"{self._past[0][-1] * status.full_torque * 1e3:.2f} mN·m", f"{hz:g} Hz"
        for index, name in enumerate(("torque", "vibration")):
            room = max(1, width - NAME_WIDTH - LEVEL_WIDTH - 2)
            past = list(self._past[index])[-room:]
            steps = [round(STEPS + gain_to_db(one) / STEP_DB) if one > 0.0 else 0 for one in past]
            marks = [view.BLOCKS[min(step, STEPS)] if step > 0 else " " for step in steps]
            marks[::10] = [mark.replace(" ", "·") for mark in marks[::10]]
            text = ("none", "silent")[index]
            if steps[-1] > 0:
                text = f"{gain_to_db(past[-1]):.0f} dB {words[index]}".replace("-", "−")
            text = "muted" if no_tactor and index else text
            text += "  clicks muted" if no_clicks and index else ""
            colour = ("hand", "passed")[index]
            row = view.cells(
                (name.ljust(NAME_WIDTH), ""), ("".join(marks), colour), (f"  {text}", "bold")
            )
            rows.append(view.spread(width, row))
        return rows


def keys(width: int, first: str) -> view.Row:
    """Return the keys that there is room for; what to do first (`first`) is in colour."""
    right = view.cells(("?", "bold"), (" help  ", ""), ("q", "bold"), (" quit", ""))
    label = view.cells((f" {first} ", "label"), ("  ", "")) if first else []
    row: view.Row = []
    for key, word in view.TABLES["keys"]["shown"]:
        entry = view.cells((key, "bold"), (f" {word}  ", ""))
        if len(row) + len(entry) + len(label) + len(right) > width - 1:
            break
        row, label = [*row, *entry, *label], []
    return view.spread(width, [*row, *label][:-2], right)


class CommandProvider(SystemCommandsProvider):
    """Commands of the palette; a complete command that the user types is offered first."""

    async def search(self, query: str) -> Hits:
        """Yield a complete command as typed, and the choices that match."""
        app, words = self.app, query.split()
        if isinstance(app, PlayApp) and words and words[0] in FORMS and query not in app.choices:
            yield Hit(1.0, query, partial(app.player.queue_command, *words), help=FORMS[words[0]])
        async for hit in super().search(query):
            yield hit


class TextScreen(ModalScreen[None]):
    """Text that covers the timeline until any key or click."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text, self._dismissed = text, False

    def compose(self) -> ComposeResult:
        """Show the text."""
        yield ScrollableContainer(Static(self._text, markup=False))

    def on_key(self, event: Key) -> None:
        """Scroll, or close."""
        if event.key not in ("up", "down", "pageup", "pagedown"):
            self.on_click()

    def on_click(self) -> None:
        """Close once: a second key may arrive before the screen is gone."""
        if not self._dismissed:
            self._dismissed = True
            self.dismiss()


class PlayApp(App[None]):
    """Application that plays a timeline by mouse and keys."""

    CSS_PATH = "app.tcss"
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (view.PANEL_FROM, "-wide")]  # noqa: RUF012
    VERTICAL_BREAKPOINTS = [(0, "-short"), (FULL_HEIGHT, "-full")]  # noqa: RUF012
    COMMANDS: ClassVar = {CommandProvider}
    COMMAND_PALETTE_BINDING = "c"
    BINDINGS: ClassVar[list[BindingType]] = [
        *(Binding(key, action, show=False) for key, action in view.TABLES["keys"]["bound"].items()),
        *(
            Binding(key, f"press('{key}')", show=False)
            for key in view.TABLES["keys"]["same"]["names"]
        ),
    ]

    def __init__(
        self,
        player: Player,
        source: Input | None = None,
        stopped: Callable[[], bool] | None = None,
        invitation: str = "",
    ) -> None:
        driver, ansi = nonblocking_driver(self.get_driver_class()), "NO_COLOR" in os.environ
        super().__init__(driver_class=driver, ansi_color=ansi or None)
        self.skin = view.Skin(os.environ, self.console.color_system)
        self.theme = self.skin.theme
        self.player, self._source, self._stopped = player, source, stopped
        self._invitation = invitation
        self._status: Status | None = None
        self.failure: Exception | None = None
        self._ended, self._polls, self._faults = False, 0, 0
        self._faults_said = -FAULTS_EVERY_S
        self._shown: list[tuple[float, str]] = []
        self._drawn: tuple[object, ...] = ()  # surface and sizes
        self._finger: tuple[float, float] | None = None  # position and time, once it has touched
        self._trace, self._report = Trace(), PositionReport(player)
        self._actions = KeyActions(player)
        self._view = view.TimelineView(player, self.skin)
        names = ("readout", "legend", "signals", "events", "state", "keys")
        self._rows = {name: view.Cells(self.skin, id=name) for name in names}

    @cached_property
    def choices(self) -> list[str]:
        """Commands of the palette, with the present presets, actuators and devices."""
        from overview_dsp.design.presets.library import bundled_presets, user_presets
        from overview_dsp.live.output.devices import devices
        from overview_dsp.signal.actuators.library import actuator_names

        found = [f"preset {name}" for name in (*bundled_presets(), *user_presets())]
        found += [f"actuator {name}" for name in actuator_names()]
        found.append(f"window 0 {self.player.timeline.duration_s:g}")
        with contextlib.suppress(OverviewError):  # without PortAudio
            found += [f"device {device.index} {device.name}" for device in devices()]
        return [*view.TABLES["commands"]["names"], *found]

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Yield the commands of the palette."""
        for choice in self.choices:
            # a device's name after its number is only for display
            words = choice.split()[: 2 if choice.startswith("device ") else None]
            yield SystemCommand(choice, "", partial(self.player.queue_command, *words))

    def compose(self) -> ComposeResult:
        """Yield read-out, timeline, legend, torque and vibration; events; state and keys."""
        readout, legend, signals, *others = self._rows.values()
        with Horizontal():
            with Vertical():
                yield from (readout, self._view)
                if self._invitation:
                    yield Static(self._invitation.splitlines()[0], id="invitation", markup=False)
                yield from (legend, signals)
            yield others[0]
        yield from others[1:]

    def on_mount(self) -> None:
        """Poll the player thirty times per second."""
        self.set_interval(1.0 / POLLS_PER_SECOND, self._poll)

    def _poll(self) -> None:
        if self._ended:
            return
        writer = getattr(self._driver, "writer", None)
        gone = writer is not None and (writer.closed or has_hung_up(writer.fileno()))
        if gone or (self._stopped is not None and self._stopped()):
            self._end()
            return
        if writer is not None and writer.pop_skipped():
            self.refresh(layout=True)
        try:
            status = poll(self.player, self._source)
        except Exception as error:  # the command line shows it after the screen is restored
            self._end(error)
            return
        lines = [printable(line) for text in status.messages for line in text.splitlines()]
        faults = status.stream.late + status.stream.underflows + status.dropped
        self._status, now = status, time.monotonic()
        if faults > self._faults and now - self._faults_said >= FAULTS_EVERY_S:
            lines.append("blocks were late, see i")
            self._faults, self._faults_said = faults, now
        self._shown = [(since, line) for since, line in self._shown if now - since < MESSAGE_S]
        self._shown += [(now, line) for line in lines]
        self._polls += 1
        if self._trace.add(status) or self._polls % POLLS_PER_SECOND == 1:
            hz = self.player.engine.preset.number("tactor.frequency_hz")
            self._rows["signals"].draw(self._trace.rows(status, hz, self._view.size.width))
        moves = status.touching or not self.player.at_rest
        if self._polls % (VIEW_EVERY if moves else 2 * VIEW_EVERY) == 0:
            self._show(status)

    def _show(self, status: Status) -> None:
        """Draw what has changed: read-out, timeline, state and keys, and a new legend."""
        player, window, (width, height) = self.player, self.player.active_window, self.size
        picture_width = self._view.size.width
        place, drawn = finger_position(player), (player.engine.surface, self.size, self._view.size)
        is_new, self._drawn = drawn != self._drawn, drawn
        if place is not None:
            self._finger = place, player.time_at(place)
        elif is_new and self._finger is not None:  # the same moment in another window
            at = float(window.angle_map.position_of(self._finger[1] - player.window[0]))
            self._finger = min(max(at, 0.0), 1.0), self._finger[1]
        if is_new:
            self._labels = view.Labels(player, self.skin)
            self._rows["legend"].draw([self._labels.legend(picture_width)])
        last_s = window.window_timeline.known_until_s or window.window_timeline.duration_s
        finger = self._finger[0] if self._finger else float(window.angle_map.position_of(last_s))
        (moment, end, value), time_s, event = self._report.here(finger)
        minute, half = match_minute(self._labels.halves, time_s)
        end = f"minute {minute}, {half}" if minute and not end else end
        end = "where you released it" if self._finger and place is None else end
        named = [] if event is None else view.cells(*self._labels.named(event))
        source = (status.following or "") if self._source is None else self._source.status_text
        recording = f"take: {status.recording}" if status.recording else ""
        messages = list(dict.fromkeys(line for _, line in self._shown))[-2:]
        texts = [*messages, source, recording]
        scored = zip(player.timeline.sides, value.split(" to "), strict=False)
        texts.append(", ".join(f"{team} {goals}" for team, goals in scored if goals.isdigit()))
        note, large = "; ".join(filter(None, texts)), (self.skin.has_utf8, height >= FULL_HEIGHT)
        lines = [view.cells(*title(player.timeline, self.skin))]
        lines += readout((moment, end, value), named, note, *large, picture_width)
        self._rows["readout"].draw([view.spread(picture_width, line) for line in lines])
        if picture_width < width:
            self._rows["events"].draw(self._labels.panel(event, time_s, height - 2))
        shown = finger if self._finger else None
        self._view.show(is_new, status.cursor, shown, place is not None, event)
        self._rows["state"].draw([self._state(status, width)])
        first = "Esc release" if player.pointer.touching else ""
        first = "] next event" if self._finger and not status.touching else first
        first = "p stop" if status.replay is not None else first
        first = "c device" if status.state.name == "output lost" else first
        self._rows["keys"].draw([keys(width, first)])

    def _state(self, status: Status, width: int) -> view.Row:
        """Return the row with the state, its reason, and the output."""
        name, reason = status.state.name, status.state.reason
        if name == "output lost":
            text = view.shortened(f"{reason}. Plug it in, or press c", width - 14)
            return view.cells((f" Output lost  {text}".ljust(width), "lost"))
        reason = "released" if name == "no input" and self._finger else reason
        reason = self._shown[-1][1] if self.size.height < FULL_HEIGHT and self._shown else reason
        left = view.cells((name.capitalize(), "bold"), ("  ", ""))
        left += view.cells((view.shortened(reason, width - 2 - len(left)), ""))
        short = f"{sum(latencies_ms(self.player, status, self._source).values()):.1f} ms"
        delay = f"movement to output {short}"
        block = f"{status.block_size} frames, {status.sample_rate / 1e3:g} kHz, {delay}"
        rights = (f"{status.output}, {block}", block, delay, short, "")
        right = next(text for text in rights if len(left) + len(text) + 4 <= width or not text)
        return view.spread(width, left, view.cells((right, "")))

    def _end(self, failure: Exception | None = None) -> None:
        """Close the player, then the screen, which may take longer."""
        self.failure, self._ended = failure, True
        try:
            self.player.close()
        except Exception as error:
            self.failure = failure or error
        self.exit()

    async def action_quit(self) -> None:
        """End the session."""
        self._end()

    def action_press(self, key: str) -> None:
        """Run the action of a key."""
        self._actions.press(key)

    def action_remote(self) -> None:
        """Show how to connect a phone."""
        if self._invitation:
            self.push_screen(TextScreen(self._invitation))

    def action_figures(self) -> None:
        """Show the figures of the output and the signal processing, and past stops."""
        status = self._status or self.player.poll()
        text = figures_text(self.player, status, self._source, view.TABLES["words"]["figures"])
        self.push_screen(TextScreen("\n".join(map(printable, text.splitlines()))))

    def action_help(self) -> None:
        """Show the help on keys."""
        self.push_screen(TextScreen(help_text(self.player, self.skin)))


def run(player: Player, *arguments: Any) -> None:
    """Run a `PlayApp` until the user quits or it is stopped; raise errors of the player."""
    app = PlayApp(player, *arguments)
    app.run()
    if app.failure is not None:
        raise app.failure
