"""The libraries of the extras `batch` and `cluster`, imported late."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from overview_dsp.errors import InputError


def library(name: str, extra: str = "batch") -> Any:
    """Import a module of an extra; InputError says how to install it."""
    try:
        return import_module(name)
    except ImportError as error:
        what = "a cluster" if extra == "cluster" else "overview batch"
        raise InputError(
            f'{what} needs {name.partition(".")[0]}: pip install "overview-dsp[{extra}]"'
        ) from error
