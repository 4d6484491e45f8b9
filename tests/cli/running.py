"""Run the command line: in this process, or (slower) as its own."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from overview_dsp.cli import main

MATCH = "world-cup-final-2018"
ROOT = Path(__file__).resolve().parents[2]
QUICK = ("--gesture", "tap:0.2:0.05", "--sample-rate", "8000", "--tail", "0.05")
"""Options of a render that takes no time."""


@dataclass(frozen=True)
class Outcome:
    """What a command ended with."""

    code: int
    out: str
    err: str

    @property
    def errors(self) -> list[str]:
        """Lines on stderr, without notes and the one that announces a first compilation."""
        lines = self.err.splitlines()
        return [line for line in lines if not line.startswith(("note: ", "compiling the engine"))]


def overview(*arguments: object) -> Outcome:
    """The command, in this process."""
    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.object(sys, "argv", ["overview", *map(str, arguments)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        # the command line has its own way with warnings
        warnings.catch_warnings(),
    ):
        try:
            main()
        except SystemExit as stop:
            code = stop.code
    assert isinstance(code, int)
    return Outcome(code, out.getvalue(), err.getvalue())


def environment() -> dict[str, str]:
    """An environment in which this checkout is the package, from any folder."""
    return {**os.environ, "PYTHONPATH": str(ROOT)}


def overview_process(*arguments: object, **options: object) -> Outcome:
    """The command, as a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "overview_dsp", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env=environment(),
        **options,  # type: ignore[call-overload]
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


def refused(outcome: Outcome, *words: str, code: int = 2) -> str:
    """The line of an error that names these words; no traceback, nothing on stdout.

    A second one says what a file comes nearest to.
    """
    assert outcome.code == code, outcome
    line, *fix = outcome.errors
    assert len(fix) <= 1, outcome.err
    assert all("; overview timeline formats lists" in second for second in fix), outcome.err
    assert line.startswith("error: ")
    assert "Traceback" not in outcome.err
    assert "bug of this program" not in line
    for word in words:
        assert word in line, line
    return line


def end_of_group(group: int, within_s: float = 20.0) -> bool:
    """Whether all processes of a group are gone within some seconds."""
    deadline = time.monotonic() + within_s
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False
