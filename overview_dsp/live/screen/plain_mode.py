"""Plain mode: a session as lines of text, for screen readers and simple terminals.

The keys are those of the full screen. A line reports the disk's position and event after both have
stayed the same for a short time. Actions of keys are reported at once.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator

from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.key_actions import KeyActions
from overview_dsp.live.screen.timeline_view import position_text
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import Player

POLL_EVERY_S = 0.03
STABLE_S = 0.25
"""Time that the position text stays the same before it is reported."""

ESCAPES = {
    "[C": "right", "[D": "left", "[H": "home", "[F": "end", "OC": "right", "OD": "left",
    "[1~": "home", "[4~": "end", "[1;2C": "shift+right", "[1;2D": "shift+left",
}  # fmt: skip
NAMES = {" ": "space", "\r": "enter", "\n": "enter", "\x03": "q"}


def parse_keys(text: str) -> Iterator[str]:
    """Yield the names of the keys in text from a terminal."""
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
    """Play until `q` or `stopped()`; raise errors of the player."""
    actions = KeyActions(player, say)
    say(f"{player.timeline.title}. ? for the keys, q to quit.")
    reported = last = ""
    since = time.monotonic()
    with _raw_keys() as read:
        while not stopped():
            status = poll(player, source)
            for line in status.messages:
                say(line)
            for key in parse_keys(read()):
                if key == "q":
                    player.close()
                    return
                actions.press(key)
            text = position_text(player, status.cursor) + ("" if status.touching else ", released")
            if text != last:
                last, since = text, time.monotonic()
            if last != reported and time.monotonic() - since >= STABLE_S:
                reported = last
                say(reported)
        player.close()


@contextlib.contextmanager
def _raw_keys() -> Iterator[Callable[[], str]]:
    """Yield a function that waits a short time for keys and returns them without line ends."""
    file = sys.stdin.fileno()
    try:
        import termios
        import tty
    except ImportError:  # Windows, where only whole lines can be read
        yield sys.stdin.readline
        return
    before = termios.tcgetattr(file)

    def give_back(*signal_and_frame: object) -> None:
        termios.tcsetattr(file, termios.TCSANOW, before)

    def suspend(*signal_and_frame: object) -> None:
        give_back()
        os.kill(os.getpid(), signal.SIGSTOP)

    def resume(*signal_and_frame: object) -> None:
        tty.setcbreak(file, termios.TCSANOW)  # keeps what was typed

    handlers = {
        number: signal.signal(number, handler)
        for number, handler in ((signal.SIGTSTP, suspend), (signal.SIGCONT, resume))
    }
    resume()

    def read() -> str:
        if not select.select([file], [], [], POLL_EVERY_S)[0]:
            return ""
        data = os.read(file, 1024)
        if not data:  # closed
            return "q"
        return data.decode("utf-8", "replace")

    try:
        yield read
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        with contextlib.suppress(termios.error):
            give_back()
