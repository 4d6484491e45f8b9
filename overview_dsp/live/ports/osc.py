"""UDP ports: OSC comes in and goes out by them.

The disk's state to another program, by OSC, from a thread of its own.
"""

from __future__ import annotations

import errno
import select
import socket
import threading
import time
from collections.abc import Callable, Iterable

from overview_dsp.devices.controllers.osc_messages import require_osc
from overview_dsp.devices.controllers.osc_report import OscReport
from overview_dsp.errors import InputError
from overview_dsp.signal.engine.engine import Engine

HOST = "127.0.0.1"
MOST = 512
"""Datagrams read at a time; what comes faster waits in the system's buffer, and is lost beyond."""

LARGEST = 65_535


def parse_address(text: str, host: str = HOST) -> tuple[str, int]:
    """Host and port of `9000` or `0.0.0.0:9000` ([::1]:9000); InputError if it is neither."""
    given, colon, number = text.rpartition(":")
    if colon:
        host = given.removeprefix("[").removesuffix("]")
    if not (number.isascii() and number.isdigit() and 0 < int(number[:6]) < 65536) or not host:
        raise InputError(f"{text!r} is no port; it is 9000, or with a host 0.0.0.0:9000")
    return host, int(number)


class OscPort:
    """A port that is listened to.

    Attributes
    ----------
    name : str
        As `--input` names it.
    dropped : int
        Always 0: what the system drops it doesn't say.
    """

    dropped = 0

    def __init__(self, text: str) -> None:
        """Listen at `PORT` of this machine, or `HOST:PORT`.

        Raises
        ------
        InputError
            No such address, or another program listens there.
        OverviewError
            python-osc isn't installed.
        """
        require_osc()
        self.name = f"osc:{text}"
        host, port = parse_address(text)
        try:
            kind, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
            self._socket = socket.socket(kind, socket.SOCK_DGRAM)
            try:
                self._socket.bind(address)
            except OSError:
                self._socket.close()
                raise
        except OSError as error:
            raise InputError(f"{self.name}: {_why(error, host)}") from None
        self._socket.setblocking(False)

    def receive(self, wait_s: float) -> list[bytes]:
        """The datagrams that have come, waiting so long (s) for the first."""
        select.select([self._socket], [], [], wait_s)
        found: list[bytes] = []
        while len(found) < MOST:
            try:
                found.append(self._socket.recv(LARGEST))
            except BlockingIOError:
                break
            except OSError:  # of an earlier answer that nobody took; Windows says so here
                continue
        return found

    def close(self) -> None:
        """Give it back."""
        self._socket.close()


def _why(error: OSError, host: str) -> str:
    if error.errno == errno.EADDRINUSE:
        return "another program listens there; close it, or take another port"
    if error.errno == errno.EACCES:
        return "not allowed; take a port above 1023"
    if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
        return f"{host!r} is no address of this machine; 0.0.0.0 is all of them"
    return f"can't be opened ({error.strerror or error})"


class OscSender:
    """A place datagrams are sent to; what can't be delivered is lost, as by UDP."""

    def __init__(self, text: str) -> None:
        """Send to `HOST:PORT`, or to `PORT` of this machine.

        Raises
        ------
        InputError
            No such address.
        OverviewError
            python-osc isn't installed.
        """
        require_osc()
        host, port = parse_address(text)
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise InputError(f"{text}: no such host ({error.strerror or error})") from None
        self._address = found[4]
        self._socket = socket.socket(found[0], socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self.refused = 0

    def send(self, datagrams: Iterable[bytes]) -> None:
        """Send them all; what the system refuses is counted."""
        for one in datagrams:
            try:
                self._socket.sendto(one, self._address)
            except OSError:
                self.refused += 1

    def close(self) -> None:
        """Send no more."""
        self._socket.close()


EVERY_S = 0.01
AGAIN_S = 1.0
"""How long it waits after an error."""


class OscOut:
    """Sends what `OscReport` says, a hundred times a second.

    Thread: its own, the only one that takes the engine's strikes.
    """

    def __init__(
        self, engine: Engine, address: str, say: Callable[[str], None] = lambda line: None
    ) -> None:
        """Send to `HOST:PORT`, or to `PORT` of this machine, from now on; errors as `OscSender`.

        `say` is told of what a person should know, from this thread.
        """
        self._engine = engine
        self._address = address
        self._say = say
        self._sender = OscSender(address)
        self._report = OscReport()
        engine.take_strikes()  # only those from now on
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"osc out {address}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        said = set()
        while not self._over.wait(EVERY_S):
            try:
                self._send()
            except Exception as error:  # what it is can't be known: the next report may go
                line = f"osc out {self._address}: {type(error).__name__}: {error}; it goes on"
                if line not in said:
                    said.add(line)
                    self._say(line)
                self._over.wait(AGAIN_S)

    def _send(self) -> None:
        meters = self._engine.meters
        self._sender.send(
            self._report.due(
                time.monotonic(),
                meters.cursor,
                meters.torque,
                meters.touching,
                self._engine.take_struck_events(),
            )
        )

    def close(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join(2.0)
        self._sender.close()
