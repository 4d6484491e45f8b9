"""Stimuli of a study, with their levels in the grid."""

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
from overview_studies.training import GESTURE, keyed_examples, training_of

RATE = 48_000
TAIL_S = 3.0
"""Maximum duration of a stimulus after its gesture."""


@dataclass(frozen=True, eq=False)
class Stimulus:
    """One stimulus.

    Attributes
    ----------
    key : str
        Digest of all its inputs, as in `overview batch`.
    names : mapping
        Its level of each dimension: timeline, answer, preset, gesture, seed, parameters.
    timeline, preset, gesture, seed
        Inputs of `render`; the preset includes the parameters.
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
        """True if the participant makes the movement."""
        return self.names["gesture"] == FREE

    @property
    def is_catch(self) -> bool:
        """True if it is the stimulus of catch trials, without events."""
        return self.names["timeline"] == NOTHING

    @property
    def is_training(self) -> bool:
        """True if it is an example of the training, which no condition has."""
        return self.names["gesture"] == GESTURE

    def matches(self, levels: Mapping[str, Level]) -> bool:
        """Return whether it has these levels; dimensions that it does not have are ignored."""
        return all(
            self.names[name] == level for name, level in levels.items() if name in self.names
        )

    def positions(self, target: str | None) -> list[float]:
        """Return the positions of its events, 0 to 1; `target` selects one kind."""
        events = zip(self.angle_map.events.tolist(), self.timeline.events, strict=True)
        return [position for position, event in events if target is None or event.kind == target]

    def curve(self, points: int) -> NDArray[np.float64]:
        """Return the intensity curve at `points` evenly spaced positions, 0 to 1."""
        levels = self.angle_map.at_even_positions(self.timeline.normalised_levels(points - 1))
        return np.where(np.isfinite(levels), levels, 0.0)

    @property
    def angle_map(self) -> AngleMap:
        """Map between its times and positions."""
        return AngleMap.of(self.timeline, self.preset)

    def render_stimulus(
        self, gesture: Gesture | None = None, rate: int = RATE
    ) -> RenderResult[Trace]:
        """Render its gesture, or a take."""
        gesture = gesture or self.gesture
        return render(self.timeline, self.preset, gesture, rate, self.seed, tail=TAIL_S)


def stimuli_of(design: Design) -> list[Stimulus]:
    """Return all stimuli of a design: those of its training, then the others in grid order."""
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

    found = _training_stimuli(design)
    for index in range(len(grid)):
        case = grid.case(index)
        name, gesture = timelines[case.timeline], gestures[case.gesture]
        parameters = dict(zip(grid.parameters, case.values, strict=True))
        names: dict[str, Level] = {
            "timeline": name,
            "answer": design.answers[name],
            "preset": presets[case.preset],
            "gesture": gesture,
            "seed": case.seed,
            **{id: value for id, value in parameters.items() if not isinstance(value, bool)},
        }
        found.append(
            Stimulus(
                keys.key(case),
                names,
                parameters,
                grid.timelines[name],
                preset(case.preset, case.values),
                grid.gestures[gesture],
                case.seed,
            )
        )
    return found


def _training_stimuli(design: Design) -> list[Stimulus]:
    """Return the stimuli of the training, in the order of the examples of its lesson."""
    lesson = training_of(design)
    if lesson is None:
        return []
    preset, seed = next(iter(design.grid.presets)), design.file.seed
    return [
        Stimulus(
            key,
            {"timeline": name, "answer": example.kinds[0], "preset": preset, "gesture": GESTURE,
             "seed": seed},
            {},
            example.timeline,
            lesson.preset,
            example.gesture,
            seed,
        )
        for key, name, example in keyed_examples(design, lesson)
    ]  # fmt: skip


def samples_sha256(samples: NDArray[np.float32]) -> str:
    """Return the SHA-256 of samples, float32 (frames, 2), little-endian."""
    return hashlib.sha256(np.ascontiguousarray(samples, "<f4").tobytes()).hexdigest()
