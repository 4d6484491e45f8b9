"""What `overview midi learn` and `overview osc learn` share: options, waiting, the file."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, TypeVar

import click

from overview_dsp.cli.common import show

Control = TypeVar("Control")


class Port(Protocol):
    """What is listened to."""

    name: str

    def receive(self, wait_s: float) -> list[bytes]:
        """What has come."""

    def close(self) -> None:
        """Give it back."""


def learn_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options of both: where it is written, ends, how long."""
    options = (
        click.option("-o", "--output", "path", type=click.Path(dir_okay=False), required=True,
                     help="The list that it is written into; made if it isn't there."),
        click.option("--low", type=float, help="What its lower end is: a part of the timeline (0 "
                     "to 1), or a parameter's value."),
        click.option("--high", type=float, help="And its upper end."),
        click.option("--seconds", type=click.FloatRange(0.1, 3600.0), default=30.0,
                     show_default=True, help="Give up after so long."),
        click.option("--json", "as_json", is_flag=True, help="Report as JSON."),
    )  # fmt: skip
    for option in reversed(options):
        function = option(function)
    return function


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


def keep(path: str, text: str, report: dict[str, Any], as_json: bool, words: str) -> None:
    """Write the list, and say what was learned."""
    from overview_dsp.files.atomic import whole_file

    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    show(as_json, {**report, "file": path}, f"{Path(path)}: {words}")
