"""Settings last used with each output device, saved in a file that users may edit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import platformdirs

from overview_dsp.errors import InputError
from overview_dsp.files.json_table import read_table, write_table
from overview_dsp.live.output.settings import (
    PAD_ACTUATOR,
    PAD_SETTINGS,
    OutputSettings,
    SignalSettings,
    is_pad,
)
from overview_dsp.signal.actuators.calibration import apply_calibration
from overview_dsp.signal.actuators.library import reference


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
