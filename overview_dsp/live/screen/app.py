"""The application: keys and mouse to the player, the player's status to the screen.

The command palette: everything that may be changed while it plays, by a few letters.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.screen import ModalScreen
from textual.widgets import Footer, Static

from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.key_actions import KeyActions, help_text
from overview_dsp.live.screen.terminal import has_hung_up, patient
from overview_dsp.live.screen.timeline_view import TimelineView, marks, place_words
from overview_dsp.live.screen.trace_view import MetersView, TraceView
from overview_dsp.live.session.command_forms import FORMS
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.status import Status
from overview_dsp.signal.surface.model import Surface


def choices(player: Player) -> Iterator[tuple[str, ...]]:
    """Commands with their words, as far as these can be listed."""
    from overview_dsp.design.presets.library import bundled_presets, user_presets
    from overview_dsp.errors import OverviewError
    from overview_dsp.live.output.devices import devices
    from overview_dsp.signal.actuators.library import actuator_names

    yield ("record",)
    yield ("replay",)
    for name in ("1", "2", *bundled_presets(), *user_presets()):
        yield "preset", name
    for signal in ("click", "tactor"):
        yield "mute", signal
        for gain in range(-24, 7, 6):
            yield "gain", signal, str(gain)
    yield "window", "0", f"{player.timeline.duration_s:g}"
    try:
        found = devices()
    except OverviewError:
        found = []
    for device in found:
        yield "device", str(device.index), device.name
    yield "device", "none"
    for frames in (64, 128, 256, 512, 1024):
        yield "block-size", str(frames)
    for rate in (44_100, 48_000, 96_000):
        yield "rate", str(rate)
    for channels in (("1", "2"), ("2", "1"), ("3", "4"), ("1+2", "3+4")):
        yield "channels", *channels
    for name in ("none", *actuator_names()):
        yield "actuator", name


class Changes(Provider):
    """Commands to choose from; what is typed as a whole command is offered first."""

    @property
    def _player(self) -> Player:
        player: Player = self.app._player  # type: ignore[attr-defined]
        return player

    async def startup(self) -> None:
        """Look for presets and devices once."""
        self._choices = list(choices(self._player))

    async def search(self, query: str) -> Hits:
        """What matches; a whole command as it is typed."""
        words = tuple(query.split())
        if words and words[0] in FORMS and words not in self._choices:
            yield Hit(1.0, query, partial(self._player.ask, *words), help=FORMS[words[0]])
        matcher = self.matcher(query)
        for choice in self._choices:
            text = " ".join(choice)
            if (score := matcher.match(text)) > 0.0:
                yield Hit(score, matcher.highlight(text), self._asking(choice))

    async def discover(self) -> Hits:
        """Everything that can be listed."""
        for choice in self._choices:
            yield DiscoveryHit(" ".join(choice), self._asking(choice))

    def _asking(self, choice: tuple[str, ...]) -> partial[None]:
        # a device's name behind its number is for the person
        words = choice[:2] if choice[0] == "device" else choice
        return partial(self._player.ask, *words)


class TextScreen(ModalScreen[None]):
    """Text over the screen, closed by any key or click."""

    CSS = """
    TextScreen { align: center middle; }
    TextScreen Static { width: auto; height: auto; border: round $accent; padding: 0 1;
        background: black; color: white; }
    """
    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text = text

    def compose(self) -> ComposeResult:
        """Show the text."""
        yield Static(self._text, markup=False)

    def on_key(self) -> None:
        """Close."""
        self.dismiss()

    def on_click(self) -> None:
        """Close."""
        self.dismiss()


POLLS_A_SECOND = 30
VIEW_EVERY, METERS_EVERY = 3, 6
"""Polls: what is drawn costs a terminal that is far away its line."""

SHOWN_S = 10.0
"""How long a message is shown."""


class PlayApp(App[None]):
    """A timeline under the mouse and the keys."""

    CSS = """
    Screen { overflow: hidden; }
    #invitation { height: 1; }
    #title { height: 1; text-style: bold; }
    #legend { height: 1; }
    #messages { height: 2; color: $warning; }
    """
    COMMANDS: ClassVar = {Changes}
    COMMAND_PALETTE_BINDING = "c"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("left", "press('left')", "back", show=False),
        Binding("right", "press('right')", "move"),
        Binding("shift+left", "press('shift+left')", show=False),
        Binding("shift+right", "press('shift+right')", show=False),
        Binding("home", "press('home')", show=False),
        Binding("end", "press('end')", show=False),
        Binding("space", "press('space')", "let go / tap"),
        Binding("enter", "press('enter')", show=False),
        Binding("escape", "press('escape')", show=False),
        Binding("plus,equals_sign", "press('+')", "zoom", key_display="+ -"),
        Binding("minus", "press('-')", show=False),
        Binding("0", "press('0')", "whole", show=False),
        Binding("left_square_bracket", "press('[')", "event", key_display="[ ]"),
        Binding("right_square_bracket", "press(']')", show=False),
        Binding("R", "press('R')", "take"),
        Binding("p,P", "press('p')", "replay"),
        Binding("1", "press('1')", "presets", key_display="1 2"),
        Binding("2", "press('2')", show=False),
        Binding("m", "press('m')", "mute clicks", show=False),
        Binding("t", "press('t')", "mute tactor", show=False),
        Binding("r", "remote", show=False),
        Binding("question_mark", "help", "help"),
        Binding("q,ctrl+c", "quit", "quit"),
    ]

    def __init__(
        self,
        player: Player,
        source: Input | None = None,
        stopped: Callable[[], bool] | None = None,
        invitation: str = "",
    ) -> None:
        super().__init__(driver_class=patient(self.get_driver_class()))
        self._invitation = invitation
        self._player = player
        self._source = source
        self._stopped = stopped
        self._status: Status | None = None
        self.failure: Exception | None = None
        self._ended = False
        self._polls = 0
        self._peaks = [0.0, 0.0]
        self._said: list[tuple[float, str]] = []
        self._view = TimelineView(player)
        self._meters = MetersView()
        self._trace = TraceView()
        self._key_actions = KeyActions(player)
        self._marked: Surface | None = None
        self._legend = Static("", id="legend")
        self._words = Static("", id="messages", markup=False)

    def compose(self) -> ComposeResult:
        """Title, timeline, meters, messages, keys."""
        yield Static(self._player.timeline.title, id="title", markup=False)
        if self._invitation:
            yield Static(self._invitation.splitlines()[0], id="invitation", markup=False)
        yield self._legend
        yield self._view
        yield self._trace
        yield self._meters
        yield self._words
        yield Footer()

    def on_mount(self) -> None:
        """Look at the player thirty times a second."""
        self.set_interval(1.0 / POLLS_A_SECOND, self._poll)

    def _poll(self) -> None:
        if self._ended:
            return
        if self._stopped is not None and self._stopped():
            self._end()
            return
        writer = getattr(self._driver, "writer", None)
        if writer is not None and (writer.gone or has_hung_up(writer.fileno())):
            self._end()
            return
        if writer is not None and writer.take_left_out():
            self.refresh(layout=True)
        try:
            status = poll(self._player, self._source)
        except Exception as error:  # shown by the command line once the screen is given back
            self._end(error)
            return
        self._status = status
        self._trace.show(status)
        self._polls += 1
        if self._polls % VIEW_EVERY == 0:
            self._view.show(status)
            self._show_marks()
        source = self._source
        peaks = self._peaks
        peaks[:] = max(peaks[0], status.peak_click), max(peaks[1], status.peak_tactor)
        if self._polls % METERS_EVERY == 0:
            told = ("" if source is None else source.words, status.following or "")
            words = "; ".join(part for part in told if part)
            shown = replace(status, peak_click=peaks[0], peak_tactor=peaks[1])
            self._meters.show(shown, place_words(self._player, status.cursor), words)
            peaks[:] = 0.0, 0.0
        self._say(status.messages)

    def _show_marks(self) -> None:
        """Which mark is which kind of event, in the view's colours."""
        surface = self._player.engine.surface
        if surface is not self._marked:
            self._marked = surface
            shown = marks(self._player)
            text = Text(no_wrap=True, overflow="ellipsis")
            for mark, colour, kind in shown:
                text.append(f"{mark} ", f"bold {colour}").append(f"{kind}  ")
            text.append("◉ disk  ▼ finger", "dim")
            self._legend.update(text)

    def _say(self, messages: tuple[str, ...]) -> None:
        """Show what is new; what was read long enough goes."""
        now = time.monotonic()
        kept = [(said, line) for said, line in self._said if now - said < SHOWN_S]
        kept += [(now, line) for line in messages]
        if kept != self._said:
            self._said = kept
            self._words.update("\n".join(line for _, line in kept[-2:]))

    def _end(self, failure: Exception | None = None) -> None:
        """Fade out and save first: giving the screen back may take its time."""
        self.failure, self._ended = failure, True
        try:
            self._player.close()
        except Exception as error:
            self.failure = failure or error
        self.exit()

    async def action_quit(self) -> None:
        """The person has had enough."""
        self._end()

    def action_press(self, key: str) -> None:
        """Do what a key is for."""
        self._key_actions.press(key)

    def action_remote(self) -> None:
        """Show how a phone holds the disk."""
        if self._invitation:
            self.push_screen(TextScreen(self._invitation))

    def action_help(self) -> None:
        """Show the keys, explained."""
        self.push_screen(TextScreen(help_text(self._player)))


def run(
    player: Player,
    source: Input | None = None,
    stopped: Callable[[], bool] | None = None,
    invitation: str = "",
) -> None:
    """Show a player until the person quits or `stopped()`; errors of the player are raised.

    `invitation` is what a person needs to let another device in; its first line is always shown.
    """
    app = PlayApp(player, source, stopped, invitation)
    app.run()
    if app.failure is not None:
        raise app.failure
