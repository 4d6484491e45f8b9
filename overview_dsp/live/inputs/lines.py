"""Sources other than the keyboard: a take, and lines on standard input."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import SOURCES, Gesture
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.session.command_forms import parse_command
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.replay import apply_change

AHEAD_S = 0.5
"""A take's events are handed over this long before they are due."""

CHANGES_AHEAD_S = 0.1

FIRST_S = 0.2
"""A take begins so long after the stream."""

AT_MOST = 2000
"""Events handed over at a time: the engine's ring holds 4096."""


class TakeInput(Input):
    """Plays a gesture into a running engine, sample by sample.

    Thread: control; `poll` at least four times a second.
    """

    def __init__(
        self,
        gesture: Gesture,
        change: Callable[[Mapping[str, Any], int], None] | None = None,
    ) -> None:
        """Play `gesture`, from soon after the first `poll` or from the sample of `begin`.

        `change` makes a change of it at a sample (None: in the engine).
        """
        self._gesture = gesture
        self._change = change
        self._at: int | None = None
        self._fed = self._changed = 0

    def begin(self, engine: Engine, at: int, whole: Timeline) -> None:
        """Play from a sample on; windows of its changes are of the timeline `whole`."""
        self._at, self._whole = at, whole
        self._stamps = self._gesture.stamps(engine.sample_rate) + at
        self.poll(engine)

    def poll(self, engine: Engine) -> None:
        """Hand over what is due soon."""
        rate = engine.sample_rate
        if self._at is None:
            self.begin(engine, engine.sample_time + round(FIRST_S * rate), engine.timeline)
            return
        horizon = engine.sample_time + round(AHEAD_S * rate)
        due = int(np.searchsorted(self._stamps, horizon))
        for i in range(self._fed, min(due, self._fed + AT_MOST)):
            engine.control(
                float(self._gesture.theta2[i]),
                bool(self._gesture.touching[i]),
                int(self._stamps[i]),
                SOURCES[self._gesture.source[i]],
            )
            self._fed = i + 1
        changes = self._gesture.changes
        while self._changed < len(changes):
            sample = self._at + round(changes[self._changed].time_s * rate)
            if sample > engine.sample_time + round(CHANGES_AHEAD_S * rate):
                break
            try:
                if self._change is not None:
                    self._change(changes[self._changed].what, sample)
                else:
                    what = changes[self._changed].what
                    self._whole = apply_change(engine, self._whole, what, sample)
            except InputError:
                raise
            except OverviewError:  # two surfaces fade already: at the next poll
                break
            self._changed += 1

    def is_over(self, engine: Engine) -> bool:
        """Whether the whole gesture has been played."""
        if self._at is None:
            return False
        end = self._at + round(self._gesture.duration_s * engine.sample_rate)
        return self._fed == len(self._stamps) and engine.sample_time >= end


class LineInput(Input):
    """Control events as lines of text, `theta2 touching` (rad, 0 or 1), from a thread of its own.

    `R`, `P`, `1` and `2` on a line of their own are those keys of the screen, and commands are
    understood. Lines of another form are counted and the first one is reported; the end of the text
    lets go.
    """

    SOURCE = "twist"

    def __init__(
        self,
        lines: Iterable[str],
        engine: Engine,
        ask: Callable[..., None] = lambda *words: None,
    ) -> None:
        """Begin to read; `ask` receives the words of lines that are commands."""
        self._ask = ask
        self._lines = lines
        self._engine = engine
        self.refused = 0
        self.first_refused = ""
        self._messages: deque[str] = deque()
        self._over = threading.Event()
        threading.Thread(target=self._run, name="standard input", daemon=True).start()

    def _run(self) -> None:
        theta2 = 0.0
        try:
            for number, line in enumerate(self._lines, 1):
                if not line.strip():
                    continue
                event = parse_line(line)
                command = parse_command(line)
                if command is not None:
                    self._ask(*command)
                    continue
                if event is None:
                    self.refused += 1
                    self.first_refused = self.first_refused or f"line {number}: {line.strip()!r}"
                    continue
                theta2 = event[0]
                self._engine.control(*event, source=self.SOURCE)
        except Exception as error:  # not UTF-8, say
            self._messages.append(f"standard input: {error}; nothing more is read of it")
        finally:
            self._engine.control(theta2, False, source=self.SOURCE)
            self._over.set()

    def poll(self, engine: Engine) -> None:
        """Nothing to do: the thread hands events over itself."""

    def take_messages(self) -> tuple[str, ...]:
        """Why it has ended, if that isn't the text's end."""
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    def is_over(self, engine: Engine) -> bool:
        """Whether the text has ended."""
        return self._over.is_set()


def parse_line(line: str) -> tuple[float, bool] | None:
    """`theta2 touching` (rad, 0 or 1; a comma may stand between), or None if it isn't that."""
    fields = line.replace(",", " ").split()
    if len(fields) != 2 or fields[1] not in ("0", "1"):
        return None
    try:
        theta2 = float(fields[0])
    except ValueError:
        return None
    return (theta2, fields[1] == "1") if math.isfinite(theta2) else None
