"""What `overview midi learn` and `overview osc learn` share: options, waiting, the file."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

import click

from overview_dsp.cli.common import show
from overview_dsp.cli.options.groups import GENERAL, JSON, option

Control = TypeVar("Control")


class Port(Protocol):
    """What is listened to."""

    name: str

    def receive(self, wait_s: float) -> list[bytes]:
        """What has come."""

    def close(self) -> None:
        """Give it back."""


@dataclass(frozen=True)
class Learning:
    """Options of both commands: the file, the ends of the range, how long to wait."""

    heading: ClassVar[str] = GENERAL

    output: str = option(
        "The list to write it into; made if it isn't there.",
        type=click.Path(dir_okay=False),
        required=True,
    )
    low: float | None = option(
        "Value at the control's lower end: a position (0 to 1), or a parameter's value."
    )
    high: float | None = option("Value at its upper end.")
    timeout: float = option(
        "Give up after S seconds.", type=click.FloatRange(0.1, 3600.0), default=30.0, metavar="S"
    )
    as_json: bool = JSON


def require_target(target: str, known: tuple[str, ...]) -> None:
    """Raise InputError unless it is one of `known` or a parameter's id."""
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.devices.controllers.parameters import find_parameter
    from overview_dsp.errors import InputError

    if target not in known and not target.startswith("kinds."):
        try:
            find_parameter(load_preset("football"), target)
        except InputError as error:
            raise InputError(
                f"{error}; TARGET is {', '.join(known)} or a parameter's id (`overview presets "
                "docs`)"
            ) from None


def heard_from(
    open_port: Callable[[], Port],
    ask: str,
    hear: Callable[[list[bytes], float], Control | None],
    seconds: float,
    otherwise: Callable[[], str],
) -> Control:
    """What `hear` makes of a port's messages; InputError, with `otherwise`, after so long."""
    from overview_dsp.errors import InputError

    port = open_port()
    try:
        click.echo(f"{port.name}: {ask}", err=True)
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            found = hear(port.receive(0.05), time.monotonic())
            if found is not None:
                return found
    finally:
        port.close()
    raise InputError(f"{port.name}: in {seconds:g} s {otherwise()}")


def keep(learning: Learning, text: str, report: dict[str, Any], words: str) -> None:
    """Write the list, and report what was learned."""
    from overview_dsp.files.atomic import whole_file

    with whole_file(learning.output) as temporary:
        temporary.write_text(text, encoding="utf-8")
    report["file"] = learning.output
    show(learning.as_json, report, f"{Path(learning.output)}: {words}")
