"""What commands that learn from a device share: options, waiting, the file."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import click

import overview_dsp as ov
from overview_dsp.cli.common import show, write_text
from overview_dsp.cli.options.declaring import GENERAL, JSON, option
from overview_dsp.errors import InputError
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.validation import located

Learned = TypeVar("Learned")


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
    from overview_dsp.devices.controllers.parameters import find_parameter

    if target not in known and not target.startswith("kinds."):
        try:
            find_parameter(ov.load_preset("football"), target)
        except InputError as error:
            raise InputError(
                f"{error}; TARGET is {', '.join(known)} or a parameter's id (`overview presets "
                "docs`)"
            ) from None


def listen(
    port: Port,
    ask: Callable[[], str],
    hear: Callable[[list[bytes], float], Learned | None],
    timeout: float,
    otherwise: Callable[[], str],
) -> Learned:
    """Return what `hear` makes of a port's messages, which is closed then.

    `ask` is what the user is to do, printed when it changes.

    Raises
    ------
    InputError
        Nothing after `timeout` (s), with `otherwise`; or as `hear`, where the line names the port.
    """
    asked = ""
    try:
        until = time.monotonic() + timeout
        while time.monotonic() < until:
            if asked != ask():
                asked = ask()
                click.echo(f"{port.name}: {asked}", err=True)
            with located(f"{port.name}: "):
                found = hear(port.receive(WAIT_S), time.monotonic())
            if found is not None:
                return found
    finally:
        port.close()
    raise InputError(f"{port.name}: in {timeout:g} s {otherwise()}")


def save_learned(learning: Learning, text: str, report: dict[str, Any], words: str) -> None:
    """Write the list, and report what was learned."""
    write_text(learning.output, text)
    report["file"] = learning.output
    show(learning.as_json, report, f"{Path(learning.output)}: {words}")
