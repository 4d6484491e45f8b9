"""Export for a board that plays alone: a C library, its data, and a sketch for each board.

`board/` has the library, `overview_board.h`, which is the engine in single precision, and the
sketches. `timeline.h` is written here: coefficients, friction, events and modes of the kernels'
memory, and the frames of a motor knob, as constants.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.devices.force_feedback.board_loop import DISK, PART, USE, board_table, pack_disk
from overview_dsp.devices.sensors.firmware import LIBRARY
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from overview_dsp.offline.export.c_code import write_files
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.surface_slots import timeline_events

RATE = 44_100.0  # Hz: the only one of Teensy's audio library
BOARDS = ("teensy4", "esp32s3")  # a sketch and its folder each
KNOB, KNOB_POINTS = "simplefoc", 8193  # profile of a motor knob, and points of its table
_EDGE = 1 << 14  # an edge's position of one cell
_RING = 100.0 / 160.0  # part of a click's length until -100 dB, the last bit of 16


_WRAPPER = """// The sketch, as PlatformIO compiles it.
#include <Arduino.h>
#include "{0}/{0}.ino"
"""


def export_board(
    timeline: Timeline, preset: Preset, folder: str | os.PathLike[str], *, seed: int = 0
) -> list[Path]:
    """Write sketches with which a Teensy 4 or an ESP32-S3 plays a timeline without a computer.

    Events are struck at the positions of `render`, and levels are within 1 dB of it, at 44,100 Hz.

    Parameters
    ----------
    timeline : Timeline
        Data of the voice.
    preset : Preset
        Parameters of feel and sound; all friction must be viscous.
    folder : str or path
        Folder, created if missing; existing files are overwritten.
    seed : int
        Seed of the texture noise.

    Returns
    -------
    list of Path
        Written files.

    Raises
    ------
    InputError
        The folder can't be written, or the preset has bristles, detents or end stops.

    Examples
    --------
    >>> [path.name for path in ov.export.export_board(match, football, "alone")][:3]
    ['README.txt', 'platformio.ini', 'teensy4.cpp']
    """
    to = validation.path(folder, "folder")
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(RATE)
    surface = engine.surface
    if surface.bristles is not None or surface.detents is not None:
        friction = "bristles" if surface.bristles is not None else "detents or end stops"
        raise InputError(
            f"preset {preset.name!r} has {friction}, which a board alone doesn't compute; choose a "
            "preset with viscous friction only, such as football, or use --to c"
        )
    source = resources.files("overview_dsp.offline.export") / "board"
    shared = {name: (source / name).read_bytes() for name in ("overview_board.h", "hand.h")}
    shared["timeline.h"] = "\n".join(_data(engine, timeline)).encode()
    for name in ("surface.h", "timing.h"):
        shared[name] = (LIBRARY.bundled_folder / "knob" / name).read_bytes()
    contents = {name: (source / name).read_bytes() for name in ("README.txt", "platformio.ini")}
    for board in BOARDS:
        contents[f"{board}.cpp"] = _WRAPPER.format(board).encode()
        contents[f"{board}/{board}.ino"] = (source / f"{board}.ino").read_bytes()
        contents |= {f"{board}/{name}": content for name, content in shared.items()}
    return write_files(to, contents)


def _data(engine: Engine, timeline: Timeline) -> Iterator[str]:
    """Yield the parts of `timeline.h` for a prepared engine."""
    m, w, surface = engine.memory, engine.memory.view(np.int64), engine.surface
    base = layout.SURFACES + int(w[layout.ACTIVE_SLOT]) * layout.SLOT_SIZE
    count = int(w[base + layout.SLOT_EVENTS])
    yield f"// {json.dumps(timeline.title)} with the preset {json.dumps(engine.preset.name)}"
    for number, event in enumerate(timeline.events):
        label = json.dumps(f"{event.kind} {event.label}".strip())
        yield f"// event {number} at {surface.angle_map.events[number]:.4f}: {label}"
    yield f'#include "overview_board.h"\n\n#define OVERVIEW_SAMPLE_RATE {RATE:.0f}\n'
    yield _table("float", "COEFFICIENTS", m[layout.COEFF : layout.C_RECOIL_EXPONENT + 1])
    yield _table("float", "FRICTION", m[base + layout.SLOT_TABLE :][: 2 * (layout.CELLS + 1) : 2])
    steep = w[base + layout.SLOT_STEEP :][: layout.CELLS // layout.STEEP_BLOCK + 1] == 1
    yield _table("uint8_t", "STEEP", np.packbits(steep, bitorder="little"))
    for name, at in (("LOWER", layout.SLOT_LOWER), ("UPPER", layout.SLOT_UPPER)):
        positions = np.rint(m[base + at :][:count] * _EDGE).astype(np.int64)
        # the columns of events follow those of positions
        struck = w[base + at + layout.MAX_EVENTS :][:count]
        yield _table("OverviewEdge", name, positions, struck)
    kinds, kind = np.unique(w[base + layout.SLOT_KIND :][:count], return_inverse=True)
    release = m[base + layout.SLOT_RELEASE :][:count]
    yield _table("OverviewEvent", "EVENTS", release, timeline_events(surface)[:-1], kind)
    banks = m[base + layout.MODES :][: layout.BANKS * layout.MAX_MODES * layout.MODE_SIZE]
    modes = banks.reshape(layout.BANKS, -1, layout.MODE_SIZE)[kinds].reshape(-1, layout.MODE_SIZE)
    turned = (layout.MODE_RE + 1, layout.MODE_IM + 1)
    columns = (*turned, layout.MODE_TURNS, layout.MODE_DECAY, layout.MODE_GAIN)
    yield _table("OverviewMode", "MODE_TABLE", *modes[:, columns].T)
    ring = np.ceil(w[base + layout.KIND_RING + kinds] * _RING).astype(np.int64)
    yield _table("OverviewKind", "KINDS", w[base + layout.KIND_MODES + kinds], ring)
    names = ["COEFFICIENTS", "FRICTION", "STEEP", "LOWER", "UPPER", "EVENTS", "MODE_TABLE", "KINDS"]
    numbers = [count, round(m[layout.C_CARRIER] * 2**32), w[layout.S_ARRIVAL]]
    fields = [f"OVERVIEW_{name}" for name in names] + [str(number) for number in numbers]
    fields += [f"UINT64_C({m.view(np.uint64)[layout.S_SEED]})", str(w[layout.S_RELEASE_RETURNS])]
    yield f"static const OverviewTimeline OVERVIEW_TIMELINE = {{{', '.join(fields)}}};\n"
    frames = b"".join(bytes([len(one)]) + one for one in _knob_frames(engine))
    yield _table("uint8_t", "KNOB", list(frames))


def _knob_frames(engine: Engine) -> Iterator[bytes]:
    """Yield the frames that a host would send to the core of a motor knob (`surface.h`)."""
    values = engine.preset.values
    yield bytes((DISK, 1, 1)) + pack_disk(values, load_sensor(KNOB))
    table = board_table(engine.surface, KNOB_POINTS, float(values["surface.friction"]))
    for number, part in enumerate(table.parts):
        yield struct.pack("<BBH", PART, 1, number) + part.astype("<u2").tobytes()
    yield struct.pack("<BBHf", USE, 1, 0, table.unit)


def _text(number: Any) -> str:
    """Return the C constant of a number; a limit that is switched off becomes 3e38."""
    return f"{min(number, 3e38):.8e}f" if isinstance(number, float) else str(int(number))


def _table(kind: str, name: str, *columns: Any) -> str:
    """Return the C definition of a constant table, ten entries a line."""
    rows = [", ".join(map(_text, row)) for row in zip(*columns, strict=True)] or ["0"]
    # C has no empty arrays, and braces around the fields of a structure
    entries = rows if len(columns) == 1 else [f"{{{row}}}" for row in rows]
    body = ",\n".join(", ".join(entries[n : n + 10]) for n in range(0, len(entries), 10))
    return f"static const {kind} OVERVIEW_{name}[] OVERVIEW_FLASH = {{\n{body}}};\n"
