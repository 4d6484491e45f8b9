"""Self-test of the voice in C: a small image, movements over it, and the digest of all state.

Movements, changes of parameters and a reset go through every function of the voice.

`build_c.py` puts the image and the digest that numba's machine code gives into kernel.c, where
`overview_load` compares. Compilers that change a bit of the arithmetic thus show themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

RATE, BLOCK, BLOCKS = 2000.0, 64, 10
SEED, FACTOR = 14695981039346656037, 1099511628211  # of the hash FNV-1a, of words
MODELS = (0, 3)  # viscous friction; with bristles and detents
HANDS = ((0, 0.6, 1), (100, 2.6, 1), (400, 1.2, 1), (500, 1.2, 0))  # sample, theta2, touching
CHANGES = (  # sample, parameter, value
    (60, "tactor.frequency_hz", 180.0),
    (130, "texture.brightness_hz", 700.0),
    (200, "disk.inertia", 3e-5),
    (260, "disk.k2", 0.007),
    (330, "click.gain_db", -2.5),
    (390, "tactor.decay_ms", 17.0),
)
BLOCKS_AFTER_RESET = 3
# a preset of its own: a bundled one may change without a change of the kernels
PRESET = """
schema = 4
title = "Self-test"
description = "every part of the kernels takes part"
disk = { inertia = 1.55e-5, k1 = 0.00036, k2 = 0.0119 }
tactor = { reference_torque_mnm = 75.5, compression = 0.71, rise_ms = 1.4, decay_ms = 7.5 }
click = { gain_db = 6, reference_torque_mnm = 40 }
texture = { gain_db = -20, brightness_hz = 12000 }
output = { ceiling_db = -20 }

[clutch]
max_speed_ratio = 2
tap_duration_s = 3
time_constant_s = 0.045
windup_ratio = 2
max_speed = 1.07
backlash_percent = 0.32

[surface]
friction = 0.00014
angle_map = 0.7
model = "bristle"
static_ratio = 2

[kinds.default]
height = 450
width_percent = 0.01
shape = "plateau"
modes = [
  { frequency_hz = 310, decay_ms = 28, gain_db = -4.5 },
  { frequency_hz = 640, decay_ms = 19, gain_db = -7.5 },
]
"""


def image() -> bytes:
    """Return an image whose tables have equal cells, so that it has a few kilobytes.

    Value and slope of a cell are equal: friction is a saw tooth with a steep edge in each cell.
    """
    import overview_dsp as ov
    from overview_dsp.design.presets.library import parse_user_preset
    from overview_dsp.kernels import layout
    from overview_dsp.offline.export.browser_memory import encode_engine

    events = tuple(ov.Event(float(second), "default") for second in range(1, 12))
    timeline = ov.Timeline("self-test", 12.0, events)
    preset = parse_user_preset(PRESET, Path("self-test.toml"))
    engine = ov.Engine(preset, timeline, seed=1)
    engine.prepare(RATE)
    memory, ints = engine.memory, engine.memory.view(np.int64)
    memory[layout.SURFACES + layout.SLOT_SIZE :] = 0.0
    slot = memory[layout.SURFACES :][: layout.SLOT_SIZE]
    cells = layout.CELLS + 1
    for start, columns, value in (
        (layout.SLOT_TABLE, 2 * cells, 0.0004),
        (layout.SLOT_INTEGRAL, cells, 0.0),
        (layout.SLOT_SLIDING_TORQUE, 2 * cells, 0.0007),
        (layout.SLOT_PULL, 2 * cells, 0.0003),
        (layout.SLOT_DETENT_ENERGY, cells, 0.0),
        (layout.MODES, layout.BANKS * layout.MAX_MODES * layout.MODE_SIZE, 0.0),  # derived anew
        (layout.SLOT_END_STIFFNESS, 1, 1.0),
    ):
        slot[start : start + columns] = value
    # steps over edges in one half, within a cell in the other
    ints[layout.SURFACES + layout.SLOT_STEEP :][: layout.CELLS // layout.STEEP_BLOCK // 2] = 1
    ints[layout.SURFACES + layout.SLOT_OWNER :][:cells] = 1
    return encode_engine(engine)


def parts() -> tuple[tuple[int, int], ...]:
    """Return the columns that are compared: coefficients and state, and numbers of a chunk."""
    from overview_dsp.kernels import layout

    return (0, layout.TOTAL_STATE), (layout.SCRATCH, layout.LIVE)


def changes() -> tuple[tuple[int, int, float], ...]:
    """Return the changes with the numbers of their parameters."""
    from overview_dsp.signal.engine.coefficients import KERNEL_RANGES

    ids = list(KERNEL_RANGES)
    return tuple((sample, ids.index(id), value) for sample, id, value in CHANGES)


def digest(entries: Mapping[str, Callable[..., int]], picture: bytes) -> int:
    """Return the digest of the voice's state, with functions that take plain pointers."""
    from overview_dsp.kernels import layout

    memory = np.zeros(layout.TOTAL)
    ints = memory.view(np.int64)
    block = np.zeros(2 * BLOCK, np.float32)
    data = np.frombuffer(picture, np.int64)
    at, out = memory.ctypes.data, block.ctypes.data
    assert entries["overview_load"](at, data.ctypes.data, len(picture), int(data[0])) == 0
    found, strikes, limited = SEED, 0, 0
    for models in MODELS:
        ints[layout.SURFACES + layout.SLOT_MODELS] = models
        assert entries["overview_prepare"](at, RATE) == 0
        for sample, theta2, touching in HANDS:
            assert entries["overview_control"](at, 0, sample, theta2, touching) == 0
        for sample, parameter, value in changes():
            assert entries["overview_change"](at, parameter, value, sample) == 0
        heard = np.zeros(2)
        for number in range(BLOCKS + BLOCKS_AFTER_RESET):
            if number == BLOCKS:
                strikes, limited = ints[layout.M_STRIKES], ints[layout.M_LIMITED]
                assert entries["overview_reset"](at) == 0
                _, theta2, touching = HANDS[0]
                assert entries["overview_control"](at, 0, 0, theta2, touching) == 0
            assert entries["overview_process"](at, out, BLOCK, 2) == 0
            heard = np.maximum(heard, np.abs(block.reshape(-1, 2)).max(axis=0))
            for first, stop in parts():
                for word in memory[first:stop].view(np.uint64).tolist():
                    found = (found ^ word) * FACTOR % 2**64
        # all of it takes part
        assert heard.min() > 0.004
        assert strikes > 0
        assert ints[layout.M_RESETS] == 0
    assert limited > 0
    return found
