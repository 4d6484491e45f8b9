"""Differences between two presets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from overview_dsp import validation
from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, PARAMETERS


@dataclass(frozen=True)
class Difference:
    """One value that differs between two presets.

    Attributes
    ----------
    id : str
        Parameter id, such as `kinds.goal.height`.
    first, second : float, bool or str
        Value in each preset.
    unit : str
        Unit of both.

    Examples
    --------
    >>> ov.presets.differences(football, football.with_changes({"tactor.gain_db": -6.0}))
    [Difference(id='tactor.gain_db', first=0.0, second=-6.0, unit='dB')]
    """

    id: str
    first: Any
    second: Any
    unit: str


def differences(first: Preset, second: Preset) -> list[Difference]:
    """List all differences between two presets.

    Parameters
    ----------
    first, second : Preset
        Presets to compare.

    Returns
    -------
    list of Difference
        Differences in the order of the parameter table, then by kind.

    Examples
    --------
    >>> football, stadium = ov.load_preset("football"), ov.load_preset("football-stadium")
    >>> "surface.friction" in [found.id for found in ov.presets.differences(football, stadium)]
    True
    """
    validation.instance(first, Preset, "first", "ov.load_preset gives one")
    validation.instance(second, Preset, "second", "ov.load_preset gives one")
    found = [
        Difference(id, first.values[id], second.values[id], known.unit)
        for id, known in PARAMETERS.items()
        if first.values[id] != second.values[id]
    ]
    if first.points != second.points:
        found.append(_points_difference("surface.points", first, second))
    for name in dict.fromkeys((*first.kinds, *second.kinds)):
        one, other = first.kinds.get(name), second.kinds.get(name)
        if one is None or other is None:
            found.append(Difference(f"kinds.{name}", _kind_state(one), _kind_state(other), ""))
            continue
        for key, known in KIND_PARAMETERS.items():
            pair = getattr(one, key), getattr(other, key)
            if pair[0] != pair[1]:
                found.append(Difference(f"kinds.{name}.{key}", *pair, known.unit))
        if one.aliases != other.aliases:
            names = [", ".join(kind.aliases) or "none" for kind in (one, other)]
            found.append(Difference(f"kinds.{name}.aliases", names[0], names[1], ""))
        if one.points != other.points:
            found.append(_points_difference(f"kinds.{name}.points", one, other))
        if one.modes != other.modes:
            found.append(Difference(f"kinds.{name}.modes", _modes(one), _modes(other), "Hz, ms"))
    return found


def _points_difference(
    id: str, first: Preset | EventKind, second: Preset | EventKind
) -> Difference:
    return Difference(id, f"{len(first.points)} points", f"{len(second.points)} points", "")


def _kind_state(kind: EventKind | None) -> str:
    return "named" if kind is not None else "default"


def _modes(kind: EventKind) -> str:
    return (
        ", ".join(f"{mode.frequency_hz:g} {mode.decay_ms:g}" for mode in kind.modes) or "no click"
    )
