"""A preset's parameters into the memory block, and the coefficients the kernels make of them.

Say so, once, before kernels are compiled: the first use on a machine takes a while.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import is_compiled
from overview_dsp.kernels.derive import CARRIER_LIMIT, derive
from overview_dsp.kernels.precompiled import is_outdated

_CHOSEN = {"disk.release": "return"}
"""Of a parameter with two choices, the one that counts as 1."""

_COLUMN_OF = {
    id: column
    for id in PARAMETERS
    if (column := getattr(layout, f"PARAM_{id.upper().replace('.', '_')}", None)) is not None
}
"""The column of each parameter that is not the surface's or an input's, by id."""

KERNEL_RANGES = {
    id: (known.low, known.high) if isinstance(known.default, float) else (0.0, 1.0)
    for id in sorted(_COLUMN_OF, key=lambda id: _COLUMN_OF[id])
    for known in [PARAMETERS[id]]
}
"""Lowest and highest number of each of these parameters, in the order of the columns."""

_COEFFICIENTS = range(layout.C_SPRING_HELD, layout.C_RECOIL_EXPONENT + 1)


def write_parameters(memory: NDArray[np.float64], preset: Preset) -> None:
    """Put a preset's parameters into their columns; the surface has its own."""
    values = preset.values
    for id, column in _COLUMN_OF.items():
        chosen = _CHOSEN.get(id)
        memory[column] = float(values[id] if chosen is None else values[id] == chosen)


def coefficients(preset: Preset, sample_rate: float) -> dict[int, float]:
    """Every gliding coefficient, by its column in the memory block."""
    scratch = np.zeros(layout.SET_UP)
    write_parameters(scratch, preset)
    scratch[layout.S_SAMPLE_RATE] = sample_rate
    derive(scratch, scratch.view(np.int64))
    return {column: float(scratch[column]) for column in _COEFFICIENTS}


def changes(before: Preset, after: Preset, sample_rate: float) -> list[tuple[int, float]]:
    """The changes that take the kernel from one preset's parameters to another's.

    Pairs of what (a gliding coefficient or a command of `kernels.layout`) and value; the surface
    isn't among them.
    """
    old = coefficients(before, sample_rate)
    new = coefficients(after, sample_rate)
    changed = [(column, target) for column, target in new.items() if target != old[column]]
    returns = after.values["disk.release"] == "return"
    if returns != (before.values["disk.release"] == "return"):
        changed.append((layout.COMMAND_RELEASE_RETURNS, float(returns)))
    return changed


def ask(memory: NDArray[np.float64], preset: Preset, changed: Sequence[tuple[int, float]]) -> None:
    """Book a preset in the block, whose `changes` are about to be pushed."""
    write_parameters(memory, preset)
    for what, value in changed:
        if what >= 0:
            memory[layout.ASKED + what] = value
    memory.view(np.int64)[layout.ASKED_RETURNS] = preset.values["disk.release"] == "return"


def check_carrier(preset: Preset, sample_rate: float) -> None:
    """InputError if the tactor's carrier is too high for a sample rate (Hz)."""
    frequency = preset.number("tactor.frequency_hz")
    if not frequency < CARRIER_LIMIT * sample_rate:
        raise InputError(
            f"tactor.frequency_hz = {frequency:g} is too high for {sample_rate:g} Hz; "
            f"it must stay below {CARRIER_LIMIT * sample_rate:g} Hz"
        )


_announced: set[str] = set()


def announce_compile(*kernels: str) -> None:
    """A line on stderr if the first use of kernels (by name) on this machine will compile them."""
    new = set(kernels) - _announced
    if all(is_compiled(kernel) for kernel in new):
        return
    _announced.update(new)
    why = ", as its sources have changed (see tools/build_kernels.py)" if is_outdated() else ""
    print(f"compiling the engine for this machine (once, 10 to 40 s){why} ...", file=sys.stderr)
