"""`overview actuators`: list, show."""

from __future__ import annotations

import click

from overview_dsp.cli.common import print_json


@click.command(name="list", epilog="Example: overview actuators list")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def list_(as_json: bool) -> None:
    """The bundled actuators and your own, and what each is."""
    from overview_dsp.actuators.calibration import calibrated_actuator
    from overview_dsp.actuators.library import actuator_names
    from overview_dsp.errors import InputError

    found = []
    faults = []
    for name in actuator_names():
        try:
            found.append(calibrated_actuator(name))
        except InputError as error:
            faults.append(str(error))
    if as_json:
        print_json(
            [
                {
                    "name": one.name,
                    "title": one.title,
                    "description": one.description,
                    "calibration_db": one.gain_db,
                    "file": one.source,
                }
                for one in found
            ]
        )
    else:
        width = max((len(one.name) for one in found), default=0)
        for one in found:
            gain = f" (calibrated {one.gain_db:+.1f} dB)" if one.gain_db else ""
            click.echo(f"{one.name:<{width}}  {one.title}: {one.description}{gain}")
    for fault in faults:
        click.echo(f"note: left out: {fault}", err=True)


@click.command(epilog="Example: overview actuators show c2")
@click.argument("name")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def show(name: str, as_json: bool) -> None:
    """Every value of the actuator NAME (or its .toml file), and what they amount to."""
    from overview_dsp.actuators.calibration import calibrated_actuator
    from overview_dsp.actuators.describe import describe, describe_json

    actuator = calibrated_actuator(name)
    if as_json:
        print_json(describe_json(actuator))
    else:
        click.echo(describe(actuator))
