"""Tuning of heights and widths by search: kinds in an order of strength, or separated.

The search lowers the sum of squared shortfalls, in JNDs, over strokes and timelines. The first
tries raise each kind by its shortfall and those of all kinds below it. Then a seeded local search
changes one kind with a shortfall, or all of them, and keeps changes that cost less.

The start and shares of the found change are judged on timelines that were not searched too, in more
strokes, with recoils and an arm. The smallest change wins that misses fewer JNDs, on no timeline
more, and leaves no more events unfelt, also on further timelines that chose nothing, or else the
start. All steps read the table of felt events.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import Gesture, arm, sweep, tap
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameters import KIND_PARAMETERS
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.measure.event_table import FeltEvents, felt_events
from overview_dsp.measure.perception import JND_DB, MERGED_S
from overview_dsp.measure.pictures import SECONDS_EACH, pages
from overview_dsp.measure.report import KindFeel, feel_report, jnd_distance
from overview_dsp.signal.actuators.model import pacinian_db
from overview_dsp.units import clock_text

RATE = 16_000.0  # sample rate, Hz. The vibration does not depend on it, and a low one is fast.

ORDERED_JNDS, SEPARATE_JNDS = 2.0, 1.0
"""Required JNDs between a kind and the next one of a target, and between separated kinds."""

REST_JNDS = 1.0  # required JNDs of the last kind above the level between the events
MARGIN_JNDS = 0.3  # margin of the search in JNDs, so that the target holds at other speeds too

CLEAR_JNDS = 1.8
"""JNDs of separated kinds above the level between the events in the search, so that weak events are
felt."""

FAULT_JNDS = 2.0  # cost of a masked or merged event, as a shortfall in JNDs

GOOD = 0.02  # cost at which the search ends

MOST_HEIGHT, MOST_WIDTH = 8.0, 2.0
"""Ratios of change of heights and widths that a result does not reach."""

LOG_PER_DB = 0.19  # change of a height's logarithm per dB of level, compressed by 0.6 dB per dB

TRIES, TRIES_SEPARATE = 60, 2000  # tries of the search for a target, and for separate kinds
GUESSES = 3  # first tries, which raise each kind of a target by its shortfall
ALL_AT_ONCE = 0.15  # share of the tries that change all kinds

SPREAD = (0.3, 0.15)
"""Standard deviations of a try, in logarithms of the height's and the width's ratio."""

SHARES = (0.25, 0.5, 0.75, 1.0)  # judged shares of the change that the search found
LEAST_GAIN = 0.1  # JNDs that a larger change must miss less, or that a timeline may miss more
HELD_OUT, FURTHER = 2, 6  # timelines made of a single one: held out, and to confirm a result

REST = "the level between the events"
UNMET = -10.0  # JNDs of a kind that was never passed above another one


def _sweeps(*seconds: float) -> dict[str, Gesture]:
    return {f"{each:g} s": sweep(each) for each in seconds}


SEARCHED = {**_sweeps(1.0, 2.5, 6.0), "a tap": tap(1.0, 3.0)}
JUDGED = {**_sweeps(1.0, 1.5, 2.0, 4.0, 6.0), "a tap": tap(1.0, 3.0), "an arm in 2 s": arm(2.0)}
"""Gestures of the search and of the judgement; each has a recoil."""


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
        One line per requirement that is not met: the weakest event, and the reason.
    missing_jnds, missing_before : float
        Sum of the JNDs that result and start miss on the given and the held-out timelines.

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
    missing_jnds: float = 0.0
    missing_before: float = 0.0


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
        Timelines of the measurement. Every second one is held out of the search; where kinds would
        be missing, rearranged copies are held out instead. None: a synthetic timeline.
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
        Tuned preset, and the requirements that are not met in sweeps of 1 to 6 s, a tap, an arm's
        movement and all recoils. It is never worse than `preset` on given or held-out timelines.

    Raises
    ------
    InputError
        Fewer than two kinds, a kind twice, or one that the preset or all timelines lack.

    Examples
    --------
    >>> found = ov.measure.tune(football, ["goal", "foul"])
    >>> found.reached, found.missing_jnds
    (True, 0.0)
    """
    _check_target(preset, target, timelines, separate)
    rng = validation.random(seed)
    given = tuple(timelines or (pages(preset) if separate else (_alternating(target),)))
    searched, held_out = _split(given, target, rng)
    together = timelines is None
    judge = _Search(preset, tuple(target), (*given, *held_out), JUDGED, separate, together)
    start = judge.judged(preset)
    found = [start]
    if not start.reached:
        search = replace(judge, timelines=searched, gestures=SEARCHED)
        moves = search.improved(rng, progress)
        for share in SHARES:
            judged = judge.judged(search.moved(share * moves) or preset)
            less = judged.reached or judged.total < found[-1].total - LEAST_GAIN
            if less and judged.is_not_worse_than(start):
                found.append(judged)
            if found[-1].reached:
                break
    best = judge.confirmed(found, rng)
    progress(1.0)
    made = replace(best.preset, name=f"{preset.name}-tuned", title=f"{preset.title}, tuned")
    least = min((gap.jnds - gap.required for gap in best.gaps), default=math.inf)
    return TuningResult(
        made,
        least + (SEPARATE_JNDS if separate else ORDERED_JNDS),
        best.reached,
        tuple(judge.reasons(best)),
        best.total,
        start.total,
    )


def _split(
    timelines: tuple[Timeline, ...], target: Sequence[str], rng: np.random.Generator
) -> tuple[tuple[Timeline, ...], tuple[Timeline, ...]]:
    """Return the timelines of the search, with all kinds, and made ones that are held out."""
    searched, held_out = timelines[::2], timelines[1::2]
    wanted = set(target) & {kind for one in timelines for kind in one.kinds()}
    present = ({kind for one in part for kind in one.kinds()} for part in (searched, held_out))
    if target and all(wanted <= kinds for kinds in present):
        return searched, ()
    copies = HELD_OUT if len(timelines) == 1 else 1
    made = (rearranged(one, rng) for one in timelines if one.events for _ in range(copies))
    return timelines, tuple(made)


def rearranged(timeline: Timeline, rng: np.random.Generator) -> Timeline:
    """Return a timeline with its events in a random order, each as long after the one before it."""
    before = [event.time_s for event in timeline.events]
    # no two events are at one time
    spans = np.diff(before, prepend=0.0) + 1e-3
    order = rng.permutation(len(spans))
    times = np.minimum(np.cumsum(spans[order]) * (before[-1] / spans.sum()), before[-1])
    moved = zip(order, times.tolist(), strict=True)
    events = tuple(replace(timeline.events[i], time_s=time_s) for i, time_s in moved)
    title = f"{timeline.title or 'a timeline'}, rearranged"
    return replace(timeline, title=title, events=events)


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


class _Judged(NamedTuple):
    """Judgement of a preset.

    `missing`: missing JNDs by timeline number. `unfelt`: number of events of all kinds that are
    never reached, masked or lost.
    """

    preset: Preset
    gaps: list[Gap]
    missing: dict[int, float]
    unfelt: int
    reached: bool

    @property
    def total(self) -> float:
        """Sum of the JNDs that are missing."""
        return sum(self.missing.values())

    def is_not_worse_than(self, start: _Judged) -> bool:
        """Return whether no timeline misses more JNDs, and no more events are unfelt."""
        worse = any(more > start.missing[at] + LEAST_GAIN for at, more in self.missing.items())
        return not worse and self.total <= start.total and self.unfelt <= start.unfelt


@dataclass(frozen=True)
class _Search:
    """Search for changes of heights and widths, or judgement of a preset, on some timelines.

    `together`: all timelines are parts of one.
    """

    preset: Preset
    target: tuple[str, ...]
    timelines: tuple[Timeline, ...]
    gestures: Mapping[str, Gesture]
    separate: bool = False
    together: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Kinds that are changed."""
        return tuple(self.preset.kinds) if self.separate else self.target

    def moved(self, moves: FloatArray) -> Preset | None:
        """Return the preset with moved heights and widths; None for one at a limit.

        `moves`: (2 kinds,), logarithms of the ratios of heights, then of widths.
        """
        kinds, count = dict(self.preset.kinds), len(self.names)
        most = np.repeat([math.log(MOST_HEIGHT), math.log(MOST_WIDTH)], count)
        if (np.abs(moves) >= most).any():
            return None
        for name, height, width in zip(self.names, moves[:count], moves[count:], strict=True):
            kind = kinds[name]
            key = "width_percent" if kind.width_percent is not None else "width_ms"
            for id, move in (("height", height), (key, width)):
                known, value = KIND_PARAMETERS[id], getattr(kind, id) * math.exp(move)
                if move and not known.low < value < known.high:
                    return None
                kind = replace(kind, **{id: value})
            kinds[name] = kind
        return replace(self.preset, kinds=kinds)

    def judged(self, preset: Preset) -> _Judged:
        """Judge a preset by all kinds in each stroke."""
        feels = self.measured(preset, self.names)
        kinds = [kind for by_name in feels.values() for kind in by_name.values()]
        unfelt = sum(one.missed + one.masked + one.lost for one in kinds)
        gaps, missing = [], dict.fromkeys((i for _, i in feels), 0.0)
        for (stroke, i), kind in feels.items():
            found = self.gaps({(stroke, i): kind})
            missing[i] += sum(max(0.0, gap.required - gap.jnds) for gap in found)
            gaps += found
        faulty = self.separate and any(kind.masked or kind.merged for kind in kinds)
        reached = not faulty and all(gap.jnds >= gap.required for gap in gaps)
        return _Judged(preset, gaps, missing, unfelt, reached)

    def confirmed(self, found: list[_Judged], rng: np.random.Generator) -> _Judged:
        """Return the last preset that is not worse than the first on further timelines."""
        copies = max(1, FURTHER // len(self.timelines))
        made = tuple(
            rearranged(one, rng) for one in self.timelines for _ in range(copies) if one.events
        )
        further = replace(self, timelines=made)
        start = further.judged(found[0].preset) if found[1:] else found[0]
        for one in found[:0:-1]:
            if further.judged(one.preset).is_not_worse_than(start):
                return one
        return found[0]

    def reasons(self, best: _Judged) -> Iterator[str]:
        """Yield a line per requirement that is not met: its weakest event, and the reason."""
        unmet = [gap for gap in best.gaps if not gap.jnds >= gap.required]
        tables = felt_events(best.preset, self.timelines, self.gestures, RATE) if unmet else []
        weight = pacinian_db(best.preset.number("tactor.frequency_hz"))
        for gap in unmet:
            titles = {one.title for one in self.timelines} if self.together else {gap.timeline}
            rows: dict[str, list[tuple[float, int, FeltEvents]]] = {gap.first: [], gap.second: []}
            for one in tables:
                if one.name == gap.stroke and one.timeline.title in titles:
                    levels = np.nan_to_num(one.level_db + weight, nan=-np.inf).tolist()
                    for row, level in enumerate(levels):
                        rows.get(one.kind[row], []).append((level, row, one))
            level, row, one = min(rows[gap.first], key=itemgetter(0))
            if level == -np.inf:
                reason = "is not reached by the disk"
            elif one.merged[row]:
                beside = one.lost_to[row] or "another event"
                reason = f"is struck within {1000.0 * MERGED_S:.0f} ms of {beside}"
            elif one.masked[row] or gap.second == REST:
                reason = f"has {level:.1f} dB, {one.free_db + weight:.1f} dB between the events"
            else:
                high, at, other = max(rows[gap.second], key=itemgetter(0))
                at_s = clock_text(other.time_s[at])
                reason = f"has {level:.1f} dB, {gap.second} at {at_s} has {high:.1f} dB"
            yield f"{gap}: {gap.first} at {clock_text(one.time_s[row])} {reason}"

    def measured(self, preset: Preset, kinds: Sequence[str]) -> Feels:
        """Return the measurements of these kinds and of others on their timelines."""
        parts = [
            (i, [one]) for i, one in enumerate(self.timelines) if set(kinds) & set(one.kinds())
        ]
        if self.together:
            parts = [(0, [one for _, (one,) in parts])]
        return {
            (stroke.name, i): {kind.kind: kind for kind in stroke.kinds}
            for i, timelines in parts
            for stroke in feel_report(preset, timelines, self.gestures, RATE).strokes
        }

    def gaps(self, feels: Feels) -> list[Gap]:
        """Return the required and the measured JNDs of the kinds in each stroke."""
        found = []
        for (stroke, i), kinds in feels.items():
            gap = functools.partial(Gap, stroke, self.timelines[i].title)
            present = [kinds[name] for name in self.target if name in kinds]
            for one, other in itertools.pairwise(present):
                above = (one.level_db - other.level_db) / JND_DB
                required = SEPARATE_JNDS if self.separate else ORDERED_JNDS
                found.append(gap(one.kind, "above", other.kind, above, required))
            if self.separate:
                for one, other in itertools.combinations(kinds.values(), 2):
                    steps = jnd_distance(one, other)
                    found.append(gap(one.kind, "from", other.kind, steps, SEPARATE_JNDS))
            elif present and not (present[-1].passed and math.isnan(present[-1].contrast_db)):
                # the contrast is unknown where events overlap each other everywhere
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
        if self.separate:
            for kind in (kind for kinds in feels.values() for kind in kinds.values()):
                jnds = max(0.0, CLEAR_JNDS - kind.contrast_db / JND_DB)
                missing = jnds if kind.passed else FAULT_JNDS
                costs[kind.kind] += missing**2 + FAULT_JNDS**2 * (kind.masked + kind.merged)
        return np.array(list(costs.values()))

    def raised(self, moves: FloatArray, feels: Feels) -> FloatArray:
        """Raise each kind of the target by its shortfall and those of the kinds below it."""
        shortfalls = dict.fromkeys(self.target, 0.0)
        for gap in self.gaps(feels):
            if gap.jnds < gap.required and (gap.second == REST or not self.separate):
                shortfalls[gap.first] = max(shortfalls[gap.first], gap.shortfall)
        steps = np.cumsum(list(shortfalls.values())[::-1])[::-1]
        found = moves.copy()
        for name, more in zip(self.target, steps, strict=True):
            found[self.names.index(name)] += more * JND_DB * LOG_PER_DB
        return found

    def improved(self, rng: np.random.Generator, progress: Callable[[float], None]) -> FloatArray:
        """Search; return the best moves."""
        moves, everything = np.zeros(2 * len(self.names)), np.arange(len(self.names))
        feels = self.measured(self.preset, self.names)
        costs, tries = self._costs(feels), TRIES_SEPARATE if self.separate else TRIES
        for count in range(tries):
            if costs.sum() < GOOD:
                break
            progress(count / tries)
            if self.target and count < GUESSES:
                which, tried = everything, self.raised(moves, feels)
            else:
                which = np.array([rng.choice(len(costs), p=costs / costs.sum())])
                tried = moves.copy()
                if rng.random() < ALL_AT_ONCE:
                    which = everything  # the other kinds move too
                height, width = rng.choice([1.0, 0.3]) * rng.normal(0.0, SPREAD)
                tried[which] += height
                if len(which) == 1:
                    tried[which + len(costs)] += width
            if (preset := self.moved(tried)) is None:
                continue
            felt = self.measured(preset, [self.names[i] for i in which])
            changed = {at: {**kinds, **felt.get(at, {})} for at, kinds in feels.items()}
            if (cost := self._costs(changed)).sum() < costs.sum():
                moves, feels, costs = tried, changed, cost
        return moves


def _alternating(target: Sequence[str]) -> Timeline:
    """Return a timeline with each kind twice, so that none always follows the strongest."""
    names = [*target, *reversed(target)]
    spacing = 2.0 * SECONDS_EACH
    events = tuple(Event(spacing * (i + 1), name) for i, name in enumerate(names))
    return Timeline("the target's kinds", spacing * (len(names) + 1), events)
