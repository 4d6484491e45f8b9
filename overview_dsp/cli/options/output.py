"""The options about an output device: channels, gains, mutes, delays, ceilings, its actuator.

The option --actuator: what a tactor's signal is driven for, and how that is reported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from overview_dsp.live.output.settings import OutputSettings
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


def output_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Options of both signals' ways out."""
    for name in ("tactor", "click"):
        options = (
            click.option(f"--{name}-channel", callback=channels_given, metavar="N[+N]",
                         help="Its output channel, or several (3+4); 0 = none."),
            click.option(f"--{name}-gain", type=float, metavar="DB", help="-60 to 24 dB."),
            click.option(f"--{name}-mute/--no-{name}-mute", default=None, help="Silence it."),
            click.option(f"--{name}-delay", type=float, metavar="MS", help="0 to 100 ms."),
            click.option(f"--{name}-ceiling", type=float, metavar="DB", help="-60 to 0 dBFS."),
        )  # fmt: skip
        for option in reversed(options):
            function = option(function)
    return function


def channels_given(context: Any, option: Any, text: str | None) -> int | tuple[int, ...] | None:
    """Channels as they are typed: `3`, `3+4`, 0; InputError."""
    from overview_dsp.live.output.settings import channels_in

    return None if text is None else channels_in(text)


@dataclass(frozen=True)
class Chosen:
    """The settings to play with; `remembered` are the device's, `another` if not its actuator."""

    settings: OutputSettings
    remembered: OutputSettings
    another: bool

    def differ(self, played: OutputSettings) -> bool:
        """Whether what was played with in the end is to be remembered."""
        before = replace(self.remembered, actuator=played.actuator)
        return self.another or played != before


def output_settings(
    device: str | None, given: dict[str, Any], actuator: str | None, has: int = 2
) -> Chosen:
    """A device's settings (None: one that isn't remembered) with what was asked for now.

    `has` is how many channels it has.

    Raises
    ------
    InputError
        Out of range, or an actuator that can't be had.
    """
    from overview_dsp.live.output.saved_settings import load_settings
    from overview_dsp.live.output.settings import OutputSettings

    kept = OutputSettings() if device is None else load_settings(device, has)
    keys = {"channel": "channel", "gain": "gain_db", "mute": "mute", "delay": "delay_ms",
            "ceiling": "ceiling_db"}  # fmt: skip
    changes = {
        output: {
            key: given[f"{output}_{option}"]
            for option, key in keys.items()
            if given[f"{output}_{option}"] is not None
        }
        for output in ("click", "tactor")
    }
    changed = kept.changed(**changes)
    driven, another = _actuator(device, actuator, has)
    return Chosen(replace(changed, actuator=driven), kept, another)


def _actuator(device: str | None, given: str | None, has: int) -> tuple[Actuator | None, bool]:
    """The actuator given, else the device's own; whether it is another than that."""
    from overview_dsp.errors import InputError
    from overview_dsp.live.output.saved_settings import remembered_actuator, settings_file
    from overview_dsp.signal.actuators.library import reference

    remembered = None if device is None else remembered_actuator(device, has)
    if given is None:
        try:
            return calibrated(remembered), False
        except InputError as error:
            raise InputError(
                f"{settings_file()}: the actuator of {device!r}: {error}; --actuator names "
                "another, or none"
            ) from None
    chosen = calibrated(given)
    return chosen, (None if chosen is None else reference(chosen)) != remembered
