"""Cache keys of cases: the same inputs give the same key on every machine.

A changed file, value or program version gives another key.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from overview_dsp import __version__
from overview_dsp.batch.grid import Case, RenderGrid
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.sources import sources_digest

KEY_DIGITS = 24

PROGRAM = f"{__version__}+{sources_digest()}"
"""Version of this program and of its kernels, which determine the samples."""


def digest(*values: Any) -> str:
    """Return the hexadecimal digest of the content of plain values, arrays and dataclasses."""
    result = hashlib.sha256()
    for value in values:
        _update(result, value)
    return result.hexdigest()


def _update(result: Any, value: Any) -> None:
    if isinstance(value, np.ndarray):
        result.update(f"array{value.dtype.str}{value.shape}".encode())
        result.update(np.ascontiguousarray(value).data)
    elif is_dataclass(value):
        result.update(type(value).__name__.encode())
        for part in fields(value):
            if part.init:
                _update(result, getattr(value, part.name))
    elif isinstance(value, Mapping):
        result.update(f"mapping{len(value)}".encode())
        for key in value:
            _update(result, key)
            _update(result, value[key])
    elif isinstance(value, tuple | list):
        result.update(f"list{len(value)}".encode())
        for item in value:
            _update(result, item)
    elif value is None or isinstance(value, bool | int | float | str):
        text = repr(value).encode()
        result.update(f"{len(text)}:".encode() + text)
    else:
        raise TypeError(f"no digest of a {type(value).__name__}")


def preset_digest(preset: Preset) -> str:
    """Return the digest of a preset without `follow`, which doesn't change a render."""
    values = {id: value for id, value in preset.values.items() if not id.startswith("follow.")}
    return digest(values, preset.kinds)


class Keys:
    """Cache keys of the cases of a render grid."""

    def __init__(self, grid: RenderGrid) -> None:
        """Compute the digests of the inputs, once."""
        self._timelines = [  # without their texts (title, provenance, notes)
            digest(one.duration_s, one.events, one.details, one.intensity, one.gaps)
            for one in grid.timelines.values()
        ]
        self._presets = [preset_digest(preset) for preset in grid.presets.values()]
        self._gestures = [digest(gesture) for gesture in grid.gestures.values()]
        self._ids = tuple(grid.parameters)
        self._common = digest(PROGRAM, grid.settings)
        self._before_seed: dict[Any, Any] = {}

    def key(self, case: Case) -> str:
        """Return the key of a case, `KEY_DIGITS` hexadecimal digits: the name of its file."""
        parts = (case.timeline, case.preset, case.gesture, case.values)
        # seeds change fastest: the digest of all other parts is reused
        if parts not in self._before_seed:
            result = hashlib.sha256()
            _update(result, self._common)
            _update(result, self._timelines[case.timeline])
            _update(result, self._presets[case.preset])
            _update(result, self._gestures[case.gesture])
            _update(result, sorted(zip(self._ids, case.values, strict=True)))
            self._before_seed = {parts: result}
        result = self._before_seed[parts].copy()
        _update(result, case.seed)
        return str(result.hexdigest())[:KEY_DIGITS]
