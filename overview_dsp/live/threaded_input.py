"""A hand whose port is read in a thread of its own: begun, lost, found again, ended."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from overview_dsp.devices.sensors.touching import Event, TouchRules
from overview_dsp.live.hand import Input
from overview_dsp.live.port_lost import PortLostError
from overview_dsp.live.source_writer import SourceWriter
from overview_dsp.signal.engine.engine import Engine

RETRY_S = 1.0

Port = TypeVar("Port")


class ThreadedInput(Input, ABC, Generic[Port]):
    """Plays what a port brings into a running engine, as one source.

    Thread: control; the port is read in a thread of its own, the only writer of that source.
    """

    KIND = ""  # what messages put before the port's name
    GONE = "gone"  # what a port is that was lost

    _source: Any  # what makes events of what is read, by `rules`
    _port: Any  # None while it is lost

    def __init__(self, engine: Engine, source: str, port: Port, where: str) -> None:
        """Before `_begin`. `source`: one of `gestures.SOURCES`; `where`: the open port's name."""
        self._engine = engine
        self._preset = engine.preset
        self._where = where
        self._port = port
        self._writer = SourceWriter(engine, source)
        self._messages: deque[str] = deque()
        self._said: set[str] = set()
        self._heard_at = time.monotonic()
        self._lost = 0
        self._over = threading.Event()
        self._failure: Exception | None = None

    def _begin(self) -> None:
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    @property
    def _name(self) -> str:
        return self.KIND + self._where

    # --- the session's thread -------------------------------------------------------------------

    def poll(self, engine: Engine) -> None:
        """Take over a changed preset's rules; the thread does the rest.

        Raises
        ------
        Exception
            What ended the thread, if anything did.
        """
        if self._failure is not None:
            raise self._failure
        if engine.preset is not self._preset:
            self._preset = engine.preset
            self._source.rules = TouchRules.of(self._preset)

    def is_over(self, engine: Engine) -> bool:
        """Never: what is gone is waited for."""
        return False

    def close(self) -> None:
        """Let go and give the port back."""
        self._over.set()
        self._thread.join(2.0)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        new = [self._messages.popleft() for _ in range(len(self._messages))]
        return tuple(f"{self._name}: {one}" for one in new)

    def _line(self, state: str, counters: Mapping[str, int]) -> str:
        """A line for the play screen: a state, and the counters that aren't zero."""
        counted = ", ".join(
            f"{value} {name.replace('_', ' ')}" for name, value in counters.items() if value
        )
        return f"{self._name}: {state}; {counted or 'nothing yet'}"

    def report(self) -> dict[str, Any]:
        """Everything counted, and how long events wait for their sample, ms."""
        median, highest = self._writer.waits_s
        return {
            "port": self._where,
            "connected": self._port is not None,
            "connections_lost": self._lost,
            **self._counted(),
            "wait_p50_ms": round(1e3 * median, 2),
            "wait_p99_ms": round(1e3 * highest, 2),
        }

    @abstractmethod
    def _counted(self) -> dict[str, Any]:
        """What `report` says of the hand."""

    # --- the port's thread ----------------------------------------------------------------------

    @abstractmethod
    def _read(self, port: Port) -> None:
        """Wait a little for something to come, and hand it over; PortLostError."""

    @abstractmethod
    def _release(self) -> Event | None:
        """Let the hand go: its last event, if it held on."""

    @abstractmethod
    def _open_again(self) -> Port | None:
        """The lost port, if it is back, with everything that reads it as new."""

    def _run(self) -> None:
        try:
            while not self._over.is_set():
                if self._port is None:
                    self._over.wait(RETRY_S)
                    self._find_again()
                    continue
                try:
                    self._read(self._port)
                except PortLostError:
                    self._lose()
        except Exception as error:  # shown by the session, which polls
            self._failure = error
        self._let_go()
        if self._port is not None:
            self._port.close()

    def _let_go(self) -> bool:
        return self._writer.let_go(self._release())

    def _lose(self) -> None:
        self._let_go()
        self._port.close()
        self._port = None
        self._lost += 1
        self._messages.append(f"{self.GONE}; the disk is let go, waiting for it to come back")

    def _find_again(self) -> None:
        if (port := self._open_again()) is not None:
            self._writer.restart()
            self._heard_at = time.monotonic()
            self._port = port
            self._messages.append("is back")

    def _say_once(self, line: str) -> None:
        if line not in self._said:
            self._said.add(line)
            self._messages.append(line)
