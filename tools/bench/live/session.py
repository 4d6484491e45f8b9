"""Cost of a whole session: processor time of `overview play`, and the output of its screen.

Blocks have 64 frames. Each session runs with or without the screen, idle or with keys that move the
finger. It runs in its own pseudo-terminal, as a user's session runs in a terminal; Linux only.
"""

from __future__ import annotations

import os
import select
import signal
import struct
import subprocess
import sys
import threading
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from overview_dsp.errors import InputError, OverviewError

BLOCK = 64
SIZE = (100, 30)  # columns and rows of the terminal
SCREEN_TEXT = b"vibration"
STARTS_WITHIN_S = 60.0
ENDS_WITHIN_S = 6.0
SETTLE_S = 2.0
KEY_EVERY_S = 0.05
KEYS = b"\x1b[C" * 40 + b"\x1b[D" * 40
"""The finger moves over 40 hundredths of the timeline and back."""


@dataclass(frozen=True)
class SessionRow:
    """Cost of a session of `seconds`, with its `screen` or headless, `moving` or idle.

    `cpu_percent` is of one core; `kb_a_second` is the output to the terminal, kB/s.
    """

    screen: bool
    moving: bool
    seconds: float
    cpu_percent: float
    kb_a_second: float


def can_measure() -> bool:
    """Return whether this platform reports the resources of a process."""
    return Path(f"/proc/{os.getpid()}/stat").exists()


def measure_session(
    device: int | str | None, screen: bool, moving: bool, seconds: float
) -> SessionRow:
    """Play the bundled match in its own process for `seconds`; errors as `measure_live`."""
    arguments = ["play", "world-cup-final-2018", "--block-size", str(BLOCK)]
    if device is not None:
        arguments += ["--device", str(device)]
    if not screen:
        arguments += ["--screen", "json"]
    with closing(_Session(arguments)) as session:
        session.wait_for(SCREEN_TEXT if screen else b"{")
        session.move(moving, SETTLE_S)
        began, used, printed = time.monotonic(), session.used_s, len(session.output)
        session.move(moving, seconds)
        took = time.monotonic() - began
        return SessionRow(
            screen=screen,
            moving=moving,
            seconds=took,
            cpu_percent=100.0 * (session.used_s - used) / took,
            kb_a_second=1e-3 * (len(session.output) - printed) / took,
        )


class _Session:
    """`overview` in a pseudo-terminal, read as fast as it writes."""

    def __init__(self, arguments: list[str]) -> None:
        import fcntl  # some platforms lack these three
        import pty
        import termios

        self.output = bytearray()
        self._closed = False
        self._terminal, child_end = pty.openpty()
        size = struct.pack("HHHH", SIZE[1], SIZE[0], 0, 0)
        fcntl.ioctl(self._terminal, termios.TIOCSWINSZ, size)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "overview_dsp", *arguments],
            stdin=child_end,
            stdout=child_end,
            stderr=child_end,
            env={**os.environ, "TERM": "xterm-256color"},
            start_new_session=True,
        )
        os.close(child_end)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        while not self._closed:
            if select.select([self._terminal], [], [], 0.1)[0]:
                try:
                    self.output += os.read(self._terminal, 65_536)
                except OSError:  # the process has ended
                    return

    def wait_for(self, text: bytes) -> None:
        """Wait until the process prints `text`; InputError with its message if it ends first."""
        until = time.monotonic() + STARTS_WITHIN_S
        while text not in self.output:
            if self._process.poll() is not None:
                self._reader.join(1.0)
                rows = self.output.decode("utf-8", "replace").strip().splitlines() or ["it ended"]
                raise InputError(next((one for one in rows if one.startswith("error")), rows[-1]))
            if time.monotonic() > until:
                raise OverviewError(f"overview play did not start within {STARTS_WITHIN_S:g} s")
            time.sleep(0.05)

    def move(self, moving: bool, seconds: float) -> None:
        """Wait for `seconds`; if `moving`, press the keys that move the finger."""
        until, number = time.monotonic() + seconds, 0
        while (left := until - time.monotonic()) > 0.0:
            if moving:
                at = 3 * number % len(KEYS)
                os.write(self._terminal, KEYS[at : at + 3])
                number += 1
            time.sleep(min(left, KEY_EVERY_S if moving else 1.0))

    @property
    def used_s(self) -> float:
        """Processor time so far, s."""
        fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def close(self) -> None:
        """End the process, by force if it does not end in time."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGTERM)
        try:
            self._process.wait(ENDS_WITHIN_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._closed = True
        self._reader.join()
        os.close(self._terminal)


def session_table(rows: list[SessionRow]) -> list[str]:
    """Return the sessions as lines of text."""
    lines = [
        f"a whole session (overview play), {BLOCK} frames, {SIZE[0]} x {SIZE[1]} characters",
        f"{'session':<32}{'CPU % of a core':>17}{'to the terminal kB/s':>22}",
    ]
    for row in rows:
        name = f"{'screen' if row.screen else 'headless'}, {'moving' if row.moving else 'idle'}"
        lines.append(f"{name:<32}{row.cpu_percent:>17.1f}{row.kb_a_second:>22.1f}")
    return lines
