"""OSC over UDP: a port that receives, and a thread that sends the disk's state."""

from __future__ import annotations

import contextlib
import errno
import select
import socket
import threading
import time
from collections.abc import Callable

from overview_dsp.devices.controllers.osc_messages import OscReport, require_osc
from overview_dsp.errors import InputError
from overview_dsp.live.ports.port import Datagram, Port
from overview_dsp.signal.engine.engine import Engine

HOST = "127.0.0.1"
MAX_DATAGRAMS = 512
"""Maximum number of datagrams per read. More wait in the system's buffer, or are lost if it is
full."""

MAX_DATAGRAM_BYTES = 65_535


def parse_address(text: str) -> tuple[str, int]:
    """Parse host and port from `9000`, `0.0.0.0:9000` or `[::1]:9000`; InputError."""
    prefix, colon, number = text.rpartition(":")
    host = prefix.removeprefix("[").removesuffix("]") if colon else HOST
    if not (number.isascii() and number.isdigit() and 0 < int(number[:6]) < 65536) or not host:
        raise InputError(f"{text!r} must be PORT or HOST:PORT, such as 9000 or 0.0.0.0:9000")
    return host, int(number)


class OscPort(Port):
    """UDP port that receives datagrams. Datagrams dropped by the system aren't counted."""

    def __init__(self, text: str) -> None:
        """Listen at `PORT` of this machine, or `HOST:PORT`.

        InputError: the address isn't valid, or another program uses it.
        OverviewError: python-osc isn't installed.
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
        """Return new datagrams, waiting up to `wait_s` (s) for the first."""
        select.select([self._socket], [], [], wait_s)
        found: list[bytes] = []
        while len(found) < MAX_DATAGRAMS:
            try:
                data, address = self._socket.recvfrom(MAX_DATAGRAM_BYTES)
                datagram = Datagram(data)
                datagram.sender = f"{address[0]}:{address[1]}"
                found.append(datagram)
            except BlockingIOError:
                break
            except OSError:  # Windows reports an earlier answer that wasn't delivered
                continue
        return found

    def close(self) -> None:
        """Close the port."""
        self._socket.close()


def _why(error: OSError, host: str) -> str:
    if error.errno == errno.EADDRINUSE:
        return "another program uses this port; close that program, or choose another port"
    if error.errno == errno.EACCES:
        return "not allowed; choose a port above 1023"
    if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
        return f"{host!r} isn't an address of this machine; 0.0.0.0 means all its addresses"
    return f"can't be opened ({error.strerror or error})"


SEND_EVERY_S = 0.01
RETRY_AFTER_S = 1.0
"""Pause after an error."""


class OscOut:
    """Sender of `OscReport` messages at 100 Hz by UDP, which doesn't resend lost datagrams.

    Thread: its own, the only one that reads the engine's strikes.
    """

    def __init__(
        self,
        engine: Engine,
        address: str,
        say: Callable[[str], None] = lambda line: None,
        state: Callable[[], tuple[str, ...]] = tuple,
    ) -> None:
        """Start to send to `HOST:PORT`, or to `PORT` of this machine.

        `say` receives messages for the user, from this thread. `state` returns name, reason and
        last stop of the session.

        InputError: the address isn't valid.
        OverviewError: python-osc isn't installed.
        """
        require_osc()
        host, port = parse_address(address)
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise InputError(f"{address}: host not found ({error.strerror or error})") from None
        self._engine = engine
        self._name = f"osc out {address}"
        self._say, self._state = say, state
        self._address = found[4]
        self._socket = socket.socket(found[0], socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._report = OscReport()
        engine.pop_strikes()  # discard earlier ones
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        reported = set()
        while not self._over.wait(SEND_EVERY_S):
            try:
                meters, struck = self._engine.meters, self._engine.pop_strike_events()
                state = meters.cursor, meters.torque, meters.touching, struck, self._state()
                for datagram in self._report.messages(time.monotonic(), *state):
                    with contextlib.suppress(OSError):  # not accepted by the system
                        self._socket.sendto(datagram, self._address)
            except Exception as error:  # an unknown error must not end the thread
                line = f"{self._name}: {type(error).__name__}: {error}; sending continues"
                if line not in reported:
                    reported.add(line)
                    self._say(line)
                self._over.wait(RETRY_AFTER_S)

    def close(self) -> None:
        """Stop sending."""
        self._over.set()
        self._thread.join(2.0)
        self._socket.close()
