"""Signals that end a command: SIGTERM and SIGHUP act as Ctrl-C, so no partial output is left."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from overview_dsp.files.atomic import remove_temporaries

END_WITHIN_S = 2.0
LOOK_EVERY_S = 0.1

_received: list[int] = []


@contextmanager
def _handled(receive: Callable[[int, Any], None]) -> Iterator[None]:
    known = [
        getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
    ]
    # not those that are ignored (nohup)
    before = {
        number: signal.signal(number, receive)
        for number in known
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """Raise KeyboardInterrupt for the first signal; later ones don't interrupt the cleanup."""
    _received.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _handled(_stop):
        yield


def _stop(number: int, frame: Any) -> None:
    if not _received:
        _received.append(number)
        raise KeyboardInterrupt


def stop_code() -> int:
    """Return the exit code of a stopped command."""
    return 128 + (_received[0] if _received else signal.SIGINT)


@contextmanager
def ended_by_signals(save: Callable[[], None] | None = None) -> Iterator[list[int]]:
    """Collect signals, so that a command can end in its own way.

    A process that still runs `END_WITHIN_S` after the first signal (because a terminal or a device
    doesn't answer) is ended after `save`.
    """
    received: list[int] = []

    def receive(number: int, frame: Any) -> None:
        received.append(number)
        if len(received) == 1:
            threading.Thread(target=end_anyway, name="end", daemon=True).start()

    def end_anyway() -> None:
        time.sleep(END_WITHIN_S)
        try:
            if save is not None:
                save()
            remove_temporaries()
        finally:
            os._exit(128 + received[0])

    with _handled(receive):
        yield received


def wait_for_end(received: list[int], seconds: float | None) -> None:
    """Wait for a signal, at most `seconds`."""
    until = None if seconds is None else time.monotonic() + seconds
    while not received and (until is None or time.monotonic() < until):
        time.sleep(LOOK_EVERY_S)


def exit_if_stopped(received: list[int]) -> None:
    """Exit with the code of the first signal, if there is one."""
    if received:
        from overview_dsp.cli.common import say

        say(f"stopped by {signal.Signals(received[0]).name}")
        sys.exit(128 + received[0])
