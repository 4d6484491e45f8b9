"""Signals that ask a command to end: SIGTERM and SIGHUP are as Ctrl-C, so nothing stays behind.

What plays live answers them in its own way (`live_session.ended_by_signals`).
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_received: list[int] = []


def signals_that_end() -> list[int]:
    """Those of this platform; one that is ignored stays so (nohup)."""
    wanted = [
        getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
    ]
    return [number for number in wanted if signal.getsignal(number) is not signal.SIG_IGN]


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """Raise KeyboardInterrupt for the first of them; what comes later disturbs no cleaning up."""
    _received.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, _stop) for number in signals_that_end()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(number: int, frame: Any) -> None:
    if not _received:
        _received.append(number)
        raise KeyboardInterrupt


def stop_code() -> int:
    """The exit code of a command that was stopped."""
    return 128 + (_received[0] if _received else signal.SIGINT)
