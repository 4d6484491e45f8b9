"""A study for tests of its page, served by a process that can be killed."""

from __future__ import annotations

import contextlib
import json
import signal
import socket
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from overview_studies.design import load_design
from overview_studies.folder import build_folder


def built(folder: Path, text: str, **forms: str) -> Path:
    """The folder of a study from its TOML and its forms."""
    for name, form in forms.items():
        (folder / f"{name}.html").write_text(form)
    file = folder / "study.toml"
    file.write_text(text)
    build_folder(load_design(file), folder / "built")
    return folder / "built"


class Process:
    """`overview study serve` on a port of its own, which can be killed and started again."""

    def __init__(self, folder: Path, answers: Path) -> None:
        self.folder, self.answers = folder, answers
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.start()

    def start(self) -> None:
        """Serve; the same answers and the same address as before."""
        command = [
            *(sys.executable, "-m", "overview_dsp", "study", "serve", str(self.folder)),
            *("--db", str(self.answers), "--port", str(self.port), "--json"),
        ]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert self.process.stdout is not None
        self.url = json.loads(self.process.stdout.readline())["address"]

    def kill(self) -> None:
        """As a power cut does, but for the disk's own cache."""
        self.process.send_signal(signal.SIGKILL)
        self.process.communicate()

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
