"""Protocol of a session's inputs other than mouse and keys, and a combination of several.

`devices.controllers.source` has the rule by which one input takes over from another.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from overview_dsp.signal.engine.engine import Engine


class Input(Protocol):
    """Input of control events other than mouse and keys."""

    def poll(self, engine: Engine) -> None:
        """Send the events that are due to the engine."""

    def is_over(self, engine: Engine) -> bool:
        """Return whether no more events will arrive."""

    def take_messages(self) -> tuple[str, ...]:
        """Return messages for the user, added since the last call."""
        return ()

    @property
    def status_text(self) -> str:
        """Status for display on the play screen; may be empty."""
        return ""

    def report(self) -> Mapping[str, Any]:
        """Return counters and state for a JSON line."""
        return {}

    def close(self) -> None:
        """Release the disk and close all ports."""
        return


class CombinedInput(Input):
    """Combination of inputs, each of which is a source of its own.

    Thread: control.
    """

    def __init__(self, inputs: Mapping[str, Input]) -> None:
        """Combine inputs, by the names of their sources."""
        self._inputs = dict(inputs)

    def poll(self, engine: Engine) -> None:
        """Poll each input."""
        for one in self._inputs.values():
            one.poll(engine)

    def is_over(self, engine: Engine) -> bool:
        """Return whether all inputs are over."""
        return all(one.is_over(engine) for one in self._inputs.values())

    def take_messages(self) -> tuple[str, ...]:
        """Return messages of all inputs, added since the last call."""
        return tuple(line for one in self._inputs.values() for line in one.take_messages())

    @property
    def status_text(self) -> str:
        """Status of each input, one per line."""
        return "\n".join(one.status_text for one in self._inputs.values() if one.status_text)

    def report(self) -> dict[str, Any]:
        """Return the report of each input by the name of its source."""
        return {name: dict(one.report()) for name, one in self._inputs.items()}

    def close(self) -> None:
        """Close each input."""
        for one in self._inputs.values():
            one.close()
