"""Scale of the varied levels: the axis on which answers are fitted and averaged."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import presets

SAME_RATIO = 1e-3
"""Largest relative difference of ratios between levels that are spaced by one ratio."""


@dataclass(frozen=True)
class Scale:
    """Positions of levels on their axis.

    Attributes
    ----------
    kind : {"linear", "dB", "log", "index"}
        ``log``: the position is the decimal logarithm; ``index``: the place in `levels`.
    levels : list
        All levels in order.
    """

    kind: str
    levels: Sequence[Any]

    def position(self, level: Any) -> float:
        """Return the position of a level."""
        if self.kind == "index":
            return float(list(self.levels).index(level))
        return math.log10(level) if self.kind == "log" else float(level)

    def level(self, position: float) -> float:
        """Return the level at a position; with ``index`` the position itself.

        Of a difference of positions with ``log``, it is the ratio of the levels.
        """
        return 10.0**position if self.kind == "log" else position

    def axis_position(self, level: float) -> float:
        """Return the position of which `level` made a level or a ratio."""
        return math.log10(level) if self.kind == "log" else level

    def steps(self, levels: Sequence[Any]) -> NDArray[np.float64]:
        """Return positions in mean steps of the scale, 0 at the first of `levels`."""
        found = np.array([self.position(level) for level in levels])
        steps: NDArray[np.float64] = np.round((found - found.min()) / self._mean_step, 9)
        return steps

    @cached_property
    def _mean_step(self) -> float:
        known = [self.position(level) for level in self.levels]
        return (max(known) - min(known)) / (len(known) - 1) if len(known) > 1 else 1.0


def scale_kind(vary: str | None, levels: Sequence[Any], chosen: str | None = None) -> str:
    """Return the kind of scale of the levels of a dimension.

    It is the `chosen` one, or that of the parameter table. Levels spaced by one ratio have a log
    scale, whatever the table says.
    """
    numbers = [one for one in levels if isinstance(one, int | float)]
    if len(numbers) < len(levels) or not numbers:
        return "index"
    if chosen is not None:
        return chosen
    name = str(vary).split(".")
    known = presets.PARAMETERS.get(str(vary)) or presets.KIND_PARAMETERS.get(name[-1])
    if known is not None and known.unit == "dB":
        return "dB"
    if min(numbers) > 0.0:
        ratios = np.diff(np.log(sorted(numbers)))
        even = len(ratios) > 1 and float(np.ptp(ratios)) <= SAME_RATIO * float(ratios.mean())
        if even or (known is not None and known.scale == "log"):
            return "log"
    return "linear"


def scale_of(study: Mapping[str, Any]) -> Scale:
    """Return the scale of a study's varied levels."""
    levels = list(dict.fromkeys(one["level"] for one in study["stimuli"].values()))
    levels = [level for level in levels if level is not None]
    kind = study["task"].get("scale") or scale_kind(study["task"]["vary"], levels)
    return Scale(kind, levels)
