"""An audio output that runs the engine: PortAudio with the native callback, or a Python one.

The native callback (the default) is machine code that never waits for the interpreter; the Python
callback is the fallback for platforms where that can't run, chosen by name and never silently.
`sounddevice` is imported here alone, and late.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine import Engine
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.kernels import layout

CallbackKind = Literal["native", "python"]
UNDERFLOW = 4

# A running stream must outlive every other reference to it: PortAudio goes on calling.
_RUNNING: set[OutputStream] = set()


@dataclass(frozen=True)
class StreamMeters:
    """What the device side reports since the stream began.

    `callbacks`, `frames` delivered, `underflows` (callbacks told of one), `late` (callbacks that
    took longer than their own frames last), `median_s`, `p99_s`, `longest_s` (callback time; the
    first two to a fifth), `latency_s` (as PortAudio tells it).
    """

    callbacks: int
    frames: int
    underflows: int
    late: int
    median_s: float
    p99_s: float
    longest_s: float
    latency_s: float


def import_sounddevice() -> Any:
    """The sounddevice module; OverviewError with how to install PortAudio if it isn't there."""
    try:
        import sounddevice
    except OSError as error:
        raise OverviewError(
            f"no PortAudio library ({error}): on Debian or Ubuntu apt install libportaudio2, "
            "on macOS and Windows reinstall sounddevice"
        ) from None
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
        channels: int = 2,
        callback: CallbackKind = "native",
        latency: float | Literal["low", "high"] = "low",
    ) -> None:
        """Open an output device (None = the default) at the engine's sample rate; `start` plays.

        `block_size` is in frames; 0 lets the device choose, at most the engine's prepared size.

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
        self._engine = engine
        self._memory = engine.memory
        self._w = self._memory.view(np.int64)
        self.callback: CallbackKind = callback
        self.block_size = block_size
        self._clear_meters(channels)
        keywords = {
            "samplerate": engine.sample_rate,
            "blocksize": block_size,
            "device": device,
            "channels": channels,
            "dtype": "float32",
            "latency": latency,
        }
        try:
            self._stream = (
                self._native_stream(sounddevice, keywords)
                if callback == "native"
                else sounddevice.OutputStream(callback=self._python_callback, **keywords)
            )
        except (sounddevice.PortAudioError, ValueError) as error:
            raise InputError(f"output device {device!r}: {error}; see `overview devices`") from None
        _RUNNING.add(self)

    def _native_stream(self, sounddevice: Any, keywords: dict[str, Any]) -> Any:
        from overview_dsp.kernels.callback import native_callback

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
        started = time.perf_counter()
        self._engine.process(out)
        seconds = time.perf_counter() - started
        w, m = self._w, self._memory
        w[layout.L_CALLBACKS] += 1
        w[layout.L_FRAMES] += frames
        w[layout.L_UNDERFLOWS] += bool(status.output_underflow)
        w[layout.L_LATE] += seconds * self._engine.sample_rate > frames
        m[layout.L_LONGEST] = max(m[layout.L_LONGEST], seconds)
        octaves = np.log2(max(seconds / layout.SHORTEST_S, 1.0))
        w[layout.L_BUSY + min(int(octaves * layout.BINS_AN_OCTAVE), layout.BUSY_BINS - 1)] += 1

    def _clear_meters(self, channels: int) -> None:
        self._w[layout.LIVE : layout.SURFACES] = 0
        self._w[layout.L_CHANNELS] = channels

    def start(self) -> None:
        """Begin to play."""
        self._stream.start()

    def stop(self) -> None:
        """End playing; `start` may follow."""
        self._stream.stop()

    def close(self) -> None:
        """End playing and give the device back; may be called twice."""
        self._stream.close()
        _RUNNING.discard(self)

    @property
    def active(self) -> bool:
        """Whether the device is calling."""
        return bool(self._stream.active)

    @property
    def meters(self) -> StreamMeters:
        """Counters and callback times so far."""
        w, m = self._w, self._memory
        return StreamMeters(
            callbacks=int(w[layout.L_CALLBACKS]),
            frames=int(w[layout.L_FRAMES]),
            underflows=int(w[layout.L_UNDERFLOWS]),
            late=int(w[layout.L_LATE]),
            median_s=self._busy_quantile(0.5),
            p99_s=self._busy_quantile(0.99),
            longest_s=float(m[layout.L_LONGEST]),
            latency_s=float(self._stream.latency),
        )

    def _busy_quantile(self, part: float) -> float:
        counts = np.cumsum(self._w[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS])
        if not counts[-1]:
            return 0.0
        where = int(np.searchsorted(counts, part * counts[-1]))
        return float(layout.SHORTEST_S * 2.0 ** ((where + 1) / layout.BINS_AN_OCTAVE))

    def __enter__(self) -> OutputStream:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
