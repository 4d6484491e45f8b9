"""What each output device is given: channels, gain, mute, delay, ceiling, and an actuator.

They are kept per device.

They come after the engine: a recording doesn't hold them, and a replay doesn't need them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from overview_dsp.actuators.coefficients import write_actuator
from overview_dsp.actuators.library import reference
from overview_dsp.actuators.model import Actuator
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import whole_file
from overview_dsp.kernels import layout
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.public.reprs import changed_fields

MIN_GAIN_DB, MAX_GAIN_DB = -60.0, 24.0
MAX_DELAY_MS = 100.0
MIN_CEILING_DB, MAX_CEILING_DB = -60.0, 0.0
MAX_CHANNELS = 64


@dataclass(frozen=True)
class SignalSettings:
    """One signal's way out.

    Parameters
    ----------
    channel : int
        From 1; 0 is nowhere.
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
        A value out of range.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> ov.live.SignalSettings(3, gain_db=-6.0)
    SignalSettings(channel=3, gain_db=-6.0)
    """

    channel: int
    gain_db: float = 0.0
    mute: bool = False
    delay_ms: float = 0.0
    ceiling_db: float = 0.0

    def __post_init__(self) -> None:
        _within(self.channel, "channel", 0, MAX_CHANNELS, "1 is the first, 0 nowhere")
        _within(self.gain_db, "gain", MIN_GAIN_DB, MAX_GAIN_DB, "dB")
        _within(self.delay_ms, "delay", 0.0, MAX_DELAY_MS, "ms")
        _within(self.ceiling_db, "ceiling", MIN_CEILING_DB, MAX_CEILING_DB, "dBFS")

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

    >>> import overview_dsp as ov
    >>> settings = ov.live.OutputSettings(ov.live.SignalSettings(1), ov.live.SignalSettings(3))
    >>> settings.channels
    3
    """

    click: SignalSettings = field(default_factory=lambda: SignalSettings(1))
    tactor: SignalSettings = field(default_factory=lambda: SignalSettings(2))
    actuator: Actuator | None = None

    def __post_init__(self) -> None:
        if self.click.channel and self.click.channel == self.tactor.channel:
            raise InputError(
                f"clicks and tactor can't share channel {self.click.channel}; give each its own"
            )

    @property
    def signals(self) -> tuple[SignalSettings, SignalSettings]:
        """Click and tactor."""
        return self.click, self.tactor

    @property
    def channels(self) -> int:
        """How many channels the device needs, at least two."""
        return max(2, self.click.channel, self.tactor.channel)

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
        >>> import overview_dsp as ov
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
            Without gliding, before the stream runs; the actuator is taken then only.

        Raises
        ------
        InputError
            A sample rate that is too low for the actuator.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
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


def _within(value: float, what: str, low: float, high: float, unit: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        raise InputError(f"{what} {value!r} isn't a number; it is {low:g} to {high:g} ({unit})")
    if not low <= value <= high:
        raise InputError(f"{what} {value:g} is out of range; it is {low:g} to {high:g} ({unit})")


def settings_file() -> Path:
    """Where the devices' settings are kept: `outputs.json` in the user's config folder."""
    return Path(platformdirs.user_config_dir("overview-dsp")) / "outputs.json"


def load_settings(device: str) -> OutputSettings:
    """The settings last used with a device (by its name), or the defaults; without the actuator.

    Raises
    ------
    InputError
        A damaged settings file: names it.
    """
    kept = _read().get(device)
    if kept is None:
        return OutputSettings()
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


def remembered_actuator(device: str) -> str | None:
    """What the actuator last used with a device is loaded by, or None; InputError as above."""
    kept = _read().get(device)
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
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps(kept, indent=1, ensure_ascii=False), encoding="utf-8")


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
