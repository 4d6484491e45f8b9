"""Options of an output device: settings of its signals, and its actuator."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, cast

from overview_dsp.cli.options.declaring import option, parse_pairs
from overview_dsp.errors import InputError
from overview_dsp.validation import within

if TYPE_CHECKING:
    from overview_dsp.arrays import SampleArray
    from overview_dsp.live.output.settings import Channels, OutputSettings
    from overview_dsp.live.output.threshold import SamplePlayback
    from overview_dsp.signal.actuators.model import Actuator
    from overview_dsp.signal.actuators.stage import ProtectionReport

NONE = "none"
CALLBACK = "OVERVIEW_CALLBACK"
CALLBACKS = ("native", "python")

ACTUATOR = option(metavar="NAME")
DEVICE = option(metavar="NAME")
SET = option("--set", metavar="KEY=VALUE")


def saved_output(device: str | None) -> tuple[OutputSettings, str, float, int | None]:
    """Return the saved settings of an output device, and its name, rate (Hz) and index.

    The index is None for no output.
    """
    from overview_dsp.live.output.devices import find_device
    from overview_dsp.live.output.portaudio_library import SILENT, device_named
    from overview_dsp.live.output.settings import OutputSettings, load_settings

    if device == SILENT:
        return OutputSettings(), "no output", 48_000.0, None
    found = find_device(device_named(device))
    settings = load_settings(found.full_name, found.channels)
    return settings, found.full_name, found.sample_rate, found.index


def sample_player(samples: SampleArray, rate: float, index: int | None) -> SamplePlayback:
    """Return a player of samples on the output device of an index; None plays without sound."""
    from overview_dsp.live.output.threshold import NullSamplePlayer, SamplePlayer

    return NullSamplePlayer(samples, rate) if index is None else SamplePlayer(samples, rate, index)


def callback_kind() -> Literal["native", "python"]:
    """Return the kind of the PortAudio callback, from the variable OVERVIEW_CALLBACK."""
    kind = os.environ.get(CALLBACK) or CALLBACKS[0]
    if kind not in CALLBACKS:
        raise InputError(f"{CALLBACK} is {kind}; must be {' or '.join(CALLBACKS)}")
    return cast("Literal['native', 'python']", kind)


@dataclass(frozen=True)
class Output:
    """Options of the output device."""

    heading: ClassVar[str] = "Output"

    device: str | None = DEVICE
    block_size: int | None = option(metavar="FRAMES")
    sample_rate: float | None = option(metavar="HZ")
    actuator: str | None = ACTUATOR
    settings: tuple[str, ...] = SET

    def __post_init__(self) -> None:
        from overview_dsp.signal.engine.engine import MAX_SAMPLE_RATE, MIN_SAMPLE_RATE

        # PortAudio reads 0 as the rate of the device
        rate = self.sample_rate
        if rate is not None:
            within(rate, "--sample-rate", MIN_SAMPLE_RATE, MAX_SAMPLE_RATE, " Hz")


def _switch(text: str) -> bool:
    answers = {"yes": True, "on": True, "true": True, "no": False, "off": False, "false": False}
    if text not in answers:
        raise InputError("must be yes or no")
    return answers[text]


def _channels(text: str) -> Channels:
    from overview_dsp.live.output.settings import parse_channels

    return parse_channels(text)


def _number(text: str) -> float:
    if not math.isfinite(number := float(text)):
        raise ValueError
    return number


FIELDS: dict[str, tuple[str, Any]] = {
    "channel": ("channel", _channels),
    "gain": ("gain_db", _number),
    "mute": ("mute", _switch),
    "delay": ("delay_ms", _number),
    "ceiling": ("ceiling_db", _number),
}
"""Field of `SignalSettings` and parser of each setting of a signal."""


def output_changes(texts: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """Parse --set to changed fields of `SignalSettings` for click and tactor; InputError."""
    known = {f"{signal}.{name}": read for signal in ("click", "tactor")
             for name, (_, read) in FIELDS.items()}  # fmt: skip
    changes: dict[str, dict[str, Any]] = {"click": {}, "tactor": {}}
    for key, value in parse_pairs("--set", texts, known).items():
        signal, _, name = key.partition(".")
        changes[signal][FIELDS[name][0]] = value
    return changes


def load_calibrated(name: str | None) -> Actuator | None:
    """Load an actuator by name or file, with its calibrated gain; None for none."""
    from overview_dsp.signal.actuators.calibration import apply_calibration

    return None if name is None or name == NONE else apply_calibration(name)


def drive_line(actuator: Actuator, protected: ProtectionReport) -> str:
    """Return a line about an actuator and its protection."""
    gain = f", calibrated {actuator.gain_db:+.1f} dB" if actuator.gain_db else ""
    return (
        f"driven for {actuator.title}{gain}: reduced by up to {protected.reduction_db:.1f} dB to "
        f"keep its rating; {protected.at_peak} samples were limited to its peak"
    )
