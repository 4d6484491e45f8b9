"""Streams that run an engine: what they share, their meters, and a block that is run in Python."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.output_stage import finish_block
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.public import counted
from overview_dsp.signal.engine.engine import Engine


@dataclass(frozen=True)
class StreamMeters:
    """What the device side reports since the stream began.

    Attributes
    ----------
    callbacks, frames : int
        How often the device called, and what it was given.
    underflows, late : int
        Callbacks that reported one, and that took longer than their own frames last.
    load : float
        Part of the time that callbacks take, 0 to 1 (to a fifth): beyond 1 the output stutters.
    median_s, p99_s, longest_s : float
        Callback times, s; the first two to a fifth.
    latency_s : float
        As PortAudio gives it, s.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> stream = ov.live.SilentStream(engine)
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


def clear_meters(memory: NDArray[np.float64], channels: int) -> None:
    """As for a new stream: counters, delay lines, the fade; gains, actuator, channels are kept."""
    w = memory.view(np.int64)
    kept = memory[layout.L_GAIN : layout.L_LEFT].copy()
    delays = w[layout.L_DELAY : layout.L_DELAY + layout.SIGNALS].copy()
    also = w[layout.L_ALSO_CLICK : layout.L_ALSO_CLICK + layout.SIGNALS].copy()
    w[layout.LIVE : layout.L_ACTUATOR] = 0
    w[layout.L_ALSO_CLICK : layout.L_ALSO_CLICK + layout.SIGNALS] = also
    memory[layout.L_GAIN : layout.L_LEFT] = kept
    w[layout.L_DELAY : layout.L_DELAY + layout.SIGNALS] = delays
    w[layout.L_DELAY_WANTED : layout.L_DELAY_WANTED + layout.SIGNALS] = delays
    w[layout.L_CHANNELS] = channels


def play_again(memory: NDArray[np.float64]) -> None:
    """After a fade: as before it, with nothing left in the delay lines."""
    w = memory.view(np.int64)
    w[layout.L_STOP] = w[layout.L_FADED] = 0
    w[layout.L_LINES : layout.L_LINES + layout.SIGNALS * layout.DELAY_LINE] = 0


def record_callback(
    memory: NDArray[np.float64], frames: int, seconds: float, underflow: bool = False
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


def read_meters(memory: NDArray[np.float64], latency_s: float) -> StreamMeters:
    """The counters so far."""
    w = memory.view(np.int64)
    median, p99 = _quantile(w, 0.5), _quantile(w, 0.99)
    longest = float(memory[layout.L_LONGEST])
    return StreamMeters(
        callbacks=int(w[layout.L_CALLBACKS]),
        frames=int(w[layout.L_FRAMES]),
        underflows=int(w[layout.L_UNDERFLOWS]),
        late=int(w[layout.L_LATE]),
        load=_load(w, float(memory[layout.S_SAMPLE_RATE])),
        median_s=min(median, longest),  # a bin's upper end may lie beyond
        p99_s=min(p99, longest),
        longest_s=longest,
        latency_s=latency_s,
    )


def take_peaks(memory: NDArray[np.float64]) -> tuple[float, float]:
    """The highest click and tactor sample (linear, as the device got them) since the last call."""
    peaks = memory[layout.L_PEAK : layout.L_PEAK + layout.SIGNALS]
    click, tactor = peaks.tolist()
    peaks[:] = 0.0
    return click, tactor


def _load(w: NDArray[np.int64], sample_rate: float) -> float:
    """The callback times, each at the middle of its bin, over how long their frames last."""
    bins = np.arange(layout.BUSY_BINS) + 0.5
    seconds = layout.SHORTEST_S * 2.0 ** (bins / layout.BINS_PER_OCTAVE)
    busy = float(w[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS] @ seconds)
    return busy * sample_rate / max(1, int(w[layout.L_FRAMES]))


def _quantile(w: NDArray[np.int64], part: float) -> float:
    counts = np.cumsum(w[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS])
    if not counts[-1]:
        return 0.0
    where = int(np.searchsorted(counts, part * counts[-1]))
    return float(layout.SHORTEST_S * 2.0 ** ((where + 1) / layout.BINS_PER_OCTAVE))


class Stream(ABC):
    """Runs an engine in time: an `OutputStream`, or a `SilentStream` where there is no device.

    Thread: main; while it plays, its audio thread owns the engine's `process`.
    """

    name: str
    block_size: int
    _engine: Engine

    @abstractmethod
    def _start(self) -> None:
        """Begin to call `process`; OverviewError if the device can't."""

    @abstractmethod
    def _stop(self) -> None:
        """Fade out and stop calling `process`; OverviewError if the device doesn't answer."""

    @abstractmethod
    def _close(self) -> None:
        """Fade out and end; may be called twice."""

    def start(self) -> None:
        """Begin to play.

        Raises
        ------
        OverviewError
            The device can't.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.SilentStream(engine)
        >>> stream.start()
        >>> stream.active
        True
        >>> stream.close()
        """
        self._start()

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
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> with ov.live.SilentStream(engine) as stream:
        ...     stream.restart(engine.reset)
        """
        self._stop()
        begin()
        play_again(self._engine.memory)
        self._start()

    def set(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings while it plays; channels and actuator stay.

        Parameters
        ----------
        settings : OutputSettings
            It glides to these.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> with ov.live.SilentStream(engine) as stream:
        ...     stream.set(ov.live.OutputSettings().changed(click={"mute": True}))
        """
        settings.write(self._engine.memory, self._engine.sample_rate)

    def close(self) -> None:
        """Fade out, end playing and close the device; may be called twice.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.SilentStream(engine)
        >>> stream.start()
        >>> stream.close()
        >>> stream.active
        False
        """
        self._close()

    @property
    @abstractmethod
    def active(self) -> bool:
        """Whether the engine is run."""

    @property
    @abstractmethod
    def _latency_s(self) -> float:
        """From a sample to the output, as the device reports it, s."""

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
    """Ready an engine's memory for a new stream; how many channels that needs.

    Without settings the engine's channel map stays, and the signals go out as they are.
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
    (settings or OutputSettings()).write(memory, engine.sample_rate, at_once=True)
    return channels


def compile_python_path(engine: Engine) -> None:
    """Compile what `run_block` needs, so that the first block isn't late for it."""
    run_block(engine, np.zeros((0, engine.memory.view(np.int64)[layout.L_CHANNELS]), np.float32))
    clear_meters(engine.memory, int(engine.memory.view(np.int64)[layout.L_CHANNELS]))


def run_block(engine: Engine, out: NDArray[np.float32], underflow: bool = False) -> bool:
    """A block of float32 (frames, channels), through the device's stage; whether it was the last.

    Thread: audio.
    """
    started = time.perf_counter()
    engine.process(out)
    memory = engine.memory
    over = finish_block(memory, memory.view(np.int64), out.reshape(-1), *out.shape)
    record_callback(memory, len(out), time.perf_counter() - started, underflow)
    return bool(over)
