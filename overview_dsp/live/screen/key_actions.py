"""Actions of the keys, which are the same on the screen and in plain lines, and their help."""

from __future__ import annotations

from collections.abc import Callable

from overview_dsp.live.screen.timeline_view import STRETCHED, marks
from overview_dsp.live.session.player import Player

STEP = 0.01
ZOOM = 1.5

HELP = """\
drag         the finger holds the disk and pulls it over the surface
click        a tap: everything up to that point, then let go
release      let go: the disk recoils

left right   move the finger (with shift, ten times as far)
Home End     touch the start, the end
space        let go; or tap, if nothing holds
Enter        tap where the finger was last
Escape       let go
[ ]          touch the previous, the next event
+ -  0       zoom about the disk; the whole
R            begin a take, end it
P            play the last take in a loop, or stop
1 2          the first, the second preset: from the loop's start
             on; pressed again: at once
c            change preset, window, gains, device, block size, rate,
             channels, actuator
m t          mute the clicks, the tactor
r            the address for a phone (with --remote)
q            quit

MARKS
▼ finger  ~ spring  ◉ disk: it sticks where friction is high

any key closes this"""


class KeyActions:
    """What each key does to the player; keys are named as in `press`.

    Thread: control.
    """

    def __init__(self, player: Player, say: Callable[[str], None] = lambda line: None) -> None:
        """`say` shows what a key did where nothing else shows it."""
        self._player, self._say = player, say
        self._actions: dict[str, Callable[[], object]] = {
            "left": lambda: self._move(-1),
            "right": lambda: self._move(1),
            "shift+left": lambda: self._move(-10),
            "shift+right": lambda: self._move(10),
            "home": lambda: player.touch(0.0),
            "end": lambda: player.touch(1.0),
            "space": self._hold,
            "enter": lambda: player.tap(player.finger.position),
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
            "1": lambda: player.choose_preset(0),
            "2": lambda: player.choose_preset(1),
            "m": lambda: self._mute("click", "clicks"),
            "t": lambda: self._mute("tactor", "tactor"),
            "?": lambda: self._say(help_text(player)),
        }

    def press(self, key: str) -> None:
        """Do what a key is for; an unknown one does nothing."""
        if key in self._actions:
            self._actions[key]()

    def _position(self) -> float:
        """Where the finger is, or the disk if it isn't down."""
        player = self._player
        return player.finger.position if player.finger.holding else player.engine.meters.cursor

    def _move(self, steps: int) -> None:
        """Move the finger by hundredths of the timeline, touching down if it isn't."""
        self._player.touch(min(max(self._position() + steps * STEP, 0.0), 1.0))

    def _hold(self) -> None:
        """Release if the finger holds, else tap where it was last."""
        if self._player.finger.holding:
            self._player.release()
        else:
            self._player.tap(self._player.finger.position)

    def _mute(self, signal: str, what: str) -> None:
        muted = getattr(self._player.output.settings, signal).mute
        self._player.output.mute(signal, not muted)
        self._say(f"{what} {'on' if muted else 'muted'}")


def help_text(player: Player) -> str:
    """Return the keys, and what the marks above the timeline are."""
    shown = "  ".join(f"{mark} {kind}" for mark, _, kind in marks(player)) or "no events"
    if not player.active_window.angle_map.is_linear:
        shown += f"\n{STRETCHED} time is stretched: events lie close together there"
    return HELP.replace("MARKS", shown)
