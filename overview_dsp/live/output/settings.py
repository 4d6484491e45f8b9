"""Settings of an output device: channels, gain, mute, delay, ceiling, and an actuator.

They are applied after the engine, so that recordings and replays don't depend on them. A DualSense
game pad connected by USB is an output whose channels 3 and 4 are its voice coils. The settings last
used with each device are saved in a file that users may edit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.files.json_table import read_table, write_table
from overview_dsp.kernels import layout
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.device.output_stage import LONGEST_DELAY_S
from overview_dsp.kernels.device.router import MAX_TACTORS
from overview_dsp.public import changed_fields
from overview_dsp.signal.actuators.calibration import apply_calibration
from overview_dsp.signal.actuators.library import reference
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import write_actuator

MIN_GAIN_DB, MAX_GAIN_DB = -60.0, 24.0
MAX_DELAY_MS = 1e3 * LONGEST_DELAY_S
MIN_CEILING_DB, MAX_CEILING_DB = -60.0, 0.0
MAX_CHANNELS = 64

Channels = int | tuple[int, ...] | tuple[tuple[int, ...], ...]
"""Output channel, several with the same samples, or those of each of several tactors."""


@dataclass(frozen=True)
class SignalSettings:
    """Output settings of one signal.

    Parameters
    ----------
    channel : int, tuple of int, or tuple of tuple of int
        Output channel, from 1; 0 for no output. Several channels, such as a pad's two voice
        coils, get the same samples. A tuple for each of up to eight tactors splits the signal
        among them, as the preset's `tactor.routing` says.
    gain_db : float
        Gain, -60 to 24 dB.
    mute : bool
        Whether the signal is muted.
    delay_ms : float
        Delay, 0 to 100 ms.
    ceiling_db : float
        Limit of the samples, -60 to 0 dBFS.

    Raises
    ------
    InputError
        A value is out of range, or a channel is listed twice.

    Examples
    --------
    >>> ov.live.SignalSettings((3, 4), gain_db=-6.0)
    SignalSettings(channel=(3, 4), gain_db=-6.0)
    >>> ov.live.SignalSettings(((3,), (4,))).tactors  # two tactors
    ((3,), (4,))
    """

    channel: Channels
    gain_db: float = 0.0
    mute: bool = False
    delay_ms: float = 0.0
    ceiling_db: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "channel", _check_channels(self.channel))
        _check_range(self.gain_db, "gain", MIN_GAIN_DB, MAX_GAIN_DB, "dB")
        _check_range(self.delay_ms, "delay", 0.0, MAX_DELAY_MS, "ms")
        _check_range(self.ceiling_db, "ceiling", MIN_CEILING_DB, MAX_CEILING_DB, "dBFS")

    @property
    def channels(self) -> tuple[int, ...]:
        """Output channels of the signal, from 1; empty if it has none."""
        return tuple(channel for tactor in self.tactors for channel in tactor)

    @property
    def tactors(self) -> tuple[tuple[int, ...], ...]:
        """Output channels of each tactor that the signal is split among; one for other signals."""
        groups = (self.channel,) if isinstance(self.channel, int) else self.channel
        if groups == (0,):
            return ((),)
        channels = tuple(one for one in groups if isinstance(one, int))
        return (channels,) if channels else tuple(one for one in groups if isinstance(one, tuple))

    @property
    def gain(self) -> float:
        """Linear gain; 0 when muted."""
        return 0.0 if self.mute else gain_of_db(self.gain_db)

    def __repr__(self) -> str:
        return changed_fields(self)


@dataclass(frozen=True)
class OutputSettings:
    """Output settings of both signals, and the actuator that the tactor's signal drives.

    Parameters
    ----------
    click, tactor : SignalSettings
        Settings of each signal; the defaults are channels 1 and 2 without changes.
    actuator : Actuator or None
        Actuator connected to the tactor's channel.

    Raises
    ------
    InputError
        Both signals use the same channel, or the clicks are split.

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
        if len(self.click.tactors) > 1:
            raise InputError("clicks are one signal; use + between their channels (1+2)")
        for channel in self.click.channels:
            if channel in self.tactor.channels:
                raise InputError(
                    f"clicks and tactor both use channel {channel}; each must have its own"
                )

    @property
    def signals(self) -> tuple[SignalSettings, SignalSettings]:
        """Click and tactor."""
        return self.click, self.tactor

    @property
    def channels(self) -> int:
        """Number of channels that the device must have, at least two."""
        return max(2, *self.click.channels, *self.tactor.channels)

    @property
    def channels_text(self) -> str:
        """Channels of each signal as text for the user."""
        click, tactor = (
            ", ".join("+".join(map(str, each)) for each in one.tactors) or "none"
            for one in self.signals
        )
        return f"clicks on {click}, tactor{'s' * (len(self.tactor.tactors) > 1)} on {tactor}"

    def changed(
        self, click: Mapping[str, Any] | None = None, tactor: Mapping[str, Any] | None = None
    ) -> OutputSettings:
        """Return a copy with some settings of the signals changed.

        Parameters
        ----------
        click, tactor : mapping or None
            Changed fields of `SignalSettings`.

        Returns
        -------
        OutputSettings
            Changed copy.

        Raises
        ------
        InputError
            A value is out of range.

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

    def write(self, memory: FloatArray, sample_rate: float, at_once: bool = False) -> None:
        """Request these settings from the audio thread, which changes to them smoothly.

        Parameters
        ----------
        memory : float64
            Memory of an engine.
        sample_rate : float
            Sample rate, Hz.
        at_once : bool
            Whether to apply them at once, before the stream runs. Only this sets the actuator
            and the second and further channels of a signal.

        Raises
        ------
        InputError
            The sample rate is too low for the actuator.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> ov.live.OutputSettings().write(engine.memory, engine.sample_rate, at_once=True)
        """
        if at_once:
            write_actuator(memory, layout.L_ACTUATOR, self.actuator, sample_rate)
        integers = memory.view(np.int64)
        for index, signal in enumerate(self.signals):
            # an actuator's own stage limits its signal
            can_exceed = signal.gain > 1.0 and not (signal is self.tactor and self.actuator)
            limited = signal.ceiling_db < MAX_CEILING_DB or can_exceed
            targets = (signal.gain, gain_of_db(signal.ceiling_db), float(limited))
            for row, value in enumerate(targets):
                at = row * layout.SIGNALS + index
                memory[layout.L_WANTED + at] = value
                if at_once:
                    memory[layout.L_GAIN + at] = memory[layout.L_TARGET + at] = value
            delay = round(signal.delay_ms * 1e-3 * sample_rate)
            integers[layout.L_DELAY_WANTED + index] = delay
            if at_once:
                integers[layout.L_DELAY + index] = delay
                # a router writes all channels of several tactors
                same = signal.channels[1:] if len(signal.tactors) == 1 else ()
                further_channels = sum(1 << (channel - 1) for channel in same)
                memory.view(np.uint64)[layout.L_ALSO_CLICK + index] = further_channels


def parse_channels(text: str) -> Channels:
    """Parse output channels: `3`, `3+4`, `3,4` for two tactors, or `0` for none; InputError."""
    try:
        groups = [tuple(int(word) for word in group.split("+")) for group in text.split(",")]
    except ValueError:
        raise InputError(
            f"channel {text!r} must be a number, several numbers (3+4), those of "
            "each tactor (3,4), or 0"
        ) from None
    return _check_channels(groups[0] if len(groups) == 1 else tuple(groups))


def _check_channels(channel: Any) -> Channels:
    """Return one channel, several as a tuple, or those of each tactor; InputError."""
    groups = tuple(channel) if isinstance(channel, list | tuple) else (channel,)
    if not groups or () in groups or [] in groups:
        raise InputError("channels are empty; use 0 for none")
    split = all(isinstance(group, list | tuple) for group in groups)
    if len(groups) > MAX_TACTORS and split:
        raise InputError(f"channels are for {len(groups)} tactors; must be at most {MAX_TACTORS}")
    numbers = tuple(number for group in groups for number in group) if split else groups
    least, note = (0, "1 is the first, 0 none") if len(numbers) == 1 else (1, "1 is the first")
    for number in numbers:
        _check_range(number, "channel", least, MAX_CHANNELS, note)
        if not isinstance(number, int):
            raise InputError(f"channel {number:g} must be a whole number")
        if numbers.count(number) > 1:
            raise InputError(f"channel {number} is listed twice")
    if split and len(groups) > 1:
        return tuple(tuple(group) for group in groups)
    return numbers if len(numbers) > 1 else int(numbers[0])


def _check_range(value: float, name: str, low: float, high: float, unit: str) -> None:
    allowed = f"must be {low:g} to {high:g} ({unit})"
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        raise InputError(f"{name} {value!r} isn't a number; {allowed}")
    if not low <= value <= high:
        raise InputError(f"{name} {value:g} is out of range; {allowed}")


PAD_NAMES = ("dualsense", "wireless controller")
"""Names of the pad as an output, which depend on the system. An older pad has two channels."""

PAD_CHANNELS = 4
PAD_SETTINGS = OutputSettings(SignalSettings((1, 2)), SignalSettings((3, 4)))
"""Defaults for a pad: clicks to both sides of its headphone socket, tactor to both voice coils."""

PAD_ACTUATOR = "dualsense"


def is_pad(name: str, channels: int) -> bool:
    """Return whether an output is a pad with voice coils, by its name and number of channels."""
    return channels >= PAD_CHANNELS and any(word in name.casefold() for word in PAD_NAMES)


def settings_file() -> Path:
    """Return the path of the saved settings: `outputs.json` in the user's config folder."""
    return Path(platformdirs.user_config_dir("overview-dsp")) / "outputs.json"


def load_settings(device: str, channels: int = 2) -> OutputSettings:
    """Return the settings last used with a device (by full name), or defaults; no actuator.

    `channels` is the number of its channels. A pad with voice coils has other defaults.

    InputError: the settings file is damaged.
    """
    saved = _read().get(device)
    if saved is None:
        return PAD_SETTINGS if is_pad(device, channels) else OutputSettings()
    try:
        names = {entry.name for entry in fields(SignalSettings)}
        click, tactor = (
            SignalSettings(**{key: saved[signal][key] for key in names})
            for signal in ("click", "tactor")
        )
        return OutputSettings(click, tactor)
    except (KeyError, TypeError, InputError) as error:
        raise InputError(
            f"{settings_file()}: settings of {device!r} are damaged ({error}); correct or delete "
            "the file"
        ) from None


def file_requiring(device: str, channels: int) -> Path | None:
    """Return the settings file if its settings of a device need that many channels, or None."""
    needed = device in _read() and load_settings(device).channels >= channels
    return settings_file() if needed else None


def remembered_actuator(device: str, channels: int = 2) -> str | None:
    """Return the name or file of the actuator last used with a device, or the default, or None."""
    saved = _read().get(device)
    if saved is None and is_pad(device, channels):
        return PAD_ACTUATOR
    name = saved.get("actuator") if isinstance(saved, dict) else None
    return None if name is None else str(name)


def save_settings(device: str, settings: OutputSettings) -> None:
    """Save settings of a device; InputError or OutputError if the file can't be written."""
    saved = _read()
    saved[device] = {
        "click": asdict(settings.click),
        "tactor": asdict(settings.tactor),
        "actuator": None if settings.actuator is None else reference(settings.actuator),
    }
    write_table(settings_file(), saved)


@dataclass(frozen=True)
class ResolvedOutput:
    """Settings to play with, the `remembered` ones, and whether another actuator was chosen."""

    settings: OutputSettings
    remembered: OutputSettings
    other_actuator: bool

    def differ(self, played: OutputSettings) -> bool:
        """Return whether the settings at the end of a session must be saved."""
        before = replace(self.remembered, actuator=played.actuator)
        return self.other_actuator or played != before


def resolve_output(
    device: str | None,
    click: Mapping[str, Any],
    tactor: Mapping[str, Any],
    actuator: str | None,
    channels: int = 2,
) -> ResolvedOutput:
    """Return a device's saved settings, or defaults if `device` is None, with the given changes.

    `click` and `tactor` are changed fields of `SignalSettings`. `actuator` is a name or file,
    "none", or None for the saved one. `channels` is the number of channels of the device.

    InputError: a setting is out of range, or the actuator can't be loaded.
    """
    remembered, saved = OutputSettings(), None
    if device is not None:
        remembered, saved = load_settings(device, channels), remembered_actuator(device, channels)
    chosen = saved if actuator is None else actuator
    try:
        loaded = None if chosen in (None, "none") else apply_calibration(chosen)
    except InputError as error:
        if actuator is not None:
            raise
        raise InputError(
            f"{settings_file()}: actuator of {device!r}: {error}; use --actuator NAME or "
            "--actuator none"
        ) from None
    name = None if loaded is None else reference(loaded)
    settings = replace(remembered.changed(click, tactor), actuator=loaded)
    return ResolvedOutput(settings, remembered, actuator is not None and name != saved)


def _read() -> dict[str, Any]:
    return read_table(settings_file(), "must be a table of devices")
