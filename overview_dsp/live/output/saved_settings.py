"""The settings last used with each output device, kept in a file that a person may edit."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import platformdirs

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file
from overview_dsp.live.output import settings as pad_output
from overview_dsp.live.output.settings import OutputSettings, SignalSettings
from overview_dsp.signal.actuators.calibration import apply_calibration
from overview_dsp.signal.actuators.library import reference


def settings_file() -> Path:
    """Where the devices' settings are kept: `outputs.json` in the user's config folder."""
    return Path(platformdirs.user_config_dir("overview-dsp")) / "outputs.json"


def load_settings(device: str, channels: int = 2) -> OutputSettings:
    """The settings last used with a device (by its name), or the defaults; without the actuator.

    `channels` is how many it has: the defaults of a pad that has coils are others.

    Raises
    ------
    InputError
        A damaged settings file: names it.
    """
    kept = _read().get(device)
    if kept is None:
        return pad_output.SETTINGS if pad_output.is_pad(device, channels) else OutputSettings()
    try:
        names = {entry.name for entry in fields(SignalSettings)}
        click, tactor = (
            SignalSettings(**{key: kept[signal][key] for key in names})
            for signal in ("click", "tactor")
        )
        return OutputSettings(click, tactor)
    except (KeyError, TypeError, InputError) as error:
        raise InputError(
            f"{settings_file()}: the settings of {device!r} are damaged ({error}); correct or "
            "delete the file"
        ) from None


def asked_by(device: str, channels: int) -> Path | None:
    """The file, if what it remembers of a device needs so many channels; else None."""
    asks = device in _read() and load_settings(device).channels >= channels
    return settings_file() if asks else None


def remembered_actuator(device: str, channels: int = 2) -> str | None:
    """What the actuator last used with a device, or a pad's own, is loaded by; or None."""
    kept = _read().get(device)
    if kept is None and pad_output.is_pad(device, channels):
        return pad_output.ACTUATOR
    name = kept.get("actuator") if isinstance(kept, dict) else None
    return None if name is None else str(name)


def save_settings(device: str, settings: OutputSettings) -> None:
    """Remember settings for a device; InputError or OutputError if that can't be written."""
    kept = _read()
    kept[device] = {
        "click": asdict(settings.click),
        "tactor": asdict(settings.tactor),
        "actuator": None if settings.actuator is None else reference(settings.actuator),
    }
    path = settings_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(kept, indent=1, ensure_ascii=False), encoding="utf-8")


@dataclass(frozen=True)
class ResolvedOutput:
    """Settings to play with; `remembered` are the device's, `other_actuator` if not its own."""

    settings: OutputSettings
    remembered: OutputSettings
    other_actuator: bool

    def differ(self, played: OutputSettings) -> bool:
        """Return whether the settings at the end are to be remembered."""
        before = replace(self.remembered, actuator=played.actuator)
        return self.other_actuator or played != before


def resolve_output(
    device: str | None,
    click: Mapping[str, Any],
    tactor: Mapping[str, Any],
    actuator: str | None,
    channels: int = 2,
) -> ResolvedOutput:
    """Return a device's settings (None: one that isn't remembered), with those of now applied.

    `click` and `tactor` are fields of `SignalSettings` that are changed; `actuator` is the name or
    file of one, "none", or None for the device's own; `channels` is how many the device has.

    Raises
    ------
    InputError
        A setting out of range, or an actuator that can't be loaded.
    """
    remembered, own = OutputSettings(), None
    if device is not None:
        remembered, own = load_settings(device, channels), remembered_actuator(device, channels)
    wanted = own if actuator is None else actuator
    try:
        driven = None if wanted in (None, "none") else apply_calibration(wanted)
    except InputError as error:
        if actuator is not None:
            raise
        raise InputError(
            f"{settings_file()}: the actuator of {device!r}: {error}; --actuator names another, or "
            "none"
        ) from None
    name = None if driven is None else reference(driven)
    settings = replace(remembered.changed(click, tactor), actuator=driven)
    return ResolvedOutput(settings, remembered, actuator is not None and name != own)


def _read() -> dict[str, Any]:
    path = settings_file()
    try:
        kept = json.loads(path.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: can't be read ({error}); correct or delete it") from None
    if not isinstance(kept, dict):
        raise InputError(f"{path}: not a table of devices; correct or delete it")
    return kept
