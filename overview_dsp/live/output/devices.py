"""Audio outputs of this machine, and errors of outputs that can't be opened."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal

from overview_dsp.errors import InputError
from overview_dsp.live.output.portaudio_library import PAD, import_sounddevice, platform_hint
from overview_dsp.live.output.settings import file_requiring, is_pad

Kind = Literal["input", "output"]
_CARD = re.compile(r"\(hw:\d+(,\d+)*\)")


@dataclass(frozen=True)
class OutputDevice:
    """An audio output.

    Attributes
    ----------
    index : int
        PortAudio's index of the device.
    name, host : str
        Names of the device and of its host API.
    channels : int
        Number of output channels.
    sample_rate : float
        Default sample rate, Hz.
    latency_s : float
        Lowest latency, s.
    default : bool
        Whether it is the default output of the system.

    Examples
    --------
    >>> ov.live.OutputDevice(0, "Headphones", "ALSA", 2, 48_000.0, 0.005, True).name
    'Headphones'
    """

    index: int
    name: str
    host: str
    channels: int
    sample_rate: float
    latency_s: float
    default: bool

    @property
    def full_name(self) -> str:
        """Name and host; saved settings are stored under it."""
        return f"{self.name} ({self.host})"


def devices() -> list[OutputDevice]:
    """List the audio outputs that PortAudio finds, without opening them.

    Returns
    -------
    list of OutputDevice
        Outputs in PortAudio's order.

    Raises
    ------
    OverviewError
        The PortAudio library is missing. The message explains how to install it.

    Examples
    --------
    This needs PortAudio:

    >>> [device.name for device in ov.live.devices()]  # doctest: +SKIP
    ['HDA Intel PCH: ALC257', 'default']
    """
    return listed("output")


def listed(kind: Kind) -> list[OutputDevice]:
    """Return the audio outputs, or the inputs in the same form."""
    sounddevice = import_sounddevice()
    hosts = sounddevice.query_hostapis()
    chosen = sounddevice.default.device[kind == "output"]
    return [
        OutputDevice(
            one["index"], one["name"], hosts[one["hostapi"]]["name"], one[f"max_{kind}_channels"],
            one["default_samplerate"], one[f"default_low_{kind}_latency"], one["index"] == chosen,
        )
        for one in sounddevice.query_devices()
        if one[f"max_{kind}_channels"] > 0
    ]  # fmt: skip


def find_device(device: int | str | None) -> OutputDevice:
    """Find an audio output.

    Parameters
    ----------
    device : int, str or None
        Index or part of the name. None is the default output, `"pad"` a DualSense by USB.

    Returns
    -------
    OutputDevice
        The output found.

    Raises
    ------
    InputError
        No output has that name, or there is no output.
    OverviewError
        The PortAudio library is missing. The message explains how to install it.

    Examples
    --------
    This needs an output:

    >>> ov.live.find_device(None).channels  # doctest: +SKIP
    2
    """
    if device == PAD:
        return _pad()
    sounddevice = import_sounddevice()
    try:
        found = sounddevice.query_devices(device, "output")
    except (sounddevice.PortAudioError, ValueError) as error:
        raise open_error(sounddevice, device, 0, 0.0, error) from None
    return next(output for output in devices() if output.index == found["index"])


def same_device(known: OutputDevice, kind: Kind = "output") -> OutputDevice:
    """Return the present output or input with the host and name of one that was open.

    ALSA's names contain the number of the card, which may change. Of several such outputs the one
    with the same name and the nearest index is returned. InputError: there is none.
    """
    found = [
        one
        for one in (devices() if kind == "output" else listed(kind))
        if one.host == known.host and _CARD.sub("", one.name) == _CARD.sub("", known.name)
    ]
    if not found:
        raise InputError(f"{kind} {known.full_name} is not there; connect it again")
    return min(found, key=lambda one: (one.name != known.name, abs(one.index - known.index)))


def _pad() -> OutputDevice:
    """Return a pad with its coils on channels 3 and 4, of the default host if possible."""
    outputs = devices()
    found = [output for output in outputs if is_pad(output.name, output.channels)]
    default_hosts = {output.host for output in outputs if output.default}
    found.sort(key=lambda output: output.host not in default_hosts)
    if not found:
        raise InputError(
            "--device pad: no output is a pad with its coils on channels 3 and 4; connect a "
            "DualSense by USB (Bluetooth doesn't work), or see `overview devices`"
        )
    return found[0]


def open_error(
    sounddevice: Any, device: Any, channels: int, sample_rate: float, error: Exception
) -> InputError:
    """Return the error for an output that can't be opened, with its reason and a remedy."""
    what = "default output" if device is None else f"output device {device!r}"
    try:
        found = sounddevice.query_devices(device, "output")
    except (sounddevice.PortAudioError, ValueError):
        if not devices():
            hint = platform_hint("output")
            return InputError(
                f"no audio output found: {hint}; or play without sound (--device none)"
            )
        return InputError(f"{what}: {first_line(error)}; `overview devices` lists all outputs")
    if channels > found["max_output_channels"]:
        host = sounddevice.query_hostapis(found["hostapi"])["name"]
        advice = _channel_advice(
            f"{found['name']} ({host})", found["max_output_channels"], channels
        )
    elif "sample rate" in str(error).lower():
        rate = found["default_samplerate"]
        advice = f"{sample_rate:g} Hz isn't supported; try its default, --sample-rate {rate:g}"
    elif "unavailable" in str(error).lower():
        advice = "another program may use it; close that program, or choose another output"
    else:
        advice = "`overview devices` lists all outputs"
    return InputError(f"{what} ({found['name']}): {first_line(error)}; {advice}")


def first_line(error: Exception) -> str:
    """Return the first line of an error's message."""
    return str(error).splitlines()[0].rstrip(". ")


def _channel_advice(full_name: str, available: int, channels: int) -> str:
    """Return what to do about a device with fewer channels than the settings need."""
    advice = f"it has {available} channels, but {channels} are needed"
    if (path := file_requiring(full_name, channels)) is not None:
        advice += f" by its settings in {path}"
    if available < 2:
        return f"{advice}; choose another output"
    return (
        f"{advice}; use `overview play` with --set click.channel=1 --set tactor.channel=2, or the "
        "command `channels 1 2` during playback"
    )
