"""What each output device is given: channels, gain, mute, delay, ceiling, and an actuator.

They come after the engine: a recording doesn't hold them, and a replay doesn't need them.

A game pad as an output: a DualSense by USB is a sound card, its coils channels 3 and 4.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.device.output_stage import LONGEST_DELAY_S
from overview_dsp.public import changed_fields
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import write_actuator

MIN_GAIN_DB, MAX_GAIN_DB = -60.0, 24.0
MAX_DELAY_MS = 1e3 * LONGEST_DELAY_S
MIN_CEILING_DB, MAX_CEILING_DB = -60.0, 0.0
MAX_CHANNELS = 64


@dataclass(frozen=True)
class SignalSettings:
    """One signal's way out.

    Parameters
    ----------
    channel : int or tuple of int
        From 1; 0 is nowhere. Several get the same samples: a pad's two voice coils.
    gain_db : float
        -60 to 24 dB.
    mute : bool
        Whether it is silent.
    delay_ms : float
        0 to 100 ms.
    ceiling_db : float
        What no sample passes, -60 to 0 dBFS.

    Raises
    ------
    InputError
        A value out of range, or a channel named twice.

    Examples
    --------
    >>> ov.live.SignalSettings((3, 4), gain_db=-6.0)
    SignalSettings(channel=(3, 4), gain_db=-6.0)
    """

    channel: int | tuple[int, ...]
    gain_db: float = 0.0
    mute: bool = False
    delay_ms: float = 0.0
    ceiling_db: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "channel", _checked(self.channel))
        _within(self.gain_db, "gain", MIN_GAIN_DB, MAX_GAIN_DB, "dB")
        _within(self.delay_ms, "delay", 0.0, MAX_DELAY_MS, "ms")
        _within(self.ceiling_db, "ceiling", MIN_CEILING_DB, MAX_CEILING_DB, "dBFS")

    @property
    def channels(self) -> tuple[int, ...]:
        """Its channels, from 1; none if it goes nowhere."""
        several = self.channel if isinstance(self.channel, tuple) else (self.channel,)
        return tuple(channel for channel in several if channel)

    @property
    def gain(self) -> float:
        """The gain, linear; 0 when muted."""
        return 0.0 if self.mute else gain_of_db(self.gain_db)

    def __repr__(self) -> str:
        return changed_fields(self)


@dataclass(frozen=True)
class OutputSettings:
    """Both signals' ways out of a device, and the actuator that the tactor's signal drives.

    Parameters
    ----------
    click, tactor : SignalSettings
        Channels 1 and 2 as they are, if left out.
    actuator : Actuator or None
        What hangs on the tactor's channel.

    Raises
    ------
    InputError
        One channel for both.

    Examples
    --------
    A pad whose voice coils are channels 3 and 4:

    >>> ears, coils = ov.live.SignalSettings((1, 2)), ov.live.SignalSettings((3, 4))
    >>> ov.live.OutputSettings(ears, coils).channels
    4
    """

    click: SignalSettings = field(default_factory=lambda: SignalSettings(1))
    tactor: SignalSettings = field(default_factory=lambda: SignalSettings(2))
    actuator: Actuator | None = None

    def __post_init__(self) -> None:
        for channel in self.click.channels:
            if channel in self.tactor.channels:
                raise InputError(
                    f"clicks and tactor can't share channel {channel}; give each its own"
                )

    @property
    def signals(self) -> tuple[SignalSettings, SignalSettings]:
        """Click and tactor."""
        return self.click, self.tactor

    @property
    def channels(self) -> int:
        """How many channels the device needs, at least two."""
        return max(2, *self.click.channels, *self.tactor.channels)

    @property
    def placed(self) -> str:
        """Which channels each signal goes to, in words."""
        click, tactor = ("+".join(map(str, one.channels)) or "none" for one in self.signals)
        return f"clicks on {click}, tactor on {tactor}"

    def changed(
        self, click: Mapping[str, Any] | None = None, tactor: Mapping[str, Any] | None = None
    ) -> OutputSettings:
        """Make settings with some of the click's and of the tactor's changed.

        Parameters
        ----------
        click, tactor : mapping or None
            Fields of `SignalSettings`.

        Returns
        -------
        OutputSettings
            These but for them.

        Raises
        ------
        InputError
            A value out of range.

        Examples
        --------
        >>> ov.live.OutputSettings().changed(tactor={"gain_db": -6.0}).tactor.gain_db
        -6.0
        """
        return replace(
            self,
            click=replace(self.click, **(click or {})),
            tactor=replace(self.tactor, **(tactor or {})),
        )

    def write(self, memory: NDArray[np.float64], sample_rate: float, at_once: bool = False) -> None:
        """Ask the audio thread for these; it glides there.

        Parameters
        ----------
        memory : float64
            An engine's.
        sample_rate : float
            Hz.
        at_once : bool
            Without gliding, before the stream runs; actuator and further channels are taken
            then only.

        Raises
        ------
        InputError
            A sample rate that is too low for the actuator.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> ov.live.OutputSettings().write(engine.memory, engine.sample_rate, at_once=True)
        """
        if at_once:
            write_actuator(memory, layout.L_ACTUATOR, self.actuator, sample_rate)
        w = memory.view(np.int64)
        for index, signal in enumerate(self.signals):
            # an actuator's drive has its own limit
            loud = signal.gain > 1.0 and not (signal is self.tactor and self.actuator)
            limited = signal.ceiling_db < MAX_CEILING_DB or loud
            wanted = (signal.gain, gain_of_db(signal.ceiling_db), float(limited))
            for row, value in enumerate(wanted):
                at = row * layout.SIGNALS + index
                memory[layout.L_WANTED + at] = value
                if at_once:
                    memory[layout.L_GAIN + at] = memory[layout.L_TARGET + at] = value
            delay = round(signal.delay_ms * 1e-3 * sample_rate)
            w[layout.L_DELAY_WANTED + index] = delay
            if at_once:
                w[layout.L_DELAY + index] = delay
                also = sum(1 << (channel - 1) for channel in signal.channels[1:])
                memory.view(np.uint64)[layout.L_ALSO_CLICK + index] = also


def channels_in(text: str) -> int | tuple[int, ...]:
    """Channels as a person writes them: `3`, `3+4`, or 0 for nowhere; InputError."""
    try:
        numbers = tuple(int(word) for word in text.split("+"))
    except ValueError:
        raise InputError(f"channel {text!r}; it is a number, several (3+4), or 0") from None
    return _checked(numbers)


def _checked(channel: Any) -> int | tuple[int, ...]:
    """One channel, or several as a tuple; InputError."""
    numbers = tuple(channel) if isinstance(channel, list | tuple) else (channel,)
    if not numbers:
        raise InputError("no channel is given; 0 is nowhere")
    least, words = (0, "1 is the first, 0 nowhere") if len(numbers) == 1 else (1, "1 is the first")
    for number in numbers:
        _within(number, "channel", least, MAX_CHANNELS, words)
        if not isinstance(number, int):
            raise InputError(f"channel {number:g} isn't a whole number")
        if numbers.count(number) > 1:
            raise InputError(f"channel {number} is named twice")
    return numbers if len(numbers) > 1 else int(numbers[0])


def _within(value: float, what: str, low: float, high: float, unit: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        raise InputError(f"{what} {value!r} isn't a number; it is {low:g} to {high:g} ({unit})")
    if not low <= value <= high:
        raise InputError(f"{what} {value:g} is out of range; it is {low:g} to {high:g} ({unit})")


NAMES = ("dualsense", "wireless controller")
"""What its card is called, by the system and the pad's age; an older pad's has two channels."""

CHANNELS = 4
SETTINGS = OutputSettings(SignalSettings((1, 2)), SignalSettings((3, 4)))
"""Clicks for both ears at its socket, the tactor's signal for both hands."""

ACTUATOR = "dualsense"


def is_pad(name: str, channels: int) -> bool:
    """Whether an output of that name and number of channels is such a pad."""
    return channels >= CHANNELS and any(word in name.casefold() for word in NAMES)
