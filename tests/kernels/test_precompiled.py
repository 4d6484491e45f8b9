"""The machine code that comes with the package: what the sources give, or not used."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import subprocess
import sys
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import precompiled
from overview_dsp.kernels.sources import sources_digest
from tools.c_abi.entry_points import NAMES

ROOT = Path(__file__).resolve().parents[2]
OBJECTS = resources.files("overview_dsp.kernels") / "objects"

# everything that is in the machine code, in one process
PLAYED = """
import ctypes, hashlib, sys
import numpy as np
import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.callback import native_callback
from overview_dsp.kernels.precompiled import usable
from overview_dsp.live.output.settings import OutputSettings, SignalSettings
from overview_dsp.live.output.stream import connect, run_block

match = ov.load_timeline("world-cup-final-2018")
settings = OutputSettings(
    SignalSettings(1, gain_db=6.0, delay_ms=3.0, ceiling_db=-6.0),
    SignalSettings(2),
    ov.load_actuator("c2"),
)
digest = hashlib.sha256()
for preset in ("football", "creaking-door", "clock-key"):
    result = ov.render(
        match, preset, "sweep:0.4+tap:0.9:0.1", sample_rate=44_100, tail=0.2,
        actuator=ov.load_actuator("lra"),
    )
    digest.update(result.samples.tobytes())
    digest.update(np.column_stack([result.trace[name] for name in result.trace]).tobytes())
    digest.update(result.engine.tactor_of(result.trace.torque).tobytes())
    for native in (False, True):
        engine = ov.Engine(ov.load_preset(preset), match, seed=2)
        engine.prepare(48_000, 512)
        connect(engine, settings)
        engine.control(2.0, True, 100)
        engine.set("tactor.gain_db", -3.0, sample_time=4000)
        callback = native_callback().ctypes
        out = np.zeros((512, 2), np.float32)
        for _ in range(24):
            if native:
                callback(None, out.ctypes.data, 512, None, 0, engine.memory.ctypes.data)
            else:
                run_block(engine, out)
            digest.update(out.tobytes())
jobs = [ov.RenderJob(match, ov.load_preset("football"), ov.sweep(0.3), seed) for seed in range(5)]
for trace in (False, True):
    for job in ov.render_many(jobs, sample_rate=44_100, trace=trace, tail=0.1):
        digest.update(job.samples.tobytes())
        if trace:
            digest.update(np.column_stack([job.trace[name] for name in job.trace]).tobytes())
print(usable(), digest.hexdigest())
"""


def played(**environment):
    done = subprocess.run(
        [sys.executable, "-c", PLAYED],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
        timeout=1200,
    )
    used, digest = done.stdout.split()
    return used, digest, done.stderr


def test_it_is_of_these_sources():
    assert not precompiled.is_outdated(), "run python tools/build_kernels.py"


@pytest.mark.skipif(
    precompiled.usable() is None, reason="no machine code is precompiled for this processor"
)
@pytest.mark.soak  # numba compiles everything: 40 s
def test_it_gives_the_bits_that_numba_gives_and_compiles_nothing(tmp_path):
    used, quick, said = played(NUMBA_CACHE_DIR=str(tmp_path))
    assert used == precompiled.usable()
    assert "compiling" not in said
    assert not list(tmp_path.rglob("*.nbc"))
    used, compiled, _ = played(OVERVIEW_JIT="1")
    assert used == "None"
    assert quick == compiled


def test_every_function_of_it_has_a_door():
    assert NAMES.keys() == precompiled.KERNELS


def test_what_is_made_of_other_sources_is_not_used(monkeypatch):
    precompiled.usable.cache_clear()
    monkeypatch.setattr(precompiled, "sources_digest", lambda: "0" * 16)
    try:
        assert precompiled.usable() is None
        assert precompiled.precompiled_function("process") is None
    finally:
        monkeypatch.undo()
        precompiled.usable.cache_clear()


@pytest.mark.parametrize(
    ("features", "expected", "lanes"),
    [
        (precompiled.X86_64_V4, "linux-x86-64-v3", "linux-x86-64-v4"),
        (precompiled.X86_64_V4 - {"avx512f"}, "linux-x86-64-v3", "linux-x86-64-v3"),
        (precompiled.X86_64_V3 - {"avx2"}, "linux-x86-64-v2", "linux-x86-64-v2"),
        (precompiled.X86_64_V2 - {"popcnt"}, None, None),
    ],
)
def test_a_processor_gets_what_it_can_run(monkeypatch, features, expected, lanes):
    monkeypatch.delenv(precompiled.FORCED, raising=False)
    monkeypatch.setattr(precompiled, "runs_as_python", lambda: False)
    monkeypatch.setattr(precompiled, "is_outdated", lambda: False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    every = dict.fromkeys(precompiled.X86_64_V4, False) | dict.fromkeys(features, True)
    monkeypatch.setattr(precompiled.llvm, "get_host_cpu_features", lambda: every)
    assert precompiled.usable.__wrapped__() == expected
    assert precompiled.usable.__wrapped__("process_lanes") == lanes
    monkeypatch.setattr("platform.machine", lambda: "riscv64")
    assert precompiled.usable.__wrapped__() is None


@pytest.fixture
def damageable(monkeypatch, tmp_path):
    """A copy of the machine code that is read in place of the package's, which is restored."""
    if precompiled.usable() is None:
        pytest.skip("no machine code is precompiled for this processor")
    for path in OBJECTS.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    cached = (precompiled.usable, precompiled.manifest, precompiled._content)
    monkeypatch.setattr(precompiled, "_folder", lambda: tmp_path)

    def changed(name, content):
        (tmp_path / name).write_bytes(content)
        for function in cached:
            function.cache_clear()

    yield changed
    monkeypatch.undo()
    for function in cached:
        function.cache_clear()


def damages():
    """40 objects: cut, with random bytes, one byte changed."""
    rng = np.random.default_rng(5)
    whole = (OBJECTS / f"{precompiled.usable()}.o").read_bytes()
    for _ in range(13):
        yield whole[: rng.integers(0, len(whole))]
        at = int(rng.integers(0, len(whole) - 64))
        yield whole[:at] + rng.bytes(64) + whole[at + 64 :]
        at = int(rng.integers(64, len(whole)))  # of a constant or an instruction
        yield whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :]
    yield b""


def test_each_damaged_object_is_named_and_another_gives_the_sound(damageable, football, match):
    best = precompiled.usable()
    expected = ov.render(match, football, "tap:0.6:0.1", sample_rate=8000, tail=0.0).samples
    engine = ov.Engine(football, match)
    engine.prepare(8000, len(expected))
    gesture = ov.tap(0.6, 0.1)
    m = engine.memory
    for content in damages():
        damageable(f"{best}.o", content)
        with pytest.warns(ov.OverviewWarning, match=rf"{best}\.o: damaged, .*reinstall") as noted:
            assert precompiled.usable() != best
        assert len(noted) == 1
        assert "\n" not in str(noted[0].message)
        process = precompiled.precompiled_function("process")
        if process is None:  # no other object fits this processor: numba compiles
            continue
        engine.reset()
        engine.control_all(gesture.theta2, gesture.touching, gesture.stamps(8000), gesture.source)
        out = np.zeros((len(expected), 2), np.float32)
        process(m, m.view(np.int64), m.view(np.uint64), out.ravel(), len(out), 2, m, False)
        assert np.array_equal(out, expected)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"kernels": "0"}', b"\xff\x00"])
def test_without_the_list_of_objects_none_is_used(damageable, content):
    damageable("objects.json", content)
    with pytest.warns(ov.OverviewWarning, match=r"objects\.json: damaged") as noted:
        assert precompiled.usable() is None
    assert len(noted) == 1
    assert precompiled.precompiled_function("process") is None


def test_arrays_that_are_not_in_one_piece_are_refused():
    if precompiled.usable() is None:
        pytest.skip("no machine code is precompiled for this processor")
    door = precompiled.precompiled_function("derive")
    with pytest.raises(ValueError, match="contiguous"):
        door(np.zeros(1000)[::2], None)


@pytest.mark.soak
def test_built_anew_it_is_the_one_in_the_package(tmp_path):
    made = json.loads((OBJECTS / "objects.json").read_text(encoding="utf-8"))
    assert made["kernels"] == sources_digest()
    for part, version in made["toolchain"].items():
        if importlib.metadata.version(part) != version:
            pytest.skip(f"the same bytes need the same tool-chain: pip install {part}=={version}")
    tool = ROOT / "tools" / "build_objects.py"
    subprocess.run([sys.executable, str(tool), str(tmp_path)], check=True)
    for path in tmp_path.iterdir():
        ours = (OBJECTS / path.name).read_bytes()
        assert hashlib.sha256(path.read_bytes()).digest() == hashlib.sha256(ours).digest(), path
