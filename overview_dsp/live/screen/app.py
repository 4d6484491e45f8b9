"""The application: keys and mouse to the player, the player's status to the screen.

The command palette: everything that may be changed while it plays, by a few letters.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.widgets import Footer, Static

from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.help_screen import TextScreen
from overview_dsp.live.screen.moves import Moves, help_text
from overview_dsp.live.screen.terminal import has_hung_up, patient
from overview_dsp.live.screen.timeline_view import TimelineView, marks, place_words
from overview_dsp.live.screen.trace_view import MetersView, TraceView
from overview_dsp.live.session.commands import FORMS
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.status import Status
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.live.session.player import Player


def choices(player: Player) -> Iterator[tuple[str, ...]]:
    """Commands with their words, as far as these can be listed."""
    from overview_dsp.design.presets.library import bundled_presets, own_names
    from overview_dsp.errors import OverviewError
    from overview_dsp.live.output.devices import devices
    from overview_dsp.signal.actuators.library import actuator_names

    yield ("record",)
    yield ("replay",)
    for name in ("1", "2", *bundled_presets(), *own_names()):
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
        Binding("left", "move(-1)", "back", show=False),
        Binding("right", "move(1)", "move"),
        Binding("shift+left", "move(-10)", show=False),
        Binding("shift+right", "move(10)", show=False),
        Binding("home", "to(0)", show=False),
        Binding("end", "to(1)", show=False),
        Binding("space", "hold", "let go / tap"),
        Binding("enter", "tap", show=False),
        Binding("escape", "release", show=False),
        Binding("plus,equals_sign", "zoom(1)", "zoom", key_display="+ -"),
        Binding("minus", "zoom(-1)", show=False),
        Binding("0", "whole", "whole", show=False),
        Binding("left_square_bracket", "event(-1)", "event", key_display="[ ]"),
        Binding("right_square_bracket", "event(1)", show=False),
        Binding("R", "take", "take"),
        Binding("p,P", "replay", "replay"),
        Binding("1", "preset(0)", "presets", key_display="1 2"),
        Binding("2", "preset(1)", show=False),
        Binding("m", "mute_click", "mute clicks", show=False),
        Binding("t", "mute_tactor", "mute tactor", show=False),
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
        self._moves = Moves(player, lambda line: None)
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
            if self._source is not None:
                self._source.poll(self._player.engine)
            status = self._player.poll()
        except Exception as error:  # shown by the command line once the screen is given back
            self._end(error)
            return
        self._status = status
        self._moves.look(status)
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
        messages = (*status.messages, *(() if source is None else source.take_messages()))
        self._say(messages)

    def _show_marks(self) -> None:
        """Which mark is which kind of event, in the view's colours."""
        if self._player.surface is not self._marked:
            self._marked = self._player.surface
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

    # --- the hand -------------------------------------------------------------------------------

    def on_timeline_view_touched(self, message: TimelineView.Touched) -> None:
        """The mouse holds or drags."""
        self._player.touch(message.position)

    def on_timeline_view_released(self, message: TimelineView.Released) -> None:
        """The mouse releases; a click is a tap, as the disk goes all the way."""
        self._player.release()

    def action_move(self, steps: int) -> None:
        """Move the finger by hundredths of the timeline, touching down if it isn't."""
        self._moves.move(steps)

    def action_to(self, position: float) -> None:
        """Touch the start or the end."""
        self._player.touch(float(position))

    def action_hold(self) -> None:
        """Let go if the finger holds, else tap where it was last."""
        self._moves.hold()

    def action_tap(self) -> None:
        """A step to where the finger is or was last."""
        self._player.tap(self._player.finger)

    def action_release(self) -> None:
        """Let go."""
        self._player.release()

    def action_event(self, direction: int) -> None:
        """Touch the next or the previous event."""
        self._player.go_to_event(direction, self._moves.finger())

    # --- the view and the output ------------------------------------------------------------------

    def action_zoom(self, direction: int) -> None:
        """More or less detail about the finger, or the disk if no hand holds it."""
        self._moves.zoom(direction)

    def action_whole(self) -> None:
        """The whole timeline."""
        self._player.show(0.0, self._player.timeline.duration_s)

    def action_mute_click(self) -> None:
        """Clicks off or on."""
        self._player.mute_click(not self._player.settings.click.mute)

    def action_mute_tactor(self) -> None:
        """Tactor off or on."""
        self._player.mute_tactor(not self._player.settings.tactor.mute)

    def action_take(self) -> None:
        """Begin a take, or end it."""
        self._player.toggle_take()

    def action_replay(self) -> None:
        """The last take again and again, or no more."""
        self._player.toggle_replay()

    def action_preset(self, which: int) -> None:
        """One of the two presets."""
        self._player.choose_preset(which)

    def action_remote(self) -> None:
        """How a phone takes hold of the disk."""
        if self._invitation:
            self.push_screen(TextScreen(self._invitation))

    def action_help(self) -> None:
        """The keys, explained."""
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
