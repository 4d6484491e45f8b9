"""What a served page is given beyond the files of a folder: any window, felt by any preset.

``POST /data/window`` with ``{"window": [start_s, end_s], "preset": P}`` answers as
``data/window-N.json`` is (`site_data`), with `points` where one file can't have them all;
``POST /sound/change`` with ``{"sample_rate": 48000, "before": P, "after": P, "window": [start_s,
end_s]}`` the bytes of `encoding`. P is a name, a
preset as `/data/preset` has it, or left out for the one that is served. A change without a window
keeps the surface: that will do where no parameter of the surface or of a kind differs.

What a page sounds with: a window's bytes for one sample rate, and what differs at others.

``sound/N.packed`` are `browser_memory`'s bytes, packed as below, for the first rate, of the
whole's memory (N = 0) or of a change to window N (N = ``back``: to the whole again).
``sound/N-RATE.patch`` makes those of another rate of them, little-endian::

    uint32 1 (replace all) or 0, uint32 number of runs; then, if 1, the bytes themselves, else runs:
    uint32 column (of 8 bytes), uint32 columns, the columns

Only coefficients and clicks depend on the rate, not the half megabyte of friction.

Packed are, by zlib's deflate, to every bit (`unpack.js`)::

    uint8 order; the first byte of every column of 8, the second of every column, ...

of columns that were, as int64 that wrap around, replaced `order` times by their differences to the
column before, and then by (n << 1) ^ (n >> 63), so that small negative ones are small too. A
friction table's neighbours are numbers of almost the same bits, on almost a straight line.
"""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.offline.export.browser_memory import encode_change, encode_engine
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface
from overview_dsp.web.preset_data import preset_given
from overview_dsp.web.site_data import window_json
from overview_dsp.web.values import all_points, has_values, points_json

MIN_RATE, MAX_RATE = 8_000.0, 192_000.0
"""What browsers play at, Hz."""

CHANGE_KEYS = {"sample_rate", "before", "after", "window"}
WINDOW_KEYS = {"window", "preset"}


def window(timeline: Timeline, served: Preset, asked: dict[str, Any]) -> dict[str, Any]:
    """What is drawn of a window; InputError for what can't be."""
    _require_keys(asked, WINDOW_KEYS, {"window"})
    start, end = _window(timeline, asked["window"])
    part = _part(timeline, start, end)
    surface = build_surface(part, _preset(asked, "preset", served))
    drawn = window_json(part, surface, start)
    if has_values(timeline) and not all_points(timeline):
        drawn["points"] = points_json(timeline, start, end)
    return drawn


def change(timeline: Timeline, served: Preset, asked: dict[str, Any]) -> bytes:
    """From one preset to another, and to a window's surface; InputError for what can't be."""
    _require_keys(asked, CHANGE_KEYS, {"sample_rate"})
    before, after = _preset(asked, "before", served), _preset(asked, "after", served)
    surface = None
    if "window" in asked:
        part = _part(timeline, *_window(timeline, asked["window"]))
        surface = build_surface(part, after)
    return encode_change(before, after, _rate(asked["sample_rate"]), surface)


def _preset(asked: dict[str, Any], key: str, served: Preset) -> Preset:
    return preset_given(asked[key]) if key in asked else served


def _window(timeline: Timeline, given: Any) -> tuple[float, float]:
    if not isinstance(given, list) or len(given) != 2:
        raise InputError("window is [start_s, end_s]")
    return timeline.require_window(*given)


def _part(timeline: Timeline, start: float, end: float) -> Timeline:
    """What a window is felt as; the whole as it is, without what only a closer look finds."""
    whole = start <= 0.0 and end >= timeline.duration_s
    return timeline if whole else timeline.window(start, end)


def _rate(given: Any) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise InputError("sample_rate is a number of Hz")
    if not MIN_RATE <= given <= MAX_RATE:
        raise InputError(f"sample_rate is out of range; it is {MIN_RATE:g} to {MAX_RATE:g} Hz")
    return float(given)


def _require_keys(asked: dict[str, Any], known: set[str], needed: set[str]) -> None:
    if not needed <= asked.keys() <= known:
        raise InputError(
            f"the body has the keys {', '.join(sorted(known))}; needed: {', '.join(sorted(needed))}"
        )


BLOCK = 128
"""Frames of a browser's block."""


def whole_bytes(
    timeline: Timeline, preset: Preset, rate: int, seed: int, actuator: Actuator | None
) -> bytes:
    """The memory of an engine that is ready at a sample rate (Hz)."""
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(rate, BLOCK)
    return encode_engine(engine, OutputSettings(actuator=actuator))


def window_bytes(surface: Surface, preset: Preset, rate: int) -> bytes:
    """A change to a window's surface at a sample rate (Hz)."""
    return encode_change(preset, preset, rate, surface)


def patch_of(base: bytes, wanted: bytes) -> bytes:
    """What makes `wanted` of `base`."""
    if len(base) != len(wanted):
        return np.array([1, 0], "<u4").tobytes() + wanted
    different = np.flatnonzero(np.frombuffer(base, "<u8") != np.frombuffer(wanted, "<u8"))
    runs = np.split(different, np.flatnonzero(np.diff(different) > 1) + 1) if len(different) else []
    parts = [np.array([0, len(runs)], "<u4").tobytes()]
    for run in runs:
        first, count = int(run[0]), len(run)
        parts.append(np.array([first, count], "<u4").tobytes())
        parts.append(wanted[8 * first : 8 * (first + count)])
    return b"".join(parts)


ORDERS = range(8)
QUICK, BEST = 1, 9
"""zlib's levels."""


def packed(raw: bytes) -> bytes:
    """Bytes, a multiple of 8 of them, packed."""
    planes = [_planes(np.frombuffer(raw, "<i8"), order) for order in ORDERS]
    return zlib.compress(min(planes, key=lambda one: len(zlib.compress(one, QUICK))), BEST)


def _planes(columns: np.ndarray, order: int) -> bytes:
    for _ in ORDERS[:order]:
        columns = np.diff(columns, prepend=np.int64(0))
    small = (columns << 1) ^ (columns >> 63)
    return bytes([order]) + small.view(np.uint8).reshape(-1, 8).T.tobytes()
