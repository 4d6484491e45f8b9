"""What a page that makes the sound itself is given: the kernel's memory, and changes of it.

``POST /sound/whole`` with ``{"sample_rate": 48000, "preset": P, "window": [start_s, end_s],
"seed": 0}`` and ``POST /sound/change`` with ``{"sample_rate": 48000, "before": P, "after": P,
"window": [start_s, end_s]}``, P a name or a preset as `/data/preset` has it, answer the bytes of
`encoding`. A whole without a window or a seed has the whole timeline and 0. A change without a
window keeps the surface: that will do where no parameter of the surface or of a kind differs.
"""

from __future__ import annotations

from typing import Any

from overview_dsp.engine import Engine
from overview_dsp.errors import InputError
from overview_dsp.surface import build_surface
from overview_dsp.timeline import Timeline
from overview_dsp.web.encoding import encode_change, encode_engine
from overview_dsp.web.preset_data import preset_given

BLOCK = 128
"""Frames of a browser's block."""

MIN_RATE, MAX_RATE = 8_000.0, 192_000.0
"""What browsers play at, Hz."""

WHOLE_KEYS = {"sample_rate", "preset", "window", "seed"}
CHANGE_KEYS = {"sample_rate", "before", "after", "window"}


def whole(timeline: Timeline, asked: dict[str, Any]) -> bytes:
    """The memory of a prepared engine; InputError for what can't be."""
    _require_keys(asked, WHOLE_KEYS, {"sample_rate", "preset"})
    seed = asked.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**53:
        raise InputError(f"seed is a whole number from 0 to {2**53 - 1}")
    rate = _rate(asked["sample_rate"])
    part = timeline.window(*_window(timeline, asked.get("window")))
    engine = Engine(preset_given(asked["preset"]), part, seed=seed)
    engine.prepare(rate, BLOCK)
    return encode_engine(engine)


def change(timeline: Timeline, asked: dict[str, Any]) -> bytes:
    """From one preset to another, and to a window's surface; InputError for what can't be."""
    _require_keys(asked, CHANGE_KEYS, {"sample_rate", "before", "after"})
    before, after = preset_given(asked["before"]), preset_given(asked["after"])
    surface = None
    if "window" in asked:
        part = timeline.window(*_window(timeline, asked["window"]))
        surface = build_surface(part, after)
    return encode_change(before, after, _rate(asked["sample_rate"]), surface)


def _window(timeline: Timeline, given: Any) -> tuple[float, float]:
    if given is None:
        return 0.0, timeline.duration_s
    if not isinstance(given, list) or len(given) != 2:
        raise InputError("window is [start_s, end_s]")
    return timeline.require_window(*given)


def _rate(given: Any) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise InputError("sample_rate is a number of Hz")
    if not MIN_RATE <= given <= MAX_RATE:
        raise InputError(f"sample_rate is out of range; it is {MIN_RATE:g} to {MAX_RATE:g} Hz")
    return float(given)


def _require_keys(asked: dict[str, Any], known: set[str], needed: set[str]) -> None:
    if not needed <= asked.keys() <= known:
        raise InputError(f"the body has the keys {', '.join(sorted(known))}")
