"""Interpolation between two presets, and random variation of one.

Each number is interpolated on its own scale (frequencies, stiffnesses and times by ratio, levels by
dB). Choices change half-way. A kind of only one preset is interpolated with the default of the
other.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MODE_PARAMETERS, PARAMETERS
from overview_dsp.errors import InputError, quoted
from overview_dsp.kernels.layout import MAX_KINDS

MAX_STEPS = 1000


def morph(first: Preset, second: Preset, steps: int) -> list[Preset]:
    """Interpolate presets from one to another, including both.

    Parameters
    ----------
    first, second : Preset
        First and last preset.
    steps : int
        Number of presets, 2 to 1000.

    Returns
    -------
    list of Preset
        Presets from one that feels like `first` to one that feels like `second`.

    Raises
    ------
    InputError
        The number of steps is out of range, or both have too many kinds together.

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
        raise InputError(f"steps is {quoted(steps)}; must be 2 to {MAX_STEPS}")
    names = tuple(dict.fromkeys((*first.kinds, *second.kinds)))
    if len(names) > MAX_KINDS:
        raise InputError(f"both have {len(names)} kinds together; must be at most {MAX_KINDS}")
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
        # widths in percent and in ms cannot be mixed: the nearer preset's is used
        values[key] = getattr(near, key) if None in pair else _mix(known, *pair, part)
    modes = _mixed_modes(first.modes, second.modes, part)
    # points cannot be mixed: the nearer preset's are used
    return EventKind(modes=modes, points=near.points, aliases=aliases, **values)


def _mixed_modes(
    first: tuple[ClickMode, ...], second: tuple[ClickMode, ...], part: float
) -> tuple[ClickMode, ...]:
    found = []
    for one, other in itertools.zip_longest(first, second):
        # a mode of only one preset fades
        quiet = MODE_PARAMETERS["gain_db"].low
        pair = one or replace(other, gain_db=quiet), other or replace(one, gain_db=quiet)
        mixed = {
            key: _mix(known, getattr(pair[0], key), getattr(pair[1], key), part)
            for key, known in MODE_PARAMETERS.items()
        }
        if mixed["gain_db"] != quiet:
            found.append(ClickMode(**mixed))  # type: ignore[arg-type]
    return tuple(found)


def randomize(preset: Preset, seed: int, amount: float = 0.3) -> Preset:
    """Make a random variation of a preset.

    Parameters
    ----------
    preset : Preset
        Preset to vary.
    seed : int
        Random seed; the same seed gives the same preset.
    amount : float
        Share of the distance to a random value of the range, 0 to 1. Levels, mutes and the carrier
        do not change.

    Returns
    -------
    Preset
        Preset of the name `NAME-SEED`.

    Raises
    ------
    InputError
        The amount is out of range.

    Examples
    --------
    >>> ov.presets.randomize(ov.load_preset("football"), seed=7).name
    'football-7'
    """
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    amount = validation.within(amount, "amount", 0.0, 1.0)
    random = validation.random(seed)
    values: dict[str, Value] = dict(preset.values)
    for id, known in PARAMETERS.items():
        fixed = id.endswith("gain_db") or id in ("output.ceiling_db", "tactor.frequency_hz")
        if not known.choices and not fixed:
            values[id] = _moved(known, preset.number(id), amount, random)
    kinds = {}
    for name, kind in preset.kinds.items():
        changes: dict[str, Any] = {
            key: _moved(known, value, amount, random)
            for key, known in KIND_PARAMETERS.items()
            if isinstance(value := getattr(kind, key), float) and key in _VARIED_KIND_KEYS
        }
        modes = []
        for mode in kind.modes:
            moved = {
                key: _moved(MODE_PARAMETERS[key], getattr(mode, key), amount / 2.0, random)
                for key in ("frequency_hz", "decay_ms")
            }
            modes.append(replace(mode, **moved))
        kinds[name] = replace(kind, modes=tuple(modes), **changes)
    return replace(
        preset,
        name=f"{preset.name}-{seed}",
        title=f"{preset.title}, variation {seed}",
        description=f"{preset.name} with random changes of all values (seed {seed}, "
        f"amount {amount:g})",
        values=values,
        kinds=kinds,
    )


_VARIED_KIND_KEYS = ("height", "width_percent", "width_ms")


def _moved(known: Parameter, value: float, amount: float, random: np.random.Generator) -> float:
    """Return a value moved towards a random one of its range, or near it for a large range."""
    low, high = known.low, known.high
    if known.scale == "log":
        # two decades at most, since some ranges are limited only by arithmetic
        low, high = max(low, value / 10.0), min(high, value * 10.0)
        drawn = math.exp(random.uniform(math.log(low), math.log(high)))
        moved = math.exp(math.log(value) * (1.0 - amount) + math.log(drawn) * amount)
    else:
        low, high = max(low, value - max(abs(value), 1.0)), min(high, value + max(abs(value), 1.0))
        moved = value * (1.0 - amount) + random.uniform(low, high) * amount
    return min(max(moved, known.low), known.high)
