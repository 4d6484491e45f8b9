"""Shared output of commands: notes, compile message, progress bar, reports."""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

import overview_dsp as ov
from overview_dsp.errors import InputError, printable
from overview_dsp.files.atomic import protect_input, unprotect_inputs

if TYPE_CHECKING:
    from overview_dsp.design.gestures import Gesture

BAR_AFTER_S = 1.0
STANDARD_ERROR = 2
T = TypeVar("T")


def note(message: str) -> None:
    """Print a note on standard error."""
    say(f"note: {message}")


def say(line: str) -> None:
    """Print a line on standard error, unless its terminal was closed."""
    try:
        click.echo("\n".join(map(printable, line.split("\n"))), err=True)
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, STANDARD_ERROR)  # else Python would fail at exit
        os.close(nowhere)


class LineReader:
    """Reader of the lines of standard input, in a thread."""

    WAIT_S = 0.01

    def __init__(self) -> None:
        self._lines: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._read, name="standard input", daemon=True).start()

    def _read(self) -> None:
        for line in iter(sys.stdin.readline, ""):
            self._lines.put(line.strip())
        self._lines.put(None)

    def discard(self) -> None:
        """Discard earlier lines, but not the end of the input."""
        while not self._lines.empty():
            if self._lines.get() is None:
                self._lines.put(None)
                return

    def next(self) -> str | None:
        """Return the next line, None after a short wait; InputError if the input ended."""
        try:
            line = self._lines.get(timeout=self.WAIT_S)
        except queue.Empty:
            return None
        if line is None:
            raise InputError("standard input ended before an answer; run the command in a terminal")
        return line


def announce_compile(*kernels: str) -> None:
    """Print a message if the kernels must be compiled first on this machine."""
    from overview_dsp.signal.engine.coefficients import announce_compile

    announce_compile("process", *kernels)


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Show a bar for work longer than a second; yields the setter of its progress, 0 to 1."""
    started, shown = time.monotonic(), 0
    bar: Any = None
    with ExitStack() as stack:

        def report(part: float) -> None:
            nonlocal bar, shown
            if bar is None:
                if time.monotonic() - started < BAR_AFTER_S or not sys.stderr.isatty():
                    return
                bar = click.progressbar(length=1000, label=label, file=sys.stderr)
                stack.enter_context(bar)
            now = round(part * 1000)
            bar.update(now - shown)
            shown = now

        yield report


def protect_inputs(*paths: str) -> None:
    """Refuse outputs of the command that would overwrite one of its inputs."""
    for path in paths:
        protect_input(path)
    click.get_current_context().call_on_close(unprotect_inputs)


def read_gesture(text: str) -> Gesture:
    """Parse a gesture, and protect its takes; errors as `parse_gesture`."""
    for part in text.split("+"):
        # a recorded take has a JSON file
        protect_inputs(part, os.path.splitext(part)[0] + ".json")
    return ov.parse_gesture(text)


def print_json(report: Any) -> None:
    """Print a report as JSON."""
    click.echo(json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False))


def show(as_json: bool, report: Any, *lines: object) -> None:
    """Print a report as JSON, or as lines of text."""
    if as_json:
        print_json(report)
    else:
        rows = "\n".join(map(str, lines)).split("\n")
        click.echo("\n".join(map(printable, rows)), nl=bool(lines))


def list_profiles(
    names: Iterable[str],
    load: Callable[[str], T],
    more: Callable[[T], dict[str, Any]],
    as_json: bool,
    remark: Callable[[T], str] = lambda profile: "",
) -> None:
    """List profiles with name, title and description; print errors of invalid files as notes.

    `more` returns the other keys of a profile's JSON report; `remark` the end of its line.
    """
    found, faults = [], []
    for name in names:
        try:
            found.append(load(name))
        except InputError as error:
            faults.append(str(error))
    texts = ("name", "title", "description")
    rows = [{key: getattr(one, key) for key in texts} | more(one) for one in found]
    width = max((len(row["name"]) for row in rows), default=0)
    lines = (
        f"{row['name']:<{width}}  {row['title']}: {row['description']}{remark(profile)}"
        for row, profile in zip(rows, found, strict=True)
    )
    show(as_json, rows, *lines)
    for fault in faults:
        note(f"not listed: {fault}")
