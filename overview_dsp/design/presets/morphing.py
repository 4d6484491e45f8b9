"""Presets between two presets, and near one: morphing and chance.

Each number moves on its own scale (frequencies, stiffnesses and times by ratio, levels by dB);
choices change half-way. A kind that only one of the two names starts from the other's default.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MODE_PARAMETERS, PARAMETERS
from overview_dsp.errors import InputError, shown
from overview_dsp.kernels.layout import MAX_KINDS

MAX_STEPS = 1000


def morph(first: Preset, second: Preset, steps: int) -> list[Preset]:
    """Make presets from one to the other, both among them.

    Parameters
    ----------
    first, second : Preset
        Where it begins and ends.
    steps : int
        How many, 2 to 1000.

    Returns
    -------
    list of Preset
        The first of them feels like `first`, the last one like `second`.

    Raises
    ------
    InputError
        Fewer or more steps; more kinds together than a preset may have.

    Examples
    --------
    >>> football, heart = ov.load_preset("football"), ov.load_preset("heart")
    >>> _, between, _ = ov.presets.morph(football, heart, steps=3)
    >>> between.title
    'Football to Heart, 50 %'
    """
    validation.instance(first, Preset, "first", "ov.load_preset gives one")
    validation.instance(second, Preset, "second", "ov.load_preset gives one")
    if not 2 <= validation.whole(steps, "steps") <= MAX_STEPS:
        raise InputError(f"{shown(steps)} steps; a morph has 2 to {MAX_STEPS}")
    names = tuple(dict.fromkeys((*first.kinds, *second.kinds)))
    if len(names) > MAX_KINDS:
        raise InputError(f"{len(names)} kinds together; a preset has up to {MAX_KINDS}")
    return [_between(first, second, names, k / (steps - 1), k + 1) for k in range(steps)]


def _between(first: Preset, second: Preset, names: tuple[str, ...], part: float, k: int) -> Preset:
    near = first if part < 0.5 else second
    values = {
        id: _mix(known, first.values[id], second.values[id], part)
        for id, known in PARAMETERS.items()
    }
    kinds = {
        name: _mixed_kind(
            first.kinds[first.kind_for(name) or DEFAULT_KIND],
            second.kinds[second.kind_for(name) or DEFAULT_KIND],
            part,
            near.kinds[name].aliases if name in near.kinds else (),
        )
        for name in names
    }
    title = f"{first.title} to {second.title}, {100.0 * part:.0f} %"
    description = f"{100.0 * (1.0 - part):.0f} % {first.name}, {100.0 * part:.0f} % {second.name}"
    name = f"{first.name}-{second.name}-{k}"
    return Preset(name, title, description, values, kinds, near.tags, near.authors, near.points)


def _mix(known: Parameter, first: Value | None, second: Value | None, part: float) -> Value:
    if isinstance(first, float) and isinstance(second, float):
        if first == second or part == 0.0:
            return first
        if part == 1.0:
            return second
        if known.scale == "log":
            return math.exp(math.log(first) * (1.0 - part) + math.log(second) * part)
        return first * (1.0 - part) + second * part
    chosen = first if part < 0.5 else second
    assert chosen is not None
    return chosen


def _mixed_kind(
    first: EventKind, second: EventKind, part: float, aliases: tuple[str, ...]
) -> EventKind:
    near = first if part < 0.5 else second
    values: dict[str, Any] = {}
    for key, known in KIND_PARAMETERS.items():
        pair = getattr(first, key), getattr(second, key)
        # a width of the other sort can't be mixed: the nearer preset's stays
        values[key] = getattr(near, key) if None in pair else _mix(known, *pair, part)
    modes = _mixed_modes(first.modes, second.modes, part)
    # what was drawn by hand can't be mixed: the nearer preset's stays
    return EventKind(modes=modes, points=near.points, aliases=aliases, **values)


def _mixed_modes(
    first: tuple[ClickMode, ...], second: tuple[ClickMode, ...], part: float
) -> tuple[ClickMode, ...]:
    count = max(len(first), len(second))
    found = []
    for i in range(count):
        one = first[i] if i < len(first) else None
        other = second[i] if i < len(second) else None
        # a mode that one of them lacks fades
        quiet = MODE_PARAMETERS["gain_db"].low
        pair = one or replace(other, gain_db=quiet), other or replace(one, gain_db=quiet)  # type: ignore[type-var]
        mixed = {
            key: _mix(known, getattr(pair[0], key), getattr(pair[1], key), part)
            for key, known in MODE_PARAMETERS.items()
        }
        if mixed["gain_db"] != quiet:
            found.append(ClickMode(**mixed))  # type: ignore[arg-type]
    return tuple(found)


def randomize(preset: Preset, seed: int, amount: float = 0.3) -> Preset:
    """Make a preset near another one, by chance.

    Parameters
    ----------
    preset : Preset
        Which one.
    seed : int
        The same seed gives the same preset.
    amount : float
        How far values go: a part of the way to a value drawn from all of their range, 0 to 1.
        Levels, mutes and the carrier stay.

    Returns
    -------
    Preset
        Called `NAME-SEED`.

    Raises
    ------
    InputError
        An amount out of range.

    Examples
    --------
    >>> ov.presets.randomize(ov.load_preset("football"), seed=7).name
    'football-7'
    """
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    amount = validation.real(amount, "amount")
    # written so that NaN fails
    if not 0.0 <= amount <= 1.0:
        raise InputError(f"amount {amount:g} is out of range; it is 0 to 1")
    random = validation.random(seed)
    values: dict[str, Value] = dict(preset.values)
    for id, known in PARAMETERS.items():
        if not known.choices and not _kept(id):
            values[id] = _moved(known, preset.number(id), amount, random)
    kinds = {}
    for name, kind in preset.kinds.items():
        changes: dict[str, Any] = {
            key: _moved(known, value, amount, random)
            for key, known in KIND_PARAMETERS.items()
            if isinstance(value := getattr(kind, key), float) and key in _KIND_MOVES
        }
        modes = tuple(
            replace(
                mode,
                frequency_hz=_moved(
                    MODE_PARAMETERS["frequency_hz"], mode.frequency_hz, amount / 2.0, random
                ),
                decay_ms=_moved(MODE_PARAMETERS["decay_ms"], mode.decay_ms, amount / 2.0, random),
            )
            for mode in kind.modes
        )
        kinds[name] = replace(kind, modes=modes, **changes)
    return Preset(
        f"{preset.name}-{seed}",
        f"{preset.title}, by chance {seed}",
        f"{preset.name} with every value moved by chance (seed {seed}, amount {amount:g})",
        values,
        kinds,
        preset.tags,
        preset.authors,
        preset.points,
    )


_KIND_MOVES = ("height", "width_percent", "width_ms")


def _kept(id: str) -> bool:
    return id.endswith("gain_db") or id in ("output.ceiling_db", "tactor.frequency_hz")


def _moved(known: Parameter, value: float, amount: float, random: np.random.Generator) -> float:
    """A value part of the way to one drawn from its range; from around it where that is huge."""
    low, high = known.low, known.high
    if known.scale == "log":
        # two decades at most: the ends of some ranges are limits of arithmetic, not of taste
        low, high = max(low, value / 10.0), min(high, value * 10.0)
        drawn = math.exp(random.uniform(math.log(low), math.log(high)))
        moved = math.exp(math.log(value) * (1.0 - amount) + math.log(drawn) * amount)
    else:
        low, high = max(low, value - max(abs(value), 1.0)), min(high, value + max(abs(value), 1.0))
        moved = value * (1.0 - amount) + random.uniform(low, high) * amount
    return min(max(moved, known.low), known.high)
