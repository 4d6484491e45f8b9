"""Public names that are imported when they are first used (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from overview_dsp.public.moved import moved_name


def lazy_names(
    package: str, places: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make the `__getattr__` and the `__dir__` of a package.

    Parameters
    ----------
    package : str
        The package's own name.
    places : mapping of str to str
        Each public name, and the module in the package that holds it (`"render"` is in
        `"rendering.offline"`); `"rendering.offline:render"` where it has another name there, and
        `""` for a module of the package itself.

    Returns
    -------
    tuple of callables
        `__getattr__`, which knows moved names too, and `__dir__`, which lists `__all__`.
    """

    def get(name: str) -> Any:
        if name not in places:
            return moved_name(package, name)
        module, _, own_name = places[name].partition(":")
        if not module:
            return import_module(f"{package}.{name}")
        value = getattr(import_module(f"{package}.{module}"), own_name or name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return list(sys.modules[package].__all__)

    return get, names
