"""The stimuli of a study: each with its place in the grid, what it is, and how it is rendered."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from overview_dsp import Gesture, Preset, RenderResult, Timeline, Trace, render
from overview_dsp.cli.extensions import AngleMap, Keys, Value
from overview_studies.design import FREE, NOTHING, Design
from overview_studies.file_model import Level

RATE = 48_000
TAIL_S = 3.0
"""A stimulus is rendered on for so long at most."""


@dataclass(frozen=True, eq=False)
class Item:
    """One stimulus.

    Attributes
    ----------
    key : str
        Digest of all that makes it, as `overview batch` names it.
    names : mapping
        Its level of each dimension: timeline, answer, preset, gesture, seed, parameters.
    timeline, preset, gesture, seed
        What `render` takes; the preset with its parameters.
    """

    key: str
    names: Mapping[str, Level]
    parameters: Mapping[str, Value]
    timeline: Timeline
    preset: Preset
    gesture: Gesture
    seed: int

    @property
    def free(self) -> bool:
        """Whether the hand is the person's own."""
        return self.names["gesture"] == FREE

    @property
    def nothing(self) -> bool:
        """Whether it is a catch trial's."""
        return self.names["timeline"] == NOTHING

    def fits(self, levels: Mapping[str, Level]) -> bool:
        """Whether it has these levels of what it has at all."""
        return all(
            self.names[name] == level for name, level in levels.items() if name in self.names
        )

    def places(self, target: str | None) -> list[float]:
        """Where its events are (of one kind, if `target` says so), 0 to 1."""
        events = zip(self.angle_map.events.tolist(), self.timeline.events, strict=True)
        return [place for place, event in events if target is None or event.kind == target]

    def curve(self, points: int) -> NDArray[np.float64]:
        """The curve of the timeline at so many even places, 0 to 1."""
        levels = self.angle_map.at_even_positions(self.timeline.normalised_levels(points - 1))
        return np.where(np.isfinite(levels), levels, 0.0)

    @property
    def angle_map(self) -> AngleMap:
        """The map between its times and places."""
        return AngleMap.of(self.timeline, self.preset)

    def rendered(self, gesture: Gesture | None = None, rate: int = RATE) -> RenderResult[Trace]:
        """What is felt: of its own gesture, or of a take."""
        hand = gesture or self.gesture
        return render(self.timeline, self.preset, hand, rate, self.seed, tail=TAIL_S)


def items_of(design: Design) -> list[Item]:
    """Every stimulus, in the grid's order."""
    grid = design.grid
    keys = Keys(grid)
    timelines, presets = list(grid.timelines), list(grid.presets)
    gestures = list(grid.gestures)

    @cache
    def preset(index: int, values: tuple[Value, ...]) -> Preset:
        found = grid.presets[presets[index]]
        for id, value in zip(grid.parameters, values, strict=True):
            found = found.with_value(id, value)
        return found

    found = []
    for index in range(len(grid)):
        case = grid.case(index)
        name, hand = timelines[case.timeline], gestures[case.gesture]
        parameters = dict(zip(grid.parameters, case.values, strict=True))
        names: dict[str, Level] = {
            "timeline": name,
            "answer": design.answers[name],
            "preset": presets[case.preset],
            "gesture": hand,
            "seed": case.seed,
            **{id: value for id, value in parameters.items() if not isinstance(value, bool)},
        }
        found.append(
            Item(
                keys.key(case),
                names,
                parameters,
                grid.timelines[name],
                preset(case.preset, case.values),
                grid.gestures[hand],
                case.seed,
            )
        )
    return found


def samples_sha256(samples: NDArray[np.float32]) -> str:
    """Of a render's samples, float32 (frames, 2), little-endian."""
    return hashlib.sha256(np.ascontiguousarray(samples, "<f4").tobytes()).hexdigest()
