"""What a search may move: each kind's height and width, by ratio, within what presets allow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.design.presets.parameters import KIND_PARAMETERS

MOST_HEIGHT = 8.0
MOST_WIDTH = 2.0
"""Heights move by up to this ratio, widths by less: a width is a kind's character."""

RATE = 16_000.0
"""The disk and its vibration are the same at any rate; a low one is quick."""


@dataclass(frozen=True)
class Tuned:
    """A preset tuned by search.

    Attributes
    ----------
    preset : Preset
        Called `NAME-tuned`.
    least_steps : float
        Just noticeable steps between the two kinds that are nearest to each other.
    reached : bool
        Whether that is what was wanted.
    unreached : tuple of str
        Where it isn't, on the timelines it was tuned on: a line each.

    Examples
    --------
    >>> ov.measure.Tuned(ov.load_preset("football"), least_steps=2.1, reached=True).reached
    True
    """

    preset: Preset
    least_steps: float
    reached: bool
    unreached: tuple[str, ...] = ()


def limits(count: int) -> NDArray[np.float64]:
    """The largest moves of `count` kinds, (2 count,): heights, then widths; logs of ratios."""
    return np.repeat([math.log(MOST_HEIGHT), math.log(MOST_WIDTH)], count)


def moved(preset: Preset, names: Sequence[str], moves: NDArray[np.float64]) -> Preset:
    """The preset with each named kind's height and width moved.

    Parameters
    ----------
    moves : float64 (2 names,), as `limits`
    """
    kinds = dict(preset.kinds)
    for name, height, width in zip(names, moves[: len(names)], moves[len(names) :], strict=True):
        kinds[name] = _moved_kind(kinds[name], math.exp(height), math.exp(width))
    return replace(preset, kinds=kinds)


def _moved_kind(kind: EventKind, height: float, width: float) -> EventKind:
    key = "width_percent" if kind.width_percent is not None else "width_ms"
    changes: dict[str, Any] = {
        "height": _within("height", kind.height * height),
        key: _within(key, getattr(kind, key) * width),
    }
    return replace(kind, **changes)


def _within(key: str, value: float) -> float:
    known = KIND_PARAMETERS[key]
    return min(max(value, known.low), known.high)
