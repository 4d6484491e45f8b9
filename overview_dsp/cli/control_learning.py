"""Shared parts of commands that learn from a device: options, waiting, the map file."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import click

import overview_dsp as ov
from overview_dsp.cli.common import show
from overview_dsp.cli.options.declaring import GENERAL, JSON, option
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import write_file
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.validation import prefix_errors

Learned = TypeVar("Learned")


@dataclass(frozen=True)
class Learning:
    """Options of `osc learn` and `midi learn`: file, range and timeout."""

    heading: ClassVar[str] = GENERAL

    output: str = option(
        "Map file to extend; created if missing.", type=click.Path(dir_okay=False), required=True
    )
    low: float | None = option(
        "Value at the lower end of the control: a position (0 to 1), or of the parameter."
    )
    high: float | None = option("Value at the upper end of the control.")
    timeout: float = option(
        "Give up after S seconds.", type=click.FloatRange(0.1, 3600.0), default=30.0, metavar="S"
    )
    as_json: bool = JSON


def require_target(target: str, known: tuple[str, ...]) -> None:
    """Check that a target is one of `known` or the id of a parameter; InputError otherwise."""
    from overview_dsp.devices.controllers.parameters import find_parameter

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
    prompt: Callable[[], str],
    decode: Callable[[list[bytes], float], Learned | None],
    timeout: float,
    failure: Callable[[], str],
) -> Learned:
    """Read messages of a port until `decode` returns a result; then close the port.

    `prompt` returns the instruction for the user, which is printed when it changes. InputError
    names the port: no result after `timeout` (s), with the reason of `failure`; or an error of
    `decode`.
    """
    printed = ""
    try:
        until = time.monotonic() + timeout
        while time.monotonic() < until:
            if printed != prompt():
                printed = prompt()
                click.echo(f"{port.name}: {printed}", err=True)
            with prefix_errors(f"{port.name}: "):
                found = decode(port.receive(WAIT_S), time.monotonic())
            if found is not None:
                return found
    finally:
        port.close()
    raise InputError(f"{port.name}: {failure()} within {timeout:g} s")


def save_learned(learning: Learning, text: str, report: dict[str, Any], summary: str) -> None:
    """Write the map file, and report the new control."""
    write_file(learning.output, text)
    report["file"] = learning.output
    show(learning.as_json, report, f"{Path(learning.output)}: {summary}")
