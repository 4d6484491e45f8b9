"""The command group `overview actuators`, and the description of an actuator."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import click

from overview_dsp.cli.actuators.calibrate import calibrate
from overview_dsp.cli.actuators.sweep import measure, sweep
from overview_dsp.cli.common import list_profiles
from overview_dsp.cli.common import show as show_report
from overview_dsp.cli.options.declaring import JSON, cli_command
from overview_dsp.files.toml import read_text
from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS, Actuator
from overview_dsp.units import gain_to_db


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
        lambda actuator: {"calibration_db": actuator.gain_db, "file": actuator.source},
        as_json,
        lambda one: f" (calibrated {one.gain_db:+.1f} dB)" if one.gain_db else "",
    )


@cli_command("actuators show c2", group=command)
def show(name: str, *, as_json: bool = JSON) -> None:
    """Show all values and limits of the actuator NAME (or of a .toml file)."""
    from overview_dsp.signal.actuators.calibration import apply_calibration

    actuator = apply_calibration(name)
    show_report(as_json, describe_json(actuator), describe(actuator))


command.add_command(sweep)
command.add_command(measure)
command.add_command(calibrate)


_IN_DRIVE_UNITS = ("drive.rated_rms", "drive.peak", "drive.full_scale")


def describe_json(actuator: Actuator) -> dict[str, Any]:
    """Return all values by id and the derived quantities; levels in dBFS."""
    return {
        "name": actuator.name,
        "title": actuator.title,
        "description": actuator.description,
        "file": actuator.source,
        "values": dict(actuator.values),
        "q": round(actuator.q, 3),
        "rise_ms": round(actuator.rise_ms, 3),
        "overdriven_rise_ms": round(
            actuator.rise_ms * min(1.0, actuator.overdrive_q / actuator.q), 3
        ),
        "peak_dbfs": round(gain_to_db(actuator.peak), 2),
        "nominal_dbfs": round(gain_to_db(actuator.nominal), 2),
        "rms_limit_dbfs": round(0.5 * gain_to_db(actuator.mean_square), 2),
        "rms_window_s": round(actuator.window_s, 3),
        "calibration_db": round(actuator.gain_db, 2),
    }


def describe(actuator: Actuator) -> str:
    """Return a description of the actuator as text."""
    facts = describe_json(actuator)
    lines = [f"{actuator.name}: {actuator.title}", actuator.description, ""]
    section = ""
    for id, known in ACTUATOR_PARAMETERS.items():
        if id not in actuator.values:
            continue
        if id.split(".")[0] != section:
            section = id.split(".")[0]
            lines.append(f"[{section}]")
        value = actuator.values[id]
        unit = str(actuator.values["drive.unit"]) if id in _IN_DRIVE_UNITS else known.unit
        text = str(value).lower() if isinstance(value, bool) else value
        shown = f"{text:g} {unit}".strip() if isinstance(text, float) else str(text)
        lines.append(f"  {known.key:<16} {shown:<16} {known.doc}")
    lines += [
        "",
        f"A vibration rises in {facts['rise_ms']:.3g} ms (Q {facts['q']:.3g}), with overdrive in "
        f"{facts['overdriven_rise_ms']:.3g} ms, if the peak allows it.",
        f"The full tactor signal is a tone of {facts['nominal_dbfs']:.1f} dBFS. No sample exceeds "
        f"{facts['peak_dbfs']:.1f} dBFS,",
        f"and no RMS over {facts['rms_window_s']:g} s exceeds {facts['rms_limit_dbfs']:.1f} dBFS.",
    ]
    if actuator.gain_db:
        lines.append(f"Calibrated: {actuator.gain_db:+.1f} dB.")
    file_lines = read_text(Path(actuator.source)).splitlines()
    # its first comment has the sources and assumptions
    remarks = itertools.takewhile(lambda line: line.startswith("#"), file_lines)
    return "\n".join([*lines, "", *(line.lstrip("#").strip() for line in remarks)])
