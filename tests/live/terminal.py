"""`overview play` in a pseudo-terminal of its own, as a person's terminal runs it."""

from __future__ import annotations

import fcntl
import os
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import threading
import time

CLOSE_TIMEOUT_S = 3.0


class Terminal:
    """A command as the foreground process of a terminal; `read` by a thread unless it is frozen."""

    def __init__(self, arguments, environment, size=(100, 30), kind="xterm-256color"):
        self.ours, theirs = os.openpty()
        self.resize(*size)

        def take_terminal():
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)
            # as from a shell, also where these tests are run in the background or by nohup
            for number in (signal.SIGINT, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)

        # pytest's workers have a size there, which would count instead of the terminal's
        environment = {k: v for k, v in environment.items() if k not in ("COLUMNS", "LINES")}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "overview_dsp", *map(str, arguments)],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env={**environment, "TERM": kind},
            start_new_session=True,
            preexec_fn=take_terminal,
        )
        os.close(theirs)
        self.shown = bytearray()
        self.frozen = False
        self._closed = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        while not self._closed:
            if self.frozen or not select.select([self.ours], [], [], 0.05)[0]:
                time.sleep(0.01)
                continue
            try:
                self.shown += os.read(self.ours, 65_536)
            except OSError:  # nobody writes any more
                return

    @property
    def text(self):
        """What was shown, without control sequences, which may lie within a word."""
        return re.sub(rb"\x1b\[[\d;?]*[a-zA-Z]", b"", bytes(self.shown))

    @property
    def echoes(self):
        """Whether what is typed is shown, as before the command."""
        return bool(termios.tcgetattr(self.ours)[3] & termios.ECHO)

    @property
    def threads(self):
        names = []
        for thread in os.listdir(f"/proc/{self.process.pid}/task"):
            with open(f"/proc/{self.process.pid}/task/{thread}/comm") as file:
                names.append(file.read().strip())
        return sorted(names)

    def press(self, keys):
        os.write(self.ours, keys.encode())

    def resize(self, columns, rows):
        fcntl.ioctl(self.ours, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def close(self):
        """Close the window."""
        if not self._closed:
            self._closed = True
            self._reader.join()
            os.close(self.ours)

    def wait_for(self, condition, seconds=60.0):
        until = time.monotonic() + seconds
        while not condition():
            assert self.process.poll() is None, self.shown.decode(errors="replace")[-3000:]
            assert time.monotonic() < until, self.shown.decode(errors="replace")[-3000:]
            time.sleep(0.002)
        return time.monotonic()

    def end(self):
        """How long it takes to end by itself from now, s, and its exit code; None if it doesn't.

        Whether it echoes then is in `echoed`.
        """
        began = time.monotonic()
        try:
            code = self.process.wait(2 * CLOSE_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            code = None
        took = time.monotonic() - began
        self.echoed = not self._closed and self.echoes
        self.process.kill()
        self.process.wait()
        self.close()
        return took, code
