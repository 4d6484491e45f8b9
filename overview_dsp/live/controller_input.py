"""A controller as a hand: its own thread reads, and hands events over; parameters go by `poll`."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from overview_dsp.controllers.control_messages import Asked, Counters, Dialled, Move, Turned
from overview_dsp.controllers.parameters import PickUp, as_asked, find_parameter
from overview_dsp.controllers.source import ControllerHand
from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.hand_writer import HandWriter
from overview_dsp.live.player import Input
from overview_dsp.live.port_lost import PortLostError
from overview_dsp.presets.model import Preset
from overview_dsp.sensors.touching import TouchRules
from overview_dsp.units import HALF_TURN

WAIT_S = 0.05
TICK_S = 0.005
"""How often what holds on is looked after, while nothing comes."""

RETRY_S = 1.0


class Port(Protocol):
    """Where messages come from: UDP, a MIDI port, or a test's."""

    name: str
    dropped: int

    def receive(self, wait_s: float) -> list[bytes]:
        """What has come, waiting so long (s) for the first; PortLostError if nothing more will."""

    def close(self) -> None:
        """Give it back."""


class Reader(Protocol):
    """Messages in, moves out."""

    counters: Counters

    def read(self, data: bytes, time_s: float) -> list[Move]:
        """The moves of a message."""

    def tick(self, time_s: float) -> list[Move]:
        """The moves that time alone makes."""

    def take_messages(self) -> list[str]:
        """What a person should know, new since the last call."""


class ControllerInput(Input):
    """Plays a controller into a running engine, as one source.

    Thread: control; the port is read in a thread of its own, the only writer of that source.
    """

    def __init__(
        self,
        engine: Engine,
        source: str,
        open_port: Callable[[], Port],
        make_reader: Callable[[Counters], Reader],
        silent_s: float | None = None,
    ) -> None:
        """Open the port and begin; `open_port` is called again when it is lost.

        `source`: one of `gestures.SOURCES`; `silent_s`: one that holds on and says nothing for so
        long lets go (None: never).

        Raises
        ------
        InputError
            The port can't be opened.
        """
        self._engine = engine
        self._open_port = open_port
        self._make_reader = make_reader
        self._silent_s = silent_s
        self.counters = Counters()
        self._preset: Preset = engine.preset
        self._port: Port | None = open_port()
        self._name = self._port.name
        self._reader = make_reader(self.counters)
        self._hand = ControllerHand(TouchRules.of(self._preset))
        self._writer = HandWriter(engine, source)
        self._messages: deque[str] = deque()
        self._said: set[str] = set()
        self._wanted: dict[str, Asked | Dialled] = {}
        self._wanting = threading.Lock()
        self._pick_ups: dict[str, PickUp] = {}
        self._heard_at = time.monotonic()
        self._lost = 0
        self._over = threading.Event()
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    # --- the session's thread -------------------------------------------------------------------

    def poll(self, engine: Engine) -> None:
        """Take over a changed preset's rules, and set the parameters that were asked for.

        Raises
        ------
        Exception
            What ended the thread, if anything did.
        """
        if self._failure is not None:
            raise self._failure
        if engine.preset is not self._preset:
            self._preset = engine.preset
            self._hand.rules = TouchRules.of(self._preset)
        with self._wanting:
            wanted, self._wanted = self._wanted, {}
        for id, asked in wanted.items():
            try:
                self._set(engine, asked)
            except InputError as error:
                self.counters.refused += 1
                self._say(str(error))
            except OverviewError:  # two surfaces fade already: the next time, unless another came
                with self._wanting:
                    self._wanted.setdefault(id, asked)

    def _set(self, engine: Engine, asked: Asked | Dialled) -> None:
        known, present = find_parameter(engine.preset, asked.id)
        if isinstance(asked, Asked):
            value = known.check(as_asked(known, asked.value))
        else:
            picked = self._pick_ups.setdefault(asked.id, PickUp()).value(engine.preset, asked)
            if picked is None:
                return
            value = picked
        if value != present:
            engine.set(asked.id, value)

    def is_over(self, engine: Engine) -> bool:
        """Never: one that is gone is waited for."""
        return False

    def close(self) -> None:
        """Let go and give the port back."""
        self._over.set()
        self._thread.join(2.0)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        said = []
        while self._messages:
            said.append(f"{self._name}: {self._messages.popleft()}")
        return tuple(said)

    @property
    def words(self) -> str:
        """A line for the play screen: its angle, the counters that aren't zero."""
        counted = ", ".join(
            f"{value} {name}" for name, value in vars(self.counters).items() if value
        )
        hold = (
            f"{180.0 * self._hand.theta2 / HALF_TURN:.0f}°, holding" if self._hand.holding else ""
        )
        state = "gone" if self._port is None else hold or "listening"
        return f"{self._name}: {state}; {counted or 'nothing yet'}"

    def report(self) -> dict[str, Any]:
        """Everything counted, and how long events wait for their sample, ms."""
        median, highest = self._writer.waits_s
        return {
            "port": self._name,
            "connected": self._port is not None,
            "connections_lost": self._lost,
            "theta2_rad": round(self._hand.theta2, 6),
            "holding": self._hand.holding,
            **vars(self.counters),
            "wait_p50_ms": round(1e3 * median, 2),
            "wait_p99_ms": round(1e3 * highest, 2),
        }

    # --- the port's thread ----------------------------------------------------------------------

    def _run(self) -> None:
        try:
            while not self._over.is_set():
                self._turn_round()
        except Exception as error:  # shown by the session, which polls
            self._failure = error
        self._let_go()
        if self._port is not None:
            self._port.close()

    def _turn_round(self) -> None:
        if self._port is None:
            self._over.wait(RETRY_S)
            self._find_again()
            return
        try:
            came = self._port.receive(TICK_S if self._hand.holding else WAIT_S)
        except PortLostError:
            self._lose()
            return
        self.counters.overrun += self._port.dropped
        self._port.dropped = 0
        self._take(came, time.monotonic())

    def _take(self, came: list[bytes], now: float) -> None:
        moves = [move for data in came for move in self._reader.read(data, now)]
        moves += self._reader.tick(now)
        found = self._writer.find()
        events = []
        for move in moves:
            if isinstance(move, Turned) and not self._hand.rules.by_rest:
                self._say('a control feels no taps: choose twist.release = "rest"')
            if isinstance(move, Asked | Dialled):
                with self._wanting:
                    self._wanted[move.id] = move
            else:
                events += self._hand.move(move, now, *found)
        events += self._hand.tick(now, *found)
        for line in self._reader.take_messages():
            self._say(line)
        if self.counters.overrun:
            self._say("more comes than can be read; the oldest is given up (counted on)")
        if came:
            self._heard_at = now
            self._writer.saw(now)
        self._writer.write(events)
        silent = self._silent_s is not None and now - self._heard_at > self._silent_s
        if silent and self._let_go():
            self._messages.append(f"silent for {self._silent_s:g} s; the disk is let go")

    def _let_go(self) -> bool:
        return self._writer.let_go(self._hand.release(time.monotonic()))

    def _lose(self) -> None:
        assert self._port is not None
        self._let_go()
        self._port.close()
        self._port = None
        self._lost += 1
        self._messages.append("gone; the disk is let go, waiting for it to come back")

    def _find_again(self) -> None:
        try:
            self._port = self._open_port()
        except InputError:
            return
        self._reader = self._make_reader(self.counters)
        self._writer.restart()
        self._heard_at = time.monotonic()
        self._messages.append("is back")

    def _say(self, line: str) -> None:
        if line not in self._said:
            self._said.add(line)
            self._messages.append(line)
