"""Lesson about the feel of a preset: examples with their names, then ten questions.

The steps follow published work on learning haptic icons: each kind alone with its name, then in
pairs that are easily confused, then among other events, with a reference just before each.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree

from overview_dsp import (
    Event,
    EventKind,
    Gesture,
    Preset,
    Timeline,
    load_preset,
    load_timeline,
    measure,
    sweep,
)
from overview_dsp.errors import InputError
from overview_studies.counterbalancing import RandomStream, shuffled_blocks
from overview_studies.design import ANGLE_MAP

PARTS = ("alone", "pair", "crowd", "question")
QUESTIONS = 10
MAX_TAUGHT_KINDS = 7

PASS_S = 2.5
"""Duration of a sweep over a whole timeline, s; all examples move at its speed."""

TAIL_S = 0.5
"""Time after the movement, s, in which the disk arrives and clicks decay."""

MATCH, MATCH_KIND = "world-cup-final-2018", "goal"
"""Timeline of presets that have this kind."""

DURATION_S = 5400.0
"""Duration of a timeline without data, s."""

PRESS_S = 2.0
"""Estimated time of a press or an answer, s."""

FEATURE_RATE = 16_000
JNDS = (2.3, math.log(2.0), math.log(1.25), 2.0, math.log(1.25))
"""Just noticeable differences of the features: level (dB), sharpness, duration, click (dB), pitch.

Those of touch are the ones of `overview presets compare`; those of hearing are far above the
threshold of an ear.
"""

_ALONE_END, _ALONE_AT = 0.4, 0.25
_SPREAD = 0.06
_PAIR_END, _PAIR_AT = 0.6, (0.2, 0.42)
_CROWD_OTHERS = (3, 2)
_MIN_GAP = 0.06
_MARGIN = 0.08
_LEAST_DB, _LEAST_MS, _LEAST_SHARPNESS = -90.0, 10.0, 1e-3


@dataclass(frozen=True, eq=False)
class Example:
    """One example, which is played once.

    Attributes
    ----------
    kinds : tuple of str
        Kinds of its events, in the order in which they are felt.
    caption : str
    timeline, gesture
        Inputs of `render`; the gesture ends without a release, so that nothing is felt twice.
    """

    kinds: tuple[str, ...]
    caption: str
    timeline: Timeline
    gesture: Gesture

    @property
    def duration_s(self) -> float:
        """Duration with its tail, s."""
        return self.gesture.duration_s + TAIL_S


@dataclass(frozen=True, eq=False)
class Step:
    """One step: examples in order; a question has one example, and `kind` is its answer."""

    part: str
    kind: str
    text: str
    examples: tuple[Example, ...]


@dataclass(frozen=True, eq=False)
class Lesson:
    """A lesson.

    Attributes
    ----------
    name, title : str
        Name and title of the preset.
    preset : Preset
        Preset with evenly spaced positions.
    kinds : tuple of str
        All kinds that are taught, strongest first.
    same : dict
        Kinds that feel the same as another one, which is the value; no question has them.
    steps : tuple of Step
        Steps of the examples, in order.
    questions : tuple of Step
    references : dict
        The example of each kind alone.
    seed : int
    """

    name: str
    title: str
    preset: Preset
    kinds: tuple[str, ...]
    same: dict[str, str]
    steps: tuple[Step, ...]
    questions: tuple[Step, ...]
    references: dict[str, Example]
    seed: int

    @property
    def choices(self) -> tuple[str, ...]:
        """Kinds that the questions offer, strongest first."""
        return tuple(kind for kind in self.kinds if kind not in self.same)

    @property
    def examples(self) -> tuple[Example, ...]:
        """All examples, each once: references, then those of the steps and questions."""
        every = [*self.references.values()]
        every += [one for step in (*self.steps, *self.questions) for one in step.examples]
        return tuple({id(one): one for one in every}.values())

    @property
    def digest(self) -> str:
        """Digest of the steps, by which stored progress is recognised."""
        rows = [[one.part, one.kind, one.text] for one in (*self.steps, *self.questions)]
        return hashlib.sha256(json.dumps([self.seed, *rows]).encode()).hexdigest()[:16]

    @property
    def duration_s(self) -> float:
        """Duration of all sounds, s."""
        return sum(
            example.duration_s
            for step in (*self.steps, *self.questions)
            for example in step.examples
        )

    @property
    def minutes(self) -> int:
        """Estimated duration in whole minutes: the sounds, and the time for keys and answers."""
        pressed = len(self.steps) + 2 * len(self.questions)
        return max(1, round((self.duration_s + PRESS_S * pressed) / 60.0))


def label(kind: str) -> str:
    """Return the name of a kind as text."""
    return kind.replace("_", " ")


def make_lesson(preset: str, timeline: str | None = None, seed: int = 0) -> Lesson:
    """Make the lesson of a preset (name or file); the same arguments give the same lesson.

    Raises
    ------
    InputError
        The preset or the timeline cannot be loaded, or fewer than two kinds can be told apart.
    """
    loaded = load_preset(preset)
    if timeline is None and MATCH_KIND in loaded.kinds:
        timeline = MATCH
    return lesson_of(loaded, None if timeline is None else load_timeline(timeline), seed, preset)


def lesson_of(
    preset: Preset,
    data: Timeline | None,
    seed: int,
    name: str = "",
    only: Sequence[str] | None = None,
) -> Lesson:
    """Make the lesson of a loaded preset, with the data from which crowds are taken; see above.

    `only` are the kinds to teach; None for those of the data, then others.
    """
    preset = preset.with_value(ANGLE_MAP, 0.0)
    duration = DURATION_S if data is None else data.duration_s
    named = [kind for kind in only or preset.kinds if kind != "default"]
    if len(named) < 2:
        raise InputError(f"preset {preset.name} has {len(named)} kinds; a lesson needs at least 2")
    every = {kind: _alone(kind, duration, _ALONE_AT) for kind in named}
    features = dict(
        zip(named, (one[0] for one in measured(preset, [*every.values()])), strict=True)
    )
    present = set() if data is None else {preset.kind_for(event.kind) for event in data.events}
    strength = sorted(named, key=lambda kind: -features[kind][0])
    taught = sorted(strength, key=lambda kind: kind not in present)[:MAX_TAUGHT_KINDS]
    kinds = tuple(kind for kind in strength if kind in taught)
    same = _same(kinds, features)
    asked = [kind for kind in kinds if kind not in same]
    if len(asked) < 2:
        raise InputError(f"preset {preset.name}: its kinds all feel the same; none can be taught")
    stream = RandomStream(seed, "lesson", *kinds)
    references = {kind: every[kind] for kind in kinds}
    steps = [_step_alone(kind, same, references) for kind in kinds]
    for first, second in _pairs(asked, features):
        both = _several((first, second), _PAIR_AT, duration, _PAIR_END)
        texts = (references[first], references[second], both)
        steps.append(Step("pair", first, both.caption, texts))
    for kind in asked:
        crowd = _real_crowd(preset, data, kind) or _synthetic_crowd(kind, asked, duration, stream)
        place = 1 + crowd.kinds.index(kind)
        text = f"{label(kind)} among others: number {place} of {len(crowd.kinds)}"
        steps.append(Step("crowd", kind, text, (references[kind], crowd)))
    questions = tuple(
        Step("question", kind, "Which was it?", (_alone(kind, duration, at),))
        for kind, at in _questions(asked, stream)
    )
    return Lesson(name or preset.name, preset.title, preset, kinds, same, tuple(steps), questions,
                  references, seed)  # fmt: skip


def measured(preset: Preset, examples: Sequence[Example]) -> list[NDArray[np.float64]]:
    """Return the features of each event of each example, in JNDs: float64 (events, 5)."""
    groups: dict[int, list[int]] = {}
    for i, example in enumerate(examples):
        groups.setdefault(len(example.gesture.time_s), []).append(i)
    rows: dict[int, NDArray[np.float64]] = {}
    for members in groups.values():
        gesture = {"lesson": examples[members[0]].gesture}
        timelines = [examples[i].timeline for i in members]
        tables = measure.felt_events(preset, timelines, gesture, FEATURE_RATE, TAIL_S)
        forth = [table for table in tables if table.name == "lesson"]
        for i, table in zip(members, forth, strict=True):
            pitch = [_pitch(preset.kinds[kind]) for kind in table.kind]
            columns = (
                np.fmax(table.level_db, _LEAST_DB),
                np.log(np.fmax(table.sharpness, _LEAST_SHARPNESS)),
                np.log(np.fmax(table.duration_ms, _LEAST_MS)),
                np.fmax(table.click_db, _LEAST_DB),
                np.log(pitch),
            )
            rows[i] = np.column_stack(columns) / np.array(JNDS)
    return [rows[i] for i in range(len(examples))]


def _pitch(kind: EventKind) -> float:
    """Return the centre of a click's modes, weighted by their sound, Hz."""
    weights = [10.0 ** (mode.gain_db / 20.0) * mode.decay_ms for mode in kind.modes]
    if not weights:
        return kind.pitch_hz
    sounds = (weight * mode.frequency_hz for weight, mode in zip(weights, kind.modes, strict=True))
    return float(sum(sounds) / sum(weights))


def _same(kinds: Sequence[str], features: dict[str, NDArray[np.float64]]) -> dict[str, str]:
    """Return the kinds that differ by less than one JND from a stronger one, with that one."""
    found: dict[str, str] = {}
    for i, kind in enumerate(kinds):
        for other in kinds[:i]:
            if other not in found and _distance(features[kind], features[other]) < 1.0:
                found[kind] = other
                break
    return found


def _distance(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    return float(np.max(np.abs(first - second)))


def _pairs(kinds: Sequence[str], features: dict[str, NDArray[np.float64]]) -> list[tuple[str, str]]:
    """Return the nearest pairs that connect all kinds, the most different first."""
    table = np.array([[_distance(features[a], features[b]) for b in kinds] for a in kinds])
    tree = minimum_spanning_tree(table).toarray()
    found = sorted(((-tree[i, j], min(i, j), max(i, j)) for i, j in np.argwhere(tree)))
    return [(kinds[i], kinds[j]) for _, i, j in found]


def _questions(kinds: Sequence[str], stream: RandomStream) -> list[tuple[str, float]]:
    """Return kind and position of each question; each kind occurs equally often, or once more."""
    repeats = math.ceil(QUESTIONS / len(kinds))
    blocks = shuffled_blocks(kinds, repeats, stream)
    order = [kind for block in blocks for kind in block][:QUESTIONS]
    spread = ((_ALONE_AT + stream.uniform(-_SPREAD, _SPREAD)) for _ in order)
    return [(kind, round(at, 4)) for kind, at in zip(order, spread, strict=True)]


def _movement(end: float) -> Gesture:
    """Return a movement from the start to a position, without a release."""
    whole = sweep(PASS_S * end, 0.0, end)
    held = whole.touching
    return Gesture(whole.time_s[held], whole.theta2[held], held[held], whole.duration_s)


def _several(
    kinds: Sequence[str], positions: Sequence[float], duration: float, end: float
) -> Example:
    events = tuple(Event(at * duration, kind) for kind, at in zip(kinds, positions, strict=True))
    caption = ", then ".join(map(label, kinds))
    timeline = Timeline(caption, duration, events, provenance="example of a lesson")
    return Example(tuple(kinds), caption, timeline, _movement(end))


def _alone(kind: str, duration: float, at: float) -> Example:
    return _several((kind,), (at,), duration, _ALONE_END)


def _step_alone(kind: str, same: dict[str, str], references: dict[str, Example]) -> Step:
    text = label(kind)
    examples: tuple[Example, ...] = (references[kind],)
    if kind in same:
        text += f": feels the same as {label(same[kind])}, and no question has it"
        examples = (references[same[kind]], references[kind])
    return Step("alone", kind, text, examples)


def _real_crowd(preset: Preset, data: Timeline | None, kind: str) -> Example | None:
    """Return the part of the data where the kind occurs once among others that are well apart."""
    events = [] if data is None else [(e.time_s, preset.kind_for(e.kind)) for e in data.events]
    for others in _CROWD_OTHERS:
        best: tuple[float, int] | None = None
        for first in range(len(events) - others):
            part = events[first : first + others + 1]
            names = [name for _, name in part]
            times = np.array([time for time, _ in part])
            length = (times[-1] - times[0]) / (1.0 - 2.0 * _MARGIN)
            outside = data is None or times[0] < _MARGIN * length or (
                times[0] + (1.0 - _MARGIN) * length > data.duration_s)  # fmt: skip
            if names.count(kind) != 1 or None in names or length <= 0.0 or outside:
                continue
            gap = float(np.min(np.diff(times))) / length
            if gap >= _MIN_GAP and (best is None or gap > best[0]):
                best = gap, first
        if best is not None and data is not None:
            part = events[best[1] : best[1] + others + 1]
            length = (part[-1][0] - part[0][0]) / (1.0 - 2.0 * _MARGIN)
            start = part[0][0] - _MARGIN * length
            return _crowd(data, start, length, [(time, str(name)) for time, name in part])
    return None


def _crowd(data: Timeline, start: float, length: float, part: list[tuple[float, str]]) -> Example:
    window = data.window(start, start + length)
    events = tuple(Event(time - start, name) for time, name in part)
    kinds = tuple(name for _, name in part)
    caption = ", ".join(map(label, kinds))
    timeline = Timeline(
        caption, window.duration_s, events, window.intensity, provenance=data.provenance
    )
    return Example(kinds, caption, timeline, _movement(1.0))


def _synthetic_crowd(
    kind: str, kinds: Sequence[str], duration: float, stream: RandomStream
) -> Example:
    others = [other for other in stream.shuffled(kinds) if other != kind] * _CROWD_OTHERS[0]
    others = others[: _CROWD_OTHERS[0]]
    at = stream.below(len(others) + 1)
    names = [*others[:at], kind, *others[at:]]
    room = (1.0 - 2.0 * _MARGIN) / len(names)
    positions = [_MARGIN + room * (i + stream.uniform(0.25, 0.75)) for i in range(len(names))]
    made = _several(names, positions, duration, 1.0)
    return Example(made.kinds, ", ".join(map(label, names)), made.timeline, made.gesture)
