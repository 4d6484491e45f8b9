"""Actions of the keys, on the screen and in plain mode, and the help on them."""

from __future__ import annotations

from collections.abc import Callable

from overview_dsp.files.toml import load_toml
from overview_dsp.live.screen.timeline_view import STRETCHED, marks
from overview_dsp.live.session.player import Player

STEP = 0.01
ZOOM = 1.5

HELP: dict[str, str] = load_toml(__file__, "help.toml")
"""Help on the keys: of the full screen, and of plain mode."""


class KeyActions:
    """Actions of the keys on a player.

    Thread: control.
    """

    def __init__(self, player: Player) -> None:
        self._player = player
        self._actions: dict[str, Callable[[], object]] = {
            "left": lambda: self._move(-1),
            "right": lambda: self._move(1),
            "shift+left": lambda: self._move(-10),
            "shift+right": lambda: self._move(10),
            "home": lambda: player.touch(0.0),
            "end": lambda: player.touch(1.0),
            "space": self._release_or_tap,
            "enter": lambda: player.tap(player.pointer.position),
            "escape": player.release,
            "[": lambda: player.go_to_event(-1, self._position()),
            "]": lambda: player.go_to_event(1, self._position()),
            "+": lambda: player.zoom(ZOOM, self._position()),
            "=": lambda: player.zoom(ZOOM, self._position()),
            "-": lambda: player.zoom(1.0 / ZOOM, self._position()),
            "0": lambda: player.show(0.0, player.timeline.duration_s),
            "R": player.toggle_take,
            "p": player.toggle_replay,
            "P": player.toggle_replay,
            "n": lambda: player.queue_command("missed"),
            "k": lambda: player.queue_command("mark"),
            "u": lambda: player.queue_command("unmark"),
            "1": lambda: player.choose_preset(0),
            "2": lambda: player.choose_preset(1),
            "m": lambda: player.queue_command("mute", "click"),
            "t": lambda: player.queue_command("mute", "tactor"),
        }

    def press(self, key: str) -> bool:
        """Run the action of a key, named as in `_actions`; return whether it has one."""
        if key in self._actions:
            self._actions[key]()
        return key in self._actions

    def _position(self) -> float:
        """Return the pointer's position during its touch, otherwise the disk's."""
        player = self._player
        return player.pointer.position if player.pointer.touching else player.engine.meters.cursor

    def _move(self, steps: int) -> None:
        """Touch at a position that is `steps` hundredths of the window away."""
        self._player.touch(self._position() + steps * STEP)

    def _release_or_tap(self) -> None:
        """Release during a touch, otherwise tap at the last position."""
        if self._player.pointer.touching:
            self._player.release()
        else:
            self._player.tap(self._player.pointer.position)


def help_text(player: Player) -> str:
    """Return the help on keys and marks."""
    shown = "  ".join(f"{mark} {kind}" for mark, _, kind in marks(player)) or "no events"
    if sides := player.timeline.sides:
        shown += f"\nupper lane: {sides[0]}, lower lane: {sides[1]}"
    if not player.active_window.angle_map.is_linear:
        shown += f"\n{STRETCHED} time is stretched, because events are close together"
    return HELP["full"].replace("MARKS", shown)
