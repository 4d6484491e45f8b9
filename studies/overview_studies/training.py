"""Training phase of a study: the lesson about its kinds, with a criterion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from overview_dsp.cli.extensions import Keys
from overview_dsp.errors import InputError
from overview_studies.design import Design
from overview_studies.lesson import MAX_TAUGHT_KINDS, Example, Lesson, lesson_of

GESTURE = "lesson"
"""Name of the gestures of training stimuli."""


def training_of(design: Design) -> Lesson | None:
    """Return the lesson of a study; None if it has no training.

    Raises
    ------
    InputError
        The task or the stimuli do not allow a lesson.
    """
    if design.file.training is None:
        return None
    task, presets = design.file.task, list(design.grid.presets.values())
    if task.name != "identify" or task.of != "answer":
        raise InputError(f"{design.path}: training: only an identify task of kinds has a lesson")
    if len(presets) > 1:
        raise InputError(f"{design.path}: training: a lesson requires one preset")
    kinds = [str(kind) for kind in design.dimension("answer")]
    unknown = [kind for kind in kinds if kind not in presets[0].kinds]
    if unknown or len(kinds) > MAX_TAUGHT_KINDS:
        why = f"{unknown[0]!r} is not a kind of the preset" if unknown else f"{len(kinds)} kinds"
        raise InputError(
            f"{design.path}: training: {why}; a lesson has at most {MAX_TAUGHT_KINDS} kinds, all "
            "of its preset"
        )
    return lesson_of(presets[0], None, design.file.seed, only=kinds)


def keyed_examples(design: Design, lesson: Lesson) -> Iterator[tuple[str, str, Example]]:
    """Yield the key (as in `overview batch`), a name and the example, for each example."""
    name = next(iter(design.grid.presets))
    for number, example in enumerate(lesson.examples, 1):
        grid = replace(
            design.grid,
            timelines={f"example-{number}": example.timeline},
            presets={name: lesson.preset},
            gestures={GESTURE: example.gesture},
            seeds=(design.file.seed,),
            parameters={},
        )
        yield Keys(grid).key(grid.case(0)), f"example-{number}", example
