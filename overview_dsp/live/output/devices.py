"""The audio outputs that there are, and why one of them can't be opened."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.live.output.portaudio_library import PAD, import_sounddevice
from overview_dsp.live.output.saved_settings import asked_by
from overview_dsp.live.output.settings import is_pad

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
        """Name and host, which what is remembered goes by."""
        return f"{self.name} ({self.host})"


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
        Its index or a part of its name; None is the default, `"pad"` a DualSense by USB.

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

    >>> ov.live.find_device(None).channels  # doctest: +SKIP
    2
    """
    if device == PAD:
        return _pad()
    sounddevice = import_sounddevice()
    try:
        found = sounddevice.query_devices(device, "output")
    except (sounddevice.PortAudioError, ValueError) as error:
        raise no_stream(sounddevice, device, 0, 0.0, error) from None
    return next(output for output in devices() if output.index == found["index"])


def _pad() -> OutputDevice:
    """A pad whose coils are channels 3 and 4: of the default's host, if there; InputError."""
    there = devices()
    found = [output for output in there if is_pad(output.name, output.channels)]
    usual = {output.host for output in there if output.default}
    found.sort(key=lambda output: output.host not in usual)
    if not found:
        raise InputError(
            "--device pad: no output is a pad with its coils on channels 3 and 4 (a DualSense by "
            "USB, not by Bluetooth); `overview devices` lists what is there"
        )
    return found[0]


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
        host = sounddevice.query_hostapis(found["hostapi"])["name"]
        advice = _too_many(f"{found['name']} ({host})", found["max_output_channels"], channels)
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


def _too_many(full_name: str, has: int, channels: int) -> str:
    """That more channels are asked for than it has, who asks, and what changes that."""
    advice = f"it has {has} channels, {channels} are asked for"
    if (path := asked_by(full_name, channels)) is not None:
        advice += f", as {path} remembers"
    if has < 2:
        return f"{advice}; choose another output"
    return (
        f"{advice}; `overview play` with --set click.channel=1 --set tactor.channel=2 (or "
        "`channels 1 2` while it plays) changes that"
    )
