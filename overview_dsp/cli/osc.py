"""`overview osc`: what the messages of other programs and apps do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from overview_dsp.cli.control_learning import Learning, listen, require_target, save_learned
from overview_dsp.cli.options.declaring import cli_command
from overview_dsp.files.atomic import require_writable

if TYPE_CHECKING:
    from overview_dsp.devices.controllers.control_map import OscControl


@click.group(name="osc", epilog="Example: overview osc learn 0.0.0.0:9000 theta2 -o tablet.toml")
def command() -> None:
    """Assign the messages of other programs, for `overview play --input osc:PORT,map=FILE`."""


@cli_command("osc learn 0.0.0.0:9000 device -o phone.toml", group=command)
def learn(port: str, target: str, *, learning: Learning) -> None:
    """Move a control that sends OSC to PORT (or HOST:PORT): from now on it does TARGET.

    TARGET is theta2 (the angle), touch (the disk is held while it is pressed), device (what sends
    is itself turned in the hand) or a parameter's id (`overview presets docs`). The control that is
    moved is added to the list, or takes the place of what did the same.
    """
    from overview_dsp.devices.controllers.control_map import (
        SENSED,
        THETA2,
        TOUCH,
        OscControl,
        load_osc_map,
        parse_osc_map,
        write_map,
    )
    from overview_dsp.devices.controllers.learning import DEVICE, OscLearner
    from overview_dsp.live.ports.osc import OscPort

    require_target(target, (THETA2, TOUCH, DEVICE))
    to = "acceleration" if target == DEVICE else target
    parse_osc_map(write_map((OscControl("/x", to, low=learning.low, high=learning.high),)), target)
    require_writable(learning.output)
    controls = load_osc_map(learning.output) if Path(learning.output).exists() else ()
    learner = OscLearner(target)

    def hear(came: list[bytes], now_s: float) -> OscControl | None:
        for data in came:
            learner.read(data, now_s)
        return learner.found(now_s)

    def otherwise() -> str:
        came = f"heard were {learner.received}" if learner.received else "nothing came"
        return f"no message was known that can be {target!r}; {came}"

    found = listen(OscPort(port), lambda: learner.instruction, hear, learning.timeout, otherwise)
    found = replace(found, low=learning.low, high=learning.high)
    replaced = SENSED if target == DEVICE else (target,)
    same = (found.address, found.value)
    kept = tuple(
        one for one in controls if (one.address, one.value) != same and one.to not in replaced
    )
    sent = "" if target in (DEVICE, TOUCH) else f", {found.sends[0]:g} to {found.sends[1]:g},"
    words = f"{found.address}{sent} is {found.to if target == DEVICE else target}"
    report = {"address": found.address, "value": found.value, "to": found.to}
    save_learned(learning, write_map((*kept, found)), report, words)
