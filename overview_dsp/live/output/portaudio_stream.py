"""PortAudio output that runs the engine in a native or a Python callback.

The native callback (the default) is machine code that never waits for the interpreter. The Python
callback is for platforms without it; it is used only if it is chosen explicitly.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.kernels import layout
from overview_dsp.live.output import jack, stream
from overview_dsp.live.output import portaudio_library as library
from overview_dsp.live.output.devices import find_device, first_line, open_error
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.public import short
from overview_dsp.signal.engine.engine import Engine

CallbackKind = Literal["native", "python"]


class OutputStream(stream.Stream):
    """A stream that plays an engine through PortAudio, at the engine's sample rate.

    While it is open, only its audio thread calls the engine's `process`. The control thread may
    call `control`, `set` and `set_surface` and read meters. As a context manager it starts and
    closes.

    Thread: main.

    Parameters
    ----------
    engine : Engine
        Prepared engine.
    device : int, str or None
        Output, as in `find_device`.
    block_size : int
        Block size in frames; 0 lets the device choose, at most the engine's prepared size.
    settings : OutputSettings or None
        Channels, gains, delays, ceilings and actuator; None uses the engine's channels and
        unchanged signals.
    callback : {"native", "python"}
        `native` is machine code that never waits for the interpreter; `python` is the fallback.
    latency : float, "low" or "high"
        Latency requested from PortAudio, s.

    Raises
    ------
    InputError
        The device doesn't exist or doesn't support the settings.
    OverviewError
        The PortAudio library is missing. The message explains how to install it.
    NotPreparedError
        The engine isn't prepared.

    Examples
    --------
    This needs an output:

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
        from overview_dsp.kernels.device.callback import native_callback

        sounddevice = library.import_sounddevice()
        engine.sample_time  # noqa: B018 - raises NotPreparedError
        if callback not in ("native", "python"):
            raise InputError(f"callback {callback!r} is unknown; must be native or python")
        self._sounddevice = sounddevice
        self._engine = engine
        self._memory = engine.memory
        self._w = self._memory.view(np.int64)
        self.callback: CallbackKind = callback
        self.block_size = validation.whole(block_size, "block_size", least=0)
        self._started = False
        if device == library.PAD:
            device = find_device(device).index
        channels = stream.connect(engine, settings)
        self._router = engine.router  # the callback uses its memory
        keywords: dict[str, Any] = {
            "samplerate": engine.sample_rate, "blocksize": block_size, "device": device,
            "channels": channels, "dtype": "float32", "latency": latency,
        }  # fmt: skip
        make = sounddevice.OutputStream
        if callback == "python":
            stream.compile_python_path(engine)
            keywords["callback"] = self._python_callback
        else:
            make, ffi = partial(sounddevice._StreamBase, "output"), sounddevice._ffi
            self._compiled = native_callback()  # the machine code must outlive the stream
            keywords["callback"] = ffi.cast("PaStreamCallback*", self._compiled.address)
            keywords["userdata"] = ffi.cast("void*", self._memory.ctypes.data)
        try:
            found = sounddevice.query_devices(device, "output")
            self.name = str(found["name"])
            host = str(sounddevice.query_hostapis(found["hostapi"])["name"])
            self.index = int(found["index"])
            self.waits_for_server = "JACK" in host
            self._stream = make(**keywords)
        except (sounddevice.PortAudioError, ValueError) as error:
            raise open_error(sounddevice, device, channels, engine.sample_rate, error) from None
        library.OPEN_STREAMS.add(self)

    def _python_callback(
        self, out: NDArray[np.float32], frames: int, when: Any, status: Any
    ) -> None:
        if stream.run_block(self._engine, out, bool(status.output_underflow)):
            raise self._sounddevice.CallbackStop

    def _start(self) -> None:
        with self._named_errors():
            self._stream.start()
        self._started = True
        if self.connections is not None and (client := library.client_name()) is not None:
            self.missing_connections = jack.connect(client, self.connections)

    def _stop(self) -> None:
        if not self._fade_out():
            stream.undo_fade(self._memory)
            raise OverviewError(f"output {self.name} doesn't respond")
        self._keep_connections()
        with self._named_errors():
            self._stream.stop()
        self._started = False

    @contextlib.contextmanager
    def _named_errors(self) -> Iterator[None]:
        """Convert a PortAudio error to an OverviewError that names the output."""
        try:
            yield
        except self._sounddevice.PortAudioError as error:
            raise OverviewError(f"output {self.name}: {first_line(error)}") from None

    def _fade_out(self) -> bool:
        """Fade out; return whether the stream has ended by itself, as of a device that responds."""
        self._w[layout.L_STOP] = 1
        until = time.monotonic() + stream.FADE_WITHIN_S
        while self._stream.active and time.monotonic() < until:
            time.sleep(0.002)
        return bool(self._w[layout.L_FADED] >= self._w[layout.S_GLIDE])

    def _close(self) -> None:
        if self not in library.OPEN_STREAMS:
            return
        with library.LIBRARY_LOCK:
            library.OPEN_STREAMS.discard(self)
            if not self._fade_out() and self._started and self.waits_for_server:
                # closing would wait for the server for ten minutes
                library.ABANDONED.append(self)
            else:
                self._keep_connections()
                self._stream.close()

    def _keep_connections(self) -> None:
        """Read the connections, before PortAudio stops and undoes them."""
        client = library.client_name() if self._started and self.waits_for_server else None
        if client is not None:
            self.connections = jack.connections(client) or None

    @property
    def active(self) -> bool:
        """State of the stream: True while the device calls it."""
        return bool(self._stream.active)

    @property
    def _latency_s(self) -> float:
        """Latency from a sample to the output as reported by PortAudio, s."""
        return float(self._stream.latency)

    def __repr__(self) -> str:
        return f"<OutputStream: {short(self.name)}, {self.callback} callback>"
