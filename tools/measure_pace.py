"""Effect of the level's dependence on pace on the recognition of events; prints a table.

A fast movement passes an event with more torque than a slow one. This program multiplies the level
of both channels by (pace / 0.33 timelines per second)^-alpha, at the events or everywhere. Then it
trains and evaluates an observer with movements of mixed pace (`docs/explanation/observer.md`). Each
alpha has the same renders, movements and noise: a gain is the mean of pairs, with its standard
deviation.

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
from overview_dsp.measure.observer.noticed import MODALITIES, PACE, Modality, Noticed, notice
from overview_dsp.measure.observer.scoring import groups_of
from overview_dsp.measure.observer.strokes import Met, met, owners

ALPHAS = (0.0, 0.25, 0.5, 0.71)
"""0.71 is the exponent of pace that football's compression leaves, so it removes all of it."""

SCOPES = ("at events", "everywhere")
USUAL_PACE, SLOWEST, FASTEST = 0.33, 0.05, 2.0
"""Timelines per second; beyond the last two the level follows the pace again."""

BEFORE_MS, AFTER_MS = 5, 40
TRAINED, EVALUATED = 120, 80
AT_THE_ENDS = ("period",)
KNOWN, UNKNOWN = "knows its pace", "does not"
Key = tuple[str, float]


def gains(
    log_pace: NDArray[np.float64], passed: Met, alpha: float, scope: str
) -> NDArray[np.float64]:
    """Return the gain of a stroke's level in each millisecond."""
    pace = np.clip(np.exp(log_pace), SLOWEST, FASTEST)
    everywhere = (pace / USUAL_PACE) ** -alpha
    if scope == "everywhere":
        return np.asarray(everywhere)
    found = np.ones(len(pace))
    for enters, leaves in zip(passed.enters_ms, passed.leaves_ms, strict=True):
        first = min(int(enters), len(pace) - 1)
        found[max(0, first - BEFORE_MS) : int(leaves) + AFTER_MS] = everywhere[first]
    return found


def strokes_by_alpha(
    preset: ov.Preset, count: int, seed: int
) -> dict[Key, list[strokes.StrokeMet]]:
    """Return features of strokes in random timelines at mixed pace, by scope and alpha."""
    timelines = ov.measure.random_timelines(preset, count, seed)
    jobs = [
        ov.RenderJob(timeline, preset, ov.measure.random_hand(seed + i))
        for i, timeline in enumerate(timelines)
    ]
    found: dict[Key, list[strokes.StrokeMet]] = {(w, a): [] for w in SCOPES for a in ALPHAS}
    for done in ov.render_many(jobs, strokes.SOUND_RATE, tail=strokes.ARRIVAL_S, trace=True):
        out = ov.measure.strokes(done.trace.engaged, done.trace.cursor)[0]
        frames = slice(out.start, out.stop)
        passed = met(done.surface, done.trace.cursor[frames], done.sample_rate)
        pace = strokes.log_pace(done.job.gesture)
        samples = done.samples[frames]
        at_ms = np.arange(len(samples)) * (1000.0 / done.sample_rate)
        for scope, alpha in found:
            gain = gains(pace, passed, alpha, scope)
            scaled = samples * np.interp(at_ms, np.arange(len(gain)), gain)[:, None]
            features = notice(np.clip(scaled, -1.0, 1.0), done.sample_rate, MODALITIES, pace)
            whose = {modality: owners(one.at_ms, passed) for modality, one in features.items()}
            found[scope, alpha].append(strokes.StrokeMet(strokes.MIXED, features, whose, passed))
    return found


def without_pace(one: strokes.StrokeMet) -> strokes.StrokeMet:
    return replace(
        one,
        noticed={
            modality: Noticed(
                found.at_ms,
                found.features[:, [name != PACE for name in found.names]],
                tuple(name for name in found.names if name != PACE),
            )
            for modality, found in one.noticed.items()
        },
    )


def balanced(
    preset: ov.Preset,
    training: Sequence[strokes.StrokeMet],
    evaluation: Sequence[strokes.StrokeMet],
    modality: Modality,
    seed: int,
) -> tuple[float, float]:
    """Return the balanced recall of groups and of kinds, without the kinds at the ends."""
    kinds = tuple(preset.kinds)
    rng = np.random.default_rng([seed, MODALITIES.index(modality)])
    forest, names = observing.taught(training, modality, kinds, rng)
    found = observing.asked_of(evaluation, modality, kinds, forest, names, rng).kinds
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
        training = strokes_by_alpha(preset, TRAINED, 10_000 * repeat)
        evaluation = strokes_by_alpha(preset, EVALUATED, 10_000 * repeat + 5_000_000)
        for scope, alpha in training:
            if not alpha and scope != SCOPES[0]:
                continue  # alpha 0 is the same everywhere
            for observer in (KNOWN, UNKNOWN):
                pair = [training[scope, alpha], evaluation[scope, alpha]]
                if observer == UNKNOWN:
                    pair = [[without_pace(one) for one in strokes_met] for strokes_met in pair]
                for modality in MODALITIES:
                    found = balanced(preset, pair[0], pair[1], modality, repeat)
                    rows.setdefault((observer, modality, scope, alpha), []).append(found)
        print(f"{repeat + 1} of {options.repeats}", flush=True)
    print(f"{preset.name}: balanced recall, %, {options.repeats} times {EVALUATED} timelines")
    print("| the observer | sense | scaled | alpha | goal, card, minor | gain | kinds | gain |")
    print("|---" * 8 + "|")
    for (observer, modality, scope, alpha), scores in rows.items():
        level = 100.0 * np.array(scores)
        gain = level - 100.0 * np.array(rows[observer, modality, SCOPES[0], 0.0])
        cells = [
            cell
            for i in range(2)
            for cell in (
                f"{level[:, i].mean():.1f}",
                f"{gain[:, i].mean():+.1f} ± {gain[:, i].std(ddof=1):.1f}" if alpha else "",
            )
        ]
        print(f"| {observer} | {modality} | {scope} | {alpha:g} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
