"""A headless JACK server for tests: a real PortAudio stream with no sound card."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import time

INSTALL = (
    "needs a JACK server, PortAudio and its Python client: "
    "apt install jackd2 libportaudio2; pip install JACK-Client"
)


def available() -> bool:
    """Whether the server and its client are installed."""
    return (
        sys.platform == "linux"
        and shutil.which("jackd") is not None
        and importlib.util.find_spec("jack") is not None
    )


class Server:
    """`jackd` with its dummy driver, at one rate and period."""

    def __init__(self, period: int = 256, rate: int = 48_000) -> None:
        self.period, self.rate = period, rate

    def __enter__(self) -> Server:
        command = ["jackd", "-r", "-d", "dummy", "-r", str(self.rate), "-p", str(self.period)]
        self._process = subprocess.Popen(
            [*command, "-C", "2", "-P", "2"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for _ in range(50):
            time.sleep(0.1)
            if subprocess.run(["jack_wait", "-c"], capture_output=True).stdout.startswith(b"run"):
                break
        return self

    def __exit__(self, *error: object) -> None:
        self._process.terminate()
        self.log = self._process.communicate(timeout=20)[0]

    def run(self, script: str, *arguments: object, timeout: float = 120.0) -> str:
        """Run a Python script in a process of its own: PortAudio sees the server at its start."""
        return run(script, *arguments, timeout=timeout)


def run(script: str, *arguments: object, timeout: float = 120.0) -> str:
    """What a Python script in a process of its own prints."""
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=timeout,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout
