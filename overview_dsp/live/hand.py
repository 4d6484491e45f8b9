"""A control source of a session, other than mouse and keyboard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from overview_dsp.signal.engine.engine import Engine


class Input(Protocol):
    """A control source other than mouse and keyboard."""

    def poll(self, engine: Engine) -> None:
        """Hand over what is due."""

    def is_over(self, engine: Engine) -> bool:
        """Whether nothing more will come."""

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        return ()

    @property
    def words(self) -> str:
        """A line for the play screen, or nothing."""
        return ""

    def report(self) -> Mapping[str, Any]:
        """What it counted, for a line of JSON."""
        return {}

    def close(self) -> None:
        """Let go and give back what was opened."""
        return
