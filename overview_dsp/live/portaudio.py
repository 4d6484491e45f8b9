"""An audio output that runs the engine: PortAudio with the native callback, or a Python one.

The native callback (the default) is machine code that never waits for the interpreter; the Python
callback is the fallback for platforms where that can't run, chosen by name and never silently.
`sounddevice` is imported here alone, and late.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError, OverviewError, require_internals
from overview_dsp.kernels import layout
from overview_dsp.live.output_settings import OutputSettings
from overview_dsp.live.python_path import compile_python_path, connect, run_block
from overview_dsp.live.stream_meters import StreamMeters, play_again, read_meters
from overview_dsp.public.reprs import short

SOUNDDEVICE = "sounddevice>=0.4.6,<0.6"
"""As pyproject.toml has it. `_StreamBase` is there for library authors; the rest of its inside is
promised to nobody."""

_INTERNALS = (
    "_StreamBase",
    "_ffi.cast",
    "_ffi.dlopen",
    "_lib",
    "_initialized",
    "_initialize",
    "_terminate",
)

CallbackKind = Literal["native", "python"]
FADE_WITHIN_S = 0.5
"""How long closing waits for the fade: a device that has stopped calling never ends it."""

# A running stream must outlive every other reference to it: PortAudio goes on calling.
_RUNNING: set[OutputStream] = set()

_ABANDONED: list[Any] = []


_LIBRARY_HINTS = {
    "linux": "install it (Debian, Ubuntu: apt install libportaudio2; Fedora: dnf install "
    "portaudio; Arch: pacman -S portaudio)",
    "darwin": "pip install --force-reinstall sounddevice brings it (or brew install portaudio)",
    "win32": "pip install --force-reinstall sounddevice brings it",
}
_OUTPUT_HINTS = {
    "linux": "plug in a sound card, or start a sound server (PipeWire, PulseAudio with "
    "libasound2-plugins, or JACK: apt install jackd2)",
    "darwin": "plug in an output and choose it in System Settings, Sound",
    "win32": "plug in an output and enable it in Settings, System, Sound",
}


def no_output_hint() -> str:
    """What to do on this platform when there is no output."""
    return _OUTPUT_HINTS.get(sys.platform, _OUTPUT_HINTS["linux"])


def import_sounddevice() -> Any:
    """The sounddevice module.

    Raises
    ------
    OverviewError
        No PortAudio, or a sounddevice that doesn't have what is used here; how to install them.
    """
    try:
        import sounddevice
    except OSError as error:
        hint = _LIBRARY_HINTS.get(sys.platform, _LIBRARY_HINTS["linux"])
        raise OverviewError(f"no PortAudio library ({error}): {hint}") from None
    require_internals(sounddevice, _INTERNALS, SOUNDDEVICE)
    return sounddevice


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


class OutputStream:
    """A stream that plays an engine through PortAudio, at the engine's sample rate.

    While it is open its audio thread owns the engine's `process`; the control thread may go on
    calling `control`, `set`, `set_surface` and reading meters. As a context it starts and closes.

    Thread: main.

    Parameters
    ----------
    engine : Engine
        Prepared.
    device : int, str or None
        An output's index or a part of its name; None is the default.
    block_size : int
        Frames; 0 lets the device choose, at most the engine's prepared size.
    settings : OutputSettings or None
        Channels, gains, delays, ceilings and actuator; left out, the engine's channels and the
        signals as they are.
    callback : {"native", "python"}
        `native` is machine code that never waits for the interpreter; `python` is the fallback.
    latency : float, "low" or "high"
        What is asked of PortAudio, s.

    Raises
    ------
    InputError
        No such device, or one that can't do this.
    OverviewError
        There is no PortAudio library; how to install it.
    NotPreparedError
        The engine isn't prepared.

    Examples
    --------
    This needs an output:

    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> with ov.live.OutputStream(engine) as stream:  # doctest: +SKIP
    ...     engine.control(theta2=1.2, touching=True)
    """

    def __init__(
        self,
        engine: Engine,
        device: int | str | None = None,
        block_size: int = 256,
        settings: OutputSettings | None = None,
        callback: CallbackKind = "native",
        latency: float | Literal["low", "high"] = "low",
    ) -> None:
        sounddevice = import_sounddevice()
        engine.sample_time  # noqa: B018 - raises NotPreparedError
        if callback not in ("native", "python"):
            raise InputError(f"callback {callback!r} is not known; it is native or python")
        self._sounddevice = sounddevice
        self._engine = engine
        self._memory = engine.memory
        self._w = self._memory.view(np.int64)
        self.callback: CallbackKind = callback
        self.block_size = block_size
        self._started = False
        channels = connect(engine, settings)
        if callback == "python":
            compile_python_path(engine)
        keywords = {
            "samplerate": engine.sample_rate,
            "blocksize": block_size,
            "device": device,
            "channels": channels,
            "dtype": "float32",
            "latency": latency,
        }
        try:
            found = sounddevice.query_devices(device, "output")
            self.name = str(found["name"])
            self._host = str(sounddevice.query_hostapis(found["hostapi"])["name"])
            self._stream = (
                self._native_stream(sounddevice, keywords)
                if callback == "native"
                else sounddevice.OutputStream(callback=self._python_callback, **keywords)
            )
        except (sounddevice.PortAudioError, ValueError) as error:
            raise no_stream(sounddevice, device, channels, engine.sample_rate, error) from None
        _RUNNING.add(self)

    def _native_stream(self, sounddevice: Any, keywords: dict[str, Any]) -> Any:
        from overview_dsp.kernels.device.callback import native_callback

        compiled = native_callback()
        ffi = sounddevice._ffi

        class NativeStream(sounddevice._StreamBase):  # type: ignore[misc]
            """A stream with a C callback, as sounddevice provides for library authors."""

            def __init__(stream) -> None:  # noqa: N805
                super().__init__(
                    kind="output",
                    wrap_callback=None,
                    callback=ffi.cast("PaStreamCallback*", compiled.address),
                    userdata=ffi.cast("void*", self._memory.ctypes.data),
                    **keywords,
                )

        self._compiled = compiled  # the machine code must outlive the stream
        return NativeStream()

    def _python_callback(
        self, out: NDArray[np.float32], frames: int, when: Any, status: Any
    ) -> None:
        if run_block(self._engine, out, bool(status.output_underflow)):
            raise self._sounddevice.CallbackStop

    def set(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings while it plays; channels and actuator stay.

        Parameters
        ----------
        settings : OutputSettings
            It glides to these.

        Examples
        --------
        This needs an output:

        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.OutputStream(engine)  # doctest: +SKIP
        >>> stream.set(ov.live.OutputSettings().changed(click={"mute": True}))  # doctest: +SKIP
        """
        settings.write(self._memory, self._engine.sample_rate)

    def start(self) -> None:
        """Begin to play.

        Examples
        --------
        This needs an output:

        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.OutputStream(engine)  # doctest: +SKIP
        >>> stream.start()  # doctest: +SKIP
        """
        self._stream.start()
        self._started = True

    def restart(self, begin: Callable[[], None]) -> None:
        """Fade out, call `begin` while nothing runs the engine, and play on.

        Parameters
        ----------
        begin : callable
            May call what needs the engine to itself: `reset`, `restart`.

        Raises
        ------
        OverviewError
            The device doesn't answer any more; `begin` wasn't called.

        Examples
        --------
        This needs an output:

        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.OutputStream(engine)  # doctest: +SKIP
        >>> stream.restart(engine.reset)  # doctest: +SKIP
        """
        self._fade_out()
        if self._stream.active:
            raise OverviewError(f"output {self.name} doesn't answer")
        try:
            self._stream.stop()
            begin()
            play_again(self._memory)
            self._stream.start()
        except self._sounddevice.PortAudioError as error:
            raise OverviewError(f"output {self.name}: {_first_line(error)}") from None

    def _fade_out(self) -> None:
        self._w[layout.L_STOP] = 1
        until = time.monotonic() + FADE_WITHIN_S
        while self._stream.active and time.monotonic() < until:
            time.sleep(0.002)

    def close(self) -> None:
        """Fade out, end playing and give the device back; may be called twice.

        Examples
        --------
        This needs an output:

        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.OutputStream(engine)  # doctest: +SKIP
        >>> stream.close()  # doctest: +SKIP
        """
        if self not in _RUNNING:
            return
        self._fade_out()
        faded = self._w[layout.L_FADED] >= self._w[layout.S_GLIDE]
        if "JACK" in self._host and self._started and not faded:
            # its server has died: closing would wait for it for ten minutes, and terminating
            # PortAudio at exit would abort; the stream stays open, and in _RUNNING
            self._sounddevice._initialized = 0
            return
        self._stream.close()
        _RUNNING.discard(self)

    @property
    def active(self) -> bool:
        """Whether the device is calling."""
        return bool(self._stream.active)

    @property
    def meters(self) -> StreamMeters:
        """Counters and callback times (s) so far."""
        return read_meters(self._memory, float(self._stream.latency))

    def __enter__(self) -> OutputStream:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<OutputStream: {short(self.name)}, {self.callback} callback>"


def rescan() -> None:
    """Let PortAudio look for devices again: it lists those of its start only. No stream is open."""
    sounddevice = import_sounddevice()
    # sounddevice has no public names for these
    if any("JACK" in host["name"] for host in sounddevice.query_hostapis()):
        abandon_library(sounddevice)
    else:
        sounddevice._terminate()
        sounddevice._initialize()


def abandon_library(sounddevice: Any) -> None:
    """Begin anew with a copy of the PortAudio library, and leave the old one as it is.

    Once its JACK server has died, PortAudio can't be terminated (an assertion ends the process),
    so it can't be restarted either; a copy of the file is loaded with a state of its own.
    """
    sounddevice._initialized = 0  # else sounddevice terminates the old one at exit
    handle, path = tempfile.mkstemp(suffix=".so")
    os.close(handle)
    try:
        shutil.copyfile(_loaded_file("libportaudio"), path)
        _ABANDONED.append(sounddevice._lib)  # unloaded, its threads would run into nothing
        sounddevice._lib = sounddevice._ffi.dlopen(path)
    finally:
        os.unlink(path)
    sounddevice._initialize()


def _loaded_file(name: str) -> str:
    """The file of a library that this process has loaded (Linux)."""
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
            found = [line.split(None, 5)[5].strip() for line in maps if name in line]
    except OSError:
        found = []
    for path in found:
        if os.path.isfile(path):
            return path
    raise OverviewError("the JACK server has gone; when it is back, start overview play again")


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
        return InputError(f"{what}: {_first_line(error)}; `overview devices` lists what is there")
    if channels > found["max_output_channels"]:
        advice = f"it has {found['max_output_channels']} channels, {channels} are asked for"
    elif "sample rate" in str(error).lower():
        rate = found["default_samplerate"]
        advice = f"it can't do {sample_rate:g} Hz; its own rate is {rate:g}: --sample-rate {rate:g}"
    elif "unavailable" in str(error).lower():
        advice = "another program may hold it: close that, or choose another output"
    else:
        advice = "`overview devices` lists what is there"
    return InputError(f"{what} ({found['name']}): {_first_line(error)}; {advice}")


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0].rstrip(". ")
