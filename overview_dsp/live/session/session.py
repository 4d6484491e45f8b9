"""Session: an engine, its counters across restarts, and the messages for the user."""

from __future__ import annotations

from collections import deque

from overview_dsp.signal.engine.engine import Engine


class Session:
    """Engine and messages of a live session, which all parts of its player share.

    Thread: control; any thread may call `say`.

    Attributes
    ----------
    engine : Engine
        Prepared engine; it may be restarted during the session.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self._messages: deque[str] = deque()
        self._played_before_s = 0.0
        self._dropped_before = 0

    def say(self, line: str) -> None:
        """Add a message for the user."""
        self._messages.append(line)

    def take_messages(self) -> tuple[str, ...]:
        """Return the messages added since the last call."""
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    @property
    def played_s(self) -> float:
        """Time played since the start of the session, s."""
        return self._played_before_s + self.engine.sample_time / self.engine.sample_rate

    @property
    def dropped_events(self) -> int:
        """Control events dropped since the start of the session."""
        return self._dropped_before + self.engine.meters.dropped_events

    def keep_counts(self) -> None:
        """Keep the engine's counts; call this before the engine restarts and counts from 0."""
        self._played_before_s, self._dropped_before = self.played_s, self.dropped_events
