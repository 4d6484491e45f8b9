"""Session: an engine, its counters across restarts, and the messages for the user."""

from __future__ import annotations

from overview_dsp.devices.messages import Messages
from overview_dsp.signal.engine.engine import Engine


class Session(Messages):
    """Engine and messages of a live session, which all parts of its player share.

    Thread: control; any thread may call `say`.

    Attributes
    ----------
    engine : Engine
        Prepared engine; it may be restarted during the session.
    """

    def __init__(self, engine: Engine) -> None:
        super().__init__()
        self.engine = engine
        self._played_before_s = 0.0
        self._dropped_before = 0

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
