"""Figures as files: PNG, SVG, PDF, whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, require_writable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PICTURES = (".png", ".svg", ".pdf")
"""How a picture may be written, by the suffix of its file."""


def require_picture(path: str | os.PathLike[str]) -> None:
    """Refuse early, with InputError, a picture that could not be written at the end."""
    _picture_suffix(path)
    require_writable(path)


def _picture_suffix(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in PICTURES:
        raise InputError(f"{path}: a picture is {', '.join(PICTURES)}; choose one of them")
    return suffix


def save_picture(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure as one file (`PICTURES`), whole or not at all; errors as `atomic_file`."""
    import matplotlib

    # no date and fixed ids: the same figure gives the same bytes
    metadata = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    suffix = _picture_suffix(path)
    with (
        matplotlib.rc_context({"svg.hashsalt": "overview", "svg.fonttype": "none"}),
        atomic_file(path) as temporary,
    ):
        figure.savefig(temporary, dpi=150, metadata=metadata[suffix])


def save_figure(figure: Figure, stem: str | os.PathLike[str]) -> list[Path]:
    """Write a figure as PNG and as SVG; the files, whole or absent."""
    written = []
    for suffix in (".png", ".svg"):
        path = Path(f"{os.fspath(stem)}{suffix}")
        save_picture(figure, path)
        written.append(path)
    return written
