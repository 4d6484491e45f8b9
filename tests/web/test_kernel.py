"""The browser's kernel is the native one, bit for bit."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.live.output_settings import OutputSettings, SignalSettings
from tests.profiles import share
from tests.web.schedule import BLOCK, FRAMES, RELEASE, change, engine, played
from tests.web.surfaces import preset_of
from tests.web.wasm_runner import WasmKernel

ROOT = Path(__file__).resolve().parents[2]
CLOCKED = [layout.L_LONGEST, layout.L_LATE, layout.L_SECONDS, layout.L_NANOSECONDS]


def rendered(memory, sizes):
    kernel = WasmKernel(memory, FRAMES)
    parts, done = [], 0
    for size in [*sizes, FRAMES]:
        frames = min(size, FRAMES - done)
        if not frames:
            break
        parts.append(kernel.render(frames))
        done += frames
    return np.concatenate(parts), kernel.memory


@pytest.fixture(scope="module")
def native(match, football):
    made = engine(match, football)
    change(made)
    return played(made)


def test_the_schedule_sounds_and_releases(native):
    assert len(native) >= 3 * 48_000
    assert np.abs(native).max(axis=0).min() > 0.1
    assert np.abs(native[RELEASE + 100 :]).max() > 0.001


@pytest.mark.parametrize("size", [1_000, BLOCK, FRAMES])
def test_the_wasm_gives_the_native_bits(match, football, native, size):
    made = engine(match, football)
    change(made)
    out, _ = rendered(made.memory, [size] * (FRAMES // size))
    assert np.array_equal(out, native)


@settings(max_examples=share(0.16))
@given(sizes=st.lists(st.integers(1, 3_000), max_size=300))
def test_no_partition_changes_a_bit(match, football, native, sizes):
    made = engine(match, football)
    change(made)
    out, _ = rendered(made.memory, sizes)
    assert np.array_equal(out, native)


PRESETS = {
    "viscous": lambda: ov.load_preset("football"),
    "bristles": lambda: preset_of("door"),
    "detents": lambda: preset_of("dial"),
}


@pytest.mark.parametrize("preset", PRESETS)
def test_the_whole_memory_stays_the_native_one(match, preset):
    """State, rings, logs, meters, surfaces and the device's columns; not what a clock counts."""
    made = engine(match, PRESETS[preset]())
    models = {"viscous": 0, "bristles": layout.HAS_BRISTLES, "detents": layout.HAS_DETENTS}[preset]
    assert made.memory.view(np.int64)[layout.SURFACES + layout.SLOT_MODELS] & models == models
    out, memory = rendered(made.memory, [BLOCK] * (FRAMES // BLOCK))
    assert np.array_equal(out, played(made, BLOCK))
    ours, theirs = made.memory.view(np.int64).copy(), memory.view(np.int64).copy()
    for columns in (ours, theirs):
        columns[CLOCKED] = 0
        columns[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS] = 0
    assert np.array_equal(ours, theirs)


def test_the_device_stage_and_an_actuator_are_the_native_ones(match, football):
    given = OutputSettings(
        SignalSettings(1, gain_db=6.0, delay_ms=3.0, ceiling_db=-6.0),
        SignalSettings(2, gain_db=-3.0),
        ov.load_actuator("c2"),
    )
    made = engine(match, football, settings=given)
    given.changed(click={"delay_ms": 11.0, "mute": True}).write(made.memory, made.sample_rate)
    out, _ = rendered(made.memory, [BLOCK] * (FRAMES // BLOCK))
    assert np.array_equal(out, played(made, BLOCK))
    assert np.abs(out[:, 1]).max() > 0.1


def test_a_stream_that_is_stopped_fades_and_says_so(match, football):
    made = engine(match, football)
    made.memory.view(np.int64)[layout.L_STOP] = 1
    kernel = WasmKernel(made.memory, FRAMES)
    kernel.render(BLOCK)
    assert not kernel.over
    kernel.render(1_000)
    assert kernel.over
    assert not kernel.render(BLOCK).any()


def test_a_state_that_is_not_finite_is_silenced_and_counted(match, football):
    made = engine(match, football)
    made.memory[layout.V] = np.nan
    kernel = WasmKernel(made.memory, FRAMES)
    assert not kernel.render(BLOCK).any()
    assert kernel.memory.view(np.int64)[layout.M_RESETS] == 1


def sections(module):
    """Number and content of each section of a WebAssembly module."""
    at = 8
    while at < len(module):
        number, at = module[at], at + 1
        size = shift = 0
        more = True
        while more:
            byte, at = module[at], at + 1
            size |= (byte & 127) << shift
            shift, more = shift + 7, byte > 127
        yield number, module[at : at + size]
        at += size


def test_the_kernel_built_anew_is_the_one_in_the_package(tmp_path):
    shipped = (resources.files("overview_dsp.web") / "kernel.wasm").read_bytes()
    notes = [content for number, content in sections(shipped) if number == 0]
    toolchain = json.loads(notes[-1].removeprefix(b"\x09toolchain"))
    for part, version in toolchain.items():
        if importlib.util.find_spec(part) is None or metadata.version(part) != version:
            pytest.skip(f"the same bytes need the same tool-chain: pip install {part}=={version}")
    again = tmp_path / "kernel.wasm"
    subprocess.run([sys.executable, str(ROOT / "tools" / "build_wasm.py"), str(again)], check=True)
    assert again.read_bytes() == shipped


def test_the_kernel_needs_nothing_from_the_page():
    shipped = (resources.files("overview_dsp.web") / "kernel.wasm").read_bytes()
    assert 2 not in [number for number, _ in sections(shipped)]  # section 2 lists imports
