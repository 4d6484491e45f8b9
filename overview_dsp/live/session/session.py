"""Session: an engine, what it has counted so far, and the messages for the user."""

from __future__ import annotations

from collections import deque

from overview_dsp.signal.engine.engine import Engine


class Session:
    """An engine and the messages of a live session, which all parts of its player share.

    Thread: control; `say` from any.

    Attributes
    ----------
    engine : Engine
        Prepared; it may begin again while the session goes on.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self._messages: deque[str] = deque()
        self._played_before_s = 0.0
        self._dropped_before = 0

    def say(self, line: str) -> None:
        """Show the user a message; from any thread."""
        self._messages.append(line)

    def take_messages(self) -> tuple[str, ...]:
        """Return the messages added since the last call."""
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    @property
    def played_s(self) -> float:
        """Time played since the session began, s."""
        return self._played_before_s + self.engine.sample_time / self.engine.sample_rate

    @property
    def dropped_events(self) -> int:
        """Control events dropped since the session began."""
        return self._dropped_before + self.engine.meters.dropped_events

    def keep_counts(self) -> None:
        """Add up what the engine has counted: it is about to count from 0 again."""
        self._played_before_s, self._dropped_before = self.played_s, self.dropped_events
