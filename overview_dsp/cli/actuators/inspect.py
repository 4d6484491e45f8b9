"""`overview actuators`: list, show."""

from __future__ import annotations

import click

from overview_dsp.cli.common import list_profiles, print_json


@click.command(name="list", epilog="Example: overview actuators list")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def list_(as_json: bool) -> None:
    """The bundled actuators and your own, and what each is."""
    from overview_dsp.signal.actuators.calibration import calibrated_actuator
    from overview_dsp.signal.actuators.library import actuator_names

    list_profiles(
        actuator_names(),
        calibrated_actuator,
        lambda actuator: {
            "name": actuator.name,
            "title": actuator.title,
            "description": actuator.description,
            "calibration_db": actuator.gain_db,
            "file": actuator.source,
        },
        as_json,
        lambda one: f" (calibrated {one.gain_db:+.1f} dB)" if one.gain_db else "",
    )


@click.command(epilog="Example: overview actuators show c2")
@click.argument("name")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def show(name: str, as_json: bool) -> None:
    """Every value of the actuator NAME (or its .toml file), and what they amount to."""
    from overview_dsp.signal.actuators.calibration import calibrated_actuator
    from overview_dsp.signal.actuators.describe import describe, describe_json

    actuator = calibrated_actuator(name)
    if as_json:
        print_json(describe_json(actuator))
    else:
        click.echo(describe(actuator))
