"""Queue of messages for a user, which a session shows."""

from __future__ import annotations

from collections import deque


class Messages:
    """Messages for a user.

    Thread: any may add; one takes.
    """

    def __init__(self) -> None:
        self._queue: deque[str] = deque()
        self._said: set[str] = set()

    def say(self, line: str) -> None:
        """Add a message."""
        self._queue.append(line)

    def say_once(self, line: str) -> None:
        """Add a message unless it was added in this way before."""
        if line not in self._said:
            self._said.add(line)
            self.say(line)

    def take_messages(self) -> tuple[str, ...]:
        """Return the messages added since the last call."""
        return tuple(self._queue.popleft() for _ in range(len(self._queue)))
