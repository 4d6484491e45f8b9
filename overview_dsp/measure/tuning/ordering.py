"""Heights and widths moved until kinds follow each other in strength, two steps apart.

The search (scipy's differential evolution, seeded) moves each kind's height and width by ratio,
renders slow, medium and fast sweeps over the preset's own kinds, and asks that at every speed each
kind's level is two steps above the next one's, the last one a step above the bare surface; of what
gives that, it prefers what is nearest to the preset as it was.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.measure.feel import FeelReport
from overview_dsp.measure.felt import STEP_DB
from overview_dsp.measure.report import feel_report
from overview_dsp.measure.tuning.moves import RATE, Tuned, limits, moved
from overview_dsp.offline.rendering.audition import SECONDS_EACH

WANTED_STEPS = 2.0
_AIM_STEPS = 2.2  # a little more, so that the search may stop a little short of it
SPEEDS = {"slow": sweep(6.0), "medium": sweep(3.0), "fast": sweep(1.0)}

REPEATS = 2
GENERATIONS = 40
POPULATION = 4
GOOD = 0.03
"""A cost that only small moves make up: nothing lacks."""


def tuned(
    preset: Preset,
    target: Sequence[str],
    seed: int = 0,
    progress: Callable[[float], None] = lambda part: None,
) -> Tuned:
    """Move heights and widths until kinds follow each other in strength, two steps apart.

    Parameters
    ----------
    preset : Preset
        Whose kinds are moved.
    target : sequence of str
        Kinds, the strongest first: two or more, each named by the preset.
    seed : int
        The same seed gives the same preset.
    progress : callable
        Called with the part done, 0 to 1.

    Returns
    -------
    Tuned
        The nearest found to the preset as it was.

    Raises
    ------
    InputError
        Fewer than two kinds, one that the preset doesn't name, one twice.

    Examples
    --------
    >>> wide = ov.EventKind(height=120.0, width_percent=3.0, shape="plateau")
    >>> low = ov.EventKind(height=4.0, width_percent=1.0)
    >>> kinds = {"default": low, "strong": wide, "weak": low}
    >>> preset = ov.Preset("mine", "Mine", "two kinds", {}, kinds)
    >>> ov.measure.tuned(preset, ["strong", "weak"]).reached
    True
    """
    from scipy.optimize import differential_evolution

    check_target(preset, target)
    timeline = _timeline(target)
    done = 0
    evaluations = (GENERATIONS + 1) * POPULATION * 2 * len(target)

    def cost(moves: NDArray[np.float64]) -> float:
        nonlocal done
        done += 1
        progress(min(1.0, done / evaluations))
        gaps = _gaps(moved(preset, target, moves), timeline, target)
        lacking = np.maximum(_AIM_STEPS - gaps, 0.0)
        return float(np.sum(lacking**2)) + 0.01 * float(np.mean(moves**2))

    start = np.zeros(2 * len(target))
    if _gaps(preset, timeline, target).min() < WANTED_STEPS:
        most = limits(len(target))
        found = differential_evolution(
            cost,
            list(zip(-most, most, strict=True)),
            x0=start,
            rng=validation.random(seed),
            maxiter=GENERATIONS,
            popsize=POPULATION,
            polish=False,
            tol=0.0,
            callback=lambda intermediate_result: intermediate_result.fun < GOOD,
        )
        start = found.x
    progress(1.0)
    best = moved(preset, target, start)
    least = float(_gaps(best, timeline, target).min())
    named = replace(best, name=f"{preset.name}-tuned", title=f"{preset.title}, tuned")
    return Tuned(named, least, least >= WANTED_STEPS)


def check_target(preset: Preset, target: Sequence[str]) -> None:
    """InputError unless these are two kinds or more that the preset names, each once."""
    if len(target) < 2:
        raise InputError("a target has two kinds or more, the strongest first: goal>foul")
    for name in target:
        if name not in preset.kinds:
            raise InputError(
                f"preset {preset.name!r} names no kind {name!r}{did_you_mean(name, preset.kinds)}"
            )
    if len(set(target)) < len(target):
        raise InputError("a kind is named twice in the target; name each once")


def _timeline(target: Sequence[str]) -> Timeline:
    names = [name for name in target for _ in range(REPEATS)]
    # strong and weak in turn, so that none is always met after the strongest
    order = [*names[::2], *names[1::2][::-1]]
    spacing = 2.0 * SECONDS_EACH
    events = tuple(Event(spacing * (i + 1), name) for i, name in enumerate(order))
    return Timeline(
        title="the target's kinds", duration_s=spacing * (len(order) + 1), events=events
    )


def _gaps(preset: Preset, timeline: Timeline, target: Sequence[str]) -> NDArray[np.float64]:
    """Steps from each kind down to the next (the last one: above the rest), at every speed."""
    report: FeelReport = feel_report(preset, timeline, SPEEDS, RATE, recoils=False)
    found = []
    for name in SPEEDS:
        stroke = report.stroke(name)
        level = {kind.kind: kind.level_db for kind in stroke.kinds}
        steps = [level[kind] for kind in target]
        # the last one needs one step, not two, above the rest
        steps.append(stroke.event_free_db - STEP_DB)
        found += [(a - b) / STEP_DB for a, b in itertools.pairwise(steps)]
    gaps = np.array(found)
    # not felt at all
    return np.where(np.isfinite(gaps), gaps, -10.0)
