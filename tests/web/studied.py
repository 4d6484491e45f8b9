"""A study for tests of its page: made small, served by a process that can be killed, or by a host."""

from __future__ import annotations

import contextlib
import json
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx

from overview_dsp.studies.design import load_design
from overview_dsp.studies.folder import build_folder

TOKEN = "token-of-a-test-that-is-long-enough"
SECONDS = 60.0


def built(folder: Path, text: str) -> Path:
    """The folder of a study from its TOML."""
    file = folder / "study.toml"
    file.write_text(text)
    build_folder(load_design(file), folder / "built")
    return folder / "built"


class Process:
    """A server of a study on a port of its own, in a process of its own."""

    def __init__(self, folder: Path, answers: Path) -> None:
        self.folder, self.answers = folder, answers
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.origin = f"http://127.0.0.1:{self.port}"
        self.url = f"{self.origin}/#token={TOKEN}"
        self.start()

    def start(self) -> None:
        """Serve; the same answers and the same address as before."""
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.web.study_server", str(self.folder), str(self.answers),
             str(self.port), TOKEN],
        )  # fmt: skip
        end = time.monotonic() + SECONDS
        while True:
            try:
                httpx.get(self.origin, timeout=5.0)
                return
            except httpx.HTTPError:
                assert time.monotonic() < end and self.process.poll() is None
                time.sleep(0.05)

    def kill(self) -> None:
        """As a power cut does, but for the disk's own cache."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def rows(self) -> dict[str, dict[str, Any]]:
        """What is stored of the only session, by trial."""
        with contextlib.closing(sqlite3.connect(self.answers)) as database:
            found = database.execute("SELECT trial, row FROM trial ORDER BY rowid").fetchall()
        return {trial: json.loads(row) for trial, row in found}


@contextlib.contextmanager
def served_study(folder: Path, answers: Path) -> Iterator[Process]:
    server = Process(folder, answers)
    try:
        yield server
    finally:
        server.kill()


def trials_of(folder: Path, number: int = 1) -> list[dict[str, Any]]:
    """The steps of a list that ask for something."""
    steps = json.loads((folder / "lists" / f"{number:03d}.json").read_text())["steps"]
    return [step for step in steps if step["type"] in ("trial", "form", "adaptive")]
