"""The types that a user's checker sees: `mypy --strict` on small programs and on the README's."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

PROGRAM = """
from pathlib import Path
from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov

timeline = ov.load_timeline("world-cup-final-2018")
preset: ov.Preset = ov.load_preset("football")
gesture = ov.sweep(4.0) + ov.pause(2.0) + ov.tap(0.8)

result = ov.render(timeline, preset, gesture, sample_rate=48_000, seed=0)
torque: NDArray[np.float64] = result.trace.torque
assert_type(result.trace["cursor"], NDArray[np.float64])
assert_type(result.samples, NDArray[np.float32])
named: ov.RenderResult = result
assert_type(named.trace, ov.Trace)
assert_type(ov.render(timeline, preset, gesture, trace=False).trace, None)
result.save(Path("out.wav"))
assert_type(ov.render("match.json", "football", "sweep:2").trace, ov.Trace)
without = ov.render(Path("match.json"), Path("mine.toml"), Path("take.csv"), trace=False)
assert_type(without, ov.RenderResult[None])
assert_type(ov.render([1.0, 2.0], tail="none"), ov.RenderResult)

array = np.zeros(100)
for data in (array, array.tolist(), b"time,x", open("a.csv"), open("a.csv", "rb")):
    assert_type(ov.load_timeline(data, rate=10.0), ov.Timeline)
ov.load_timeline([1.0, 2.0], time=array)
ov.load_timeline([(1.0, "goal"), (2.0, "foul", "late")], kind="kind", label="label")
ov.load_timeline([{"time_s": 1.0, "kind": "goal"}])
ov.load_timeline({"time": [0, 1], "value": array})
ov.load_timeline(timeline).plot().savefig("match.png")
result.plot()
preset.plot()
rows = len(result.trace.to_dataframe()) + len(result.strikes.to_dataframe())
rows += len(timeline.to_dataframe("curve"))


class Frame:
    def to_numpy(self, dtype: str | None = None, copy: bool = False) -> NDArray[np.float64]:
        return np.zeros((3, 2))


ov.load_timeline(Frame(), value="x")

def whichever(trace: bool) -> ov.Trace | None:
    return ov.render(timeline, preset, gesture, trace=trace).trace


jobs = ov.render_jobs([timeline], [preset], [gesture], seeds=range(3))
for rendered in ov.render_many(jobs, trace=True):
    assert_type(rendered.trace.envelope, NDArray[np.float64])
for silent in ov.render_many(jobs):
    assert_type(silent.trace, None)

engine = ov.Engine(preset, timeline)
engine.prepare(sample_rate=48_000, max_block_size=512)
out = np.zeros((512, 2), dtype=np.float32)
engine.control(theta2=1.2, touching=True)
engine.process(out)
engine.set("tactor.gain_db", -6.0)
engine.load_state(engine.save_state())
latency: int = engine.latency_samples

loud = preset.with_changes({"surface.friction": 6e-4})
lines: list[str] = ov.measure.feel_report(loud, timeline).warnings()
tuned: ov.Preset = ov.measure.tune(loud, ["goal", "foul"]).preset
between: list[ov.Preset] = ov.presets.morph(preset, loud, steps=5)
ov.presets.save(loud, "loud.toml")
files: tuple[Path, ...] = ov.export.export(result, "ahap", "match.ahap").files
stage = ov.actuators.ActuatorStage(ov.actuators.load("c2"), 48_000)
stage.process(out, channel=1)
with ov.live.OutputStream(engine, device=None, block_size=256) as stream:
    late: int = stream.meters.late
"""

MISTAKES = """
import overview_dsp as ov

result = ov.render(ov.load_timeline("a"), ov.load_preset("b"), ov.sweep(1.0))
result.trace.torqe
ov.render(ov.load_timeline("a"), ov.load_preset("b"), ov.sweep(1.0), trace=False).trace.torque
ov.rendr
ov.render(ov.load_timeline("a"), ov.load_preset("b"), 1.0)
ov.load_timeline(3)
ov.load_timeline([1.0], time=3.0)
ov.load_timeline("a").to_dataframe("curves")
"""


def python_blocks(path):
    return re.findall(r"^( *)```python\n(.*?)^\1```", path.read_text(encoding="utf-8"), re.M | re.S)


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """A function that gives mypy's lines about a program, as a user has it."""
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("needs mypy: pip install '.[dev]'")
    folder = tmp_path_factory.mktemp("user")

    def check(program):
        (folder / "program.py").write_text(program, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "program.py"],
            capture_output=True,
            text=True,
            check=False,
            cwd=folder,
            env={**os.environ, "MYPYPATH": str(ROOT)},
        )
        assert done.returncode in (0, 1), done.stderr
        return [line for line in done.stdout.splitlines() if ": error:" in line]

    return check


def test_a_users_program_passes_mypy_strict(checked):
    assert checked(PROGRAM) == []


def test_the_types_catch_a_users_mistakes(checked):
    lines = [int(line.split(":")[1]) for line in checked(MISTAKES)]
    assert lines == [5, 6, 7, 8, 9, 10, 11]


def test_the_readmes_python_passes_mypy_strict(checked):
    blocks = [block for indent, block in python_blocks(ROOT / "README.md") if not indent]
    assert blocks
    assert checked("\n".join(blocks)) == []
