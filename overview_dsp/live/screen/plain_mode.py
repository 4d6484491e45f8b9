"""Plain mode: a session as lines of text, for screen readers and simple terminals.

The keys are those of the full screen. A line reports the position of the finger, value and event,
at once after a key or a movement and then at most four times per second: the newest, and the last.
"""

from __future__ import annotations

import contextlib
import os
import re
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator

from overview_dsp.errors import printable
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.screen.key_actions import HELP, KeyActions, figures_text
from overview_dsp.live.screen.position_report import PositionReport, finger_position
from overview_dsp.live.session import blind
from overview_dsp.live.session.command_forms import FORMS
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.headless import is_over
from overview_dsp.live.session.player import Player

POLL_EVERY_S = 0.03
LINE_EVERY_S = 0.25
"""Shortest time between two lines on the position."""

_SEQUENCE = re.compile(r"\[[\d;]*[A-Za-z~]|O[A-Z]")


def parse_keys(text: str) -> Iterator[str]:
    """Yield the names of the keys in text from a terminal."""
    while text:
        if text[0] != "\x1b":
            yield HELP["names"].get(text[0], text[0])
            text = text[1:]
            continue
        found = _SEQUENCE.match(text, 1)
        yield HELP["escapes"].get(found[0], "of that name") if found else "escape"
        text = text[1 + len(found[0] if found else "") :]


class LineSession:
    """Keys of a session, and reports on its finger (control thread)."""

    def __init__(
        self, player: Player, say: Callable[[str], None], address: str, source: Input | None = None
    ) -> None:
        """Report to `say`; `address` explains how to connect a phone."""
        self._player, self._report = player, PositionReport(player)
        self._say_line, self._address, self._source = say, address, source
        self._actions = KeyActions(player)
        self.command: str | None = None  # that is being typed
        self._finger: float | None = None
        self._place = player.pointer.position  # of the next report
        # reasons for a line on the position
        self._requested = self._moved = self._goes_to_event = False
        self._reported_at, self._reported = 0.0, ""
        self._state = self._read_state()

    def say(self, text: str) -> None:
        """Print each line of a text, without control codes."""
        for line in text.splitlines():
            self._say_line(printable(line).strip())

    def press(self, key: str) -> None:
        """Run the action of a key, or add it to the command that is being typed."""
        before, player = finger_position(self._player), self._player
        if self.command is not None:
            self._type(key)
        elif key == "?":
            self.say(HELP["plain"] if player.blind is None else HELP["blind"] + HELP["plain"])
        elif player.blind is not None and key in blind.KEYS:
            player.queue_command(*blind.KEYS[key])
        elif key == "c":
            self.command = ""
            self.say(f"Command, then Enter: {', '.join(FORMS.values())}")
        elif key == "r":
            self.say(self._address or "No address: start with --remote.")
        elif key == "w":
            held = player.engine.active_input
            holder = "not held" if held is None else f"held by {held[0]}"
            which = f" Preset {player.active_window.presets.name}." if player.blind is None else ""
            self.say(f"{self._report.text(self._place)} Disk {holder}. {player.state.text}.{which}")
        elif key == "i":
            figures = figures_text(player, status := player.poll(), self._source, HELP["figures"])
            self.say("\n".join((*status.messages, figures)))
        elif not self._actions.press(key):
            self.say(f"No key {key}. Press question mark.")
        elif key in HELP["moves"]["names"]:
            place = player.pointer.position
            if key in "[]" and (place == before or not player.pointer.touching):
                self.say("No next event." if key == "]" else "No previous event.")
            else:
                self._place, self._requested, self._goes_to_event = place, True, key in "[]"

    def _type(self, key: str) -> None:
        if key in ("enter", "escape"):
            words = tuple((self.command or "").split())
            self.command = None
            if key == "enter" and words:
                self._player.queue_command(*words)
            else:
                self.say("No command.")
        elif key in ("\x7f", "\x08"):
            self.command = (self.command or "")[:-1]
        elif key == "space" or (len(key) == 1 and key.isprintable()):
            self.command = (self.command or "") + key.replace("space", " ")

    def update(self, now_s: float) -> None:
        """Print what has changed since the last call; call this often."""
        state = self._read_state()
        self.say("\n".join(new for new, old in zip(state, self._state, strict=True) if new != old))
        self._state = state
        finger = finger_position(self._player)
        self._moved |= finger != self._finger
        self._place = self._place if finger is None else finger
        self._finger = finger
        if (self._moved or self._requested) and now_s - self._reported_at >= LINE_EVERY_S:
            self._say_position(now_s)

    def _say_position(self, now_s: float) -> None:
        text = self._report.text(self._place, self._goes_to_event)
        if self._finger is None:
            text = f"Released at {text}"
            self._report.forget()
        # of a replay, only what it meets: it may be repeated for long
        is_empty = self._player.loop.playing and ". " not in text
        if self._requested or (text != self._reported and not is_empty):
            self.say(text)
            self._reported_at, self._reported = now_s, text
        self._requested = self._moved = self._goes_to_event = False

    def _read_state(self) -> tuple[str, ...]:
        """Return the window and the replay as sentences."""
        window = " to ".join(map(self._report.moment, self._player.window))
        if self._player.live_updates is not None:  # it may grow all the time
            window = ""
        replay = "Replay." if self._player.loop.playing else "No replay."
        return f"Window {window}.", replay


def run(
    player: Player,
    source: Input | None,
    stopped: Callable[[], bool],
    say: Callable[[str], None] = lambda line: print(line, flush=True),
    address: str = "",
    has_keys: bool = True,
) -> None:
    """Play until `q` or `stopped()`, without keys also until the input is over; raise errors."""
    session = LineSession(player, say, address, source)
    keys = " Press question mark for the keys, q to quit." if has_keys else ""
    session.say(f"{player.timeline.title}.{keys}")
    replayed = player.loop.playing
    with _raw_keys() if has_keys else contextlib.nullcontext(_no_keys) as read:
        while not (stopped() or (not has_keys and is_over(player, source, replayed))):
            for line in poll(player, source).messages:
                session.say(line)
            for key in parse_keys(read()):
                if key == "q" and session.command is None:
                    player.close()
                    return
                session.press(key)
            session.update(time.monotonic())
        session.update(time.monotonic() + LINE_EVERY_S)
        player.close()


def _no_keys() -> str:
    time.sleep(POLL_EVERY_S)
    return ""


@contextlib.contextmanager
def _raw_keys() -> Iterator[Callable[[], str]]:
    """Yield a function that waits a short time for keys, without a wait for Enter."""
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
        # no bytes from a closed terminal: Escape, then quit
        return os.read(file, 1024).decode("utf-8", "replace") or "\x1bq"

    try:
        yield read
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        with contextlib.suppress(termios.error):
            give_back()
