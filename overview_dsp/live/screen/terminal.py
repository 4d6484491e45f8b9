"""Terminal driver that never waits for a frozen or closed terminal, and draws ASCII if necessary.

Textual's own writer blocks the application when its queue is full, even at exit. This one skips
output while the terminal doesn't read. The whole screen is drawn again when it reads again.
"""

from __future__ import annotations

import os
import re
import select
import threading
import unicodedata
from collections import deque
from collections.abc import Mapping
from typing import IO, Any

from textual.driver import Driver

from overview_dsp.files.toml import load_toml

MAX_QUEUED = 65_536
"""Number of queued bytes above which output is skipped."""

MAX_MODE_LENGTH = 24
"""Maximum length of control sequences that are never skipped, because they set terminal modes."""

END_WITHIN_S = 0.3
"""Longest wait for the terminal to read the rest at exit."""

CHUNK = 512

ASCII = str.maketrans(*load_toml(__file__, "signs.toml")["ascii"].values())
"""Replacements for a terminal without UTF-8, of the same width."""


def has_utf8(environment: Mapping[str, str]) -> bool:
    """Return whether a terminal shows UTF-8, by its locale (UTF-8 if unknown) and its kind."""
    names = ("LC_ALL", "LC_CTYPE", "LANG")
    locale = next(filter(None, (environment.get(name) for name in names)), "utf-8").casefold()
    return environment.get("TERM") != "linux" and ("utf-8" in locale or "utf8" in locale)


class TerminalWriter(threading.Thread):
    """Writer in a thread of its own, which replaces Textual's; any thread may call `write`."""

    def __init__(self, file: IO[str]) -> None:
        """Prepare to write to an open terminal; `start` starts the thread."""
        super().__init__(daemon=True, name="terminal")
        self._file = file
        self._utf8 = has_utf8(os.environ)
        self._queue: deque[bytes] = deque()
        self._count = 0
        self._changed = threading.Condition()
        self._ending = False
        self._skipped = False
        self.closed = False

    def write(self, text: str) -> None:
        """Queue text, or skip it if the terminal doesn't read."""
        with self._changed:
            is_mode = len(text) <= MAX_MODE_LENGTH and text.startswith("\x1b[")
            if self.closed or (self._count > MAX_QUEUED and not is_mode):
                self._skipped = True
                return
            if self._utf8:
                data = text.encode("utf-8", "replace")
            else:
                plain = unicodedata.normalize("NFD", text.translate(ASCII))
                data = re.sub("[\u0300-\u036f]", "", plain).encode("ascii", "replace")
            self._queue.append(data)
            self._count += len(data)
            self._changed.notify()

    def pop_skipped(self) -> bool:
        """Return whether output was skipped and the terminal reads again; then forget the skip."""
        with self._changed:
            skipped = self._skipped and not self._queue and not self.closed
            if skipped:
                self._skipped = False
            return skipped

    def isatty(self) -> bool:
        """Return True."""
        return True

    def fileno(self) -> int:
        """Return the descriptor of the terminal."""
        return self._file.fileno()

    def flush(self) -> None:
        """Do nothing: the thread writes at once."""

    def run(self) -> None:
        """Write the queued text until `stop`."""
        while True:
            with self._changed:
                while not self._queue and not self._ending:
                    self._changed.wait()
                if not self._queue:
                    return
                data = self._queue[0]
            try:
                # not by the file object, whose lock would delay the exit of the process
                rest = data
                while rest:
                    rest = rest[os.write(self._file.fileno(), rest[:CHUNK]) :]
            except (OSError, ValueError):
                self.closed = True
            with self._changed:
                self._queue.popleft()
                self._count -= len(data)
                if self.closed:
                    self._queue.clear()
                    return

    def stop(self) -> None:
        """Write the rest and end; don't wait for a terminal that doesn't read."""
        with self._changed:
            self._ending = True
            self._changed.notify()
        self.join(END_WITHIN_S)


def has_hung_up(file: int) -> bool:
    """Return whether a terminal was closed."""
    if not hasattr(select, "poll"):
        return False
    poll = select.poll()
    poll.register(file, 0)
    return any(event & (select.POLLHUP | select.POLLNVAL) for _, event in poll.poll(0))


def nonblocking_driver(driver: type[Driver]) -> type[Driver]:
    """Return Textual's driver for this platform with a `TerminalWriter`."""

    class NonblockingDriver(driver):  # type: ignore[valid-type, misc]
        """Driver that replaces the writer which Textual creates."""

        writer: TerminalWriter | None = None
        _suspended = False

        @property
        def _writer_thread(self) -> TerminalWriter | None:
            return self.writer

        @_writer_thread.setter
        def _writer_thread(self, original: Any) -> None:
            self.writer = None if original is None else TerminalWriter(original._file)

        def suspend_application_mode(self) -> None:
            """Give the terminal back."""
            super().suspend_application_mode()
            self._suspended = True

        def resume_application_mode(self) -> None:
            """Take the terminal; SIGSTOP stops this process without giving it back first."""
            if not self._suspended:
                self.suspend_application_mode()
            self._suspended = False
            super().resume_application_mode()
            self._app.refresh(layout=True)

        def run_input_thread(self) -> None:
            """Read keys; the application detects a closed terminal."""
            try:
                super().run_input_thread()
            except OSError:
                return

    return NonblockingDriver
