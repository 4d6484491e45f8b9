"""A sound output that nobody hears: PulseAudio with a sink that only keeps time."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

START_WITHIN_S = 20.0


@contextlib.contextmanager
def null_sink(folder: Path, rate: int = 48_000) -> Iterator[dict[str, str]]:
    """The environment in which programs find it; skips without PulseAudio."""
    program = shutil.which("pulseaudio")
    if program is None:
        pytest.skip("needs a sound output: apt install pulseaudio")
    socket = folder / "socket"
    own = {**os.environ, "HOME": str(folder), "PULSE_RUNTIME_PATH": str(folder)}
    process = subprocess.Popen(
        [
            *(program, "-n", "--daemonize=no", "--exit-idle-time=-1"),
            *("-L", f"module-null-sink rate={rate}"),
            *("-L", f"module-native-protocol-unix socket={socket} auth-anonymous=1"),
        ],
        env=own,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        end = time.monotonic() + START_WITHIN_S
        while not socket.exists():
            assert process.poll() is None, "PulseAudio ended"
            assert time.monotonic() < end, "PulseAudio did not start"
            time.sleep(0.05)
        yield {**os.environ, "PULSE_SERVER": f"unix:{socket}"}
    finally:
        process.terminate()
        process.wait()
