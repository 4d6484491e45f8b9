"""Colours, markers and frames of all plots.

Colours are Okabe and Ito's, which colour-blind eyes distinguish; event kinds differ in shape too.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Timeline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#767676"
Marker = Any  # marker of matplotlib: a letter, a number, or a tuple of corners, style and rotation
Style = tuple[Marker, str, str]  # marker, face colour, words

# the paper's goals are blue, its cards yellow and red
KIND_STYLE: dict[str, Style] = {
    "goal": ("o", BLUE, "goal"),
    "own_goal": ("h", SKY, "own goal"),
    "near_miss": ("^", GREEN, "near miss"),
    "yellow_card": ("s", YELLOW, "yellow card"),
    "red_card": ("D", VERMILION, "red card"),
    "foul": ("x", GREY, "foul"),
    "period": ("|", BLACK, "start or end of a half"),
    "shot": ("<", GREEN, "shot"),
    "touch": ("+", GREY, "touch"),
    # of series
    "highest": ("*", VERMILION, "highest"),
    "lowest": ((5, 1, 36), BLUE, "lowest"),
    "record_high": ((4, 1, 0), ORANGE, "record high"),
    "record_low": ((4, 1, 45), SKY, "record low"),
    "peak": ("2", VERMILION, "peak"),
    "trough": ("1", BLUE, "trough"),
    "largest_rise": ((3, 1, 0), GREEN, "largest rise"),
    "largest_fall": ((3, 1, 180), PURPLE, "largest fall"),
    "crossing_up": (">", SKY, "crossing up"),
    "crossing_down": ("v", ORANGE, "crossing down"),
    "split": ("X", BLACK, "share split"),
    # of the calendar and the clock
    "year": ("d", BLACK, "year"),
    "month": (2, BLACK, "month"),
    "week": (3, GREY, "week"),
    "day": (10, GREY, "day"),
    "hour": (11, GREY, "hour"),
    "minute": (1, GREY, "minute"),
    "second": (0, GREY, "second"),
    # of hearts
    "beat": (".", GREY, "beat"),
    "premature": ("H", ORANGE, "premature beat"),
    "premature_atrial": ("p", SKY, "premature atrial"),
    "premature_ventricular": ("P", VERMILION, "premature ventricular"),
    "other_shape": ((5, 2, 0), VERMILION, "beat of another shape"),
    "missed_beat": ((6, 2, 0), BLACK, "missed beat"),
    "rhythm": ("8", PURPLE, "rhythm"),
    # of crowds
    "cheer": ((8, 1, 0), YELLOW, "cheer"),
    "burst": ((7, 1, 0), ORANGE, "burst"),
}
# of kinds without a style, selected by the kind's name
_OTHERS: tuple[tuple[Marker, str], ...] = tuple(
    (marker, colour)
    for marker, colour in zip(
        (
            *((6, 1, 0), (5, 0, 180), (7, 0, 0), (9, 1, 0), (10, 1, 0), (12, 1, 0), (4, 2, 0)),
            *((5, 2, 0), (7, 2, 0), (8, 2, 0), (3, 0, 30), (3, 0, 90), (6, 1, 30), (9, 0, 0)),
        ),
        2 * (VERMILION, BLUE, YELLOW, SKY, GREEN, ORANGE, PURPLE),
        strict=True,
    )
)
GAP_STYLE: Any = {"facecolor": "none", "edgecolor": "#b0b0b0", "hatch": "////", "linewidth": 0.0}
_POINTS = 1500  # steps of a curve, of which the extremes are kept, to limit the size of an SVG


def has_face(marker: Marker) -> bool:
    """Return whether a marker is an area instead of lines."""
    from matplotlib.markers import MarkerStyle

    return bool(MarkerStyle(marker).is_filled()) and (isinstance(marker, str) or marker[1] != 2)


def styles_of(timeline: Timeline) -> dict[str, Style]:
    """Return the style of each kind of a timeline, which is the same in all plots.

    Kinds without one of their own share a few by their names; two of one picture differ if
    possible.
    """
    kinds = timeline.kinds()
    found = {kind: style for kind, style in KIND_STYLE.items() if kind in kinds}
    taken: set[int] = set()
    for kind in sorted(set(kinds) - set(found)):
        at = zlib.crc32(kind.encode()) % len(_OTHERS)
        while at in taken and len(taken) < len(_OTHERS):
            at = (at + 1) % len(_OTHERS)
        taken.add(at)
        found[kind] = (*_OTHERS[at], kind.replace("_", " "))
    return found


def mark_events(
    axes: Axes, x: ArrayLike, y: ArrayLike, style: Style, size: float, **options: Any
) -> None:
    """Plot events with the marker of their kind; areas have a black edge."""
    marker, colour, words = style
    options.setdefault("linewidths", 0.7 if has_face(marker) else 1.6)
    options.setdefault("label", words)
    edges = BLACK if has_face(marker) else None
    axes.scatter(x, y, s=size, marker=marker, color=colour, edgecolors=edges, **options)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches, without a window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def tidy(axes: Axes) -> None:
    """Add a light grid behind the data and remove the frame at the top and right."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def extremes(x: FloatArray, y: FloatArray, points: int = _POINTS) -> tuple[FloatArray, FloatArray]:
    """Return a curve with fewer points: the lowest and highest value of each step."""
    if len(x) <= 2 * points:
        return x, y
    edges = np.linspace(0, len(x), points + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)
    return np.repeat(x[edges], 2), np.column_stack([low, high]).ravel()
