"""What the keys do to the player: the same on the screen and in plain lines."""

from __future__ import annotations

from collections.abc import Callable

from overview_dsp.live.screen.help_screen import HELP
from overview_dsp.live.screen.timeline_view import STRETCHED, marks
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.status import Status

STEP = 0.01
ZOOM = 1.5


class Moves:
    """Keys to moves.

    Thread: control.
    """

    def __init__(self, player: Player, say: Callable[[str], None]) -> None:
        self._player = player
        self._say = say
        self._cursor = 0.0

    def finger(self) -> float:
        """Where the hand is, or the disk if no hand holds it."""
        # not the status: keys may come faster than it is read
        return self._player.finger if self._player.holding else self._cursor

    def look(self, status: Status) -> None:
        """How the disk is."""
        self._cursor = status.cursor

    def move(self, steps: int) -> None:
        """Move the finger by hundredths of the timeline, touching down if it isn't."""
        self._player.touch(min(max(self.finger() + steps * STEP, 0.0), 1.0))

    def hold(self) -> None:
        """Let go if the finger holds, else tap where it was last."""
        if self._player.holding:
            self._player.release()
        else:
            self._player.tap(self._player.finger)

    def zoom(self, direction: int) -> None:
        """More or less detail about the finger, or the disk if no hand holds it."""
        self._player.zoom(ZOOM if direction > 0 else 1.0 / ZOOM, self.finger())

    def press(self, key: str, status: Status) -> None:
        """Do what a key is for; an unknown one does nothing."""
        self.look(status)
        player = self._player
        actions: dict[str, Callable[[], object]] = {
            "left": lambda: self.move(-1),
            "right": lambda: self.move(1),
            "shift+left": lambda: self.move(-10),
            "shift+right": lambda: self.move(10),
            "home": lambda: player.touch(0.0),
            "end": lambda: player.touch(1.0),
            "space": self.hold,
            "enter": lambda: player.tap(player.finger),
            "escape": player.release,
            "[": lambda: player.go_to_event(-1, self.finger()),
            "]": lambda: player.go_to_event(1, self.finger()),
            "+": lambda: self.zoom(1),
            "=": lambda: self.zoom(1),
            "-": lambda: self.zoom(-1),
            "0": lambda: player.show(0.0, player.timeline.duration_s),
            "R": player.toggle_take,
            "p": player.toggle_replay,
            "P": player.toggle_replay,
            "1": lambda: player.choose_preset(0),
            "2": lambda: player.choose_preset(1),
            "m": lambda: self._mute("clicks", player.settings.click.mute, player.mute_click),
            "t": lambda: self._mute("tactor", player.settings.tactor.mute, player.mute_tactor),
            "?": lambda: self._say(help_text(player)),
        }
        if key in actions:
            actions[key]()

    def _mute(self, what: str, muted: bool, mute: Callable[[bool], None]) -> None:
        mute(not muted)
        self._say(f"{what} {'on' if muted else 'muted'}")


def help_text(player: Player) -> str:
    """The keys, and what the marks above the timeline are."""
    shown = "  ".join(f"{mark} {kind}" for mark, _, kind in marks(player)) or "no events"
    if not player.under_hand.angle_map.is_linear:
        shown += f"\n{STRETCHED} time is stretched: events lie close together there"
    return HELP.replace("MARKS", shown)
