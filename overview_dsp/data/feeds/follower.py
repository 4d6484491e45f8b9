"""Keeps a LiveTimeline up with a source, in a thread of its own; loses it and finds it again."""

from __future__ import annotations

import random
import threading
import time
from collections import deque
from collections.abc import Generator

from overview_dsp.data.feeds.feed_lines import Lines, take_line
from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.feeds.sources import Came, LostError, Source
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError
from overview_dsp.units import clock_text

AGAIN_S = (0.25, 15.0)
"""A lost source is tried again after so long, and then after twice as long each time, up to ..."""

SILENT_S = 60.0
"""Nothing for so long is told."""

MOST_SAID = 20
"""So many different faults of a feed are told; the rest is counted."""


class Follower:
    """Follows a source until it ends or `close`.

    Thread: `live` is fed by the follower's own; everything else any.

    Attributes
    ----------
    live : LiveTimeline
        What it keeps up.
    refused : int
        Lines that were none.
    lost : int
        How often the source was lost.
    """

    def __init__(self, live: LiveTimeline, source: Source) -> None:
        self.live = live
        self._source = source
        self._messages: deque[str] = deque(maxlen=200)
        self._said: set[str] = set()
        self._over = threading.Event()
        self._stop = threading.Event()
        self._heard_at = time.monotonic()
        self._silent = self._is_lost = False
        self.refused = self.lost = 0
        self._thread = threading.Thread(target=self._run, name="feed", daemon=True)

    def start(self) -> Follower:
        """Begin."""
        self._thread.start()
        return self

    def close(self) -> None:
        """Stop; a source that waits for longer than it may is left to itself."""
        self._stop.set()
        self._thread.join(self._source.ends_within_s)

    @property
    def over(self) -> bool:
        """Whether nothing more comes: the source has ended, or can't be followed."""
        return self._over.is_set()

    @property
    def words(self) -> str:
        """How it stands, for a person."""
        until = f"data until {clock_text(self.live.now_s)}"
        if self.live.ended:
            return f"the end, {until}"
        if self._is_lost:
            return f"feed lost, {until}"
        return until if not self.over else f"feed ended, {until}"

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        silent = time.monotonic() - self._heard_at > SILENT_S and not self.over
        if silent and not self._silent and not self.live.ended:
            self._messages.append(f"{self._source.name}: silent; {self.words}")
        self._silent = silent
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    # --- the follower's thread ------------------------------------------------------------------

    def _run(self) -> None:
        wait_s = AGAIN_S[0]
        try:
            while not self._stop.is_set():
                lines = Lines()
                coming = self._source.come()
                try:
                    for came in coming:
                        if self._stop.is_set():
                            return
                        if came is not None:
                            wait_s = AGAIN_S[0]
                            self._take(came, lines)
                    for line in lines.last():
                        self._take_line(line)
                    return
                except LostError as error:
                    self._lose(error)
                    # apart from each other, where many have lost the same server
                    wait_s = min(2.0 * wait_s, AGAIN_S[1])
                    self._stop.wait(max(wait_s * random.uniform(0.5, 1.0), error.wait_s))
                finally:
                    if isinstance(coming, Generator):
                        coming.close()  # what it opened is given back here, and now
        except InputError as error:
            self._messages.append(f"{error}; nothing more is followed")
        except Exception as error:  # a fault of this program: the disk plays on
            self._messages.append(f"{self._source.name}: {type(error).__name__}: {error}")
        finally:
            self._over.set()

    def _take(self, came: Came, lines: Lines) -> None:
        if came:
            self._heard_at = time.monotonic()
        if self._is_lost:
            self._is_lost = False
            self._messages.append(f"{self._source.name}: is back")
        if isinstance(came, Timeline):
            self.live.replace(came)
            return
        assert came is not None
        before = lines.too_long
        for line in lines.cut(came):
            self._take_line(line)
        if lines.too_long > before:
            self._refuse("a line longer than 64 KB")

    def _take_line(self, line: bytes) -> None:
        try:
            if take_line(self.live, line) == "later":
                self._refuse("a line of a later version of the format")
        except InputError as error:
            self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        self.refused += 1
        if len(self._said) < MOST_SAID and why not in self._said:
            self._said.add(why)
            self._messages.append(f"{self._source.name}: passed over: {why}")

    def _lose(self, error: LostError) -> None:
        if not self._is_lost:
            self._is_lost = True
            self.lost += 1
            self._messages.append(f"{self._source.name}: lost ({error}); it is tried again")
