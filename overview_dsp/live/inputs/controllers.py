"""Controller input, whose thread reads a MIDI or OSC port; `poll` sets the parameters."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from overview_dsp.devices.controllers import control_messages as control
from overview_dsp.devices.controllers.midi_messages import MidiReader
from overview_dsp.devices.controllers.osc_messages import OscReader
from overview_dsp.devices.controllers.source import ControllerSource
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.inputs.threaded import ThreadedInput
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

TICK_S = 0.005
"""Interval at which a touch is updated while no messages arrive."""

Reader = MidiReader | OscReader
"""Converter of messages to movements and commands."""

Change = control.SetParameter | control.ScaleParameter | control.StepParameter
"""Change of a parameter."""


class ControllerInput(ThreadedInput):
    """Input that plays a controller into a running engine, as one source.

    Thread: as `ThreadedInput`.
    """

    _source: ControllerSource

    def __init__(
        self,
        engine: Engine,
        source: str,
        open_port: Callable[[], Port],
        make_reader: Callable[[control.Counters], Reader],
        silent_s: float | None = None,
        queue_command: Callable[..., None] = lambda *arguments: None,
        smooth_s: float = 0.0,
    ) -> None:
        """Open the port and start; `open_port` is called again when the port is lost.

        `source` is one of `gestures.SOURCES`. A touch ends after `silent_s` without messages (None:
        never). `queue_command` receives the words of each command, from this thread. Messages apply
        at the next block, or with a `smooth_s` (s) more evenly and that much later.

        InputError: the port can't be opened.
        """
        self._open_port = open_port
        self._make_reader = make_reader
        self._silent_s = silent_s
        self._queue_command = queue_command
        self.counters = control.Counters()
        port = open_port()
        super().__init__(engine, source, port, port.name, smooth_s)
        self._source = ControllerSource(TouchRules.of(self._preset))
        self._reader = make_reader(self.counters)
        self._changes: dict[str, Change] = {}
        self._changes_lock = threading.Lock()
        self._takeovers: dict[str, control.SoftTakeover] = {}
        self._rejected: set[str] = set()
        self._start()

    # --- the session's thread -------------------------------------------------------------------

    def poll(self, engine: Engine) -> None:
        """Use the rules of a changed preset, and set the parameters that were changed.

        Exception: the thread has failed with it.
        """
        super().poll(engine)
        with self._changes_lock:
            changes, self._changes = self._changes, {}
        for id, change in changes.items():
            try:
                self._set(engine, change)
            except InputError as error:
                self.counters.rejected += 1
                if id not in self._rejected:
                    self._rejected.add(id)
                    self.say_once(f"{error} (further ones are only counted)")
            except OverviewError:  # two surfaces are being crossfaded: try again at the next poll
                with self._changes_lock:
                    self._changes.setdefault(id, change)

    def _set(self, engine: Engine, change: Change) -> None:
        try:
            parameter, present = control.find_parameter(engine.preset, change.id)
        except InputError as error:
            if not self.counters.unknown:
                self.say_once(f"{error} (further ones are only counted)")
            self.counters.unknown += 1
            return
        if isinstance(change, control.SetParameter):
            value = parameter.check(control.coerce_value(parameter, change.value))
        elif isinstance(change, control.StepParameter):
            value = control.stepped_value(parameter, change, present)
        else:
            takeover = self._takeovers.setdefault(change.id, control.SoftTakeover())
            taken = takeover.value(engine.preset, change)
            if taken is None:
                return
            value = taken
        if value != present:
            engine.set(change.id, value)

    @property
    def status_text(self) -> str:
        """Line for the play screen: angle, and the counters that aren't zero."""
        state = "listening"
        if self._port is None:
            state = self.GONE
        elif self._source.holding:
            degrees = 180.0 * self._source.theta2 / HALF_TURN
            state = f"{self._source.holder}: {degrees:.0f}°, touching"
        return self._line(state, vars(self.counters))

    def _source_report(self) -> dict[str, Any]:
        return {
            "theta2_rad": round(self._source.theta2, 6),
            "holding": self._source.holding,
            **vars(self.counters),
        }

    # --- the port's thread ----------------------------------------------------------------------

    def _read(self, port: Port) -> None:
        messages = port.receive(TICK_S if self._source.holding else WAIT_S)
        self.counters.overrun += port.dropped
        port.dropped = 0
        self._process(messages, time.monotonic())

    def _process(self, messages: list[bytes], now: float) -> None:
        moves: list[tuple[float, control.Message]] = []
        for data in messages:
            time_s = getattr(data, "time_s", 0.0) or now
            moves += [(time_s, move) for move in self._reader.read(data, time_s)]
            self._writer.observe(time_s)
        moves += [(now, move) for move in self._reader.tick(now)]
        disk = self._writer.disk_state()
        events = []
        for time_s, move in moves:
            if isinstance(move, control.AngleChanged) and not self._source.rules.by_rest:
                self.say_once('a controller can\'t detect taps; set twist.release = "rest"')
            if isinstance(move, control.Command):
                self._queue_command(*move.arguments)
            elif isinstance(move, Change):
                with self._changes_lock:
                    before = self._changes.get(move.id)
                    if isinstance(move, step := control.StepParameter) and isinstance(before, step):
                        move = replace(move, step=before.step + move.step)
                    self._changes[move.id] = move
            elif isinstance(move, control.Scheduled):
                found = self._source.move(move.movement, time_s, disk)
                events += [replace(event, scheduled_s=move.time_s) for event in found]
            else:
                events += self._source.move(move, time_s, disk)
        events += self._source.tick(now, disk)
        for line in self._reader.take_messages():
            self.say_once(line)
        if self.counters.overrun:
            self.say_once("messages arrive too fast; the oldest are discarded and counted")
        if messages:
            self._received_at = now
        self._writer.tags.observe(time.monotonic(), self._engine.sample_time)
        self._writer.write(events)
        silent = self._silent_s is not None and now - self._received_at > self._silent_s
        if silent and self._write_release():
            self.say(f"no messages for {self._silent_s:g} s; disk released")

    def _release(self) -> Event | None:
        return self._source.release(time.monotonic())

    def _open_again(self) -> Port | None:
        try:
            port = self._open_port()
        except InputError:
            return None
        self._reader = self._make_reader(self.counters)
        return port
