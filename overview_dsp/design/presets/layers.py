"""A preset file and those it extends, as one.

`extends = "football"` takes everything from that preset (a bundled or own name, or a path from the
file's folder) and changes what is written here: single keys, kinds, variables. A list of modes is
taken whole. Variables of the base may be set anew, and what is worked out from them follows.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from overview_dsp.design.presets.migrations import migrated
from overview_dsp.errors import InputError, shown

MAX_LAYERS = 8

Find = Callable[[str, str], tuple[str, str]]
"""From (what `extends` says, the file that says it) to (the base's file, its text)."""


@dataclass(frozen=True)
class Layer:
    """One file: where it is, its text, and its data in the present schema."""

    source: str
    text: str
    data: dict[str, Any]


def read_layers(source: str, text: str, find: Find) -> list[Layer]:
    """The file and its bases, the file first.

    Raises
    ------
    InputError
        Not TOML; a base that isn't there, is no name, or extends what extends it.
    """
    layers = [_layer(source, text)]
    while (base := layers[-1].data.get("extends")) is not None:
        here = layers[-1]
        if not isinstance(base, str):
            raise InputError(f"{here.source}: extends = {shown(base)}; it is a preset's name")
        if len(layers) == MAX_LAYERS:
            raise InputError(f"{source}: more than {MAX_LAYERS} presets extend each other")
        try:
            found = find(base, here.source)
        except InputError as error:
            raise InputError(f"{here.source}: extends: {error}") from None
        if any(found[0] == layer.source for layer in layers):
            raise InputError(f"{here.source}: extends {base!r}, which extends it in turn")
        layers.append(_layer(*found))
    return layers


def _layer(source: str, text: str) -> Layer:
    try:
        data = tomllib.loads(text)
    # ValueError: not TOML, and an integer of thousands of digits
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not TOML: {error}") from None
    return Layer(source, text, migrated(data))


def merged(layers: list[Layer]) -> dict[str, Any]:
    """The data of all layers as one, the first layer's last word."""
    found: dict[str, Any] = {}
    for layer in reversed(layers):
        own = {key: value for key, value in layer.data.items() if key != "extends"}
        found = _over(found, own)
    return found


def _over(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    found = dict(base)
    for key, value in own.items():
        below = found.get(key)
        if not (isinstance(below, dict) and isinstance(value, dict)):
            found[key] = value
            continue
        found[key] = _over(below, value)
        # an event's width is given in one of two ways: the file's own is meant
        _one_width(found[key], value)
    return found


def _one_width(found: dict[str, Any], own: dict[str, Any]) -> None:
    for given, other in (("width_percent", "width_ms"), ("width_ms", "width_percent")):
        if given in own and other not in own:
            found.pop(other, None)


def layer_of(layers: list[Layer], path: tuple[str | int, ...]) -> Layer:
    """The layer that says a value: the first one that has it, else the file itself."""
    for layer in layers:
        value: Any = layer.data
        for part in path:
            try:
                value = value[part]
            except (KeyError, IndexError, TypeError):
                break
        else:
            return layer
    return layers[0]
