"""The option --actuator: what a tactor's signal is driven for, and how that is reported."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from overview_dsp.signal.actuators.model import Actuator
    from overview_dsp.signal.actuators.stage import Protected

NONE = "none"


def actuator_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """The option --actuator."""
    return click.option(
        "--actuator", metavar="NAME", help="Drive this actuator, within what it bears; or none."
    )(function)


def calibrated(name: str | None) -> Actuator | None:
    """The actuator of that name or file, with the gain it was calibrated to; None for none."""
    from overview_dsp.signal.actuators.calibration import calibrated_actuator

    return None if name is None or name == NONE else calibrated_actuator(name)


def drive_line(actuator: Actuator, protected: Protected) -> str:
    """An actuator and what its protection did, in a line."""
    gain = f", calibrated {actuator.gain_db:+.1f} dB" if actuator.gain_db else ""
    return (
        f"driven for {actuator.title}{gain}: up to {protected.taken_db:.1f} dB taken back for its "
        f"rating, {protected.at_peak} samples at its peak"
    )
