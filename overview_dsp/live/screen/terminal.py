"""The terminal's driver: one that never waits for a terminal that reads nothing, or has gone.

The library's own writer has a bounded queue that blocks the application, and its end, once nobody
reads. Here what is drawn meanwhile is left out, and all of it drawn anew when it is read again.
"""

from __future__ import annotations

import os
import select
import threading
from collections import deque
from typing import IO, Any

from textual.driver import Driver

MOST_WAITING = 65_536
"""Characters that may wait; more of the screen is left out."""

SHORT = 24
"""A control sequence up to so long is never left out: modes of the terminal, not its picture."""

END_WITHIN_S = 0.3
"""How long the end of the screen waits for the terminal to take what is left."""

CHUNK = 512


class TerminalWriter(threading.Thread):
    """Writes to a terminal from a thread of its own; nobody waits for it.

    Thread: any for `write`; it stands in for the library's writer.
    """

    def __init__(self, file: IO[str]) -> None:
        """For an open terminal; `start` it."""
        super().__init__(daemon=True, name="terminal")
        self._file = file
        self._waiting: deque[bytes] = deque()
        self._count = 0
        self._changed = threading.Condition()
        self._ending = False
        self._left_out = False
        self.gone = False

    def write(self, text: str) -> None:
        """Have text written soon, or left out if the terminal reads nothing."""
        with self._changed:
            is_mode = len(text) <= SHORT and text.startswith("\x1b[")
            if self.gone or (self._count > MOST_WAITING and not is_mode):
                self._left_out = True
                return
            data = text.encode("utf-8", "replace")
            self._waiting.append(data)
            self._count += len(data)
            self._changed.notify()

    def take_left_out(self) -> bool:
        """Whether something was left out and the terminal reads again: draw all of it."""
        with self._changed:
            again = self._left_out and not self._waiting and not self.gone
            if again:
                self._left_out = False
            return again

    def isatty(self) -> bool:
        """As the library's."""
        return True

    def fileno(self) -> int:
        """The terminal's."""
        return self._file.fileno()

    def flush(self) -> None:
        """Nothing: the thread does that."""

    def run(self) -> None:
        """Write what comes, until the end."""
        while True:
            with self._changed:
                while not self._waiting and not self._ending:
                    self._changed.wait()
                if not self._waiting:
                    return
                data = self._waiting[0]
            try:
                # not through the file: who ends the process would wait for its lock
                for at in range(0, len(data), CHUNK):
                    _write_all(self._file.fileno(), data[at : at + CHUNK])
            except (OSError, ValueError):  # closed
                self.gone = True
            with self._changed:
                self._waiting.popleft()
                self._count -= len(data)
                if self.gone:
                    self._waiting.clear()
                    return

    def stop(self) -> None:
        """Write what is left and end, unless the terminal takes nothing."""
        with self._changed:
            self._ending = True
            self._changed.notify()
        self.join(END_WITHIN_S)


def _write_all(file: int, data: bytes) -> None:
    while data:
        data = data[os.write(file, data) :]


def has_hung_up(file: int) -> bool:
    """Whether a terminal has been closed."""
    if not hasattr(select, "poll"):
        return False
    poll = select.poll()
    poll.register(file, 0)
    return any(what & (select.POLLHUP | select.POLLNVAL) for _, what in poll.poll(0))


def patient(driver: type[Driver]) -> type[Driver]:
    """The library's driver for this platform, with a `TerminalWriter`."""

    class PatientDriver(driver):  # type: ignore[valid-type, misc]
        """It has the library's writer made, and puts its own in the place."""

        writer: TerminalWriter | None = None

        @property
        def _writer_thread(self) -> TerminalWriter | None:
            return self.writer

        @_writer_thread.setter
        def _writer_thread(self, made: Any) -> None:
            self.writer = None if made is None else TerminalWriter(made._file)

        def run_input_thread(self) -> None:
            """Read keys; a terminal that was closed is the session's to notice."""
            try:
                super().run_input_thread()
            except OSError:
                return

    return PatientDriver
