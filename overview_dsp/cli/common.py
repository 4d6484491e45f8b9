"""What several commands share: notes, the compile notice, the progress bar, reports as JSON."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

import overview_dsp as ov
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, protect_input, unprotect_inputs

if TYPE_CHECKING:
    from overview_dsp.design.gestures import Gesture

BAR_AFTER_S = 1.0
STANDARD_ERROR = 2
T = TypeVar("T")


def note(message: str) -> None:
    """A line for the person."""
    say(f"note: {message}")


def say(line: str) -> None:
    """A line on standard error, if there is one still: it may be a terminal that was closed."""
    try:
        click.echo(line, err=True)
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, STANDARD_ERROR)  # else its end would fail again
        os.close(nowhere)


def announce_compile(*kernels: str) -> None:
    """Say so when the first use of the kernels on this machine is about to compile them."""
    from overview_dsp.signal.engine.coefficients import announce_compile

    announce_compile("process", *kernels)


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr for work longer than a second; yields its setter of the part done, 0 to 1."""
    started = time.monotonic()
    bar: Any = None
    shown = 0

    def report(part: float) -> None:
        nonlocal bar, shown
        if bar is None:
            if time.monotonic() - started < BAR_AFTER_S or not sys.stderr.isatty():
                return
            bar = click.progressbar(length=1000, label=label, file=sys.stderr)
            bar.__enter__()
        now = round(part * 1000)
        bar.update(now - shown)
        shown = now

    try:
        yield report
    finally:
        if bar is not None:
            bar.__exit__(None, None, None)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a whole text file, or nothing; OutputError."""
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def protect_inputs(path: str) -> None:
    """Let no output of the command take the place of a file that it reads."""
    protect_input(path)
    click.get_current_context().call_on_close(unprotect_inputs)


def read_gesture(text: str) -> Gesture:
    """A gesture as a person gave it, whose takes no output replaces; errors as `parse_gesture`."""
    for part in text.split("+"):
        protect_inputs(part)
        protect_inputs(os.path.splitext(part)[0] + ".json")  # what lies beside a recorded take
    return ov.parse_gesture(text)


def print_json(report: Any) -> None:
    """A report as JSON on standard output."""
    click.echo(json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False))


def show(as_json: bool, report: Any, *lines: object) -> None:
    """A report as JSON, or as lines for a person."""
    if as_json:
        print_json(report)
        return
    for line in lines:
        click.echo(line)


def list_profiles(
    names: Iterable[str],
    load: Callable[[str], T],
    described: Callable[[T], dict[str, Any]],
    as_json: bool,
    remark: Callable[[T], str] = lambda profile: "",
) -> None:
    """Those that load, with name, title and description in a line; what is wrong with the others.

    Parameters
    ----------
    described : callable
        What JSON says of one, with these three keys.
    remark : callable
        What the line ends with.
    """
    found, faults = [], []
    for name in names:
        try:
            found.append(load(name))
        except InputError as error:
            faults.append(str(error))
    rows = [described(profile) for profile in found]
    width = max((len(row["name"]) for row in rows), default=0)
    lines = (
        f"{row['name']:<{width}}  {row['title']}: {row['description']}{remark(profile)}"
        for row, profile in zip(rows, found, strict=True)
    )
    show(as_json, rows, *lines)
    for fault in faults:
        note(f"left out: {fault}")
