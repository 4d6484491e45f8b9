"""Preset files of older schema versions, brought up to the present one.

| version | what is new |
|---|---|
| 1 | the first |
| 2 | `extends`, `authors`, `[tags]`, `[variables]`, `kinds.*.spacing_percent` |
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

SCHEMA = 2


def _one_to_two(data: dict[str, Any]) -> dict[str, Any]:
    # nothing was renamed: what is new has defaults
    return {**data, "schema": 2}


_STEPS: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {1: _one_to_two}


def migrated(data: dict[str, Any]) -> dict[str, Any]:
    """A file's data in the present schema; what has no known version is left for the check."""
    version = data.get("schema")
    while type(version) is int and version in _STEPS:
        data = _STEPS[version](data)
        version = data["schema"]
    return data
