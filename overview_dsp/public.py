"""Helpers of public classes: lazy imports (PEP 562), short reprs, DataFrames, plots."""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from importlib import import_module
from typing import TYPE_CHECKING, Any

from overview_dsp.installation import require_package

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

PACKAGE = __name__.partition(".")[0]

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxtuple = 3


def lazy_names(
    package: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make the `__getattr__` and the `__dir__` of a package.

    Parameters
    ----------
    package : str
        The package's own name.
    modules : mapping of str to str
        Module in the package, by public name (`"render"`: `"offline.rendering.offline"`).
        `"offline.rendering.offline:render"` has another name in its module, and
        `"design.presets:"` is the module itself.

    Returns
    -------
    tuple of callables
        `__getattr__`, and `__dir__`, which lists `__all__`.
    """

    def get(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, colon, own_name = modules[name].partition(":")
        value: Any = import_module(f"{package}.{module}")
        if not colon or own_name:
            value = getattr(value, own_name or name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return list(sys.modules[package].__all__)

    return get, names


def short(value: object) -> str:
    """Return the repr of a value, cut to about 60 characters."""
    return _SHORT.repr(value)


def counted(count: int, what: str) -> str:
    """Return a number with its noun: `1 event`, `2 events`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def changed_fields(instance: Any, **replacements: str) -> str:
    """Return the repr of a dataclass, without the fields that have their default.

    Parameters
    ----------
    instance : dataclass
        Object to describe.
    **replacements : str
        Texts that replace the values of fields.
    """
    texts = []
    for field in fields(instance):
        value = getattr(instance, field.name)
        if field.default is MISSING or value != field.default:
            texts.append(f"{field.name}={replacements.get(field.name) or short(value)}")
    return f"{type(instance).__name__}({', '.join(texts)})"


def dataframe(columns: Mapping[str, Any]) -> DataFrame:
    """Return a DataFrame of columns of equal length; InputError if pandas is missing."""
    frame: DataFrame = require_package("pandas", "a DataFrame", "dataframes").DataFrame(
        dict(columns)
    )
    return frame


def plot_with(module: str, name: str, *arguments: Any) -> Figure:
    """Import a module of this package and call its plot function `name`."""
    figure: Figure = getattr(import_module(f"{PACKAGE}.{module}"), name)(*arguments)
    return figure
