"""How public objects draw themselves: by the pictures, which lie above what is drawn."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PACKAGE = __name__.partition(".")[0]


def drawn(module: str, name: str, *arguments: Any) -> Figure:
    """Call a function of a module of `plots`, imported by name when it is needed."""
    figure: Figure = getattr(import_module(f"{PACKAGE}.plots.{module}"), name)(*arguments)
    return figure
