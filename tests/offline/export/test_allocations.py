"""No block allocates, in the native callback and in the C voice: malloc is watched."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import overview_dsp as ov

ROOT = Path(__file__).resolve().parents[3]
COUNTER = Path(__file__).with_name("allocations.c")

PLAYED = """
import ctypes, sys
import numpy as np
import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.callback import native_callback
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import connect
from tests.web.surfaces import preset_of

counter, voice = ctypes.CDLL(sys.argv[1]), ctypes.CDLL(sys.argv[2])
BLOCKS, FRAMES = 500, 128
out = np.zeros((FRAMES, 2), np.float32)
callback = ctypes.c_void_p(native_callback().address)
settings = OutputSettings(actuator=ov.load_actuator("lra"))

def fed(preset):
    engine = ov.Engine(preset, ov.load_timeline("world-cup-final-2018"))
    engine.prepare(48_000, FRAMES)
    connect(engine, settings)
    hand = ov.sweep(0.7) + ov.tap(0.9, 0.2)
    engine.control_all(hand.theta2, hand.touching, hand.stamps(48_000), hand.source)
    engine.set("tactor.gain_db", -6.0, sample_time=5_000)
    engine.set("surface.intensity_gain", 2.0, sample_time=9_000)
    return engine

def counted(run, function, memory):
    pointers = [function, ctypes.c_void_p(memory.ctypes.data), ctypes.c_void_p(out.ctypes.data)]
    return run(*pointers, ctypes.c_long(FRAMES), ctypes.c_long(BLOCKS))

careless = ctypes.cast(counter.careless, ctypes.c_void_p)
print("careless", counted(counter.allocations_of_voice, careless, np.zeros(1)), 0)
for name in ("football", "door", "dial"):
    preset = ov.load_preset(name) if name == "football" else preset_of(name)
    engine = fed(preset)
    found = counted(counter.allocations_of_stream, callback, engine.memory)
    print(name, found, engine.meters.strikes)
    engine = fed(preset)
    process = ctypes.cast(voice.overview_process, ctypes.c_void_p)
    found = counted(counter.allocations_of_voice, process, engine.memory)
    print(name, found, engine.meters.strikes)
"""


@pytest.mark.skipif(sys.platform != "linux" or not shutil.which("gcc"), reason="needs gcc on Linux")
def test_no_block_allocates(match, football, tmp_path):
    ov.export.export_c(match, football, tmp_path)
    counter, voice = tmp_path / "counter.so", tmp_path / "voice.so"
    for source, target in ((COUNTER, counter), (tmp_path / "kernel.c", voice)):
        shared = ["gcc", "-O1", "-fno-builtin-malloc", "-fPIC", "-shared"]
        subprocess.run([*shared, str(source), "-o", str(target), "-lm"], check=True)
    done = subprocess.run(
        [sys.executable, "-c", PLAYED, str(counter), str(voice)],
        cwd=ROOT,
        env={**os.environ, "LD_PRELOAD": str(counter)},
        capture_output=True,
        text=True,
        timeout=1200,
    )
    assert done.returncode == 0, done.stderr
    careless, *rows = (line.split() for line in done.stdout.splitlines())
    assert careless == ["careless", "1000", "0"]
    assert len(rows) == 6
    for name, allocated, strikes in rows:
        assert int(allocated) == 0, name
        assert int(strikes) > 5, name
