"""Inputs without a device: a take that is replayed, and text lines on standard input."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import SOURCES, Gesture
from overview_dsp.devices.messages import Messages
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.session.command_forms import parse_command
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.replay import apply_change
from overview_dsp.validation import float_or_nan

AHEAD_S = 0.5
"""Time before its sample at which an event of a take is sent to the engine."""

CHANGES_AHEAD_S = 0.1
"""Time before its sample at which a change of a take is applied."""

FIRST_S = 0.2
"""Time from the first poll to the start of a take."""

MAX_EVENTS = 2000
"""Maximum number of events sent per poll; the engine's ring has 4096."""


class TakeInput(Input):
    """Input that replays a gesture in a running engine, with exact samples.

    Thread: control; call `poll` at least four times per second.
    """

    def __init__(
        self, gesture: Gesture, change: Callable[[Mapping[str, Any], int], None] | None = None
    ) -> None:
        """Replay `gesture` from 0.2 s after the first `poll`, or from the sample of `begin`.

        `change` applies one of its changes at a sample (None: to the engine).
        """
        self._gesture = gesture
        self._change = change
        self._start: int | None = None
        self._sent = self._changed = 0

    def begin(self, engine: Engine, start: int, whole: Timeline) -> None:
        """Replay from a sample on; windows of its changes refer to the timeline `whole`."""
        self._start, self._whole = start, whole
        self._stamps = self._gesture.stamps(engine.sample_rate) + start
        self.poll(engine)

    def poll(self, engine: Engine) -> None:
        """Send events and changes that are due soon."""
        rate = engine.sample_rate
        if self._start is None:
            self.begin(engine, engine.sample_time + round(FIRST_S * rate), engine.timeline)
            return
        horizon = engine.sample_time + round(AHEAD_S * rate)
        due = int(np.searchsorted(self._stamps, horizon))
        for i in range(self._sent, min(due, self._sent + MAX_EVENTS)):
            engine.control(
                float(self._gesture.theta2[i]), bool(self._gesture.touching[i]),
                int(self._stamps[i]), SOURCES[self._gesture.source[i]],
            )  # fmt: skip
            self._sent = i + 1
        for change in self._gesture.changes[self._changed :]:
            sample = self._start + round(change.time_s * rate)
            if sample > engine.sample_time + round(CHANGES_AHEAD_S * rate):
                break
            try:
                if self._change is not None:
                    self._change(change.what, sample)
                else:
                    self._whole = apply_change(engine, self._whole, change.what, sample)
            except InputError:
                raise
            except OverviewError:  # two surfaces are being crossfaded: try again at the next poll
                break
            self._changed += 1

    def is_over(self, engine: Engine) -> bool:
        """Return whether the whole gesture has been replayed."""
        if self._start is None:
            return False
        end = self._start + round(self._gesture.duration_s * engine.sample_rate)
        return self._sent == len(self._stamps) and engine.sample_time >= end


class TextLineInput(Messages, Input):
    """Input of text lines `theta2 touching` (rad, 0 or 1), read in a thread of its own.

    A line may also be a command, or one of the keys `R`, `P`, `1` and `2`. Other lines are counted,
    and the first of them is kept. The end of the text releases the disk.
    """

    SOURCE = "twist"

    def __init__(
        self,
        lines: Iterable[str],
        engine: Engine,
        queue_command: Callable[..., None] = lambda *arguments: None,
    ) -> None:
        """Start to read; `queue_command` receives the words of each command."""
        super().__init__()
        self._queue_command = queue_command
        self._lines = lines
        self._engine = engine
        self.rejected = 0
        self.first_rejected = ""
        self._over = threading.Event()
        threading.Thread(target=self._run, name="standard input", daemon=True).start()

    def _run(self) -> None:
        theta2 = 0.0
        try:
            for number, line in enumerate(self._lines, 1):
                if not line.strip():
                    continue
                if (command := parse_command(line)) is not None:
                    self._queue_command(*command)
                elif (event := parse_line(line)) is not None:
                    theta2 = event[0]
                    self._engine.control(*event, source=self.SOURCE)
                else:
                    self.rejected += 1
                    self.first_rejected = self.first_rejected or f"line {number}: {line.strip()!r}"
        except Exception as error:  # such as text that isn't UTF-8
            self.say(f"standard input: {error}; reading stopped")
        finally:
            self._engine.control(theta2, False, source=self.SOURCE)
            self._over.set()

    def poll(self, engine: Engine) -> None:
        """Do nothing: the thread sends the events."""

    def is_over(self, engine: Engine) -> bool:
        """Return whether the text has ended."""
        return self._over.is_set()


def parse_line(line: str) -> tuple[float, bool] | None:
    """Parse `theta2 touching` (rad, 0 or 1), with an optional comma; None for other text."""
    fields = line.replace(",", " ").split()
    if len(fields) != 2 or fields[1] not in ("0", "1"):
        return None
    theta2 = float_or_nan(fields[0])
    return (theta2, fields[1] == "1") if math.isfinite(theta2) else None
