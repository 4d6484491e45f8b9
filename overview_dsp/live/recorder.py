"""What the kernel applied, kept while it plays, for a take that replays every bit."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from overview_dsp.engine.engine import Engine
from overview_dsp.errors import OverviewError
from overview_dsp.gestures import save_take


class Recorder:
    """Collects an engine's applied events and changes from its first sample on.

    Thread: control; `poll` at least ten times a second.
    """

    def __init__(self, engine: Engine) -> None:
        """Begin with a prepared engine that has processed nothing yet."""
        if engine.sample_time != 0:
            raise OverviewError("a recording begins with the engine's first sample; reset it first")
        self._engine = engine
        self._seen = 0
        self._events: list[Any] = []
        self._changes: list[tuple[int, Mapping[str, Any]]] = []
        self.count = 0

    def poll(self) -> None:
        """Fetch what was applied since the last time.

        Raises
        ------
        OverviewError
            More was applied than the logs keep, or a surface that no take can hold.
        """
        events, self._seen = self._engine.take_applied(self._seen)
        if len(events):
            self._events.append(events)
            self.count += len(events)
        for sample, what in self._engine.take_changes():
            if what is None:
                raise OverviewError(
                    "a surface was set that a take can't hold; use set, set_preset or set_timeline"
                )
            self._changes.append((sample, what))

    def save(self, path: str | os.PathLike[str], about: Mapping[str, Any]) -> None:
        """Write the take up to now; its last line repeats the last event at the present sample.

        Raises
        ------
        InputError, OutputError
            An unwritable place, a full disk.
        """
        self.poll()
        events = [tuple(event.tolist()) for part in self._events for event in part]
        now = self._engine.sample_time
        _, source, theta2, touching = events[-1] if events else (0, 0, 0.0, False)
        if not events or events[-1][0] < now:
            events.append((now, source, theta2, touching))
        about = {"seed": self._engine.seed, **about}
        save_take(path, events, self._engine.sample_rate, about, self._changes)
