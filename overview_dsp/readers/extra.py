"""Packages that only some formats need, imported late and asked for in one line."""

from __future__ import annotations

import importlib
from typing import Any

from overview_dsp.errors import InputError


def needed(module: str, purpose: str, extra: str) -> Any:
    """Import a module of one of the extras; InputError says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{purpose} needs the package {module.partition('.')[0]} ({error}); install it: pip "
            f"install 'overview-dsp[{extra}]'"
        ) from error
