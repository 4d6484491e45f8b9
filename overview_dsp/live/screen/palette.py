"""The command palette: everything that may be changed while it plays, by a few letters."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from textual.command import DiscoveryHit, Hit, Hits, Provider

from overview_dsp.live.commands import FORMS

if TYPE_CHECKING:
    from overview_dsp.live.player import Player


def choices(player: Player) -> Iterator[tuple[str, ...]]:
    """Commands with their words, as far as these can be listed."""
    from overview_dsp.design.presets.library import bundled_presets, own_names
    from overview_dsp.errors import OverviewError
    from overview_dsp.live.output_devices import devices
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
