"""Shared parts of public names: lazy imports (PEP 562), short reprs, DataFrames, drawing."""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from importlib import import_module
from typing import TYPE_CHECKING, Any

from overview_dsp.errors import InputError
from overview_dsp.installation import install_command

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

PACKAGE = __name__.partition(".")[0]

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxtuple = 3


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
        `"offline.rendering.offline"`); `"offline.rendering.offline:render"` where it has another
        name there, and `"design.presets:"` for that module itself.

    Returns
    -------
    tuple of callables
        `__getattr__`, and `__dir__`, which lists `__all__`.
    """

    def get(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, colon, own_name = places[name].partition(":")
        value: Any = import_module(f"{package}.{module}")
        if not colon or own_name:
            value = getattr(value, own_name or name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return list(sys.modules[package].__all__)

    return get, names


def short(value: object) -> str:
    """Write a value's repr with at most some 60 characters."""
    return _SHORT.repr(value)


def counted(count: int, what: str) -> str:
    """Write how many there are: `1 event`, `2 events`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def changed_fields(instance: Any, **shown: str) -> str:
    """Write a dataclass as it is made, without the fields that have their default.

    Parameters
    ----------
    instance : dataclass
        What is written.
    **shown : str
        What is written for a field in place of its value.
    """
    given = []
    for field in fields(instance):
        value = getattr(instance, field.name)
        if field.default is MISSING or value != field.default:
            given.append(f"{field.name}={shown.get(field.name) or short(value)}")
    return f"{type(instance).__name__}({', '.join(given)})"


def dataframe(columns: Mapping[str, Any]) -> DataFrame:
    """Make a DataFrame of columns of equal length; InputError says how to install pandas."""
    try:
        from pandas import DataFrame
    except ImportError as error:
        raise InputError(f"a DataFrame needs pandas: {install_command('dataframes')}") from error
    return DataFrame(dict(columns))


def plot_with(module: str, name: str, *arguments: Any) -> Figure:
    """Call a function that draws, of a module that is imported when it is needed."""
    figure: Figure = getattr(import_module(f"{PACKAGE}.{module}"), name)(*arguments)
    return figure
