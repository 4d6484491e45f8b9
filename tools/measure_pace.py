"""Measure whether events are easier to recognize if their level doesn't depend on the pace.

A fast hand passes an event with more torque than a slow one. Here the level of both channels is
multiplied by (pace / 0.33 timelines per second)^-alpha, at the events alone or everywhere. Then an
observer of mixed pace learns and is evaluated (`docs/explanation/observer.md`). Each alpha has the
same renders, movements and noise. A gain is the mean of pairs, with its standard deviation.

python tools/measure_pace.py [--repeats N] [--preset NAME]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov
from overview_dsp.measure.observer import observing, strokes
from overview_dsp.measure.observer.features import (
    MODALITIES,
    PACE,
    Modality,
    StrokeFeatures,
    stroke_features,
)
from overview_dsp.measure.observer.scoring import groups_of
from overview_dsp.measure.observer.strokes import PassedEvents, passed_events, rows_of_onsets

ALPHAS = (0.0, 0.25, 0.5, 0.71)
"""0.71 is what football's compression leaves of a pace's level: all of it is taken off."""

PLACES = ("at events", "everywhere")
USUAL_PACE, SLOWEST, FASTEST = 0.33, 0.05, 2.0
"""Timelines per second; beyond the last two the level follows the pace again."""

BEFORE_MS, AFTER_MS = 5, 40
LEARNED, EVALUATED = 120, 80
AT_THE_ENDS = ("period",)
KNOWN, UNKNOWN = "knows its pace", "does not"
Key = tuple[str, float]


def gains(
    log_pace: NDArray[np.float64], there: PassedEvents, alpha: float, where: str
) -> NDArray[np.float64]:
    """Return the gain of a stroke's level in each millisecond."""
    pace = np.clip(np.exp(log_pace), SLOWEST, FASTEST)
    everywhere = (pace / USUAL_PACE) ** -alpha
    if where == "everywhere":
        return np.asarray(everywhere)
    found = np.ones(len(pace))
    for enters, leaves in zip(there.enters_ms, there.leaves_ms, strict=True):
        first = min(int(enters), len(pace) - 1)
        found[max(0, first - BEFORE_MS) : int(leaves) + AFTER_MS] = everywhere[first]
    return found


def observed_strokes(
    preset: ov.Preset, count: int, seed: int
) -> dict[Key, list[strokes.ObservedStroke]]:
    """Return the strokes of mixed movement over random timelines, by position and alpha."""
    timelines = ov.measure.random_timelines(preset, count, seed)
    jobs = [
        ov.RenderJob(timeline, preset, ov.measure.random_movement(seed + i))
        for i, timeline in enumerate(timelines)
    ]
    found: dict[Key, list[strokes.ObservedStroke]] = {(w, a): [] for w in PLACES for a in ALPHAS}
    for done in ov.render_many(jobs, strokes.SOUND_RATE, tail=strokes.ARRIVAL_S, trace=True):
        out = ov.measure.strokes(done.trace.engaged, done.trace.cursor)[0]
        frames = slice(out.start, out.stop)
        there = passed_events(done.surface, done.trace.cursor[frames], done.sample_rate)
        pace = strokes.log_pace(done.job.gesture)
        samples = done.samples[frames]
        at_ms = np.arange(len(samples)) * (1000.0 / done.sample_rate)
        for where, alpha in found:
            gain = gains(pace, there, alpha, where)
            scaled = samples * np.interp(at_ms, np.arange(len(gain)), gain)[:, None]
            heard = stroke_features(np.clip(scaled, -1.0, 1.0), done.sample_rate, MODALITIES, pace)
            whose = {modality: rows_of_onsets(one.at_ms, there) for modality, one in heard.items()}
            found[where, alpha].append(strokes.ObservedStroke(strokes.MIXED, heard, whose, there))
    return found


def without_pace(one: strokes.ObservedStroke) -> strokes.ObservedStroke:
    return replace(
        one,
        features={
            modality: StrokeFeatures(
                found.at_ms,
                found.features[:, [name != PACE for name in found.names]],
                tuple(name for name in found.names if name != PACE),
            )
            for modality, found in one.features.items()
        },
    )


def balanced(
    preset: ov.Preset,
    lessons: Sequence[strokes.ObservedStroke],
    evaluated: Sequence[strokes.ObservedStroke],
    modality: Modality,
    seed: int,
) -> tuple[float, float]:
    """Return balanced recall of groups and of kinds, without the ends of the timeline."""
    kinds = tuple(preset.kinds)
    rng = np.random.default_rng([seed, MODALITIES.index(modality)])
    forest, names = observing.train_observer(lessons, modality, kinds, rng)
    found = observing.evaluate_observer(evaluated, modality, kinds, forest, names, rng).kinds
    counted = (found.events > 0) & np.array([kind not in AT_THE_ENDS for kind in kinds])
    groups = np.array(groups_of(kinds))
    recalls = []
    for group in dict.fromkeys(groups[counted]):
        rows, columns = np.flatnonzero(counted & (groups == group)), np.flatnonzero(groups == group)
        right = found.confusion[np.ix_(rows, columns)].sum()
        recalls.append(right / found.events[rows].sum())
    return float(np.mean(recalls)), float(found.recall[counted].mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--preset", default="football")
    options = parser.parse_args()
    preset = ov.load_preset(options.preset)
    rows: dict[tuple[str, str, str, float], list[tuple[float, float]]] = {}
    for repeat in range(options.repeats):
        lessons = observed_strokes(preset, LEARNED, 10_000 * repeat)
        evaluated = observed_strokes(preset, EVALUATED, 10_000 * repeat + 5_000_000)
        for where, alpha in lessons:
            if not alpha and where != PLACES[0]:
                continue  # alpha 0 is the same everywhere
            for who in (KNOWN, UNKNOWN):
                pair = [lessons[where, alpha], evaluated[where, alpha]]
                if who == UNKNOWN:
                    pair = [[without_pace(one) for one in pair_strokes] for pair_strokes in pair]
                for modality in MODALITIES:
                    found = balanced(preset, pair[0], pair[1], modality, repeat)
                    rows.setdefault((who, modality, where, alpha), []).append(found)
        print(f"{repeat + 1} of {options.repeats}", flush=True)
    print(f"{preset.name}: balanced recall, %, {options.repeats} times {EVALUATED} timelines")
    print("| movement | sense | scaled | alpha | goal, card, minor | gain | kinds | gain |")
    print("|---" * 8 + "|")
    for (who, modality, where, alpha), scores in rows.items():
        level = 100.0 * np.array(scores)
        gain = level - 100.0 * np.array(rows[who, modality, PLACES[0], 0.0])
        cells = [
            cell
            for i in range(2)
            for cell in (
                f"{level[:, i].mean():.1f}",
                f"{gain[:, i].mean():+.1f} ± {gain[:, i].std(ddof=1):.1f}" if alpha else "",
            )
        ]
        print(f"| {who} | {modality} | {where} | {alpha:g} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
