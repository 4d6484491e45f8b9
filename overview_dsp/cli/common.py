"""What several commands share: the compile notice, the progress bar, reports as JSON."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

BAR_AFTER_S = 1.0


def announce_compile(*kernels: str) -> None:
    """Say so when the first use of the kernels on this machine is about to compile them."""
    from overview_dsp.engine import is_compiled

    if not all(is_compiled(kernel) for kernel in ("process", *kernels)):
        click.echo("compiling the engine for this machine (once, 10 to 20 s) ...", err=True)


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr for work that takes longer than a second; tell it the part done, 0 to 1."""
    started = time.monotonic()
    bar: Any = None
    shown = 0

    def tell(part: float) -> None:
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
        yield tell
    finally:
        if bar is not None:
            bar.__exit__(None, None, None)


def print_json(report: Any) -> None:
    """A report as JSON on standard output."""
    click.echo(json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False))
