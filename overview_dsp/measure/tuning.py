"""Tuning of heights and widths by search: kinds in an order of strength, or separated.

The cost is the sum of squared shortfalls, in JNDs, over strokes and timelines. The first tries
raise each kind by its shortfall and those of all kinds below it. Then a seeded local search changes
one kind with a shortfall, or all of them, and keeps changes that cost less: first at few speeds,
then at all of them. A preset that meets the target is not changed.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import Gesture, sweep, tap
from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.design.presets.parameters import KIND_PARAMETERS
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.measure.perceived_level import JND_DB
from overview_dsp.measure.report import KindFeel, feel_report, jnd_distance
from overview_dsp.offline.rendering.audition import SECONDS_EACH, pages

RATE = 16_000.0  # sample rate, Hz. The vibration does not depend on it, and a low one is fast.

ORDERED_JNDS, SEPARATE_JNDS = 2.0, 1.0
"""Required JNDs between a kind and the next one of a target, and between separated kinds."""

REST_JNDS = 1.0  # required JNDs of the last kind above the level between the events
MARGIN_JNDS = 0.3  # margin of the search in JNDs, so that the target holds at other speeds too

CLEAR_JNDS = 1.8
"""JNDs of separated kinds above the level between the events in the search, so that weak events are
felt."""

FAULT_JNDS = 2.0  # cost of a masked or merged event, as a shortfall in JNDs

GOOD = 0.02
"""Cost at which the search ends. A target is met once its requirements hold at the last speeds."""

MOST_HEIGHT, MOST_WIDTH = 8.0, 2.0  # largest ratios of change of heights and widths

LOG_PER_DB = 0.19
"""Change of a height's logarithm per dB of level, for a compression of 0.6 dB per dB."""

TRIES, TRIES_APART = 100, 2000  # tries of the search, at few speeds and again at all of them
GUESSES = 3  # first tries, which raise each kind of a target by its shortfall
TOGETHER = 0.15  # share of the tries that change all kinds at once

SPREAD = (0.3, 0.15)
"""Standard deviations of a try, in logarithms of the height's and the width's ratio."""

REST = "the level between the events"
UNMET = -10.0  # JNDs of a kind that was never passed above another one

Sweeps = Mapping[str, Gesture]


def _sweeps(*seconds: float) -> Sweeps:
    return {f"{each:g} s": sweep(each) for each in seconds}


ROUGH, FINE = _sweeps(1.0, 2.0, 5.0), _sweeps(1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
"""Sweeps over synthetic timelines."""

SEARCHED: Sweeps = {**_sweeps(1.0, 2.5, 6.0), "a tap": tap(1.0, 3.0)}
VERIFIED: Sweeps = {**_sweeps(1.0, 2.0, 4.0, 6.0), "a tap": tap(1.0, 3.0)}
"""Gestures over given timelines."""


@dataclass(frozen=True)
class TuningResult:
    """A preset tuned by search.

    Attributes
    ----------
    preset : Preset
        Preset of the name `NAME-tuned`.
    least_jnds : float
        JNDs between the two kinds that are nearest to each other.
    reached : bool
        Whether all requirements are met.
    unreached : tuple of str
        One line per requirement that is not met.

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
    """JNDs between two kinds in a stroke, and the required number."""

    stroke: str
    timeline: str
    first: str
    relation: str
    second: str
    jnds: float
    required: float

    @property
    def shortfall(self) -> float:
        """JNDs to the goal of the search; 0 if it is reached."""
        return max(0.0, self.required + MARGIN_JNDS - self.jnds)

    def __str__(self) -> str:
        return (
            f"{self.first} is {self.jnds:.2f} JNDs {self.relation} {self.second} in "
            f"{self.stroke} on {self.timeline or 'a timeline'}, {self.required:g} required"
        )


Feels = dict[tuple[str, int], dict[str, KindFeel]]
"""Measurements of each kind by stroke and timeline number; a synthetic timeline has number 0."""


def tune(
    preset: Preset,
    target: Sequence[str] = (),
    timelines: Sequence[Timeline] | None = None,
    separate: bool = False,
    seed: int = 0,
    progress: Callable[[float], None] = lambda part: None,
) -> TuningResult:
    """Change heights and widths until kinds have an order of strength, or are separated.

    Parameters
    ----------
    preset : Preset
        Preset whose kinds are changed.
    target : sequence of str
        Kinds, the strongest first: two or more, each named by the preset. Each is to be two JNDs
        of level above the next, and the last one JND above the level between the events.
    timelines : sequence of Timeline or None
        Timelines of the measurement, in sweeps of 1 to 6 s and a tap. None: a synthetic timeline,
        in sweeps of 1 to 6 s.
    separate : bool
        Whether all kinds of the preset are to differ by one JND, in the quantity that differs most,
        with none masked or merged. The kinds of a target are then one JND above the next.
    seed : int
        Random seed; the same seed gives the same preset.
    progress : callable
        Called with the completed share, 0 to 1.

    Returns
    -------
    TuningResult
        Tuned preset, and the requirements that are not met.

    Raises
    ------
    InputError
        Fewer than two kinds, a kind twice, or one that the preset or all timelines lack.

    Examples
    --------
    >>> wide = ov.EventKind(height=120.0, width_percent=3.0, shape="plateau")
    >>> low = ov.EventKind(height=4.0, width_percent=1.0)
    >>> kinds = {"default": low, "strong": wide, "weak": low}
    >>> preset = ov.Preset("mine", "Mine", "two kinds", {}, kinds)
    >>> ov.measure.tune(preset, ["strong", "weak"]).reached
    True
    """
    _check_target(preset, target, timelines, separate)
    search = _Search(preset, tuple(target), timelines, separate)
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
    least = min((gap.jnds - gap.required for gap in gaps), default=math.inf)
    return TuningResult(
        best,
        least + (SEPARATE_JNDS if separate else ORDERED_JNDS),
        search.reached(feels),
        tuple(str(gap) for gap in gaps if not gap.jnds >= gap.required),
    )


def gaps_of(
    preset: Preset, target: Sequence[str], timelines: Sequence[Timeline] | None = None
) -> list[Gap]:
    """Return the JNDs between the kinds of a target, in each stroke on each timeline."""
    search = _Search(preset, tuple(target), timelines, False)
    return search.gaps(search.measured(search.unmoved, search.speeds[-1], search.names))


def _check_target(
    preset: Preset, target: Sequence[str], timelines: Sequence[Timeline] | None, separate: bool
) -> None:
    if len(target) < 2 and (target or not separate):
        raise InputError("a target must have two kinds or more, the strongest first: goal>foul")
    for name in target:
        if name not in preset.kinds:
            raise InputError(
                f"preset {preset.name!r} names no kind {name!r}{did_you_mean(name, preset.kinds)}"
            )
    if len(set(target)) < len(target):
        raise InputError("a kind is named twice in the target; name each once")
    if timelines is None:
        return
    if separate:
        raise InputError("kinds are separated on a synthetic timeline; remove the timelines")
    kinds = {kind for timeline in timelines for kind in timeline.kinds()}
    for name in target:
        if name not in kinds:
            raise InputError(
                f"no event of kind {name!r} is on the given timelines{did_you_mean(name, kinds)}"
            )


class _Search:
    """Search for changes of heights and widths."""

    def __init__(
        self,
        preset: Preset,
        target: tuple[str, ...],
        timelines: Sequence[Timeline] | None,
        separate: bool,
    ) -> None:
        self._preset, self._target, self._separate = preset, target, separate
        self.names = tuple(preset.kinds) if separate else target
        self._is_synthetic = timelines is None
        self._timelines = timelines or (pages(preset) if separate else (_alternating(target),))
        self.speeds = (ROUGH, FINE) if self._is_synthetic else (SEARCHED, VERIFIED)
        self._tries = TRIES_APART if separate else TRIES
        self._most = np.repeat([math.log(MOST_HEIGHT), math.log(MOST_WIDTH)], len(self.names))

    @property
    def unmoved(self) -> FloatArray:
        """No change: (2 kinds,), logarithms of the ratios of heights, then of widths."""
        return np.zeros(2 * len(self.names))

    def moved(self, moves: FloatArray) -> Preset:
        """Return the preset with each kind's height and width moved."""
        kinds, count = dict(self._preset.kinds), len(self.names)
        for name, height, width in zip(self.names, moves[:count], moves[count:], strict=True):
            kinds[name] = _moved_kind(kinds[name], math.exp(height), math.exp(width))
        return replace(self._preset, kinds=kinds)

    def measured(self, moves: FloatArray, speeds: Sweeps, kinds: Sequence[str]) -> Feels:
        """Return the measurements of these kinds and of others on their timelines."""
        preset = self.moved(moves)
        parts = [
            (i, [one]) for i, one in enumerate(self._timelines) if set(kinds) & set(one.kinds())
        ]
        if self._is_synthetic:  # one timeline in parts
            parts = [(0, [one for _, (one,) in parts])]
        return {
            (stroke.name, i): {kind.kind: kind for kind in stroke.kinds}
            for i, timelines in parts
            for stroke in feel_report(preset, timelines, speeds, RATE, recoils=False).strokes
        }

    def gaps(self, feels: Feels) -> list[Gap]:
        """Return the required and the measured JNDs of the kinds in each stroke."""
        found = []
        for (stroke, i), kinds in feels.items():
            gap = functools.partial(Gap, stroke, self._timelines[i].title)
            present = [kinds[name] for name in self._target if name in kinds]
            for one, other in itertools.pairwise(present):
                above = (one.level_db - other.level_db) / JND_DB
                required = SEPARATE_JNDS if self._separate else ORDERED_JNDS
                found.append(gap(one.kind, "above", other.kind, above, required))
            if self._separate:
                for one, other in itertools.combinations(kinds.values(), 2):
                    steps = jnd_distance(one, other)
                    found.append(gap(one.kind, "from", other.kind, steps, SEPARATE_JNDS))
            elif present:
                contrast = present[-1].contrast_db / JND_DB
                found.append(gap(present[-1].kind, "above", REST, contrast, REST_JNDS))
        # the JNDs of a kind that was never passed are not finite
        return [one if math.isfinite(one.jnds) else one._replace(jnds=UNMET) for one in found]

    def _costs(self, feels: Feels) -> FloatArray:
        """Return the squared shortfalls by kind: (kinds,)."""
        costs = dict.fromkeys(self.names, 0.0)
        for gap in self.gaps(feels):
            for name in {gap.first, gap.second} - {REST}:
                costs[name] += gap.shortfall**2
        if self._separate:
            for kind in (kind for kinds in feels.values() for kind in kinds.values()):
                jnds = max(0.0, CLEAR_JNDS - kind.contrast_db / JND_DB)
                missing = jnds if kind.passed else FAULT_JNDS
                costs[kind.kind] += missing**2 + FAULT_JNDS**2 * (kind.masked + kind.merged)
        return np.array(list(costs.values()))

    def reached(self, feels: Feels) -> bool:
        """Return whether all requirements are met."""
        all_kinds = (kind for kinds in feels.values() for kind in kinds.values())
        faulty = self._separate and any(kind.masked or kind.merged for kind in all_kinds)
        return not faulty and all(gap.jnds >= gap.required for gap in self.gaps(feels))

    def raised(self, moves: FloatArray, feels: Feels) -> FloatArray:
        """Raise each kind of the target by its shortfall and those of the kinds below it."""
        shortfalls = dict.fromkeys(self._target, 0.0)
        for gap in self.gaps(feels):
            if gap.jnds < gap.required and (gap.second == REST or not self._separate):
                shortfalls[gap.first] = max(shortfalls[gap.first], gap.shortfall)
        steps = np.cumsum(list(shortfalls.values())[::-1])[::-1]
        found = moves.copy()
        for name, more in zip(self._target, steps, strict=True):
            found[self.names.index(name)] += more * JND_DB * LOG_PER_DB
        return found

    def improved(
        self,
        moves: FloatArray,
        speeds: Sweeps,
        rng: np.random.Generator,
        progress: Callable[[float], None],
    ) -> tuple[FloatArray, Feels]:
        """Search from the given moves; return the best moves, and measurements at these speeds."""
        feels = self.measured(moves, speeds, self.names)
        costs, everything = self._costs(feels), np.arange(len(self.names))
        for count in range(self._tries):
            enough = not self._separate and speeds is self.speeds[-1] and self.reached(feels)
            if enough or costs.sum() < GOOD:
                break
            progress(count / self._tries)
            if self._target and count < GUESSES:
                which, tried = everything, self.raised(moves, feels)
            else:
                which = np.array([rng.choice(len(costs), p=costs / costs.sum())])
                tried = moves.copy()
                if rng.random() < TOGETHER:
                    which = everything  # the other kinds move too
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
    changes: dict[str, Any] = {"height": kind.height * height, key: getattr(kind, key) * width}
    for name, value in changes.items():
        known = KIND_PARAMETERS[name]
        changes[name] = min(max(value, known.low), known.high)
    return replace(kind, **changes)


def _alternating(target: Sequence[str]) -> Timeline:
    """Return a timeline with each kind twice, so that none always follows the strongest."""
    names = [*target, *reversed(target)]
    spacing = 2.0 * SECONDS_EACH
    events = tuple(Event(spacing * (i + 1), name) for i, name in enumerate(names))
    return Timeline("the target's kinds", spacing * (len(names) + 1), events)
