"""Shared parts of commands that learn from a device: options, waiting, the map file."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import click

import overview_dsp as ov
from overview_dsp.cli.common import show
from overview_dsp.cli.options.declaring import GENERAL, JSON, option
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable, write_file
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.validation import prefix_errors

if TYPE_CHECKING:
    from overview_dsp.devices.controllers.learning import Learner, OscLearner
    from overview_dsp.devices.sensors.setup import Setup

Learned = TypeVar("Learned")


@dataclass(frozen=True)
class Learning:
    """Options of `osc learn` and `midi learn`: file, range and timeout."""

    heading: ClassVar[str] = GENERAL

    output: str = option(type=click.Path(dir_okay=False), required=True)
    low: float | None = option()
    high: float | None = option()
    timeout: float = option(type=click.FloatRange(0.1, 3600.0), default=30.0, metavar="S")
    as_json: bool = JSON

    def learn(
        self,
        load: Callable[[str], tuple[Any, ...]],
        port: Callable[[], Port],
        learner: Learner | OscLearner,
        replaced: Collection[str],
    ) -> tuple[Any, str]:
        """Return the moved control, and the text of the map file with it.

        It replaces the same control and those of the targets `replaced`. Errors as `listen`.
        """
        from overview_dsp.devices.controllers.control_map import write_map

        require_writable(self.output)
        controls = load(self.output) if Path(self.output).exists() else ()
        moved: Any = listen(port(), learner, learner.control_of, self.timeout)
        found = replace(moved, low=self.low, high=self.high)
        kept = [one for one in controls if one.key != found.key and one.to not in replaced]
        return found, write_map((*kept, found))

    def save(self, text: str, report: dict[str, Any], summary: str) -> None:
        """Write the map file, and report the new control."""
        write_file(self.output, text)
        show(self.as_json, {**report, "file": self.output}, f"{Path(self.output)}: {summary}")


def require_target(target: str, known: tuple[str, ...]) -> None:
    """Check that a target is one of `known` or the id of a parameter; InputError otherwise."""
    from overview_dsp.devices.controllers.control_messages import find_parameter

    if target not in known and not target.startswith("kinds."):
        try:
            find_parameter(ov.load_preset("football"), target)
        except InputError as error:
            raise InputError(
                f"{error}; TARGET must be {', '.join(known)} or the id of a parameter "
                "(overview presets reference)"
            ) from None


def listen(
    port: Port,
    learner: Learner | OscLearner | Setup,
    decode: Callable[[list[bytes], float], Learned | None],
    timeout: float,
) -> Learned:
    """Read messages of a port until `decode` returns a result; then close the port.

    The learner's instruction for the user is printed when it changes. InputError names the port: no
    result after `timeout` (s), with the learner's reason; or an error of `decode`.
    """
    printed = ""
    try:
        until = time.monotonic() + timeout
        while time.monotonic() < until:
            if printed != learner.instruction:
                printed = learner.instruction
                click.echo(f"{port.name}: {printed}", err=True)
            with prefix_errors(f"{port.name}: "):
                found = decode(port.receive(WAIT_S), time.monotonic())
            if found is not None:
                return found
    finally:
        port.close()
    raise InputError(f"{port.name}: {learner.failure} within {timeout:g} s")
