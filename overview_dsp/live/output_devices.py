"""The audio outputs that there are, and why one of them can't be opened."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.live.portaudio_library import import_sounddevice

_OUTPUT_HINTS = {
    "linux": "plug in a sound card, or start a sound server (PipeWire, PulseAudio with "
    "libasound2-plugins, or JACK: apt install jackd2)",
    "darwin": "plug in an output and choose it in System Settings, Sound",
    "win32": "plug in an output and enable it in Settings, System, Sound",
}


def no_output_hint() -> str:
    """What to do on this platform when there is no output."""
    return _OUTPUT_HINTS.get(sys.platform, _OUTPUT_HINTS["linux"])


@dataclass(frozen=True)
class OutputDevice:
    """An audio output.

    Attributes
    ----------
    index : int
        PortAudio's.
    name, host : str
        Of the device, and of its host API.
    channels : int
        How many it has.
    sample_rate : float
        Its own, Hz.
    latency_s : float
        The lowest, s.
    default : bool
        Whether it is the system's choice.

    Examples
    --------
    >>> import overview_dsp as ov
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


def devices() -> list[OutputDevice]:
    """List the audio outputs that PortAudio sees; none of them is opened.

    Returns
    -------
    list of OutputDevice
        In PortAudio's order.

    Raises
    ------
    OverviewError
        There is no PortAudio library; how to install it.

    Examples
    --------
    This needs PortAudio:

    >>> import overview_dsp as ov
    >>> [device.name for device in ov.live.devices()]  # doctest: +SKIP
    ['HDA Intel PCH: ALC257', 'default']
    """
    sounddevice = import_sounddevice()
    hosts = sounddevice.query_hostapis()
    chosen = sounddevice.default.device[1]
    return [
        OutputDevice(
            index=device["index"],
            name=device["name"],
            host=hosts[device["hostapi"]]["name"],
            channels=device["max_output_channels"],
            sample_rate=device["default_samplerate"],
            latency_s=device["default_low_output_latency"],
            default=device["index"] == chosen,
        )
        for device in sounddevice.query_devices()
        if device["max_output_channels"] > 0
    ]


def find_device(device: int | str | None) -> OutputDevice:
    """Find an audio output.

    Parameters
    ----------
    device : int, str or None
        Its index or a part of its name; None is the default.

    Returns
    -------
    OutputDevice
        That one.

    Raises
    ------
    InputError
        There is none of that name, or no output at all.
    OverviewError
        There is no PortAudio library; how to install it.

    Examples
    --------
    This needs an output:

    >>> import overview_dsp as ov
    >>> ov.live.find_device(None).channels  # doctest: +SKIP
    2
    """
    sounddevice = import_sounddevice()
    try:
        found = sounddevice.query_devices(device, "output")
    except (sounddevice.PortAudioError, ValueError) as error:
        raise no_stream(sounddevice, device, 0, 0.0, error) from None
    return next(output for output in devices() if output.index == found["index"])


def no_stream(
    sounddevice: Any, device: Any, channels: int, sample_rate: float, error: Exception
) -> InputError:
    """Why an output can't be opened, and what to try."""
    what = "the default output" if device is None else f"output device {device!r}"
    try:
        found = sounddevice.query_devices(device, "output")
    except (sounddevice.PortAudioError, ValueError):
        if not devices():
            return InputError(
                f"no audio output: {no_output_hint()}; or play without sound (--device none)"
            )
        return InputError(f"{what}: {first_line(error)}; `overview devices` lists what is there")
    if channels > found["max_output_channels"]:
        advice = f"it has {found['max_output_channels']} channels, {channels} are asked for"
    elif "sample rate" in str(error).lower():
        rate = found["default_samplerate"]
        advice = f"it can't do {sample_rate:g} Hz; its own rate is {rate:g}: --sample-rate {rate:g}"
    elif "unavailable" in str(error).lower():
        advice = "another program may hold it: close that, or choose another output"
    else:
        advice = "`overview devices` lists what is there"
    return InputError(f"{what} ({found['name']}): {first_line(error)}; {advice}")


def first_line(error: Exception) -> str:
    """What it says, without the rest."""
    return str(error).splitlines()[0].rstrip(". ")
