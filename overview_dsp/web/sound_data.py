"""Sound data of windows: kernel memory, changes, patches and their compression.

``POST /data/window`` with ``{"window": [start_s, end_s], "preset": P}`` returns
``data/window-N.json`` (`site_data`) for any window, with `points` if one file can't have them all.
``POST /sound/change`` with ``{"sample_rate": 48000, "before": P, "after": P, "window": [start_s,
end_s]}`` returns the bytes of `encode_change`. P is a preset name or object; its default is the
served preset. A change without a window keeps the surface. That is enough if no parameter of the
surface or of an event kind differs.

``sound/N.packed`` are the packed bytes of `browser_memory` at the first sample rate: the memory of
the whole timeline (N = 0), or the change to window N (N = ``back``: to the whole timeline).
``sound/N-RATE.patch`` turns them into those of another rate, little-endian::

    uint32 1 (replace all) or 0, uint32 number of runs; for 1 the bytes themselves, else per run:
    uint32 column (of 8 bytes), uint32 number of columns, the columns

Only coefficients and clicks depend on the rate, not the half megabyte of friction.

Packed bytes are compressed by zlib's deflate, without loss (`unpack.js`)::

    uint8 order; the first byte of every column of 8, the second of every column, ...

The columns are differences, as (n << 1) ^ (n >> 63), which makes small negative numbers small. For
an order of 0 to 7 they are the columns (int64 with wrap-around), replaced `order` times by the
differences of neighbours. Neighbours in a friction table lie almost on a line, so that their
differences are small.

Friction by rank grows by factors, plus a number of ranks n that varies from point to point. For
the order 8, two parts follow: int8 n of every column, float64 s (the logarithm of one rank's
factor). The columns are the differences from the prediction b * (b / a) * e from the two float64
before it, with e = 1 + x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4))) and x = s * n; from 0 for the
first two columns, and where the prediction is not a positive number.
"""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from overview_dsp.data.analysis.series_events import has_values
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.offline.export.browser_memory import encode_change, encode_engine
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface
from overview_dsp.web.preset_data import parse_preset
from overview_dsp.web.site_data import fits_one_file, points_json, window_json

MIN_RATE, MAX_RATE = 8_000.0, 192_000.0
"""Range of sample rates of browsers, Hz."""

CHANGE_KEYS = {"sample_rate", "before", "after", "window"}
WINDOW_KEYS = {"window", "preset"}


def window(timeline: Timeline, default: Preset, query: dict[str, Any]) -> dict[str, Any]:
    """Return the picture data of a requested window; raise InputError for an invalid request."""
    _require_keys(query, WINDOW_KEYS, {"window"})
    start, end = _window(timeline, query["window"])
    part = _window_timeline(timeline, start, end)
    surface = build_surface(part, _preset_of(query, "preset", default))
    content = window_json(part, surface, start)
    if has_values(timeline) and not fits_one_file(timeline):
        content["points"] = points_json(timeline, start, end)
    return content


def change(timeline: Timeline, default: Preset, query: dict[str, Any]) -> bytes:
    """Return a change of preset and surface; raise InputError for an invalid request."""
    _require_keys(query, CHANGE_KEYS, {"sample_rate"})
    before, after = _preset_of(query, "before", default), _preset_of(query, "after", default)
    surface = None
    if "window" in query:
        part = _window_timeline(timeline, *_window(timeline, query["window"]))
        surface = build_surface(part, after)
    return encode_change(before, after, _rate(query["sample_rate"]), surface)


def _preset_of(query: dict[str, Any], key: str, default: Preset) -> Preset:
    return parse_preset(query[key]) if key in query else default


def _window(timeline: Timeline, value: Any) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InputError("window must be [start_s, end_s]")
    return timeline.require_window(*value)


def _window_timeline(timeline: Timeline, start: float, end: float) -> Timeline:
    """Return the timeline of a window; the whole timeline has no details of windows."""
    return timeline if start <= 0.0 and end >= timeline.duration_s else timeline.window(start, end)


def _rate(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError("sample_rate must be a number of Hz")
    if not MIN_RATE <= value <= MAX_RATE:
        raise InputError(
            f"sample_rate is {value!r:.20} Hz; must be {MIN_RATE:g} to {MAX_RATE:g} Hz"
        )
    return float(value)


def _require_keys(query: dict[str, Any], allowed: set[str], required: set[str]) -> None:
    if not required <= query.keys() <= allowed:
        raise InputError(
            f"allowed keys: {', '.join(sorted(allowed))}; required: {', '.join(sorted(required))}"
        )


BLOCK = 128
"""Frames per block of a browser."""


def whole_bytes(
    timeline: Timeline, preset: Preset, rate: int, seed: int, actuator: Actuator | None
) -> bytes:
    """Return the memory of an engine prepared for a sample rate (Hz)."""
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(rate, BLOCK)
    return encode_engine(engine, OutputSettings(actuator=actuator))


def window_bytes(surface: Surface, preset: Preset, rate: int) -> bytes:
    """Return the change to a window's surface at a sample rate (Hz)."""
    return encode_change(preset, preset, rate, surface)


def make_patch(base: bytes, target: bytes) -> bytes:
    """Return the patch that turns `base` into `target`."""
    if len(base) != len(target):
        return np.array([1, 0], "<u4").tobytes() + target
    different = np.flatnonzero(np.frombuffer(base, "<u8") != np.frombuffer(target, "<u8"))
    runs = np.split(different, np.flatnonzero(np.diff(different) > 1) + 1) if len(different) else []
    parts = [np.array([0, len(runs)], "<u4").tobytes()]
    for run in runs:
        first, count = int(run[0]), len(run)
        parts.append(np.array([first, count], "<u4").tobytes())
        parts.append(target[8 * first : 8 * (first + count)])
    return b"".join(parts)


ORDERS = range(8)
QUICK, BEST = 1, 9
"""Compression levels of zlib."""


def pack(raw: bytes, rank_step: float = 0.0, level: int = BEST) -> bytes:
    """Return the packed bytes; their number must be a multiple of 8.

    `rank_step` is the difference that one rank makes to the logarithm of friction. The `level`
    `QUICK` takes a tenth of the time for ranks, and gives up to a tenth more bytes.
    """
    columns = np.frombuffer(raw, "<i8")
    found = [_predicted(columns, rank_step)] if rank_step else []
    if level == BEST or not found:
        found += [_planes(columns, order) for order in ORDERS]
    return zlib.compress(min(found, key=lambda one: len(zlib.compress(one, QUICK))), level)


def _planes(columns: np.ndarray, order: int) -> bytes:
    for _ in ORDERS[:order]:
        columns = np.diff(columns, prepend=np.int64(0))
    zigzag = (columns << 1) ^ (columns >> 63)
    return bytes([order]) + zigzag.view(np.uint8).reshape(-1, 8).T.tobytes()


def _predicted(columns: np.ndarray, rank_step: float) -> bytes:
    values, ranks = columns.view("<f8"), np.zeros(len(columns), np.int8)
    with np.errstate(all="ignore"):  # not all columns are friction
        steady = values[1:-1] * (values[1:-1] / values[:-2])
        jumps = np.rint(np.log(values[2:] / steady) / rank_step)
        ranks[2:] = np.where(np.abs(jumps) < 128.0, jumps, 0.0)
        x = rank_step * ranks[2:]
        found = steady * (1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0))))
    found = np.where((found > 0.0) & np.isfinite(found), found, 0.0)
    rest = columns - np.append(np.zeros(2, "<i8"), found.view("<i8"))[: len(columns)]
    coded = _planes(rest, 0)[1:]
    return bytes([len(ORDERS)]) + coded + ranks.tobytes() + np.array(rank_step, "<f8").tobytes()
