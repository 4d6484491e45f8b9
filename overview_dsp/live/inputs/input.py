"""A control source of a session, other than mouse and keyboard.

Several sources in one session; the rule by which they change over is `controllers.source`'s.
"""

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


class SeveralInputs(Input):
    """Inputs that play together, each as a source of its own.

    Thread: control.
    """

    def __init__(self, inputs: Mapping[str, Input]) -> None:
        """`inputs`: each by the name of its source."""
        self._inputs = dict(inputs)

    def poll(self, engine: Engine) -> None:
        """Each hands over what is due."""
        for one in self._inputs.values():
            one.poll(engine)

    def is_over(self, engine: Engine) -> bool:
        """Whether nothing more will come from any."""
        return all(one.is_over(engine) for one in self._inputs.values())

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        return tuple(line for one in self._inputs.values() for line in one.take_messages())

    @property
    def words(self) -> str:
        """A line for each."""
        return "\n".join(one.words for one in self._inputs.values() if one.words)

    def report(self) -> dict[str, Any]:
        """What each counted, by its source."""
        return {name: dict(one.report()) for name, one in self._inputs.items()}

    def close(self) -> None:
        """Each lets go and gives back what it opened."""
        for one in self._inputs.values():
            one.close()
