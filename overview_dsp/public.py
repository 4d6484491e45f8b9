"""Helpers of public classes: lazy imports (PEP 562), short reprs, DataFrames, plots."""

from __future__ import annotations

import ast
import reprlib
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from overview_dsp.installation import require_package

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

PACKAGE = __name__.partition(".")[0]

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxtuple = 3


def stub_names(
    package: str, private: Iterable[str] = ()
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Make the `__getattr__`, `__dir__` and `__all__` of a package or module from its stub (.pyi).

    Public names of a stub are imported as themselves (`from module import name as name`), or are
    other names of imported ones (`load = load_actuator`). `private` are packages in this one that
    are attributes, too, by the last part of their names.
    """
    stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi")
    try:
        text = stub.read_text(encoding="utf-8")
    except OSError as error:
        raise ImportError(f"{stub}: {error.strerror}; reinstall overview-dsp") from None
    imported: dict[str, str] = {}
    public: dict[str, str] = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.ImportFrom):
            here = {alias.name: f"{node.module}:{alias.name}" for alias in node.names}
            imported |= here
            public |= {alias.name: here[alias.name] for alias in node.names if alias.asname}
        elif isinstance(node, ast.Assign):
            public[ast.unparse(node.targets[0])] = imported[ast.unparse(node.value)]
    parents = (name.rpartition(".") for name in private)
    names = public | {name: f"{PACKAGE}.{parent}:{name}" for parent, _, name in parents}

    def get(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, own_name = names[name].partition(":")
        if module == package:
            value = import_module(f"{package}.{own_name}")
        else:
            # the list also imports a module of that name
            value = getattr(__import__(module, fromlist=[own_name]), own_name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted(public), sorted(public)


def short(value: object) -> str:
    """Return the repr of a value, cut to about 60 characters."""
    return _SHORT.repr(value)


def plural(noun: str) -> str:
    """Return the plural of a noun: `events`, `passes`."""
    return f"{noun}es" if noun.endswith(("s", "ch", "sh")) else f"{noun}s"


def counted(count: int, noun: str) -> str:
    """Return a number with its noun: `1 event`, `2 events`."""
    return f"{count} {noun if count == 1 else plural(noun)}"


def changed_fields(instance: Any, **replacements: str) -> str:
    """Return the repr of a dataclass, without the fields that have their default.

    `replacements` are texts that replace the values of fields.
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
