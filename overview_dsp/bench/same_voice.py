"""The whole voice in C, `tools/peers/same_voice.c`, on an engine's coefficients and surface."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine.engine import Engine
from overview_dsp.gestures import Gesture
from overview_dsp.kernels import layout

CONTROL = np.dtype([("sample", np.int64), ("touching", np.int64), ("theta2", np.float64)])

_COLUMNS = (
    layout.SLOT_TABLE,
    layout.SLOT_INTEGRAL,
    layout.SLOT_STEEP,
    None,  # the number of events
    layout.SLOT_LOWER,
    layout.SLOT_LOWER_EVENT,
    layout.SLOT_UPPER,
    layout.SLOT_UPPER_EVENT,
    layout.SLOT_RELEASE,
    layout.SLOT_KIND,
    layout.KIND_MODES,
    layout.KIND_RING,
    layout.MODES,
)


def controls(gesture: Gesture, sample_rate: float) -> NDArray[np.void]:
    """A gesture as the events of a C version."""
    events = np.empty(len(gesture.theta2), dtype=CONTROL)
    events["sample"] = gesture.stamps(sample_rate)
    events["touching"] = gesture.touching
    events["theta2"] = gesture.theta2
    return events


class SameVoice:
    """A voice in C on a prepared engine's first surface; keeps the engine's memory alive."""

    def __init__(self, library: Path, engine: Engine) -> None:
        """`library` is same_voice.c, built."""
        self._c = ctypes.CDLL(str(library))
        self._c.voice_size.restype = ctypes.c_int64
        self._memory = engine.memory
        self._voice = ctypes.create_string_buffer(self._c.voice_size())
        start = self._memory.ctypes.data
        slot = start + 8 * layout.SURFACES
        events = int(self._memory.view(np.int64)[layout.SURFACES + layout.SLOT_EVENTS])
        self._surface = (ctypes.c_uint64 * len(_COLUMNS))(
            *(events if column is None else slot + 8 * column for column in _COLUMNS)
        )
        self._coefficients = ctypes.c_void_p(start + 8 * layout.COEFF)
        self._seed = ctypes.c_uint64(int(self._memory.view(np.uint64)[layout.S_SEED]))
        self.reset()

    def reset(self) -> None:
        """As new."""
        self._c.voice_reset(self._voice, self._seed)

    def render(self, events: NDArray[np.void], out: NDArray[np.float32]) -> None:
        """The next frames into `out`, float32 (frames, 2), C-ordered."""
        self._c.voice_render(
            self._voice,
            self._coefficients,
            self._surface,
            events.ctypes.data_as(ctypes.c_void_p),
            ctypes.c_int64(len(events)),
            out.ctypes.data_as(ctypes.c_void_p),
            ctypes.c_int64(len(out)),
        )
