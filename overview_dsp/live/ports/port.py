"""Port: what the connections to all devices have in common, and the queue of those that call."""

from __future__ import annotations

import threading
from collections import deque
from typing import Protocol

from overview_dsp.errors import OverviewError

WAIT_S = 0.05
"""How long a thread that reads a port usually waits for the next message."""


class PortLostError(OverviewError):
    """The device has been unplugged, or its driver gave up."""


class Port(Protocol):
    """Connection to a device: bytes or messages that are read, and written where it takes any.

    Attributes
    ----------
    name : str
        As `--input` names it.
    dropped : int
        Messages discarded because more came than was read, since the reader set this to 0.
    """

    name: str
    dropped: int = 0

    @property
    def waiting(self) -> int:
        """Bytes received and not yet read; 0 where one `receive` returns all of them."""
        return 0

    def receive(self, wait_s: float) -> list[bytes]:
        """Return what has come, waiting up to `wait_s` (s) for the first.

        Raises
        ------
        PortLostError
            The device is gone.
        """

    def write(self, data: bytes) -> bool:
        """Send bytes; return whether all of them were accepted. PortLostError as `receive`."""
        return False

    def close(self) -> None:
        """Close the port; may be called twice."""


class QueuedPort(Port):
    """Port to which a thread of its library hands messages; they wait in a queue."""

    def __init__(self, name: str, most: int) -> None:
        """Keep up to `most` messages, the latest ones."""
        self.name = name
        self._messages: deque[bytes] = deque(maxlen=most)
        self._arrived = threading.Event()

    def put(self, message: bytes) -> None:
        """Append a message, in place of the oldest one if the queue is full; from any thread."""
        self.dropped += len(self._messages) == self._messages.maxlen
        self._messages.append(message)
        self._arrived.set()

    def receive(self, wait_s: float) -> list[bytes]:
        """Return the messages that have come, waiting up to `wait_s` (s) for the first."""
        self._arrived.wait(wait_s)
        self._arrived.clear()
        return [self._messages.popleft() for _ in range(len(self._messages))]
