"""A headless JACK server for tests: a real PortAudio stream with no sound card."""

from __future__ import annotations

import importlib.util
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
import time

INSTALL = (
    "needs a JACK server, PortAudio and its Python client: "
    "apt install jackd2 libportaudio2; pip install JACK-Client"
)
START_WITHIN_S = 5.0
ATTEMPTS = 3
"""Of what a machine may disturb by losing a period, at most two repeats: what is wrong each time is
wrong."""

_numbers = itertools.count()


def available() -> bool:
    """Whether the server and its client are installed."""
    return (
        sys.platform == "linux"
        and shutil.which("jackd") is not None
        and importlib.util.find_spec("jack") is not None
    )


class Server:
    """`jackd` with its dummy driver, at one rate and period, under a name of its own.

    With real-time priority as root, where the machine allows that; else without. What it printed
    is in `log` afterwards. A process finds it by `environment`.
    """

    def __init__(self, period: int = 256, rate: int = 48_000, outputs: int = 2) -> None:
        self.period, self.rate, self.outputs = period, rate, outputs
        self.name = f"overview-test-{os.getpid()}-{next(_numbers)}"
        self.environment = {**os.environ, "JACK_DEFAULT_SERVER": self.name}

    def __enter__(self) -> Server:
        # a file: a full pipe would stop the server
        self._printed = tempfile.TemporaryFile()
        priorities = [["-R", "-P", "70"], ["-r"]] if os.geteuid() == 0 else [["-r"]]
        for priority in priorities:
            if self._start(priority):
                return self
            self._end()
        raise RuntimeError(f"jackd did not start: {self.log[-3000:]}")

    def _start(self, priority: list[str]) -> bool:
        driver = ["-d", "dummy", "-r", str(self.rate), "-p", str(self.period), "-C", "2",
                  "-P", str(self.outputs)]  # fmt: skip
        self.process = subprocess.Popen(
            ["jackd", "-n", self.name, *priority, *driver],
            stdout=self._printed,
            stderr=subprocess.STDOUT,
        )
        until = time.monotonic() + START_WITHIN_S
        while time.monotonic() < until and self.process.poll() is None:
            time.sleep(0.1)
            asked = subprocess.run(["jack_wait", "-c"], capture_output=True, env=self.environment)
            if asked.stdout.startswith(b"run"):
                return True
        return False

    def _end(self) -> None:
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._printed.seek(0)
        self.log = self._printed.read().decode(errors="replace")

    def __exit__(self, *error: object) -> None:
        self._end()
        self._printed.close()

    def run(self, script: str, *arguments: object, timeout: float = 120.0) -> str:
        """Run a Python script in a process of its own: PortAudio sees the server at its start."""
        return self.python("-c", script, *arguments, timeout=timeout)

    def python(self, *arguments: object, timeout: float = 120.0) -> str:
        """Run Python with these arguments in a process of its own; what it printed."""
        done = self.attempt(*arguments, timeout=timeout)
        assert done.returncode == 0, done.stderr[-3000:]
        return done.stdout

    def attempt(
        self, *arguments: object, timeout: float = 120.0
    ) -> subprocess.CompletedProcess[str]:
        """The same, however it ends."""
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=timeout,
            env=self.environment,
        )


def run(script: str, *arguments: object) -> str:
    """What a Python script prints that starts servers itself, named `JACK_DEFAULT_SERVER`."""
    name = f"overview-test-{os.getpid()}-{next(_numbers)}"
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120.0,
        env={**os.environ, "JACK_DEFAULT_SERVER": name},
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout
