"""Heights and widths of kinds tuned by search: kinds in an order of strength, or set apart.

The cost is the sum of squared shortfalls, in just noticeable steps, over strokes and timelines.
The start raises each kind by what it lacks above all below it. Then a seeded local search moves a
kind that is in the way, or all of them, a little, and keeps what costs less: first at few speeds,
then at all of them. A preset that has what is wanted stays as it is.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import Gesture, sweep, tap
from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.design.presets.parameters import KIND_PARAMETERS
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.measure.perceived_level import STEP_DB
from overview_dsp.measure.report import KindFeel, feel_report, jnd_distance
from overview_dsp.offline.rendering.audition import SECONDS_EACH, pages

RATE = 16_000.0
"""Hz. The disk and its vibration are the same at any rate; a low one is quick."""

ORDERED_JNDS, SEPARATE_JNDS = 2.0, 1.0
"""Wanted between a kind and the next one of a target; between any two kinds that are set apart."""

REST_STEPS = 1.0
"""Wanted of the last kind above what is no event."""

MORE_STEPS = 0.3
"""So much more is aimed at, so that other speeds than the measured ones hold it too."""

CLEAR_STEPS = 1.8
"""Aimed at above what is no event by kinds set apart, so that the fainter events of a kind are
felt."""

FAULT_STEPS = 2.0
"""What a masked or merged event costs: as a pair of kinds that lack so many steps."""

GOOD = 0.02
"""The search ends at this cost: what is aimed at is all but reached. A target is met once all that
is wanted of it is reached at the last speeds."""

MOST_HEIGHT, MOST_WIDTH = 8.0, 2.0
"""Heights move by up to this ratio, widths by less: a width is a kind's character."""

LOG_PER_DB = 0.19
"""Of a height, as a logarithm, for a dB of level: what compression leaves of it (0.6 dB a dB)."""

TRIES, TRIES_APART = 100, 2000
"""Of the search, at few speeds and again at all of them."""

GUESSES = 3
"""Tries at first that raise each kind of a target by what it lacks above all below it."""

TOGETHER = 0.15
"""Part of the tries that raise or lower all kinds at once."""

SPREAD = (0.3, 0.15)
"""Of a try, in logarithms of the height's and the width's ratio."""

REST = "what is no event"
UNMET = -10.0
"""Steps of a kind that was never met above another one."""

Sweeps = Mapping[str, Gesture]


def _sweeps(*seconds: float) -> Sweeps:
    return {f"{each:g} s": sweep(each) for each in seconds}


ROUGH, FINE = _sweeps(1.0, 2.0, 5.0), _sweeps(1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
"""Over made-up timelines."""

SEARCHED: Sweeps = {**_sweeps(1.0, 2.5, 6.0), "a tap": tap(1.0, 3.0)}
VERIFIED: Sweeps = {**_sweeps(1.0, 2.0, 4.0, 6.0), "a tap": tap(1.0, 3.0)}
"""Over the timelines that are given."""


@dataclass(frozen=True)
class TuningResult:
    """A preset tuned by search.

    Attributes
    ----------
    preset : Preset
        Called `NAME-tuned`.
    least_jnds : float
        Just noticeable steps between the two kinds that are nearest to each other.
    reached : bool
        Whether that is what was wanted.
    unreached : tuple of str
        Where it isn't: a line each.

    Examples
    --------
    >>> football = ov.load_preset("football")
    >>> ov.measure.TuningResult(football, least_jnds=2.1, reached=True).reached
    True
    """

    preset: Preset
    least_jnds: float
    reached: bool
    unreached: tuple[str, ...] = ()


class Gap(NamedTuple):
    """The steps between two kinds in a stroke, and those that are wanted."""

    stroke: str
    timeline: str
    first: str
    relation: str
    second: str
    steps: float
    wanted: float

    @property
    def lacks(self) -> float:
        """Steps to what is aimed at; 0 if it is reached."""
        return max(0.0, self.wanted + MORE_STEPS - self.steps)

    def __str__(self) -> str:
        return (
            f"{self.first} is {self.steps:.2f} steps {self.relation} {self.second} in "
            f"{self.stroke} on {self.timeline or 'a timeline'}, {self.wanted:g} wanted"
        )


Feels = dict[tuple[str, int], dict[str, KindFeel]]
"""What each kind is like, by stroke and number of the timeline; a made-up one is one in parts."""


def tune(
    preset: Preset,
    target: Sequence[str] = (),
    timelines: Sequence[Timeline] | None = None,
    apart: bool = False,
    seed: int = 0,
    progress: Callable[[float], None] = lambda part: None,
) -> TuningResult:
    """Move heights and widths until kinds follow each other in strength, or are set apart.

    Parameters
    ----------
    preset : Preset
        Whose kinds are moved.
    target : sequence of str
        Kinds, the strongest first: two or more, each named by the preset. Each is to be two steps
        of level above the next, the last one a step above what is no event.
    timelines : sequence of Timeline or None
        Where that is measured, each event where it lies, in sweeps of 1 to 6 s and a tap. None: on
        a made-up timeline, in sweeps of 1 to 6 s.
    apart : bool
        All kinds of the preset are to be a step apart, in whatever they differ most in, with none
        masked and none merged; a target's kinds only a step above the next.
    seed : int
        The same seed gives the same preset.
    progress : callable
        Called with the part done, 0 to 1.

    Returns
    -------
    TuningResult
        What was found, and what of it isn't reached where.

    Raises
    ------
    InputError
        Fewer than two kinds, one that the preset doesn't name or no timeline has, one twice.

    Examples
    --------
    >>> wide = ov.EventKind(height=120.0, width_percent=3.0, shape="plateau")
    >>> low = ov.EventKind(height=4.0, width_percent=1.0)
    >>> kinds = {"default": low, "strong": wide, "weak": low}
    >>> preset = ov.Preset("mine", "Mine", "two kinds", {}, kinds)
    >>> ov.measure.tune(preset, ["strong", "weak"]).reached
    True
    """
    _check_target(preset, target, timelines, apart)
    search = _Search(preset, tuple(target), timelines, apart)
    rng = validation.random(seed)
    moves = search.unmoved
    feels = search.measured(moves, search.speeds[-1], search.names)
    if not search.reached(feels):
        rough, fine = search.speeds
        moves, _ = search.improved(moves, rough, rng, lambda part: progress(part / 2))
        moves, feels = search.improved(moves, fine, rng, lambda part: progress(0.5 + part / 2))
    progress(1.0)
    best = replace(search.moved(moves), name=f"{preset.name}-tuned", title=f"{preset.title}, tuned")
    gaps = search.gaps(feels)
    least = min((gap.steps - gap.wanted for gap in gaps), default=math.inf)
    return TuningResult(
        best,
        least + (SEPARATE_JNDS if apart else ORDERED_JNDS),
        search.reached(feels),
        tuple(str(gap) for gap in gaps if not gap.steps >= gap.wanted),
    )


def gaps_of(
    preset: Preset, target: Sequence[str], timelines: Sequence[Timeline] | None = None
) -> list[Gap]:
    """Return the steps between the kinds of a target, in each stroke on each timeline."""
    search = _Search(preset, tuple(target), timelines, False)
    return search.gaps(search.measured(search.unmoved, search.speeds[-1], search.names))


def _check_target(
    preset: Preset, target: Sequence[str], timelines: Sequence[Timeline] | None, apart: bool
) -> None:
    if len(target) < 2 and (target or not apart):
        raise InputError("a target has two kinds or more, the strongest first: goal>foul")
    for name in target:
        if name not in preset.kinds:
            raise InputError(
                f"preset {preset.name!r} names no kind {name!r}{did_you_mean(name, preset.kinds)}"
            )
    if len(set(target)) < len(target):
        raise InputError("a kind is named twice in the target; name each once")
    if timelines is None:
        return
    if apart:
        raise InputError("kinds are set apart on a made-up timeline; leave the timelines out")
    kinds = {kind for timeline in timelines for kind in timeline.kinds()}
    for name in target:
        if name not in kinds:
            raise InputError(
                f"no event of kind {name!r} is on the timelines given{did_you_mean(name, kinds)}"
            )


class _Search:
    """Measures moves of heights and widths, and improves them."""

    def __init__(
        self,
        preset: Preset,
        target: tuple[str, ...],
        timelines: Sequence[Timeline] | None,
        apart: bool,
    ) -> None:
        self._preset, self._target, self._apart = preset, target, apart
        self.names = tuple(preset.kinds) if apart else target
        self._made_up = timelines is None
        self._timelines = timelines or (pages(preset) if apart else (_alternating(target),))
        self.speeds = (ROUGH, FINE) if self._made_up else (SEARCHED, VERIFIED)
        self._tries = TRIES_APART if apart else TRIES
        self._most = np.repeat([math.log(MOST_HEIGHT), math.log(MOST_WIDTH)], len(self.names))

    @property
    def unmoved(self) -> NDArray[np.float64]:
        """The moves of the preset as it is: (2 kinds,), heights, then widths; logs of ratios."""
        return np.zeros(2 * len(self.names))

    def moved(self, moves: NDArray[np.float64]) -> Preset:
        """Return the preset with each kind's height and width moved."""
        kinds, count = dict(self._preset.kinds), len(self.names)
        for name, height, width in zip(self.names, moves[:count], moves[count:], strict=True):
            kinds[name] = _moved_kind(kinds[name], math.exp(height), math.exp(width))
        return replace(self._preset, kinds=kinds)

    def measured(self, moves: NDArray[np.float64], speeds: Sweeps, kinds: Sequence[str]) -> Feels:
        """Return how these kinds feel, and what else is on their timelines."""
        preset = self.moved(moves)
        parts = [
            (i, [one]) for i, one in enumerate(self._timelines) if set(kinds) & set(one.kinds())
        ]
        if self._made_up:  # one timeline in parts
            parts = [(0, [one for _, (one,) in parts])]
        return {
            (stroke.name, i): {kind.kind: kind for kind in stroke.kinds}
            for i, timelines in parts
            for stroke in feel_report(preset, timelines, speeds, RATE, recoils=False).strokes
        }

    def gaps(self, feels: Feels) -> list[Gap]:
        """Return what is wanted of the kinds of each stroke, and what it is."""
        found = []
        for (stroke, i), kinds in feels.items():
            gap = functools.partial(Gap, stroke, self._timelines[i].title)
            there = [kinds[name] for name in self._target if name in kinds]
            for one, other in itertools.pairwise(there):
                above = (one.level_db - other.level_db) / STEP_DB
                wanted = SEPARATE_JNDS if self._apart else ORDERED_JNDS
                found.append(gap(one.kind, "above", other.kind, above, wanted))
            if self._apart:
                for one, other in itertools.combinations(kinds.values(), 2):
                    steps = jnd_distance(one, other)
                    found.append(gap(one.kind, "from", other.kind, steps, SEPARATE_JNDS))
            elif there:
                contrast = there[-1].contrast_db / STEP_DB
                found.append(gap(there[-1].kind, "above", REST, contrast, REST_STEPS))
        # a kind that was never met
        return [one if math.isfinite(one.steps) else one._replace(steps=UNMET) for one in found]

    def _costs(self, feels: Feels) -> NDArray[np.float64]:
        """Return what lacks, squared, by kind: (kinds,)."""
        costs = dict.fromkeys(self.names, 0.0)
        for gap in self.gaps(feels):
            for name in {gap.first, gap.second} - {REST}:
                costs[name] += gap.lacks**2
        if self._apart:
            for kind in (kind for kinds in feels.values() for kind in kinds.values()):
                clear = (
                    max(0.0, CLEAR_STEPS - kind.contrast_db / STEP_DB)
                    if kind.passed
                    else FAULT_STEPS
                )
                costs[kind.kind] += clear**2 + FAULT_STEPS**2 * (kind.masked + kind.merged)
        return np.array(list(costs.values()))

    def reached(self, feels: Feels) -> bool:
        """Return whether all that is wanted is reached."""
        kinds = [kind for kinds in feels.values() for kind in kinds.values()] if self._apart else []
        return all(gap.steps >= gap.wanted for gap in self.gaps(feels)) and not any(
            kind.masked or kind.merged for kind in kinds
        )

    def raised(self, moves: NDArray[np.float64], feels: Feels) -> NDArray[np.float64]:
        """Raise each kind of the target by what it lacks above all below it."""
        lacks = dict.fromkeys(self._target, 0.0)
        for gap in self.gaps(feels):
            if gap.steps < gap.wanted and (gap.second == REST or not self._apart):
                lacks[gap.first] = max(lacks[gap.first], gap.lacks)
        steps = np.cumsum(list(lacks.values())[::-1])[::-1]
        found = moves.copy()
        for name, more in zip(self._target, steps, strict=True):
            found[self.names.index(name)] += more * STEP_DB * LOG_PER_DB
        return found

    def improved(
        self,
        moves: NDArray[np.float64],
        speeds: Sweeps,
        rng: np.random.Generator,
        progress: Callable[[float], None],
    ) -> tuple[NDArray[np.float64], Feels]:
        """Return the best moves found from some on, and how they feel at these speeds."""
        feels = self.measured(moves, speeds, self.names)
        costs, everything = self._costs(feels), np.arange(len(self.names))
        for count in range(self._tries):
            enough = not self._apart and speeds is self.speeds[-1] and self.reached(feels)
            if enough or costs.sum() < GOOD:
                break
            progress(count / self._tries)
            if self._target and count < GUESSES:
                which, tried = everything, self.raised(moves, feels)
            else:
                which = np.array([rng.choice(len(costs), p=costs / costs.sum())])
                tried = moves.copy()
                if rng.random() < TOGETHER:
                    which = everything  # the others give way
                height, width = rng.choice([1.0, 0.3]) * rng.normal(0.0, SPREAD)
                tried[which] += height
                if len(which) == 1:
                    tried[which + len(costs)] += width
            tried = np.clip(tried, -self._most, self._most)
            felt = self.measured(tried, speeds, [self.names[i] for i in which])
            now = {where: {**kinds, **felt.get(where, {})} for where, kinds in feels.items()}
            if (cost := self._costs(now)).sum() < costs.sum():
                moves, feels, costs = tried, now, cost
        return moves, feels


def _moved_kind(kind: EventKind, height: float, width: float) -> EventKind:
    key = "width_percent" if kind.width_percent is not None else "width_ms"
    changes: dict[str, Any] = {
        "height": _within("height", kind.height * height),
        key: _within(key, getattr(kind, key) * width),
    }
    return replace(kind, **changes)


def _within(key: str, value: float) -> float:
    known = KIND_PARAMETERS[key]
    return min(max(value, known.low), known.high)


def _alternating(target: Sequence[str]) -> Timeline:
    """Return a timeline with each kind twice, so that none is always met after the strongest."""
    names = [*target, *reversed(target)]
    spacing = 2.0 * SECONDS_EACH
    events = tuple(Event(spacing * (i + 1), name) for i, name in enumerate(names))
    return Timeline("the target's kinds", spacing * (len(names) + 1), events)
