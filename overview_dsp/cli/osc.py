"""The command group `overview osc`."""

from __future__ import annotations

import click

from overview_dsp.cli.control_learning import Learning, require_target
from overview_dsp.cli.options.declaring import cli_command


@click.group(name="osc", epilog="Example: overview osc learn 0.0.0.0:9000 theta2 -o tablet.toml")
def command() -> None:
    """Assign the messages of other programs, for `overview play --input osc:PORT,map=FILE`."""


@cli_command("osc learn 0.0.0.0:9000 device -o phone.toml", group=command)
def learn(port: str, target: str, *, learning: Learning) -> None:
    """Assign to TARGET the control that you move, received at PORT (or HOST:PORT).

    TARGET is theta2 (the angle), touch (holds the disk while it is pressed), mark (sets a mark),
    device (the angle is the rotation of the sender itself) or the id of a parameter (overview
    presets reference). The control is added to the map file, and replaces another of TARGET.
    """
    from overview_dsp.devices.controllers.control_map import (
        SENSED,
        SWITCHES,
        THETA2,
        OscControl,
        load_osc_map,
        parse_osc_map,
        write_map,
    )
    from overview_dsp.devices.controllers.learning import DEVICE, OscLearner
    from overview_dsp.live.ports.osc import OscPort

    require_target(target, (THETA2, *SWITCHES, DEVICE))
    to = "acceleration" if target == DEVICE else target
    parse_osc_map(write_map((OscControl("/x", to, low=learning.low, high=learning.high),)), target)
    learner = OscLearner(target)
    replaced = tuple(SENSED) if target == DEVICE else (target,)
    found, text = learning.learn(load_osc_map, lambda: OscPort(port), learner, replaced)
    sent = "" if target in (DEVICE, *SWITCHES) else f", {found.sends[0]:g} to {found.sends[1]:g},"
    summary = f"{found.address}{sent} is {found.to if target == DEVICE else target}"
    report = {"address": found.address, "value": found.value, "to": found.to}
    learning.save(text, report, summary)
