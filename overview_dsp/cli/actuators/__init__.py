"""`overview actuators`: what a tactor or speaker can do and may be given."""

from __future__ import annotations

import click

from overview_dsp.cli.actuators import calibrate, inspect, sweep


@click.group(name="actuators", epilog="Example: overview actuators show c2")
def command() -> None:
    """Show, measure and calibrate what the tactor's signal drives."""


for _one in (inspect.list_, inspect.show, sweep.sweep, calibrate.calibrate):
    command.add_command(_one)
