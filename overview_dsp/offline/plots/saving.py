"""Figure files: PNG, SVG and PDF, written completely or not at all."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, require_writable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
