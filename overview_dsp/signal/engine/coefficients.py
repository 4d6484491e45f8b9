"""Kernel coefficients: write a preset's parameters and derive the coefficients from them.

Compiling kernels takes a while on first use, so a message announces it once.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import is_compiled
from overview_dsp.kernels.derive import CARRIER_LIMIT, derive
from overview_dsp.kernels.precompiled import is_outdated

_CHOSEN = {"disk.release": "return"}  # choice that is stored as 1, for parameters with two choices

_COLUMN_OF = {
    id: column
    for id in PARAMETERS
    if (column := getattr(layout, f"PARAM_{id.upper().replace('.', '_')}", None)) is not None
}
"""Memory column of each kernel parameter, by id."""

KERNEL_RANGES = {
    id: (known.low, known.high) if isinstance(known.default, float) else (0.0, 1.0)
    for id in sorted(_COLUMN_OF, key=lambda id: _COLUMN_OF[id])
    for known in [PARAMETERS[id]]
}
"""Range of each kernel parameter, in the order of the columns."""

_COEFFICIENTS = range(layout.C_SPRING_HELD, layout.C_RECOIL_EXPONENT + 1)


def write_parameters(memory: FloatArray, preset: Preset) -> None:
    """Write a preset's kernel parameters to their columns."""
    values = preset.values
    for id, column in _COLUMN_OF.items():
        chosen = _CHOSEN.get(id)
        memory[column] = float(values[id] if chosen is None else values[id] == chosen)


def coefficients(preset: Preset, sample_rate: float) -> dict[int, float]:
    """Return all smoothed coefficients by their column in the memory block."""
    scratch = np.zeros(layout.SET_UP)
    write_parameters(scratch, preset)
    scratch[layout.S_SAMPLE_RATE] = sample_rate
    derive(scratch, scratch.view(np.int64))
    return {column: float(scratch[column]) for column in _COEFFICIENTS}


def changes(before: Preset, after: Preset, sample_rate: float) -> list[tuple[int, float]]:
    """Return the changes from one preset's kernel parameters to another's.

    Each change is a pair of a target (smoothed coefficient or command of `kernels.layout`) and a
    value. The surface is not included.
    """
    old = coefficients(before, sample_rate)
    new = coefficients(after, sample_rate)
    changed = [(column, target) for column, target in new.items() if target != old[column]]
    returns = after.values["disk.release"] == "return"
    if returns != (before.values["disk.release"] == "return"):
        changed.append((layout.COMMAND_RELEASE_RETURNS, float(returns)))
    return changed


def store_requested(
    memory: FloatArray, preset: Preset, changed: Sequence[tuple[int, float]]
) -> None:
    """Store a preset in the block whose `changes` will be pushed next."""
    write_parameters(memory, preset)
    for what, value in changed:
        if what >= 0:
            memory[layout.ASKED + what] = value
    memory.view(np.int64)[layout.ASKED_RETURNS] = preset.values["disk.release"] == "return"


def check_carrier(preset: Preset, sample_rate: float) -> None:
    """Raise InputError if the tactor's carrier is too high for a sample rate (Hz)."""
    frequency = preset.number("tactor.frequency_hz")
    if not frequency < CARRIER_LIMIT * sample_rate:
        raise InputError(
            f"tactor.frequency_hz is {frequency:g}, too high for {sample_rate:g} Hz; "
            f"must be below {CARRIER_LIMIT * sample_rate:g} Hz"
        )


_announced: set[str] = set()


def announce_compile(*kernels: str) -> None:
    """Print a line to stderr if kernels (by name) must be compiled on this machine."""
    new = set(kernels) - _announced
    if all(is_compiled(kernel) for kernel in new):
        return
    _announced.update(new)
    why = ", as its sources have changed (see tools/build_kernels.py)" if is_outdated() else ""
    print(f"compiling the engine for this machine (once, 10 to 40 s){why} ...", file=sys.stderr)
