"""Blind comparison (ABX) of the two presets of a session: is X preset A or preset B?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.session.abx import AbxTrials

if TYPE_CHECKING:
    from overview_dsp.live.session.player import Player

KEYS = {"a": ("blind", "a"), "b": ("blind", "b"), "x": ("blind", "x"),
        "A": ("blind", "is-a"), "B": ("blind", "is-b")}  # fmt: skip
"""Commands that are one key during a blind comparison."""


class BlindComparison(AbxTrials):
    """Trials in a session: A and B are its presets. Each choice restarts the engine at rest.

    Thread: control.
    """

    def __init__(
        self,
        player: Player,
        presets: Sequence[Preset],
        path: Path,
        gesture: Gesture | None = None,
        repeats: bool = True,
        seed: int | None = None,
    ) -> None:
        """Compare two presets by a gesture, or by the user's hand without one.

        `path`: new CSV file of the answers. `seed`: of the drawn presets; None: another each time.
        """
        super().__init__(path, seed)
        self._player, self._gesture, self._repeats = player, gesture, repeats
        player.active_window.presets.fix(presets)

    def run(self, word: str) -> None:
        """Play `a`, `b` or `x`, or take an answer, `is-a` or `is-b`; InputError for others."""
        if word in ("is-a", "is-b"):
            self._player.say(self.answer("ab".index(word[-1])))
        elif word in ("a", "b", "x"):
            self._choose(word)
        else:
            raise InputError(f"{word!r} must be a, b, x, is-a or is-b")

    def _choose(self, name: str) -> None:
        player, window = self._player, self._player.active_window
        if not player.output.playing:
            player.say("no output; choose again when it plays")
            return
        index = self.x if name == "x" else "ab".index(name)
        window.pop_requested_preset()
        if self._gesture is None:
            preset = window.presets.choose(index)
            player.loop.restart(window.window_timeline, window.window, preset)
        else:
            window.presets.next_choice = index
            player.loop.begin(self._gesture, name.upper(), self._repeats)
            if not player.loop.playing:  # the output doesn't respond, as was reported
                return
        self.felt_x |= name == "x"
        player.say(f"now {name.upper()}")
