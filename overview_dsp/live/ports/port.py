"""Base classes of the connections to devices, with and without a queue."""

from __future__ import annotations

import threading
from collections import deque
from typing import Protocol

from overview_dsp.errors import OverviewError

WAIT_S = 0.05
"""Usual wait of a reading thread for the next message."""


class PortLostError(OverviewError):
    """Error of a device that is disconnected, or whose driver has failed."""


class Datagram(bytes):
    """Message with the address of its sender (`192.168.1.7:9001`), and its time, s (0: unknown)."""

    sender = ""
    time_s = 0.0


class Port(Protocol):
    """Connection to a device, which sends bytes or messages and may receive bytes.

    `name`: name of the port, as in `--input`.
    `dropped`: messages discarded from a full queue since the reader set this to 0.
    """

    name: str
    dropped: int = 0

    @property
    def waiting(self) -> int:
        """Bytes received and not yet read; 0 where one `receive` returns all of them."""
        return 0

    def receive(self, wait_s: float) -> list[bytes]:
        """Return new messages, waiting up to `wait_s` (s) for the first.

        PortLostError: the device is disconnected.
        """

    def write(self, data: bytes) -> bool:
        """Send bytes; return whether all of them were accepted. PortLostError as `receive`."""
        return False

    def close(self) -> None:
        """Close the port; repeated calls do nothing."""


class QueuedPort(Port):
    """Port with a queue, which a thread of the device's library fills."""

    def __init__(self, name: str, max_messages: int) -> None:
        """Make a queue for the latest `max_messages` messages."""
        self.name = name
        self._messages: deque[bytes] = deque(maxlen=max_messages)
        self._arrived = threading.Event()

    def put(self, message: bytes) -> None:
        """Append a message, which replaces the oldest one if the queue is full; Thread: any."""
        self.dropped += len(self._messages) == self._messages.maxlen
        self._messages.append(message)
        self._arrived.set()

    def receive(self, wait_s: float) -> list[bytes]:
        """Return new messages, waiting up to `wait_s` (s) for the first."""
        self._arrived.wait(wait_s)
        self._arrived.clear()
        return [self._messages.popleft() for _ in range(len(self._messages))]
