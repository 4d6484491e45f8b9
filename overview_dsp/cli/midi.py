"""`overview midi`: what the controls of a MIDI controller do."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from overview_dsp.cli.common import show

if TYPE_CHECKING:
    from overview_dsp.controllers.midi_map import Control


@click.group(name="midi", epilog="Example: overview midi learn nano theta2 -o nano.toml")
def command() -> None:
    """Assign the controls of a MIDI controller, for `overview play --midi-map`."""


@command.command(name="learn", epilog="Example: overview midi learn nano theta2 -o nano.toml")
@click.argument("name")
@click.argument("target")
@click.option("-o", "--output", "path", type=click.Path(dir_okay=False), required=True,
              help="The list that it is written into; made if it isn't there.")  # fmt: skip
@click.option(
    "--low",
    type=float,
    help="What its lower end is: a part of the timeline (0 to 1), or a parameter's value.",
)
@click.option("--high", type=float, help="And its upper end.")
@click.option("--seconds", type=click.FloatRange(0.1, 3600.0), default=30.0, show_default=True,
              help="Give up after so long.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def learn(
    name: str,
    target: str,
    path: str,
    low: float | None,
    high: float | None,
    seconds: float,
    as_json: bool,
) -> None:
    """Move a control of the port NAME: from now on it does TARGET.

    TARGET is theta2 (the angle), touch (the disk is held while it is pressed), taps (keys, each a
    place on the timeline) or a parameter's id (`overview presets docs`). The control that is moved
    is added to the list, or takes the place of what did the same.
    """
    from dataclasses import replace

    from overview_dsp.controllers.midi_map import (
        KEYS,
        TAPS,
        THETA2,
        TOUCH,
        Control,
        load_map,
        parse_map,
        write_map,
    )
    from overview_dsp.controllers.parameters import find_parameter
    from overview_dsp.files.atomic import require_writable, whole_file
    from overview_dsp.presets.library import load_preset

    if target not in (THETA2, TOUCH, TAPS) and not target.startswith("kinds."):
        find_parameter(load_preset("football"), target)
    stand_in = Control("keys", *KEYS) if target == TAPS else Control("cc", 1)
    parse_map(write_map((replace(stand_in, to=target, low=low, high=high),)), f"{target}")
    require_writable(path)
    controls = load_map(path) if Path(path).exists() else ()
    found = replace(_moved(name, target, seconds), low=low, high=high)
    same = (found.name, found.channel)
    kept = tuple(one for one in controls if (one.name, one.channel) != same and one.to != target)
    with whole_file(path) as temporary:
        temporary.write_text(write_map((*kept, found)), encoding="utf-8")
    report = {"control": found.name, "channel": found.channel, "to": target, "file": path}
    show(as_json, report, f"{path}: {found.name}, channel {found.channel}, is {target}")


def _moved(name: str, target: str, seconds: float) -> Control:
    from overview_dsp.controllers.midi_learn import Learner
    from overview_dsp.errors import InputError
    from overview_dsp.live.midi_port import MidiPort

    learner = Learner(target)
    port = MidiPort(name)
    try:
        click.echo(f"{port.name}: {learner.ask}", err=True)
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            for data in port.receive(0.05):
                found = learner.read(data)
                if found is not None:
                    return found
    finally:
        port.close()
    raise InputError(f"{port.name}: in {seconds:g} s no control was moved that can be {target!r}")
