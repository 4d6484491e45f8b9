"""Where the disk is, in words, and which mark stands for which kind of event."""

from __future__ import annotations

from overview_dsp.live.player import Player
from overview_dsp.live.screen.timeline_view import COLOURS, MARKS, axis_text


def place_words(player: Player, cursor: float) -> str:
    """The moment under the cursor (0 to 1), and the event whose surface it is on."""
    words = axis_text(player, player.moment_s(cursor))
    surface = player.surface
    for span, event in zip(surface.span, surface.event, strict=True):
        if span[0] <= cursor <= span[1]:
            there = player.shown.events[event]
            return f"{words}  {there.kind} {there.words}".rstrip()
    return words


def marks(player: Player) -> list[tuple[str, str, str]]:
    """Mark, colour and kind of the events that are shown, in the order of the marks."""
    surface = player.surface
    kinds = {
        int(kind): player.shown.events[event].kind
        for kind, event in zip(surface.kind, surface.event, strict=True)
        if event < len(player.shown.events)
    }
    return [
        (MARKS[kind % len(MARKS)], COLOURS[kind % len(COLOURS)], kinds[kind].replace("_", " "))
        for kind in sorted(kinds)
    ]
