"""The engine's own rows: one call, blocks through Python and through the native callback."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels import layout
from overview_dsp.kernels.layout import TRACE_COLUMNS
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.measure.bench.timing import DISK, VOICE, Contender, timed
from overview_dsp.measure.bench.work import RATE, SECONDS, SWEEP_S, Disk, fed, prepared, the_sweep
from overview_dsp.signal.engine.engine import Engine

BLOCK = 64
INTERPRETED_S = 0.1
LINKS = 2_000_000
"""Of the chain that cycles are counted by: some milliseconds."""
CHAINS = 9


def one_call(
    engine: Engine, out: NDArray[np.float32], trace: NDArray[np.float64] | None = None
) -> float:
    """The whole work in one block."""
    fed(engine, the_sweep())
    return timed(SECONDS, lambda: engine.process(out, trace))


def python_calls(engine: Engine, out: NDArray[np.float32]) -> float:
    """Blocks of 64 frames, called from Python."""
    fed(engine, the_sweep())

    def work() -> None:
        for start in range(0, len(out), BLOCK):
            engine.process(out[start : start + BLOCK])

    return timed(SECONDS, work)


def native_calls(engine: Engine) -> float:
    """Blocks of 64 frames by the callback that PortAudio calls: device stage and clock included.

    The loop over blocks is compiled too, as PortAudio's is.
    """
    from overview_dsp.kernels.device.callback import repeated_callback

    run = repeated_callback()
    fed(engine, the_sweep())
    memory = engine.memory
    memory.view(np.int64)[layout.L_CHANNELS] = 2
    OutputSettings().write(memory, RATE, at_once=True)
    out = np.zeros(2 * BLOCK, dtype=np.float32)
    blocks = round(SECONDS * RATE) // BLOCK
    return timed(SECONDS, lambda: run(memory, out, BLOCK, blocks))


def disk_alone(engine: Engine, disk: Disk) -> NDArray[np.float64]:
    """The torque (N m) of the disk alone, float64 [frames]."""
    torque = np.empty(len(disk.hand))
    _run_disk(engine, disk.hand * (layout.CELLS / math.pi), torque)
    return torque


def _run_disk(engine: Engine, cells: NDArray[np.float64], torque: NDArray[np.float64]) -> None:
    from overview_dsp.kernels.disk_alone import disk_alone as run

    run(engine.memory, layout.SURFACES + layout.SLOT_TABLE, cells, torque)


def interpreted() -> float:
    """The same source as plain Python, in a process of its own."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "overview_dsp.measure.bench.overview_rows"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def clock_ghz() -> float:
    """Billions of cycles that this processor has in a second, as it is busy now."""
    from overview_dsp.kernels.cycles import CYCLES_A_LINK, chain

    word = np.uint64(1)
    chain(word, 1)
    work = 1e-9 * CYCLES_A_LINK * LINKS
    return max(timed(work, lambda: chain(word, LINKS)) for _ in range(CHAINS))


def contenders() -> list[Contender]:
    """The first of each group is what the others are compared with."""
    engine = prepared()
    disk = Disk.of(engine)
    cells = disk.hand * (layout.CELLS / math.pi)
    torque = np.empty(len(cells))
    out = np.zeros((round(SECONDS * RATE), 2), dtype=np.float32)
    trace = np.zeros((len(out), len(TRACE_COLUMNS)))
    return [
        Contender(VOICE, "overView, one call", lambda: one_call(engine, out)),
        Contender(VOICE, "overView, one call with trace", lambda: one_call(engine, out, trace)),
        Contender(VOICE, f"overView, {BLOCK}-frame native calls", lambda: native_calls(engine)),
        Contender(
            VOICE, f"overView, {BLOCK}-frame Python calls", lambda: python_calls(engine, out)
        ),
        Contender(VOICE, "the same source as plain Python", interpreted),
        Contender(
            DISK,
            "overView, one call",
            lambda: timed(SWEEP_S, lambda: _run_disk(engine, cells, torque)),
        ),
    ]


if __name__ == "__main__":
    import warnings

    warnings.simplefilter("ignore", RuntimeWarning)  # wrapping integers, as in machine code
    plain = fed(prepared(), the_sweep())
    sound = np.zeros((round(INTERPRETED_S * RATE), 2), dtype=np.float32)
    print(timed(INTERPRETED_S, lambda: plain.process(sound)))
