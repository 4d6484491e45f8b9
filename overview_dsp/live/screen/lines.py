"""The session as plain lines, for a screen reader or a terminal of any sort: the same keys.

A line says where the disk is, and the event it is on, when that has changed and the hand rests;
what a key did is said at once.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from collections.abc import Callable, Iterator

from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.key_actions import KeyActions
from overview_dsp.live.screen.timeline_view import place_words
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.status import Status

LOOK_EVERY_S = 0.03
RESTED_S = 0.25
"""How long the disk has stayed on one place before that is said."""

ESCAPES = {
    "[C": "right", "[D": "left", "[H": "home", "[F": "end", "OC": "right", "OD": "left",
    "[1~": "home", "[4~": "end", "[1;2C": "shift+right", "[1;2D": "shift+left",
}  # fmt: skip
NAMES = {" ": "space", "\r": "enter", "\n": "enter", "\x03": "q"}


def keys_of(text: str) -> Iterator[str]:
    """The names of the keys in what a terminal sent."""
    while text:
        if text[0] != "\x1b":
            yield NAMES.get(text[0], text[0])
            text = text[1:]
            continue
        sequence = next(
            (one for one in sorted(ESCAPES, key=len, reverse=True) if text[1:].startswith(one)), ""
        )
        yield ESCAPES.get(sequence, "escape")
        text = text[1 + len(sequence) :]


def run(
    player: Player,
    source: Input | None,
    stopped: Callable[[], bool],
    say: Callable[[str], None] = lambda line: print(line, flush=True),
) -> None:
    """Play until `q` or `stopped()`; errors of the player are raised."""
    actions = KeyActions(player, say)
    say(f"{player.timeline.title}. ? for the keys, q to quit.")
    said = seen = ""
    since = time.monotonic()
    with _raw_keys() as read:
        while not stopped():
            status = poll(player, source)
            for line in status.messages:
                say(line)
            for key in keys_of(read()):
                if key == "q":
                    player.close()
                    return
                actions.press(key)
            words = _words(player, status)
            if words != seen:
                seen, since = words, time.monotonic()
            if seen != said and time.monotonic() - since >= RESTED_S:
                said = seen
                say(said)
        player.close()


def _words(player: Player, status: Status) -> str:
    place = place_words(player, status.cursor)
    return place if status.touching else f"{place}, let go"


@contextlib.contextmanager
def _raw_keys() -> Iterator[Callable[[], str]]:
    """Reads the keys that were pressed, waiting a little for one, without a line's end."""
    file = sys.stdin.fileno()
    try:
        import termios
        import tty
    except ImportError:  # where a console has no such mode: whole lines
        yield lambda: sys.stdin.readline()
        return
    before = termios.tcgetattr(file)
    tty.setcbreak(file)

    def read() -> str:
        if not select.select([file], [], [], LOOK_EVERY_S)[0]:
            return ""
        data = os.read(file, 1024)
        if not data:  # closed
            return "q"
        return data.decode("utf-8", "replace")

    try:
        yield read
    finally:
        with contextlib.suppress(termios.error):
            termios.tcsetattr(file, termios.TCSANOW, before)
