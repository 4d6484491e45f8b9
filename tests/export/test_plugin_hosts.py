"""Plugins in hosts that others wrote: pedalboard, DawDreamer, scanners of Ardour and Qtractor."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from tests.export.plugin_playing import (
    DOWN,
    PRESETS,
    UP,
    VALUE,
    both_halves,
    faded,
    natively,
    preset_named,
)

BLOCK, BLOCKS = 512, 50
FRAMES = BLOCK * BLOCKS
QTRACTOR = Path("/usr/lib/x86_64-linux-gnu/qtractor/qtractor_plugin_scan")
ARDOUR = Path("/usr/lib/ardour7/ardour-vst3-scanner")
PLACES = np.minimum(np.arange(BLOCKS) / 40, 1.0).astype(np.float32).tolist()


@pytest.fixture(scope="module")
def timelines(match):
    return both_halves(match)


@pytest.fixture(scope="module")
def presets():
    return {name: preset_named(name) for name in PRESETS}


@pytest.fixture(scope="module")
def build(timelines, presets, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hosts")
    return lambda to: ov.export.build_plugin(
        timelines, [*presets.values()], to, folder, name="Match!", seed=3
    )


@pytest.fixture(scope="module")
def pedalboard():
    return pytest.importorskip("pedalboard", reason="needs pedalboard: pip install pedalboard")


@pytest.fixture(scope="module")
def daw():
    return pytest.importorskip("dawdreamer", reason="needs DawDreamer: pip install dawdreamer")


@pytest.fixture(scope="module")
def vst3(build):
    return str(build("vst3"))


def swept():
    """What is automated, and what an engine hears of it."""
    events = [(VALUE, "theta2", n * BLOCK, place) for n, place in enumerate(PLACES)]
    return [events[0], (VALUE, "touch", 0, 1.0), *events[1:]]


def clicks(plugin, rate):
    """The first output of a sweep in pedalboard, which gives no other, by blocks."""
    plugin.parameters["touch"].raw_value = 1.0
    heard = []
    for place in PLACES:
        plugin.parameters["angle"].raw_value = place
        heard.append(plugin.process([], (BLOCK + 0.5) / rate, rate, 1, BLOCK, False))
    return np.concatenate(heard, axis=1)[0]


@pytest.mark.parametrize("rate", [44_100, 48_000, 96_000, 12_345])
def test_values_in_pedalboard_are_the_engines(pedalboard, vst3, match, presets, rate):
    heard = clicks(pedalboard.load_plugin(vst3), rate)
    expected = natively(match, presets["viscous"], rate, swept(), FRAMES)
    assert np.abs(expected).max() > 0.01
    assert np.array_equal(heard, expected[:, 0])


def test_state_of_pedalboard_opens_in_a_fresh_instance(pedalboard, vst3, timelines, presets):
    first = pedalboard.load_plugin(vst3)
    first.parameters["timeline"].raw_value = 1.0
    first.parameters["click_gain_db"].raw_value = 0.7
    first.process([], 0.01, 48_000, 1, BLOCK, True)
    second = pedalboard.load_plugin(vst3)
    second.raw_state = first.raw_state
    # two at once: neither hears of the other
    heard, again = clicks(second, 48_000), clicks(pedalboard.load_plugin(vst3), 48_000)
    low, high = -60.0, 12.0
    gain = low + float(np.float32(0.7)) * (high - low)
    changed = presets["viscous"].with_changes({"click.gain_db": gain})
    expected = natively(timelines["second half"], changed, 48_000, swept(), FRAMES)
    assert np.abs(expected[:, 0]).max() > 0.01
    assert np.array_equal(heard, expected[:, 0])
    other = natively(timelines["match"], presets["viscous"], 48_000, swept(), FRAMES)
    assert np.array_equal(again, other[:, 0])


@pytest.mark.parametrize("rate", [44_100, 48_000, 96_000])
@pytest.mark.parametrize("name", PRESETS)
def test_automation_and_notes_in_dawdreamer_are_the_engines(daw, vst3, match, presets, name, rate):
    engine = daw.RenderEngine(rate, BLOCK)
    plugin = engine.make_plugin_processor("match", vst3)
    numbers = {one["name"]: one["index"] for one in plugin.get_parameters_description()}
    plugin.set_parameter(numbers["Preset"], PRESETS.index(name) / (len(PRESETS) - 1))
    plugin.set_automation(numbers["Angle"], np.repeat(np.float32(PLACES), BLOCK))
    touch = np.repeat(np.float32([n < 45 for n in range(BLOCKS)]), BLOCK)
    plugin.set_automation(numbers["Touch"], touch)
    begins, lasts = 23_456, 1_000
    plugin.add_midi_note(100, 90, begins / rate, lasts / rate)
    engine.load_graph([(plugin, [])])
    engine.render(FRAMES / rate)
    heard = engine.get_audio().T[:FRAMES]
    events = [*swept(), (VALUE, "touch", 45 * BLOCK, 0.0)]
    events += [(DOWN, 100, begins, 1.0), (UP, 100, begins + lasts, 0.0)]
    events.sort(key=lambda event: event[2])
    expected = natively(match, presets[name], rate, events, FRAMES)
    if name != PRESETS[0]:
        # the first one gives way, and nobody touched it
        expected = faded(np.zeros_like(expected), expected, 0, rate)
    assert np.abs(expected).max(axis=0).min() > 0.01
    assert np.array_equal(heard, expected)


def scanned(program, path, tmp_path, *options, **given):
    done = subprocess.run(
        [program, *options],
        env={**os.environ, "HOME": str(tmp_path), "QT_QPA_PLATFORM": "offscreen", **given},
        input=f"CLAP:{path}\n",
        capture_output=True,
        text=True,
        timeout=600,
    )
    return done.stdout + done.stderr


def test_qtractor_lists_the_clap(build, tmp_path):
    if not QTRACTOR.exists():
        pytest.skip("needs Qtractor: apt-get install qtractor")
    path = build("clap")
    # outputs, MIDI, parameters; it has a state, and is fit for real time
    assert f"CLAP|Match!|0:1|1:0|26:0|EXT,RT|{path}|0|" in scanned(QTRACTOR, path, tmp_path)


def test_ardour_lists_the_vst3(vst3, tmp_path):
    if not ARDOUR.exists() or not shutil.which("ardour7-lua"):
        pytest.skip("needs Ardour: apt-get install ardour")
    library = {"LD_LIBRARY_PATH": str(ARDOUR.parent)}
    said = scanned(ARDOUR, vst3, tmp_path, "-f", "-v", vst3, **library)
    assert "Found Plugin: Match!" in said
    (cache,) = (tmp_path / ".cache").rglob("*.v3i")
    for said in (
        'category="Instrument|Synth"',
        'n_outputs="1"',
        'n_aux_outputs="1"',
        'n_midi_inputs="1"',
    ):
        assert said in cache.read_text()
