"""Preset files of older schema versions, brought up to the present one.

| version | what is new |
|---|---|
| 1 | the first |
| 2 | `extends`, `authors`, `[tags]`, `[variables]`, `kinds.*.spacing_percent` |
| 3 | `[clutch]` with `max_speed_ratio` and `tap_duration_s`, which were `disk.catch_up` and \
`disk.unfold_s` |

In version 2 a tap took `unfold_s / catch_up`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

SCHEMA = 3


def _one_to_two(data: dict[str, Any]) -> dict[str, Any]:
    # nothing was renamed: what is new has defaults
    return {**data, "schema": 2}


def _two_to_three(data: dict[str, Any]) -> dict[str, Any]:
    disk = data.get("disk")
    if not isinstance(disk, dict):
        return {**data, "schema": 3}
    values = migrated_values({f"disk.{key}": value for key, value in disk.items()})
    found = {**data, "schema": 3, "disk": {}}
    for id, value in values.items():
        section, _, key = id.partition(".")
        found[section] = {**found.get(section, {}), key: value}
    return found


def migrated_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values by parameter id, with the ids and meanings of the present schema."""
    found = dict(values)
    ratio = found.pop("disk.catch_up", None)
    tap_s = found.pop("disk.unfold_s", None)
    if ratio is not None:
        found["clutch.max_speed_ratio"] = ratio
    if tap_s is not None:
        known = all(isinstance(value, int | float) for value in (ratio, tap_s))
        found["clutch.tap_duration_s"] = min(tap_s / ratio, 10.0) if known and ratio else tap_s
    return found


_STEPS: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {1: _one_to_two, 2: _two_to_three}


def migrated(data: dict[str, Any]) -> dict[str, Any]:
    """A file's data in the present schema; what has no known version is left for the check."""
    version = data.get("schema")
    while type(version) is int and version in _STEPS:
        data = _STEPS[version](data)
        version = data["schema"]
    return data
