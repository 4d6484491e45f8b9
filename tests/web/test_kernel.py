"""The browser's kernel is the native one, bit for bit."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.kernels import layout
from overview_dsp.kernels.sources import sources_digest
from overview_dsp.live.output.settings import OutputSettings, SignalSettings
from overview_dsp.live.output.stream import connect, run_block
from tests.profiles import share
from tests.web.schedule import BLOCK, FRAMES, RATE, RELEASE, change, engine, played
from tests.web.surfaces import preset_of
from tests.web.wasm_runner import WasmKernel

ROOT = Path(__file__).resolve().parents[2]
DERIVED = slice(layout.DERIVED, layout.DERIVED + layout.COEFFS)
CLOCKED = [layout.L_LONGEST, layout.L_LATE, layout.L_SECONDS, layout.L_NANOSECONDS]


def uncounted(memory):
    """A memory's columns, but those that a clock counts."""
    columns = memory.view(np.int64).copy()
    columns[CLOCKED] = 0
    columns[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS] = 0
    return columns


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
    assert np.array_equal(uncounted(made.memory), uncounted(memory))


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


def unheard(columns):
    """The first surface's columns of modes that no kind rings with, as they are too high."""
    heard = columns[layout.SURFACES + layout.KIND_MODES :][: layout.BANKS]
    mode = np.arange(layout.BANKS * layout.MAX_MODES)
    silent = mode[mode % layout.MAX_MODES >= np.repeat(heard, layout.MAX_MODES)]
    first = layout.SURFACES + layout.MODES + layout.MODE_SIZE * silent
    return np.add.outer(first, np.arange(layout.MODE_SIZE)).ravel()


NODE = shutil.which("node")
SETTINGS = [
    ("tactor.gain_db", -9.0, 4_000),
    ("disk.k2", 6e-3, 9_000),
    ("disk.release", "return", 9_000),
    ("click.mute", True, 20_000),
]
SWITCHED = {"return": 1, True: 1}


@pytest.mark.skipif(NODE is None, reason="needs node")
@pytest.mark.parametrize("rate", [RATE, 44_100, 12_345])
def test_javascript_sets_parameters_and_the_rate_as_an_engine_does(tmp_path, match, rate):
    """From one image: the same samples, and the same memory in every column."""
    preset = preset_of("door")
    given = OutputSettings(actuator=ov.load_actuator("lra"))
    (tmp_path / "image").write_bytes(
        ov.export.encode_engine(engine(match, preset, hands=False), given)
    )
    made = ov.Engine(preset, match, seed=3)
    made.prepare(rate, BLOCK)
    connect(made, given)
    made.control(2.0, True, 100)
    out = np.zeros((300 * BLOCK, 2), np.float32)
    for id, value, at in SETTINGS:
        made.set(id, value, sample_time=at)
    for start in range(0, len(out), BLOCK):
        run_block(made, out[start : start + BLOCK])
    numbers = [(id, SWITCHED.get(value, value), at) for id, value, at in SETTINGS]
    asked = {"rate": rate, "settings": numbers, "block": BLOCK, "blocks": 300}
    script = Path(__file__).with_name("node_kernel.mjs")
    package = str(resources.files("overview_dsp.web"))
    command = [NODE, str(script), package, str(tmp_path), json.dumps(asked)]
    subprocess.run(command, check=True, timeout=600)
    played_there = np.fromfile(tmp_path / "out", np.float32).reshape(-1, 2)
    assert np.abs(out).max(axis=0).min() > 0.01
    assert np.array_equal(played_there, out)
    ours, theirs = uncounted(made.memory), uncounted(np.fromfile(tmp_path / "memory"))
    # where coefficients are made before they are asked for
    ours[DERIVED] = theirs[DERIVED] = 0
    theirs[unheard(ours)] = 0  # of the rate before
    assert np.flatnonzero(ours != theirs).tolist() == []


@pytest.mark.skipif(NODE is None, reason="needs node")
def test_an_invalid_parameter_gives_a_one_line_error(tmp_path):
    web = resources.files("overview_dsp.web")
    script = f"""
        import {{ parameterNumber }} from "{web}/kernel.js";
        for (const [id, value] of [["tactor.loudness", 1], ["tactor.gain_db", 1e9],
                                   ["tactor.gain_db", NaN], ["toString", 0]]) {{
            try {{ parameterNumber(id, value); console.log("taken"); }}
            catch (error) {{ console.log(error.message); }}
        }}
    """
    command = [NODE, "--input-type=module", "-e", script]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=600)
    lines = done.stdout.splitlines()
    low, high = PARAMETERS["tactor.gain_db"].low, PARAMETERS["tactor.gain_db"].high
    assert lines[0].startswith("unknown parameter tactor.loudness; must be one of: disk.inertia,")
    assert lines[1] == f"tactor.gain_db = 1000000000 is out of range; allowed: {low:g} to {high:g}"
    assert lines[2] == f"tactor.gain_db = NaN is out of range; allowed: {low:g} to {high:g}"
    assert lines[3].startswith("unknown parameter toString")
    assert len(lines) == 4


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


def notes(module):
    """What a module says of itself: name and content of its custom sections."""
    custom = [content for number, content in sections(module) if number == 0]
    return {note[1 : 1 + note[0]].decode(): note[1 + note[0] :] for note in custom}


def test_the_kernel_is_made_of_the_sources_as_they_are():
    shipped = (resources.files("overview_dsp.web") / "kernel.wasm").read_bytes()
    assert notes(shipped)["sources"].decode() == sources_digest()


@pytest.mark.soak
def test_the_kernel_built_anew_is_the_one_in_the_package(tmp_path):
    shipped = (resources.files("overview_dsp.web") / "kernel.wasm").read_bytes()
    toolchain = json.loads(notes(shipped)["toolchain"])
    for part, version in toolchain.items():
        if importlib.util.find_spec(part) is None or metadata.version(part) != version:
            pytest.skip(f"the same bytes need the same tool-chain: pip install {part}=={version}")
    again = tmp_path / "kernel.wasm"
    subprocess.run([sys.executable, str(ROOT / "tools" / "build_wasm.py"), str(again)], check=True)
    assert again.read_bytes() == shipped


def test_the_kernel_needs_nothing_from_the_page():
    shipped = (resources.files("overview_dsp.web") / "kernel.wasm").read_bytes()
    assert 2 not in [number for number, _ in sections(shipped)]  # section 2 lists imports
