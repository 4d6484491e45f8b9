"""What a study's page decides and renders by itself is what Python does: in node."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_studies.adaptive import Run, quest_table
from overview_studies.static_mapping import StaticMapping

HERE = Path(__file__).parent
RATE = 8_000


def in_node(given):
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node: apt install nodejs")
    done = subprocess.run(
        [node, str(HERE / "rules.mjs")],
        input=json.dumps(given), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def find_step(task, method, rng, levels=7):
    most = 40
    table = quest_table(np.arange(float(levels)), 0.0 if method == "yesno" else 0.5)
    tracks = [
        {"start": start, "down": down, "steps": [2, 1], "reversals": 4}
        for start, down in ((levels - 1, 2), (levels // 2, 3))
    ]
    return {
        "id": "b1-a1", "type": "adaptive", "task": task, "phase": "main", "block": 1,
        "factors": {}, "output": {}, "method": method, "levels": list(range(levels)),
        "stimuli": [f"s{i}" for i in range(levels)], "standard": "standard", "most": most,
        "sides": rng.integers(0, 2, most).tolist(),
        "catch": (rng.random(most) < 0.2).tolist() if method == "yesno" else [False] * most,
        "tracks": tracks if task == "staircase" else None,
        "quest": table if task == "quest" else None,
    }  # fmt: skip


def by_python(step, rights):
    run, trials = Run(step), []
    for right in rights:
        if run.over:
            break
        presented_stimuli = step["standard"] if run.catch else step["stimuli"][run.level]
        phase = "catch" if run.catch else "main"
        correct = step["sides"][run.trial] if step["method"] == "2afc" else int(not run.catch)
        trials.append([f"b1-a1-{run.trial + 1:03d}", phase, presented_stimuli, correct])
        run.record(bool(right))
    return {"trials": trials, "over": run.over}


def test_a_page_takes_the_levels_that_python_takes():
    rng = np.random.default_rng(3)
    given = []
    for task in ("staircase", "quest"):
        for method in ("2afc", "yesno"):
            for share in (0.5, 0.75, 0.95):
                step = find_step(task, method, rng)
                given.append({"step": step, "rights": (rng.random(40) < share).tolist()})
    found = in_node({"runs": given})["runs"]
    for one, told in zip(given, found, strict=True):
        assert told == by_python(one["step"], one["rights"])
    assert {len(one["trials"]) for one in found} > {40}  # some are over before all are asked


def test_the_control_condition_is_pythons_bit_for_bit():
    rng = np.random.default_rng(4)
    amplitude = rng.random(1025) * 0.5
    carrier = np.round(np.sin(2 * np.pi * np.arange(32) / 32), 9)
    waves = [rng.normal(0, 0.4, 400), rng.normal(0, 0.7, 90)]
    clicks = [(0.2, 0), (0.21, 1), (0.5, 1), (0.8, 0)]
    made = StaticMapping(RATE, 40, amplitude, carrier, clicks, waves)
    # as hands come: in jumps, in small steps, several within a sample, with a landing elsewhere
    gesture = ov.sweep(0.3) + ov.tap(0.6, 0.1) + ov.sweep(0.2, 0.9, 0.1) + ov.tap(0.205, 0.05)
    expected = made.render(gesture, 0.1)
    events = [
        [int(stamp), SOURCES.index("touch"), float(angle), int(holds)]
        for stamp, angle, holds in zip(
            gesture.stamps(RATE), gesture.theta2, gesture.touching, strict=True
        )
    ]
    given = {"data": made.as_json(), "events": events, "frames": len(expected)}
    found = in_node({"mapped": [{**given, "block": block} for block in (128, 100_000)]})["mapped"]
    for one in found:
        words = [base64.b64decode(one[name]) for name in ("click", "tactor")]
        samples = np.column_stack([np.frombuffer(word, "<f4") for word in words])
        assert np.array_equal(samples, expected)
        assert [[s, by, a, h] for s, a, h, by in one["applied"]] == events
    assert np.abs(expected).max(axis=0).min() > 0.1
