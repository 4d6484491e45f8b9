"""Streams that run an engine: base class, meters, Python callback, and one without a device."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.output_stage import finish_block
from overview_dsp.kernels.device.router import FRAMES
from overview_dsp.live.output.jack import Connections
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.public import counted
from overview_dsp.signal.engine.engine import Engine

FADE_WITHIN_S = 0.5
"""Time that closing waits for the fade, which never ends on a device that has stopped calling."""


@dataclass(frozen=True)
class StreamMeters:
    """Counters and callback times of a stream since its start.

    Attributes
    ----------
    callbacks, frames : int
        Number of callbacks, and number of frames that they delivered.
    underflows, late : int
        Number of callbacks with an underflow, and number that took longer than their frames last.
    load : float
        Fraction of the time spent in callbacks, within 20 %. Above 1 the output stutters.
    median_s, p99_s, longest_s : float
        Callback times, s; median and 99th percentile are within 20 %.
    latency_s : float
        Latency as PortAudio reports it, s.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> stream = ov.live.NullStream(engine)
    >>> stream.meters.late
    0
    """

    callbacks: int
    frames: int
    underflows: int
    late: int
    load: float
    median_s: float
    p99_s: float
    longest_s: float
    latency_s: float

    def __repr__(self) -> str:
        return (
            f"<StreamMeters: {counted(self.callbacks, 'callback')}, {self.late} late, "
            f"{counted(self.underflows, 'underflow')}, median {1e6 * self.median_s:.0f} us, "
            f"longest {1e6 * self.longest_s:.0f} us>"
        )


def clear_meters(memory: FloatArray, channels: int) -> None:
    """Reset counters, delay lines and fade for a new stream; keep gains, actuator and channels."""
    w = memory.view(np.int64)
    gains = memory[layout.L_GAIN : layout.L_LEFT].copy()
    delays = w[layout.L_DELAY : layout.L_DELAY + layout.SIGNALS].copy()
    also = w[layout.L_ALSO_CLICK : layout.L_ALSO_CLICK + layout.SIGNALS].copy()
    w[layout.LIVE : layout.L_ACTUATOR] = 0
    w[layout.L_ALSO_CLICK : layout.L_ALSO_CLICK + layout.SIGNALS] = also
    memory[layout.L_GAIN : layout.L_LEFT] = gains
    w[layout.L_DELAY : layout.L_DELAY + layout.SIGNALS] = delays
    w[layout.L_DELAY_WANTED : layout.L_DELAY_WANTED + layout.SIGNALS] = delays
    w[layout.L_CHANNELS] = channels


def undo_fade(memory: FloatArray) -> None:
    """Make the output audible again after a fade, with empty delay lines."""
    w = memory.view(np.int64)
    w[layout.L_STOP] = w[layout.L_FADED] = 0
    w[layout.L_LINES : layout.L_LINES + layout.SIGNALS * layout.DELAY_LINE] = 0


def record_callback(
    memory: FloatArray, frames: int, seconds: float, underflow: bool = False
) -> None:
    """Record a callback that ran in Python."""
    w = memory.view(np.int64)
    w[layout.L_CALLBACKS] += 1
    w[layout.L_FRAMES] += frames
    w[layout.L_UNDERFLOWS] += underflow
    w[layout.L_LATE] += seconds * memory[layout.S_SAMPLE_RATE] > frames
    memory[layout.L_LONGEST] = max(memory[layout.L_LONGEST], seconds)
    octaves = np.log2(max(seconds / layout.SHORTEST_S, 1.0))
    w[layout.L_BUSY + min(int(octaves * layout.BINS_PER_OCTAVE), layout.BUSY_BINS - 1)] += 1


def read_meters(memory: FloatArray, latency_s: float) -> StreamMeters:
    """Return counters and callback times so far."""
    w = memory.view(np.int64)
    median, p99 = _quantile(w, 0.5), _quantile(w, 0.99)  # upper ends of bins, above the longest
    longest = float(memory[layout.L_LONGEST])
    return StreamMeters(
        callbacks=int(w[layout.L_CALLBACKS]), frames=int(w[layout.L_FRAMES]),
        underflows=int(w[layout.L_UNDERFLOWS]), late=int(w[layout.L_LATE]),
        load=_load(w, float(memory[layout.S_SAMPLE_RATE])), median_s=min(median, longest),
        p99_s=min(p99, longest), longest_s=longest, latency_s=latency_s,
    )  # fmt: skip


def take_peaks(memory: FloatArray) -> tuple[float, float]:
    """Return the highest click and tactor sample sent to the device since the last call, linear."""
    peaks = memory[layout.L_PEAK : layout.L_PEAK + layout.SIGNALS]
    click, tactor = peaks.tolist()
    peaks[:] = 0.0
    return click, tactor


def _load(w: IntArray, sample_rate: float) -> float:
    """Return the callback times, each at the middle of its bin, divided by their frames' time."""
    bins = np.arange(layout.BUSY_BINS) + 0.5
    seconds = layout.SHORTEST_S * 2.0 ** (bins / layout.BINS_PER_OCTAVE)
    busy = float(w[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS] @ seconds)
    return busy * sample_rate / max(1, int(w[layout.L_FRAMES]))


def _quantile(w: IntArray, part: float) -> float:
    counts = np.cumsum(w[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS])
    if not counts[-1]:
        return 0.0
    where = int(np.searchsorted(counts, part * counts[-1]))
    return float(layout.SHORTEST_S * 2.0 ** ((where + 1) / layout.BINS_PER_OCTAVE))


class Stream(ABC):
    """Stream that runs an engine in real time: an `OutputStream`, or a `NullStream` without device.

    Thread: main; while it plays, only its audio thread calls the engine's `process`.

    Attributes
    ----------
    name : str
        Name of the output.
    block_size : int
        Block size in frames.
    connections : list or None
        Ports on JACK that each channel was connected to when it last stopped; `start` connects
        them again. None: the default ports.
    waits_for_server : bool
        Whether its server may stop for a while and continue (JACK).
    missing_connections : sequence of str
        Ports among `connections` that the last start didn't find.
    """

    name: str
    block_size: int
    connections: Connections | None = None
    waits_for_server: bool = False
    missing_connections: Sequence[str] = ()
    _engine: Engine

    @abstractmethod
    def _start(self) -> None:
        """Start to call `process`; OverviewError if the device can't."""

    @abstractmethod
    def _stop(self) -> None:
        """Fade out and stop calling `process`; OverviewError if the device doesn't respond."""

    @abstractmethod
    def _close(self) -> None:
        """Fade out and end; repeated calls do nothing."""

    def start(self) -> None:
        """Start to play.

        Raises
        ------
        OverviewError
            The device can't start.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.NullStream(engine)
        >>> stream.start()
        >>> stream.active
        True
        >>> stream.close()
        """
        self._start()

    def restart(self, begin: Callable[[], None]) -> None:
        """Fade out, call `begin` while nothing runs the engine, and continue to play.

        Parameters
        ----------
        begin : callable
            Function that may call `reset` and `restart` of the engine.

        Raises
        ------
        OverviewError
            The device doesn't respond. `begin` wasn't called.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> with ov.live.NullStream(engine) as stream:
        ...     stream.restart(engine.reset)
        """
        self._stop()
        begin()
        undo_fade(self._engine.memory)
        self._start()

    def set(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings smoothly; channels and actuator stay.

        Parameters
        ----------
        settings : OutputSettings
            New settings.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> with ov.live.NullStream(engine) as stream:
        ...     stream.set(ov.live.OutputSettings().changed(click={"mute": True}))
        """
        settings.write(self._engine.memory, self._engine.sample_rate)

    def close(self) -> None:
        """Fade out and close the device; repeated calls do nothing.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.NullStream(engine)
        >>> stream.start()
        >>> stream.close()
        >>> stream.active
        False
        """
        self._close()

    @property
    @abstractmethod
    def active(self) -> bool:
        """State of the stream: True while it runs the engine."""

    @property
    @abstractmethod
    def _latency_s(self) -> float:
        """Latency from a sample to the output as the device reports it, s."""

    @property
    def meters(self) -> StreamMeters:
        """Counters and callback times (s) so far."""
        return read_meters(self._engine.memory, self._latency_s)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def connect(engine: Engine, settings: OutputSettings | None) -> int:
    """Prepare an engine's memory for a new stream; return the number of channels it needs.

    Without settings the engine's channels are used, and the signals aren't changed.
    """
    validation.instance(engine, Engine, "engine", "ov.Engine makes one")
    memory = engine.memory
    if settings is not None:
        click, tactor = (
            signal.channels[0] - 1 if signal.channels else None for signal in settings.signals
        )
        engine.set_channels(click, tactor)
    mapped = memory.view(np.int64)[[layout.S_CLICK_CHANNEL, layout.S_TACTOR_CHANNEL]]
    channels = max(2 if settings is None else settings.channels, int(mapped.max()) + 1)
    clear_meters(memory, channels)
    settings = settings or OutputSettings()
    settings.write(memory, engine.sample_rate, at_once=True)
    tactors = settings.tactor.tactors
    router = engine.set_tactors(len(tactors))
    if router is not None:
        router.set_channels([[channel - 1 for channel in tactor] for tactor in tactors])
        memory.view(np.int64)[layout.L_ROUTER] = router.memory.ctypes.data
    return channels


def compile_python_path(engine: Engine) -> None:
    """Compile everything that `run_block` needs, so that the first block isn't late."""
    channels = int(engine.memory.view(np.int64)[layout.L_CHANNELS])
    run_block(engine, np.zeros((0, channels), np.float32))
    clear_meters(engine.memory, channels)


def run_block(engine: Engine, out: NDArray[np.float32], underflow: bool = False) -> bool:
    """Render a block of float32 (frames, channels) for the device; return whether it is the last.

    Thread: audio.
    """
    started = time.perf_counter()
    memory, router, over = engine.memory, engine.router, False
    step = len(out) if router is None else FRAMES
    for start in range(0, max(len(out), 1), max(step, 1)):
        piece = out[start : start + step]
        engine.process(piece, None if router is None else router.trace[: len(piece)])
        over = finish_block(memory, memory.view(np.int64), piece.reshape(-1), *piece.shape)
        if router is not None:
            router.process(memory, piece, router.trace[: len(piece)])
    record_callback(memory, len(out), time.perf_counter() - started, underflow)
    return bool(over)


MAX_BLOCK = 1 << 20
"""Maximum block size in frames, far above that of any output."""


class NullStream(Stream):
    """Stream that runs an engine in real time and discards the sound, without a device.

    As a context manager it starts and closes. Thread: main; the engine's `process` runs in a thread
    of its own.

    Parameters
    ----------
    engine : Engine
        Prepared engine.
    block_size : int
        Block size in frames.
    settings : OutputSettings or None
        Settings as in `OutputStream`.

    Raises
    ------
    NotPreparedError
        The engine isn't prepared.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> with ov.live.NullStream(engine) as stream:
    ...     engine.control(theta2=1.2, touching=True)
    >>> stream.active
    False
    """

    callback = "python"
    name = "none (no sound)"

    def __init__(
        self, engine: Engine, block_size: int = 256, settings: OutputSettings | None = None
    ) -> None:
        self._engine = engine
        self.block_size = validation.whole(block_size, "block_size", 1, MAX_BLOCK)
        channels = connect(engine, settings)
        self._out = np.zeros((self.block_size, channels), dtype=np.float32)
        self._thread: threading.Thread | None = None
        compile_python_path(engine)

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="null output", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        due = time.perf_counter()
        over = False
        while not over:
            began = time.perf_counter()
            over = run_block(self._engine, self._out)
            due = max(due + self._latency_s, began - 1.0)
            time.sleep(max(0.0, due - time.perf_counter()))

    def _close(self) -> None:
        self._engine.memory.view(np.int64)[layout.L_STOP] = 1
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    _stop = _close

    @property
    def active(self) -> bool:
        """State of the stream: True while it runs the engine."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def _latency_s(self) -> float:
        """Duration of a block, s."""
        return self.block_size / self._engine.sample_rate

    def __repr__(self) -> str:
        return f"<NullStream: {'playing' if self.active else 'not playing'}>"
