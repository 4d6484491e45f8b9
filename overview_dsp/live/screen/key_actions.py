"""Actions of the keys, on the screen and in plain mode, the help on them, and the figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from overview_dsp.files.toml import load_toml
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.timeline_view import Labels, Skin
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status

STEP = 0.01
ZOOM = 1.5

HELP: dict[str, Any] = load_toml(__file__, "help.toml")
"""Help on the keys, of the full screen and of plain mode, and what terminals send for them."""


class KeyActions:
    """Actions of the keys on a player (control thread)."""

    def __init__(self, player: Player) -> None:
        self._player = player
        self._actions: dict[str, Callable[[], object]] = {
            "home": lambda: player.touch(0.0),
            "end": lambda: player.touch(1.0),
            "space": lambda: self.press("escape" if player.pointer.touching else "enter"),
            "enter": lambda: player.tap(player.pointer.position),
            "escape": player.release,
            "[": lambda: player.go_to_event(-1, self._position()),
            "]": lambda: player.go_to_event(1, self._position()),
            "+": lambda: player.zoom(ZOOM, self._position()),
            "-": lambda: player.zoom(1.0 / ZOOM, self._position()),
            "0": lambda: player.show(0.0, player.timeline.duration_s),
            "R": player.toggle_take,
            "p": player.toggle_replay,
            "1": lambda: player.choose_preset(0),
            "2": lambda: player.choose_preset(1),
            **{key: partial(self._move, steps) for key, steps in HELP["steps"].items()},
        }
        for key, words in HELP["commands"].items():
            self._actions[key] = partial(player.queue_command, *words)

    def press(self, key: str) -> bool:
        """Run the action of a key, named as in `_actions`; return whether it has one."""
        key = HELP["same"].get(key, key)
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


def help_text(player: Player, skin: Skin) -> str:
    """Return the help on keys and signs."""
    signs = (f"{sign} {text}" for (sign, _), text in Labels(player, skin).kinds())
    shown = "  ".join(signs).replace("_", " ") or "no events"
    if sides := player.timeline.sides:
        shown += f"\nupper lane: {sides[0]}, lower lane: {sides[1]}"
    return str(HELP["full"]).replace("MARKS", shown)


def latencies_ms(player: Player, status: Status, source: Input | None) -> dict[str, float]:
    """Return the latency of each part between a movement and the output."""
    told = {} if source is None else source.report()
    parts = {"input": told["wait_p99_ms"]} if "wait_p99_ms" in told else {}
    parts["smoothing"] = 1e3 * player.engine.latency_samples / status.sample_rate
    parts["output"] = 1e3 * status.stream.latency_s
    return parts


def figures_text(player: Player, status: Status, source: Input | None, form: str) -> str:
    """Return the figures of the output and the signal processing, and past stops, in a form."""
    actuator, protected, load = status.settings.actuator, status.protected, status.stream
    parts = latencies_ms(player, status, source)
    path = " + ".join(f"{name} {ms:.1f}" for name, ms in parts.items())
    times = (sum(parts.values()), 1e6 * load.p99_s, 1e6 * load.longest_s, 1e3 * status.torque)
    text = form.format(*times, status=status, stream=load, path=path)
    text += "" if source is None else f"{source.status_text}\n"
    if actuator is not None and protected is not None:
        text += f"{actuator.name} {-protected.reduction_db:.1f} dB"
    return text
