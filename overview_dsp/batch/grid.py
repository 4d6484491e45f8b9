"""A study: what is combined with what, and the numbering of its cases."""

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
    """What is the same for every case: how long its sound is, and how it is stored."""

    sample_rate: float = 48_000.0
    tail: Tail = "rest"
    format: str = "wav"
    subtype: str | None = None


@dataclass(frozen=True)
class Case:
    """One render of a study: places in its lists, the values of its parameters, a seed."""

    index: int
    timeline: int
    preset: int
    gesture: int
    values: tuple[Value, ...]
    seed: int


@dataclass(frozen=True)
class RenderGrid:
    """A grid of renders, and where they go.

    Attributes
    ----------
    out : str
        A folder, or an address of one (`s3://bucket/study`, `memory://study`).
    timelines, presets, gestures : mapping of name to what it names
    parameters : mapping of id to values
        `tactor.gain_db`, `kinds.goal.height`; each is combined with all others.
    seeds : tuple of int
    settings : Settings
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
        """Case `index` of `len(study)`: seeds change fastest, timelines slowest."""
        rest, seed = divmod(index, len(self.seeds))
        places = []
        for size in reversed(self._sizes()):
            rest, place = divmod(rest, size)
            places.append(place)
        timeline, preset, gesture, *chosen = reversed(places)
        values = tuple(
            of[place] for of, place in zip(self.parameters.values(), chosen, strict=True)
        )
        return Case(index, timeline, preset, gesture, values, self.seeds[seed])
