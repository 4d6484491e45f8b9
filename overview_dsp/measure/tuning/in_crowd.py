"""Heights and widths moved until kinds are two steps apart in strength, on real timelines.

Where events crowd, a kind's strength isn't what it is alone. So each try is measured where the
events lie, in sweeps and a tap over every timeline; what is found is measured again at other
speeds, and what isn't reached is said.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, sweep, tap
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.measure.crowd import crowd_report
from overview_dsp.measure.felt import STEP_DB
from overview_dsp.measure.tuning.moves import RATE, Tuned, limits, moved
from overview_dsp.measure.tuning.ordering import WANTED_STEPS, check_target

VERIFIED: Mapping[str, Gesture] = {
    "1 s": sweep(1.0),
    "2 s": sweep(2.0),
    "4 s": sweep(4.0),
    "6 s": sweep(6.0),
    "a tap": tap(1.0, 3.0),
}
SEARCHED: Mapping[str, Gesture] = {
    "1 s": sweep(1.0),
    "2.5 s": sweep(2.5),
    "6 s": sweep(6.0),
    "a tap": tap(1.0, 3.0),
}
ROUNDS = 16
LAST_ROUNDS = 3
NUDGE = 0.15
"""Of a height, as a logarithm, to see what it changes."""

_MORE = 0.3
"""So much more is aimed at, so that other speeds hold it too."""

_LOG_PER_DB = 0.19
"""Of a height, as a logarithm, for a dB of level: what compression leaves of it (0.6 dB a dB)."""

_STAY = 0.05
"""What a move costs, beside what lacks: of two ways, the nearer to the preset as it was."""


def tuned_on(
    preset: Preset,
    target: Sequence[str],
    timelines: Sequence[Timeline],
    progress: Callable[[float], None] = lambda part: None,
) -> Tuned:
    """Move heights and widths until kinds follow each other in strength on these timelines.

    Parameters
    ----------
    preset : Preset
        Whose kinds are moved.
    target : sequence of str
        Kinds, the strongest first: two or more, each named by the preset and by a timeline.
    timelines : sequence of Timeline
        What it is for.
    progress : callable
        Called with the part done, 0 to 1.

    Returns
    -------
    Tuned
        What was found, and what of it isn't reached where.

    Raises
    ------
    InputError
        As `tuned`; a kind that no timeline has, no timeline.

    Examples
    --------
    >>> ov.measure.tuned_on(football, ["goal", "yellow_card"], [match]).reached
    True
    """
    from scipy.optimize import least_squares

    check_target(preset, target)
    _check_timelines(target, timelines)
    tries = 0

    def lacking(moves: NDArray[np.float64]) -> NDArray[np.float64]:
        nonlocal tries
        tries += 1
        progress(min(0.9, 0.9 * tries / (ROUNDS * (2 * len(target) + 1))))
        found = gaps_on(moved(preset, target, moves), target, timelines, SEARCHED)
        wanted = np.array([_wanted(second) + _MORE for *_, second, _ in found])
        short = np.maximum(wanted - np.array([gap for *_, gap in found]), 0.0)
        return np.append(short, _STAY * moves)

    start = np.zeros(2 * len(target))
    most = limits(len(target))
    found = gaps_on(preset, target, timelines, SEARCHED)
    if any(gap < _wanted(second) for *_, second, gap in found):
        start = np.clip(_first_guess(found, target), -0.9 * most, 0.9 * most)
        start = least_squares(
            lacking,
            start,
            bounds=(-most, most),
            diff_step=NUDGE,
            x_scale=np.repeat([2.0, 0.5], len(target)),
            ftol=0.001,
            xtol=0.001,
            max_nfev=ROUNDS,
        ).x
    verified = gaps_on(moved(preset, target, start), target, timelines, VERIFIED)
    for _ in range(LAST_ROUNDS):
        if _least(verified) >= WANTED_STEPS:
            break
        # what still lacks at other speeds
        raised = np.clip(start + _first_guess(verified, target), -most, most)
        again = gaps_on(moved(preset, target, raised), target, timelines, VERIFIED)
        if _least(again) > _least(verified):
            start, verified = raised, again
    best = moved(preset, target, start)
    progress(1.0)
    unreached = tuple(
        f"{first} is {gap:.2f} steps above {second} in {way} on {title or 'a timeline'}, "
        f"{_wanted(second):g} wanted"
        for way, title, first, second, gap in verified
        if not gap >= _wanted(second)
    )
    named = replace(best, name=f"{preset.name}-tuned", title=f"{preset.title}, tuned")
    return Tuned(named, _least(verified), not unreached, unreached)


REST = "what is no event"


Gap = tuple[str, str, str, str, float]
"""A gesture, a timeline's title, a kind, the next one, and the steps between them."""


def _least(gaps: Sequence[Gap]) -> float:
    # a step above the rest counts as the two that a kind needs above another
    return min(gap + WANTED_STEPS - _wanted(second) for *_, second, gap in gaps)


def _first_guess(found: Sequence[Gap], target: Sequence[str]) -> NDArray[np.float64]:
    """Each kind raised by what lacks between it and all below it, as if nothing else changed."""
    lacks = dict.fromkeys(target, 0.0)
    for _, _, first, second, gap in found:
        if gap < _wanted(second):
            lacks[first] = max(lacks[first], _wanted(second) + _MORE - gap)
    steps = np.cumsum([lacks[kind] for kind in reversed(target)])[::-1]
    return np.append(steps * STEP_DB * _LOG_PER_DB, np.zeros(len(target)))


def _wanted(second: str) -> float:
    return 1.0 if second == REST else WANTED_STEPS


def gaps_on(
    preset: Preset,
    target: Sequence[str],
    timelines: Sequence[Timeline],
    gestures: Mapping[str, Gesture],
) -> list[Gap]:
    """From each kind down to the next that a timeline has, on each: steps between their medians.

    Returns
    -------
    list of Gap
        The last kind's next is `REST`.
    """
    found = []
    for timeline in timelines:
        there = [kind for kind in target if kind in timeline.kinds()]
        report = crowd_report(preset, [timeline], gestures, target, RATE, recoils=False)
        for stroke in report.strokes:
            levels = [stroke.kind(kind).level_db for kind in there]
            steps = [*zip(there, levels, strict=True), (REST, stroke.event_free_db)]
            found += [
                (stroke.name, timeline.title, a, b, _known((above - below) / STEP_DB))
                for (a, above), (b, below) in itertools.pairwise(steps)
            ]
    return found


def _known(gap: float) -> float:
    # a kind that was never met
    return gap if np.isfinite(gap) else -10.0


def _check_timelines(target: Sequence[str], timelines: Sequence[Timeline]) -> None:
    kinds = {kind for timeline in timelines for kind in timeline.kinds()}
    for name in target:
        if name not in kinds:
            raise InputError(
                f"no event of kind {name!r} is on the timelines given{did_you_mean(name, kinds)}"
            )
