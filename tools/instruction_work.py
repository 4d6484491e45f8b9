"""Fixed work for tools/count_instructions.py, which runs it under callgrind.

python tools/instruction_work.py [MARKS.so]

Without MARKS it only fills the cache of compiled kernels.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.callback import native_callback
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.signal.engine.simd_batch import EngineBatch

RATE = 48_000
FRAMES = RATE
GESTURE = ov.sweep(0.4) + ov.tap(0.7, 0.1)
CHANGES = {
    "viscous": {},
    "bristles": {"surface.model": "bristle", "surface.torque_ratio": 1.0},
    "detents": {"surface.model": "detent", "surface.pattern": "waves", "surface.torque_ratio": 1.0},
}

Marks = Callable[[str, Callable[[], None]], None]


def fed(
    preset: str = "viscous",
    gesture: ov.Gesture = GESTURE,
    memory: NDArray[np.float64] | None = None,
) -> ov.Engine:
    """Return an engine with pending events for a second."""
    made = ov.load_preset("football").with_changes(CHANGES[preset])
    engine = ov.Engine(made, ov.load_timeline("world-cup-final-2018"), seed=1)
    engine.prepare(RATE, FRAMES, memory=memory)
    for stamp, theta2, touching in zip(
        gesture.stamps(RATE), gesture.theta2, gesture.touching, strict=True
    ):
        engine.control(float(theta2), bool(touching), int(stamp))
    return engine


def one_call(count: Marks) -> None:
    out = np.zeros((FRAMES, 2), dtype=np.float32)
    trace = np.zeros((FRAMES, layout.TRACE))
    for name in CHANGES:
        engine = fed(name)
        count(f"{name}, one call", lambda engine=engine: engine.process(out))
    engine = fed()
    count("viscous, with trace", lambda: engine.process(out, trace))
    again = fed()
    again.set("surface.intensity_gain", 2.0, sample_time=1_000)
    again.set("tactor.gain_db", -6.0, sample_time=1_000)
    count("viscous, a glide and a crossfade", lambda: again.process(out))


def native_calls(count: Marks) -> None:
    engine = fed()
    memory = engine.memory
    memory.view(np.int64)[layout.L_CHANNELS] = 2
    OutputSettings().write(memory, RATE, at_once=True)
    out = np.zeros((64, 2), dtype=np.float32)
    call = native_callback().ctypes
    arguments = (None, out.ctypes.data, 64, None, 0, memory.ctypes.data)

    def run() -> None:
        for _ in range(FRAMES // 64):
            call(*arguments)

    count("viscous, 64-frame native calls", run)


def side_by_side(count: Marks) -> None:
    """Run one second in lanes, with one voice per lane."""
    frames = FRAMES // SIMD_WIDTH
    lanes = EngineBatch(frames)
    engines = [
        fed(
            "viscous",
            ov.sweep(1.0 / SIMD_WIDTH, lane / SIMD_WIDTH, (lane + 1) / SIMD_WIDTH),
            lanes.memory(lane),
        )
        for lane in range(SIMD_WIDTH)
    ]
    lanes.process(engines, 0, False)
    count(f"{SIMD_WIDTH} voices side by side", lambda: lanes.process(engines, frames, False))


def main(marks: str | None) -> None:
    library = ctypes.CDLL(marks) if marks else None

    def count(name: str, run: Callable[[], None]) -> None:
        if library:
            library.marks_begin()
        run()
        if library:
            library.marks_end(name.encode())

    fed().process(np.zeros((64, 2), dtype=np.float32))  # what the first call does once
    one_call(count)
    native_calls(count)
    side_by_side(count)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
