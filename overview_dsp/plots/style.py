"""Colours, markers and frames that all pictures share.

Colours are Okabe and Ito's, which colour-blind eyes distinguish; event kinds differ in shape too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.timeline import Timeline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#767676"

# kind: (marker, face colour, words); the paper's goals are blue, its cards yellow and red
KIND_STYLE: dict[str, tuple[str, str, str]] = {
    "goal": ("o", BLUE, "goal"),
    "own_goal": ("h", SKY, "own goal"),
    "near_miss": ("^", GREEN, "near miss"),
    "yellow_card": ("s", YELLOW, "yellow card"),
    "red_card": ("D", VERMILION, "red card"),
    "foul": ("x", GREY, "foul"),
    "period": ("|", BLACK, "start or end of a half"),
    "shot": ("<", GREEN, "shot"),
    "touch": ("+", GREY, "touch"),
}
# of kinds that have no style of their own, one after the other
_OTHER_MARKERS = "Pv*X>pd8"
_OTHER_COLOURS = (VERMILION, BLUE, YELLOW, SKY, GREEN, ORANGE, PURPLE)
LINES = "x|+"  # markers without a face
GAP_HATCH = "////"
_POINTS = 1500  # a curve keeps its extremes in this many steps, so that an SVG stays small


def styles_of(timeline: Timeline) -> dict[str, tuple[str, str, str]]:
    """The style of each kind of a timeline: the known ones first, the others by name."""
    kinds = timeline.kinds()
    known = {kind: style for kind, style in KIND_STYLE.items() if kind in kinds}
    others = sorted(set(kinds) - set(known))
    return known | {
        kind: (
            _OTHER_MARKERS[index % len(_OTHER_MARKERS)],
            _OTHER_COLOURS[index % len(_OTHER_COLOURS)],
            kind.replace("_", " "),
        )
        for index, kind in enumerate(others)
    }


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, in inches, without a window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def tidy(axes: Axes) -> None:
    """A light grid behind the data; no frame at the top and the right."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def extremes(
    x: NDArray[np.float64], y: NDArray[np.float64], points: int = _POINTS
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A curve with fewer points and the same extremes: the lowest and highest of each step."""
    if len(x) <= 2 * points:
        return x, y
    edges = np.linspace(0, len(x), points + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)
    return np.repeat(x[edges], 2), np.column_stack([low, high]).ravel()
