"""Runs of `tune` on timelines of six kinds: no result is worse than its start elsewhere."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.parameters import KIND_PARAMETERS
from overview_dsp.measure.tuning import JUDGED, _Search, rearranged, tune

TENNIS = {"ace": 8, "double_fault": 5, "break_point": 4, "set": 2}
TENNIS_HEIGHTS = {"set": 60.0, "break_point": 50.0, "ace": 30.0, "double_fault": 25.0}
RUNS = 10  # of each kind


def tennis_match(seed: int) -> ov.Timeline:
    rng = np.random.default_rng(seed)
    names = [name for name, count in TENNIS.items() for _ in range(count)]
    times = np.sort(rng.uniform(60.0, 7000.0, len(names)))
    events = zip(times.tolist(), rng.permutation(names).tolist(), strict=True)
    return ov.Timeline(f"tennis {seed}", 7200.0, events=tuple(ov.Event(*one) for one in events))


def tennis_preset() -> ov.Preset:
    plain = ov.load_preset("plain")
    kinds = {name: ov.EventKind(high, 0.2) for name, high in TENNIS_HEIGHTS.items()}
    kinds = {"default": plain.kinds["default"], **kinds}
    return ov.Preset("tennis", "Tennis", "aces", plain.values, kinds)


def synthetic_preset() -> ov.Preset:
    plain = ov.load_preset("plain")
    kinds = {name: ov.EventKind(30.0 - 2.0 * i, 0.15) for i, name in enumerate("abcd")}
    kinds = {"default": plain.kinds["default"], **kinds}
    return ov.Preset("letters", "Letters", "four kinds", plain.values, kinds)


def shared_matches() -> list[Path]:
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    if folder is None:
        pytest.skip("needs other people's data: set OVERVIEW_TEST_DATA to its folder")
    return sorted(Path(folder, "football", "statsbomb").rglob("*.json"))


def of_match(i: int):
    files = shared_matches()
    return ov.load_preset("football"), ov.load_timeline(files[i % len(files)])


MADE = {
    "shared matches": of_match,
    "matches": lambda i: (ov.load_preset("football"), ov.measure.random_match(i)),
    "tennis": lambda i: (tennis_preset(), tennis_match(i)),
    "shares": lambda i: (ov.load_preset("stocks"), ov.measure.random_share(i)),
    "weather": lambda i: (ov.load_preset("weather"), ov.measure.random_weather(i)),
    "synthetic": lambda i: (synthetic_preset(), ov.measure.random_events(list("abcd"), i)),
}
"""Preset and timeline of a run by the kind of timeline."""


def run(kind: str, i: int) -> Counter[str]:
    """Tune one preset for two or three kinds of its timeline, in a random order; count outcomes."""
    preset, timeline = MADE[kind](i)
    rng = np.random.default_rng(i)
    named = sorted({preset.kind_for(one) for one in timeline.kinds()} & set(timeline.kinds()))
    target = tuple(rng.permutation(named)[: 2 + i % 2].tolist())
    found = tune(preset, target, [timeline], seed=i)
    # other held-out timelines than those of the judgement
    fresh = tuple(rearranged(timeline, np.random.default_rng(1000 + 10 * i + k)) for k in range(2))
    judge = _Search(preset, target, fresh, JUDGED)
    before, after = judge.judged(preset), judge.judged(found.preset)
    assert found.reached == (not found.unreached)
    for line in found.unreached:
        assert " required: " in line
        assert " at " in line
    for name in target:
        height, before_it = found.preset.kinds[name].height, preset.kinds[name].height
        most = min(8.0 * before_it, KIND_PARAMETERS["height"].high)
        assert height == before_it or height < most
    return Counter(
        {
            "runs": 1,
            "reached": found.reached,
            "unreached, with reasons": not found.reached,
            "unchanged": found.preset.kinds == preset.kinds,
            "worse where judged": found.missing_jnds > found.missing_before,
            "worse elsewhere": after.total > before.total + 0.1,
            "JNDs missing before": round(found.missing_before),
            "JNDs missing after": round(found.missing_jnds),
            "elsewhere before": round(before.total),
            "elsewhere after": round(after.total),
        }
    )


@pytest.mark.soak
@pytest.mark.parametrize("kind", MADE)
def test_runs_of_tuning_of_each_kind_are_never_worse(kind, capsys):
    counts: Counter[str] = Counter()
    for i in range(RUNS):
        counts += run(kind, i)
    with capsys.disabled():
        print(f"\n{kind}: {', '.join(f'{name} {count}' for name, count in counts.items())}")
    assert counts["worse where judged"] == counts["worse elsewhere"] == 0
