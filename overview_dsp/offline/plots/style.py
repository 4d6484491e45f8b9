"""Colours, markers, frames and files of all plots.

Colours are Okabe and Ito's, which colour-blind eyes distinguish; event kinds differ in shape too.
Files are PNG, SVG and PDF, written completely or not at all.
"""

from __future__ import annotations

import os
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, require_writable
from overview_dsp.files.toml import load_toml

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#767676"
Marker = Any  # marker of matplotlib: a letter, a number, or a tuple of corners, style and rotation
Style = tuple[Marker, str, str]  # marker, face colour, words

_KINDS = load_toml(__file__, "kinds.toml")
# of kinds without a style, selected by the kind's name
_OTHERS = [(tuple(marker), colour) for marker, colour in _KINDS.pop("others")]
KIND_STYLE: dict[str, Style] = {
    kind: (tuple(marker) if isinstance(marker, list) else marker, colour, words)
    for kind, (marker, colour, words) in _KINDS.items()
}
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


PICTURES = (".png", ".svg", ".pdf")  # formats of figures by file suffix


def require_picture(path: str | os.PathLike[str]) -> None:
    """Raise InputError early for a figure that could not be written later."""
    _picture_suffix(path)
    require_writable(path)


def _picture_suffix(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in PICTURES:
        raise InputError(f"{path}: a picture is {', '.join(PICTURES)}; choose one of them")
    return suffix


def save_picture(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure to a file (`PICTURES`); errors as in `atomic_file`."""
    import matplotlib

    # no date and fixed ids, so that the same figure gives the same bytes
    metadata = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    suffix = _picture_suffix(path)
    # TrueType, because publishers refuse the default, Type 3
    settings: Any = {"svg.hashsalt": "overview", "svg.fonttype": "none", "pdf.fonttype": 42}
    with matplotlib.rc_context(settings), atomic_file(path) as temporary:
        figure.savefig(temporary, dpi=300, metadata=metadata[suffix])


def save_figure(figure: Figure, stem: str | os.PathLike[str]) -> list[Path]:
    """Write a figure as PNG and SVG; return the files."""
    written = [Path(f"{os.fspath(stem)}{suffix}") for suffix in (".png", ".svg")]
    for path in written:
        save_picture(figure, path)
    return written
