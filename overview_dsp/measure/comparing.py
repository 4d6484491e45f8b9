"""Just noticeable steps between two kinds of a preset, and between two presets."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from overview_dsp import validation
from overview_dsp.measure.feel import FeelReport, KindFeel, StrokeReport
from overview_dsp.measure.felt import STEP_DB, STEP_DURATION, STEP_SHARPNESS, ratio_steps


def character_steps(first: FeelReport, second: FeelReport) -> float:
    """Count the just noticeable steps between two presets on one timeline.

    In what they differ most in: the medians of the steps in level, in sharpness and in density
    over all strokes; the recoils, which are much the same after any gesture, count as one.

    Parameters
    ----------
    first, second : FeelReport
        Of the same gestures.

    Returns
    -------
    float
        How many.

    Examples
    --------
    >>> gestures = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, gestures, sample_rate=8000)
    >>> ov.measure.character_steps(report, report)
    0.0
    """
    for report in (first, second):
        validation.instance(report, FeelReport, "a report", "ov.measure.feel_report makes one")
    validation.equally_long("the reports' strokes", first.strokes, second.strokes)
    differences = np.array(
        [
            _character_differences(one, other)
            for one, other in zip(first.strokes, second.strokes, strict=True)
        ]
    )
    recoils = np.array([stroke.name.endswith("recoil") for stroke in first.strokes])
    each = [*differences[~recoils]]
    if recoils.any():
        each.append(np.nanmedian(differences[recoils], axis=0))
    return float(np.nanmax(np.nanmedian(each, axis=0)))


def _character_differences(one: StrokeReport, other: StrokeReport) -> tuple[float, float, float]:
    return (
        abs(one.level_db - other.level_db) / STEP_DB,
        ratio_steps(one.sharpness, other.sharpness, STEP_SHARPNESS),
        # a pulse a second is the least that is called a rhythm
        ratio_steps(one.density_hz + 1.0, other.density_hz + 1.0, STEP_DURATION),
    )


def steps_apart(first: KindFeel, second: KindFeel) -> float:
    """Count the just noticeable steps between two kinds, in what they differ most in.

    Parameters
    ----------
    first, second : KindFeel
        Of one stroke.

    Returns
    -------
    float
        Steps of level, of sharpness or of duration.

    Examples
    --------
    >>> gestures = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, gestures, sample_rate=8000)
    >>> kind = report.strokes[0].kinds[0]
    >>> ov.measure.steps_apart(kind, kind)
    0.0
    """
    for kind in (first, second):
        validation.instance(kind, KindFeel, "a kind", "the strokes of a feel report have them")
    steps = [
        abs(first.level_db - second.level_db) / STEP_DB,
        ratio_steps(first.sharpness, second.sharpness, STEP_SHARPNESS),
        ratio_steps(first.duration_ms, second.duration_ms, STEP_DURATION),
    ]
    return max((step for step in steps if math.isfinite(step)), default=0.0)


def alike_pairs(kinds: Sequence[KindFeel]) -> tuple[tuple[str, str, float], ...]:
    """Pairs of kinds less than a step apart, and how far they are."""
    return tuple(
        (first.kind, second.kind, apart)
        for first, second in itertools.combinations(kinds, 2)
        if first.events and second.events and (apart := steps_apart(first, second)) < 1.0
    )
