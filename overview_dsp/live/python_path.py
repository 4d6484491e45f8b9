"""What a stream does in Python: connect an engine, and run its blocks where C doesn't."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.output_stage import finish_block
from overview_dsp.live.output_settings import OutputSettings
from overview_dsp.live.stream_meters import clear_meters, record_callback
from overview_dsp.signal.engine.engine import Engine


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
