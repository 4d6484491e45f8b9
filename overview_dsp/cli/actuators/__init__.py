"""The command group `overview actuators`."""

from __future__ import annotations

import click

from overview_dsp.cli.actuators.calibrate import calibrate
from overview_dsp.cli.actuators.sweep import sweep
from overview_dsp.cli.common import list_profiles
from overview_dsp.cli.common import show as show_report
from overview_dsp.cli.options.declaring import JSON, cli_command


@click.group(name="actuators", epilog="Example: overview actuators show c2")
def command() -> None:
    """List, measure and calibrate actuators: tactors, speakers and headphones."""


@cli_command("actuators list", group=command)
def list_(*, as_json: bool = JSON) -> None:
    """List the bundled actuators and yours."""
    from overview_dsp.signal.actuators.calibration import apply_calibration
    from overview_dsp.signal.actuators.library import actuator_names

    list_profiles(
        actuator_names(),
        apply_calibration,
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


@cli_command("actuators show c2", group=command)
def show(name: str, *, as_json: bool = JSON) -> None:
    """Show all values and limits of the actuator NAME (or of a .toml file)."""
    from overview_dsp.signal.actuators.calibration import apply_calibration
    from overview_dsp.signal.actuators.describe import describe, describe_json

    actuator = apply_calibration(name)
    show_report(as_json, describe_json(actuator), describe(actuator))


command.add_command(sweep)
command.add_command(calibrate)
