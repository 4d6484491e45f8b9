"""The command group `overview midi`."""

from __future__ import annotations

from dataclasses import replace

import click

from overview_dsp.cli.control_learning import Learning, require_target
from overview_dsp.cli.options.declaring import cli_command


@click.group(name="midi", epilog="Example: overview midi learn nano theta2 -o nano.toml")
def command() -> None:
    """Assign the controls of a MIDI controller, for `overview play --input midi:NAME,map=FILE`."""


@cli_command("midi learn nano theta2 -o nano.toml", group=command)
def learn(name: str, target: str, *, learning: Learning) -> None:
    """Assign the control that you move on the port NAME to TARGET.

    TARGET is theta2 (the angle), touch (holds the disk while it is pressed), mark (sets a
    mark), taps (keys, each with one position) or the id of a parameter (overview presets
    reference). The control is added to the map file, and replaces another control of TARGET.
    A knob without ends is detected by its steps.
    """
    from overview_dsp.devices.controllers.control_map import (
        KEYS,
        SWITCHES,
        TAPS,
        THETA2,
        Control,
        load_map,
        parse_map,
        write_map,
    )
    from overview_dsp.devices.controllers.learning import Learner
    from overview_dsp.live.ports.midi import MidiPort

    require_target(target, (THETA2, *SWITCHES, TAPS))
    stand_in = Control("keys", *KEYS) if target == TAPS else Control("cc", 1)
    wanted = replace(stand_in, to=target, low=learning.low, high=learning.high)
    parse_map(write_map((wanted,)), target)  # checks the range
    learner = Learner(target)
    found, text = learning.learn(load_map, lambda: MidiPort(name), learner, (target,))
    report = {"control": found.name, "channel": found.channel, "to": target}
    steps = f" by steps ({found.relative})" if found.relative else ""
    summary = f"{found.name}, channel {found.channel}, is {target}{steps}"
    learning.save(text, report, summary)
