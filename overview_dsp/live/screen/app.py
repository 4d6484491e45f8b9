"""Terminal application: keys and mouse control the player, whose status is displayed.

Its command palette has all commands of a session.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.containers import ScrollableContainer
from textual.events import Key
from textual.screen import ModalScreen
from textual.widgets import Footer, Static

from overview_dsp.errors import printable
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.key_actions import KeyActions, help_text
from overview_dsp.live.screen.position_report import PositionReport, event_text, finger_position
from overview_dsp.live.screen.terminal import has_hung_up, nonblocking_driver
from overview_dsp.live.screen.timeline_view import TimelineView, marks, title_text
from overview_dsp.live.screen.trace_view import MetersView, TraceView
from overview_dsp.live.session.command_forms import FORMS
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status
from overview_dsp.signal.surface.model import Surface


def choices(player: Player) -> Iterator[tuple[str, ...]]:
    """Yield commands with words that can be listed, such as presets and devices."""
    from overview_dsp.design.presets.library import bundled_presets, user_presets
    from overview_dsp.errors import OverviewError
    from overview_dsp.live.output.devices import devices
    from overview_dsp.signal.actuators.library import actuator_names

    yield from (("record",), ("replay",))
    presets = ("1", "2", *bundled_presets(), *user_presets())
    yield from (("preset", name) for name in presets)
    for signal in ("click", "tactor"):
        yield "mute", signal
        yield from (("gain", signal, str(gain)) for gain in range(-24, 7, 6))
    yield "window", "0", f"{player.timeline.duration_s:g}"
    with contextlib.suppress(OverviewError):  # without PortAudio
        yield from (("device", str(device.index), device.name) for device in devices())
    yield "device", "none"
    yield from (("block-size", frames) for frames in ["64", "128", "256", "512", "1024"])
    yield from (("rate", rate) for rate in ("44100", "48000", "96000"))
    channels = (("1", "2"), ("2", "1"), ("3", "4"), ("1+2", "3+4"))
    yield from (("channels", *pair) for pair in channels)
    yield from (("actuator", name) for name in ("none", *actuator_names()))


class CommandProvider(Provider):
    """Commands of the palette; a complete command that the user types is offered first."""

    @property
    def _player(self) -> Player:
        player: Player = self.app._player  # type: ignore[attr-defined]
        return player

    async def startup(self) -> None:
        """Find presets and devices once."""
        self._choices = list(choices(self._player))

    async def search(self, query: str) -> Hits:
        """Yield a complete command as typed, and the choices that match."""
        words = tuple(query.split())
        if words and words[0] in FORMS and words not in self._choices:
            yield Hit(1.0, query, partial(self._player.queue_command, *words), help=FORMS[words[0]])
        matcher = self.matcher(query)
        for choice in self._choices:
            text = " ".join(choice)
            if (score := matcher.match(text)) > 0.0:
                yield Hit(score, matcher.highlight(text), self._action(choice))

    async def discover(self) -> Hits:
        """Yield all choices."""
        for choice in self._choices:
            yield DiscoveryHit(" ".join(choice), self._action(choice))

    def _action(self, choice: tuple[str, ...]) -> partial[None]:
        # a device's name after its number is only for display
        words = choice[:2] if choice[0] == "device" else choice
        return partial(self._player.queue_command, *words)


class TextScreen(ModalScreen[None]):
    """Text that covers the screen until any key or click."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text, self._dismissed = text, False

    def compose(self) -> ComposeResult:
        """Show the text."""
        with ScrollableContainer():
            yield Static(self._text, markup=False)

    def on_key(self, event: Key) -> None:
        """Scroll, or close."""
        if event.key not in ("up", "down", "pageup", "pagedown"):
            self.on_click()

    def on_click(self) -> None:
        """Close once: a second key may arrive before the screen is gone."""
        if not self._dismissed:
            self._dismissed = True
            self.dismiss()


POLLS_PER_SECOND = 30
VIEW_EVERY, METERS_EVERY = 3, 6
"""Polls between two updates of the views; fewer updates suit slow terminal connections."""

MESSAGE_S = 10.0
"""Time that a message is shown."""

HINT = "Drag with the mouse, or hold → to move"
"""Shown until the first touch."""


class PlayApp(App[None]):
    """Application that plays a timeline by mouse and keys."""

    CSS_PATH = "app.tcss"
    VERTICAL_BREAKPOINTS = [(0, "-short"), (20, "-tall")]  # noqa: RUF012
    COMMANDS: ClassVar = {CommandProvider}
    COMMAND_PALETTE_BINDING = "c"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("question_mark", "help", "help"),
        Binding("q,ctrl+c", "quit", "quit"),
        Binding("left", "press('left')", "back", show=False),
        Binding("right", "press('right')", "move"),
        Binding("space", "press('space')", "release / tap"),
        Binding("plus,equals_sign", "press('+')", "zoom", key_display="+ -"),
        Binding("left_square_bracket", "press('[')", "event", key_display="[ ]"),
        Binding("R", "press('R')", "take"),
        Binding("p,P", "press('p')", "replay"),
        Binding("1", "press('1')", "presets", key_display="1 2"),
        *(
            Binding(key, f"press('{key}')", show=False)
            for key in ("shift+left", "shift+right", "home", "end", "enter", "escape", *"20mt")
        ),
        Binding("minus", "press('-')", show=False),
        Binding("right_square_bracket", "press(']')", show=False),
        Binding("r", "remote", show=False),
    ]

    def __init__(
        self,
        player: Player,
        source: Input | None = None,
        stopped: Callable[[], bool] | None = None,
        invitation: str = "",
    ) -> None:
        super().__init__(driver_class=nonblocking_driver(self.get_driver_class()))
        self._invitation = invitation
        self._player = player
        self._source = source
        self._stopped = stopped
        self._status: Status | None = None
        self.failure: Exception | None = None
        self._ended = False
        self._polls = 0
        self._peaks = [0.0, 0.0]
        self._shown: list[tuple[float, str]] = [(math.inf, HINT)]
        self._view = TimelineView(player)
        self._meters = MetersView()
        self._trace = TraceView()
        self._message_text = ""
        self._report = PositionReport(player)
        self._key_actions = KeyActions(player)
        self._legend_surface: Surface | None = None
        self._legend = Static("", id="legend")
        self._title = Static(title_text(player.timeline), id="title")
        self._message_lines = Static("", id="messages", markup=False)
        self._state_line = Static("", id="state", markup=False)

    def compose(self) -> ComposeResult:
        """Yield title, legend, timeline, meters, messages and keys."""
        yield self._title
        if self._invitation:
            yield Static(self._invitation.splitlines()[0], id="invitation", markup=False)
        yield self._legend
        yield self._view
        yield self._trace
        yield self._meters
        yield self._message_lines
        yield self._state_line
        yield Footer()

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
            status = poll(self._player, self._source)
        except Exception as error:  # the command line shows it after the screen is restored
            self._end(error)
            return
        if self._status is None or status.state != self._status.state:
            self._state_line.update(status.state.text)
            self._state_line.set_class(status.state.name == "output lost", "lost")
        self._status = status
        self._trace.show(status)
        self._polls += 1
        if self._polls % VIEW_EVERY == 0:
            self._view.show(status)
            self._show_legend()
        source = self._source
        peaks = self._peaks
        peaks[:] = max(peaks[0], status.peak_click), max(peaks[1], status.peak_tactor)
        if self._polls % METERS_EVERY == 0:
            texts = ("" if source is None else source.status_text, status.following or "")
            finger = finger_position(self._player)
            place, _, event = self._report.here(status.cursor if finger is None else finger)
            words = "" if event is None else event_text(event, self._player.timeline.sides)
            with_peaks = replace(status, peak_click=peaks[0], peak_tactor=peaks[1])
            self._meters.show(
                with_peaks,
                printable(f"{place}  {words}".rstrip()),
                printable("; ".join(filter(None, texts))),
            )
            peaks[:] = 0.0, 0.0
        if status.touching and self._shown[:1] == [(math.inf, HINT)]:
            self._shown = self._shown[1:]
        self._show_messages(status.messages)

    def _show_legend(self) -> None:
        """Show the title, and the mark of each event kind in the colours of the view."""
        surface = self._player.engine.surface
        if surface is not self._legend_surface:
            self._legend_surface = surface
            text = Text(no_wrap=True, overflow="ellipsis")
            for mark, colour, kind in marks(self._player):
                text.append(f"{mark} ", f"bold {colour}").append(f"{kind}  ")
            text.append("◉ disk  ▼ input", "dim")
            self._legend.update(text)
            self._title.update(title_text(self._player.timeline))

    def _show_messages(self, messages: tuple[str, ...]) -> None:
        """Show new messages, and remove old ones."""
        now = time.monotonic()
        shown = [(since, line) for since, line in self._shown if now - since < MESSAGE_S]
        shown += [(now, printable(line)) for text in messages for line in text.splitlines()]
        text = "\n".join(line for _, line in shown[-2:])
        if text != self._message_text:
            self._message_text = text
            self._message_lines.update(text)
        self._shown = shown

    def _end(self, failure: Exception | None = None) -> None:
        """Close the player, then the screen, which may take longer."""
        self.failure, self._ended = failure, True
        try:
            self._player.close()
        except Exception as error:
            self.failure = failure or error
        self.exit()

    async def action_quit(self) -> None:
        """End the session."""
        self._end()

    def action_press(self, key: str) -> None:
        """Run the action of a key."""
        self._key_actions.press(key)

    def action_remote(self) -> None:
        """Show how to connect a phone."""
        if self._invitation:
            self.push_screen(TextScreen(self._invitation))

    def action_help(self) -> None:
        """Show the help on keys."""
        self.push_screen(TextScreen(help_text(self._player)))


def run(
    player: Player,
    source: Input | None = None,
    stopped: Callable[[], bool] | None = None,
    invitation: str = "",
) -> None:
    """Run the application until the user quits or `stopped()`; raise errors of the player.

    `invitation` explains how to connect another device. Its first line is always shown.
    """
    app = PlayApp(player, source, stopped, invitation)
    app.run()
    if app.failure is not None:
        raise app.failure
