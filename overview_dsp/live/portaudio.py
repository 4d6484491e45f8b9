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
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError, OverviewError, require_internals
from overview_dsp.kernels import layout
from overview_dsp.live.output_settings import OutputSettings
from overview_dsp.live.python_path import compile_python_path, connect, run_block
from overview_dsp.live.stream_meters import StreamMeters, read_meters

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
class Output:
    """An output device: PortAudio's index, name, host API, channels, rate (Hz), lowest latency."""

    index: int
    name: str
    host: str
    channels: int
    sample_rate: float
    latency_s: float
    default: bool


def outputs() -> list[Output]:
    """The output devices PortAudio sees; OverviewError if there is no PortAudio."""
    sounddevice = import_sounddevice()
    hosts = sounddevice.query_hostapis()
    chosen = sounddevice.default.device[1]
    return [
        Output(
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


def find_output(device: int | str | None) -> Output:
    """The output of that name or index (None = the default).

    Raises
    ------
    InputError
        There is none, or no output at all.
    """
    sounddevice = import_sounddevice()
    try:
        found = sounddevice.query_devices(device, "output")
    except (sounddevice.PortAudioError, ValueError) as error:
        raise no_stream(sounddevice, device, 0, 0.0, error) from None
    return next(output for output in outputs() if output.index == found["index"])


class OutputStream:
    """A stream that plays an engine.

    While it is open its audio thread owns the engine's `process`; the control thread may go on
    calling `control`, `set`, `set_surface` and reading meters.

    Thread: main.
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
        """Open an output device (None = the default) at the engine's sample rate; `start` plays.

        `block_size` is in frames; 0 lets the device choose, at most the engine's prepared size.
        `settings` say which channels, gains, delays, ceilings and actuator; left out,
        the engine's channels and the signals as they are.

        Raises
        ------
        InputError
            No such device, or one that can't do this.
        NotPreparedError
            The engine isn't prepared.
        """
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
        """Change gains, mutes, delays and ceilings while it plays; channels and actuator stay."""
        settings.write(self._memory, self._engine.sample_rate)

    def start(self) -> None:
        """Begin to play."""
        self._stream.start()
        self._started = True

    def close(self) -> None:
        """Fade out, end playing and give the device back; may be called twice."""
        if self not in _RUNNING:
            return
        self._w[layout.L_STOP] = 1
        until = time.monotonic() + FADE_WITHIN_S
        while self._stream.active and time.monotonic() < until:
            time.sleep(0.002)
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
        """Counters and callback times so far."""
        return read_meters(self._memory, float(self._stream.latency))

    def __enter__(self) -> OutputStream:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


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
        if not outputs():
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
