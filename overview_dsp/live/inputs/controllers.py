"""A controller as a hand: its own thread reads, and hands events over; parameters go by `poll`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from overview_dsp.devices.controllers.control_messages import (
    AngleChanged,
    Command,
    Counters,
    ScaleParameter,
    SetParameter,
    StepParameter,
)
from overview_dsp.devices.controllers.midi_messages import MidiReader
from overview_dsp.devices.controllers.osc_messages import OscReader
from overview_dsp.devices.controllers.parameters import (
    SoftTakeover,
    coerce_value,
    find_parameter,
    stepped_value,
)
from overview_dsp.devices.controllers.source import ControllerSource
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.inputs.threaded import ThreadedInput
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

TICK_S = 0.005
"""How often what holds on is looked after, while nothing comes."""


Reader = MidiReader | OscReader
"""Messages in, moves out."""


class ControllerInput(ThreadedInput):
    """Plays a controller into a running engine, as one source.

    Thread: as `ThreadedInput`.
    """

    _source: ControllerSource

    def __init__(
        self,
        engine: Engine,
        source: str,
        open_port: Callable[[], Port],
        make_reader: Callable[[Counters], Reader],
        silent_s: float | None = None,
        ask: Callable[..., None] = lambda *words: None,
    ) -> None:
        """Open the port and begin; `open_port` is called again when it is lost.

        `source`: one of `gestures.SOURCES`; `silent_s`: one that holds on and says nothing for so
        long lets go (None: never); `ask` receives the words of commands, from this thread.

        Raises
        ------
        InputError
            The port can't be opened.
        """
        self._open_port = open_port
        self._make_reader = make_reader
        self._silent_s = silent_s
        self._ask = ask
        self.counters = Counters()
        port = open_port()
        super().__init__(engine, source, port, port.name)
        self._source = ControllerSource(TouchRules.of(self._preset))
        self._reader = make_reader(self.counters)
        self._wanted: dict[str, SetParameter | ScaleParameter | StepParameter] = {}
        self._wanting = threading.Lock()
        self._pick_ups: dict[str, SoftTakeover] = {}
        self._refused: set[str] = set()
        self._begin()

    # --- the session's thread -------------------------------------------------------------------

    def poll(self, engine: Engine) -> None:
        """Take over a changed preset's rules, and set the parameters that were asked for.

        Raises
        ------
        Exception
            What ended the thread, if anything did.
        """
        super().poll(engine)
        with self._wanting:
            wanted, self._wanted = self._wanted, {}
        for id, asked in wanted.items():
            try:
                self._set(engine, asked)
            except InputError as error:
                self.counters.rejected += 1
                if id not in self._refused:
                    self._refused.add(id)
                    self._say_once(f"{error} (the first of them; counted on)")
            except OverviewError:  # two surfaces fade already: the next time, unless another came
                with self._wanting:
                    self._wanted.setdefault(id, asked)

    def _set(self, engine: Engine, asked: SetParameter | ScaleParameter | StepParameter) -> None:
        try:
            known, present = find_parameter(engine.preset, asked.id)
        except InputError as error:
            if not self.counters.unknown:
                self._say_once(f"{error} (the first of them; counted on)")
            self.counters.unknown += 1
            return
        if isinstance(asked, SetParameter):
            value = known.check(coerce_value(known, asked.value))
        elif isinstance(asked, StepParameter):
            value = stepped_value(known, asked, present)
        else:
            picked = self._pick_ups.setdefault(asked.id, SoftTakeover()).value(engine.preset, asked)
            if picked is None:
                return
            value = picked
        if value != present:
            engine.set(asked.id, value)

    @property
    def words(self) -> str:
        """A line for the play screen: its angle, the counters that aren't zero."""
        hold = (
            f"{180.0 * self._source.theta2 / HALF_TURN:.0f}°, holding"
            if self._source.holding
            else ""
        )
        state = self.GONE if self._port is None else hold or "listening"
        return self._line(state, vars(self.counters))

    def _counted(self) -> dict[str, Any]:
        return {
            "theta2_rad": round(self._source.theta2, 6),
            "holding": self._source.holding,
            **vars(self.counters),
        }

    # --- the port's thread ----------------------------------------------------------------------

    def _read(self, port: Port) -> None:
        came = port.receive(TICK_S if self._source.holding else WAIT_S)
        self.counters.overrun += port.dropped
        port.dropped = 0
        self._take(came, time.monotonic())

    def _take(self, came: list[bytes], now: float) -> None:
        moves = [move for data in came for move in self._reader.read(data, now)]
        moves += self._reader.tick(now)
        found = self._writer.find()
        events = []
        for move in moves:
            if isinstance(move, AngleChanged) and not self._source.rules.by_rest:
                self._say_once('a control feels no taps: choose twist.release = "rest"')
            if isinstance(move, Command):
                self._ask(*move.arguments)
            elif isinstance(move, SetParameter | ScaleParameter | StepParameter):
                with self._wanting:
                    before = self._wanted.get(move.id)
                    if isinstance(move, StepParameter) and isinstance(before, StepParameter):
                        move = replace(move, step=before.step + move.step)
                    self._wanted[move.id] = move
            else:
                events += self._source.move(move, now, *found)
        events += self._source.tick(now, *found)
        for line in self._reader.take_messages():
            self._say_once(line)
        if self.counters.overrun:
            self._say_once("more comes than can be read; the oldest is given up (counted on)")
        if came:
            self._heard_at = now
            self._writer.saw(now)
        self._writer.write(events)
        silent = self._silent_s is not None and now - self._heard_at > self._silent_s
        if silent and self._let_go():
            self._messages.append(f"silent for {self._silent_s:g} s; the disk is let go")

    def _release(self) -> Event | None:
        return self._source.release(time.monotonic())

    def _open_again(self) -> Port | None:
        try:
            port = self._open_port()
        except InputError:
            return None
        self._reader = self._make_reader(self.counters)
        return port
