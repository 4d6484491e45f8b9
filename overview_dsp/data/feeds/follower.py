"""Thread that updates a LiveTimeline from a source, and reconnects when the source is lost."""

from __future__ import annotations

import random
import threading
import time
from collections import deque
from collections.abc import Generator

from overview_dsp.data.feeds.clock_guard import ClockGuard
from overview_dsp.data.feeds.feed_lines import MAX_LINE_BYTES, Lines
from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.feeds.sources import LostError, Source
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError
from overview_dsp.units import clock_text

RETRY_S = (0.25, 15.0)
"""First and longest wait before a lost source is opened again, s. Each wait is twice the last."""

SILENT_S = 60.0  # time without data after which a message is shown, s
MAX_MESSAGES = 20
"""Number of different faults of a feed that are reported; further ones are only counted."""


class Follower:
    """Updates a live timeline from a source, until the source ends or `close` is called.

    `rejected`: number of invalid lines.
    `lost`: number of times the source was lost.
    `guard`: guard that holds lines whose time jumps too far.

    Thread: any. The follower's own thread updates `live`.
    """

    def __init__(self, live: LiveTimeline, source: Source) -> None:
        self.live = live
        self.guard = ClockGuard(live)
        self._source = source
        self._messages: deque[str] = deque(maxlen=200)
        self._reported: set[str] = set()
        self._over = threading.Event()
        self._stop = threading.Event()
        self._received_at = time.monotonic()
        self._silent = self._is_lost = False
        self.rejected = self.lost = 0
        self._thread = threading.Thread(target=self._run, name="feed", daemon=True)

    def start(self) -> Follower:
        """Start the thread."""
        self._thread.start()
        return self

    def close(self) -> None:
        """Stop the thread; wait for it at most the source's `close_timeout_s`."""
        self._stop.set()
        self._thread.join(self._source.close_timeout_s)

    @property
    def over(self) -> bool:
        """True after the source has ended or failed: no more data arrive."""
        return self._over.is_set()

    @property
    def status_text(self) -> str:
        """Status for display."""
        until = f"data until {clock_text(self.live.now_s)}"
        if self.live.ended:
            return f"the end, {until}"
        if self._is_lost:
            return f"feed lost, {until}"
        return until if not self.over else f"feed ended, {until}"

    def take_messages(self) -> tuple[str, ...]:
        """Return the messages added since the last call."""
        silent = time.monotonic() - self._received_at > SILENT_S and not self.over
        if silent and not self._silent and not self.live.ended:
            self._messages.append(f"{self._source.name}: silent; {self.status_text}")
        self._silent = silent
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    # --- the follower's thread ------------------------------------------------------------------

    def _run(self) -> None:
        wait_s = RETRY_S[0]
        try:
            while not self._stop.is_set():
                lines = Lines()
                items = self._source.read()
                try:
                    for item in items:
                        if self._stop.is_set():
                            return
                        if item is not None:
                            wait_s = RETRY_S[0]
                            self._receive(item, lines)
                    for line in lines.last():
                        self._apply_line(line)
                    return
                except LostError as error:
                    if not self._is_lost:
                        self._is_lost = True
                        self.lost += 1
                        self._report(f"lost ({error}); trying again")
                    # random, so that many followers of one server do not reconnect at once
                    wait_s = min(2.0 * wait_s, RETRY_S[1])
                    self._stop.wait(max(wait_s * random.uniform(0.5, 1.0), error.wait_s))
                finally:
                    if isinstance(items, Generator):
                        items.close()  # closes the file, connection or device now
        except InputError as error:
            self._messages.append(f"{error}; the feed is no longer followed")
        except Exception as error:  # a bug in this program must not stop the disk
            self._report(f"{type(error).__name__}: {error}")
        finally:
            self._over.set()

    def _receive(self, item: bytes | Timeline, lines: Lines) -> None:
        if item:
            self._received_at = time.monotonic()
        if self._is_lost:
            self._is_lost = False
            self._report("connected again")
        if isinstance(item, Timeline):
            self.live.replace(item)
            return
        before = lines.too_long
        for line in lines.cut(item):
            self._apply_line(line)
        if lines.too_long > before:
            self._reject(f"a line is longer than {MAX_LINE_BYTES >> 10} KB")

    def _apply_line(self, line: bytes) -> None:
        try:
            if self.guard.apply(line) == "later":
                self._reject("a line of a later version of the format")
        except InputError as error:
            self._reject(str(error))
        for text in self.guard.take_reports():
            self._report_once(text)

    def _reject(self, reason: str) -> None:
        self.rejected += 1
        self._report_once(f"line skipped: {reason}")

    def _report_once(self, text: str) -> None:
        if len(self._reported) < MAX_MESSAGES and text not in self._reported:
            self._reported.add(text)
            self._report(text)

    def _report(self, text: str) -> None:
        self._messages.append(f"{self._source.name}: {text}")
