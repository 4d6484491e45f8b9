"""Render grid: combinations of timelines, presets, gestures, parameters and seeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
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

    def _sizes(self) -> tuple[int, ...]:
        parameters = (len(values) for values in self.parameters.values())
        return (len(self.timelines), len(self.presets), len(self.gestures), *parameters)

    def __len__(self) -> int:
        return math.prod(self._sizes()) * len(self.seeds)

    def case(self, index: int) -> Case:
        """Return case `index` of `len(self)`: seeds change fastest, timelines slowest."""
        rest, seed = divmod(index, len(self.seeds))
        indices = []
        for size in reversed(self._sizes()):
            rest, index_in_list = divmod(rest, size)
            indices.append(index_in_list)
        timeline, preset, gesture, *chosen = reversed(indices)
        values = tuple(
            options[i] for options, i in zip(self.parameters.values(), chosen, strict=True)
        )
        return Case(index, timeline, preset, gesture, values, self.seeds[seed])
