"""Render grid: combinations of timelines, presets, gestures, parameters and seeds.

The same inputs give the same cache key of a case on every machine. A changed file, value or program
version gives another key.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import numpy as np

from overview_dsp import __version__
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import ROUTING, Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.kernels.sources import sources_digest
from overview_dsp.offline.rendering.schedule import Tail


@dataclass(frozen=True)
class Settings:
    """Settings that all cases share: duration and format of the sound files."""

    sample_rate: float = 48_000.0
    tail: Tail = "rest"
    format: str = "wav"
    subtype: str | None = None


@dataclass(frozen=True)
class Case:
    """One render of a grid: indices into its lists, parameter values and a seed."""

    index: int
    timeline: int
    preset: int
    gesture: int
    values: tuple[Value, ...]
    seed: int


@dataclass(frozen=True)
class RenderGrid:
    """A grid of renders, and their folder.

    `out`: a folder, or its URL (`s3://bucket/study`, `memory://study`).
    `timelines`, `presets`, `gestures`: objects by name.
    `parameters`: values by id (`tactor.gain_db`, `kinds.goal.height`), combined with all others.
    """

    out: str
    timelines: Mapping[str, Timeline]
    presets: Mapping[str, Preset]
    gestures: Mapping[str, Gesture]
    parameters: Mapping[str, tuple[Value, ...]] = field(default_factory=dict)
    seeds: tuple[int, ...] = (0,)
    settings: Settings = field(default_factory=Settings)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of timelines, presets, gestures, values of each parameter, and seeds."""
        lists = (self.timelines, self.presets, self.gestures, *self.parameters.values(), self.seeds)
        return tuple(map(len, lists))

    def __len__(self) -> int:
        return math.prod(self.sizes)

    def case(self, index: int) -> Case:
        """Return case `index` of `len(self)`: seeds change fastest, timelines slowest."""
        indices = map(int, np.unravel_index(index, self.sizes))
        timeline, preset, gesture, *chosen, seed = indices
        options = zip(self.parameters.values(), chosen, strict=True)
        values = tuple(several[i] for several, i in options)
        return Case(index, timeline, preset, gesture, values, self.seeds[seed])


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
            if part.init and ROUTING not in part.metadata:
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
    """Return the digest of a preset without `follow` and the choice of tactors.

    They don't change a render with one tactor.
    """
    without = ("follow.", "tactor.routing")
    values = {id: value for id, value in preset.values.items() if not id.startswith(without)}
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
