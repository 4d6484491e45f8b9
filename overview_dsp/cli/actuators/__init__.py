"""`overview actuators`: what a tactor or speaker can do and may be given."""

from __future__ import annotations

import click

from overview_dsp.cli.actuators import calibrating, reading, sweeping


@click.group(name="actuators", epilog="Example: overview actuators show c2")
def command() -> None:
    """Show, measure and calibrate what the tactor's signal drives."""


for _one in (reading.list_, reading.show, sweeping.sweep, calibrating.calibrate):
    command.add_command(_one)
