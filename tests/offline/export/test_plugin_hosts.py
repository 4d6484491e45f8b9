"""Plugins in hosts that others wrote: pedalboard, DawDreamer, scanners of Ardour and Qtractor."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.offline.export.plugin_bundle import parameter_ids
from tests.offline.export.plugin_playing import (
    DOWN,
    PRESETS,
    UP,
    VALUE,
    both_halves,
    faded,
    natively,
    preset_named,
    switched,
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


def clicks(plugins, rate, changes=()):
    """The first outputs of a sweep in pedalboard, which gives no other, of plugins side by side.

    `changes`: rows of a block, which plugin, a parameter, what it is from there on.
    """
    heard = [[] for _ in plugins]
    for plugin in plugins:
        plugin.parameters["touch"].raw_value = 1.0
    for block, place in enumerate(PLACES):
        for at, which, name, value in changes:
            if at == block:
                plugins[which].parameters[name].raw_value = value
        for plugin, blocks in zip(plugins, heard, strict=True):
            plugin.parameters["angle"].raw_value = place
            blocks.append(plugin.process([], (BLOCK + 0.5) / rate, rate, 1, BLOCK, False))
    return [np.concatenate(blocks, axis=1)[0] for blocks in heard]


@pytest.mark.parametrize("rate", [44_100, 48_000, 96_000, 12_345])
def test_values_in_pedalboard_are_the_engines(pedalboard, vst3, match, presets, rate):
    plugin = pedalboard.load_plugin(vst3)
    # it asks for a pair, is told that it has it, and then doesn't take it
    with pytest.raises(ValueError, match="not support 2-channel output"):
        plugin.process([], 0.01, rate, 2, BLOCK, False)
    (heard,) = clicks([pedalboard.load_plugin(vst3)], rate)
    expected = natively(match, presets["viscous"], rate, swept(), FRAMES)
    assert np.abs(expected).max() > 0.01
    assert np.array_equal(heard, expected[:, 0])


IMAGES = ((0, "match", "viscous"), (9, "match", "bristles"), (20, "second half", "bristles"),
          (31, "second half", "wells"))  # fmt: skip
"""Which image plays from which block on."""


def expected_of(images, timelines, presets, rate=48_000):
    named = [(at * BLOCK, timelines[timeline], presets[name]) for at, timeline, name in images]
    expected = switched(named, swept(), FRAMES, rate)
    assert np.abs(expected).max(axis=0).min() > 0.01
    return expected


def test_images_that_pedalboard_switches_fade_in(pedalboard, vst3, timelines, presets):
    changes = [(9, 0, "preset", 0.5), (20, 0, "timeline", 1.0), (31, 0, "preset", 1.0)]
    # the other hears of none of it
    two = [pedalboard.load_plugin(vst3) for _ in range(2)]
    heard, other = clicks(two, 48_000, changes)
    assert np.array_equal(heard, expected_of(IMAGES, timelines, presets)[:, 0])
    assert np.array_equal(other, expected_of(IMAGES[:1], timelines, presets)[:, 0])
    assert [one.parameters["preset"].string_value for one in two] == ["wells", "viscous"]


def in_a_fresh_process(program, *given):
    done = subprocess.run(
        [sys.executable, "-c", program, *map(str, given)],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


PEDALBOARD = """
import sys
import numpy as np, pedalboard
vst3, state, out, places, block = *sys.argv[1:5], int(sys.argv[5])
plugin = pedalboard.load_plugin(vst3)
plugin.raw_state = open(state, "rb").read()
plugin.parameters["touch"].raw_value = 1.0
heard = []
for place in np.load(places):
    plugin.parameters["angle"].raw_value = float(place)
    heard.append(plugin.process([], (block + 0.5) / 48_000, 48_000, 1, block, False))
np.save(out, np.concatenate(heard, axis=1)[0])
"""


def test_state_of_pedalboard_opens_in_a_fresh_process(
    pedalboard, vst3, timelines, presets, tmp_path
):
    first = pedalboard.load_plugin(vst3)
    first.parameters["timeline"].raw_value = 1.0
    first.parameters["preset"].raw_value = 0.5
    first.process([], 0.01, 48_000, 1, BLOCK, True)
    first.parameters["click_gain_db"].raw_value = 0.7
    first.process([], 0.01, 48_000, 1, BLOCK, False)
    (tmp_path / "state").write_bytes(first.raw_state)
    np.save(tmp_path / "places.npy", PLACES)
    out = tmp_path / "out.npy"
    in_a_fresh_process(PEDALBOARD, vst3, tmp_path / "state", out, tmp_path / "places.npy", BLOCK)
    low, high = -60.0, 12.0
    gain = low + float(np.float32(0.7)) * (high - low)
    changed = presets["bristles"].with_changes({"click.gain_db": gain})
    expected = natively(timelines["second half"], changed, 48_000, swept(), FRAMES)
    assert np.abs(expected[:, 0]).max() > 0.01
    assert np.array_equal(np.load(out), expected[:, 0])


def automated(engine, name, vst3, lines):
    """A plugin in DawDreamer with automation: of each parameter what it is, block by block."""
    plugin = engine.make_plugin_processor(name, vst3)
    numbers = {one["name"]: one["index"] for one in plugin.get_parameters_description()}
    for parameter, values in {"Angle": PLACES, **lines}.items():
        plugin.set_automation(numbers[parameter], np.repeat(np.float32(values), BLOCK))
    return plugin


def stepped(*steps):
    """A value a block, from steps of a block and what it is from there on."""
    values = np.zeros(BLOCKS)
    for at, value in steps:
        values[at:] = value
    return values


@pytest.mark.parametrize("rate", [44_100, 48_000, 96_000])
@pytest.mark.parametrize("name", PRESETS)
def test_automation_and_notes_in_dawdreamer_are_the_engines(daw, vst3, match, presets, name, rate):
    engine = daw.RenderEngine(rate, BLOCK)
    plugin = automated(engine, "match", vst3, {"Touch": stepped((0, 1.0), (45, 0.0))})
    numbers = {one["name"]: one["index"] for one in plugin.get_parameters_description()}
    plugin.set_parameter(numbers["Preset"], PRESETS.index(name) / (len(PRESETS) - 1))
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


def test_images_that_dawdreamer_switches_fade_in(daw, vst3, timelines, presets):
    engine = daw.RenderEngine(48_000, BLOCK)
    touch = {"Touch": stepped((0, 1.0))}
    lines = {"Preset": stepped((9, 0.5), (31, 1.0)), "Timeline": stepped((20, 1.0))}
    # the other hears of none of it
    two = [automated(engine, "a", vst3, touch | lines), automated(engine, "b", vst3, touch)]
    for plugin in two:
        plugin.record = True
    engine.load_graph([(plugin, []) for plugin in two])
    engine.render(FRAMES / 48_000)
    for name, images in (("a", IMAGES), ("b", IMAGES[:1])):
        heard = engine.get_audio(name).T[:FRAMES]
        assert np.array_equal(heard, expected_of(images, timelines, presets)), name


DAWDREAMER = """
import sys
import numpy as np, dawdreamer
vst3, state, out, places, block = *sys.argv[1:5], int(sys.argv[5])
engine = dawdreamer.RenderEngine(48_000, block)
plugin = engine.make_plugin_processor("match", vst3)
try:
    plugin.load_state(state)
    sys.exit("it opens no editor any more")
except RuntimeError as error:
    # it asks for one after the state is set
    assert "no available editor" in str(error), error
numbers = {one["name"]: one["index"] for one in plugin.get_parameters_description()}
line = np.repeat(np.load(places).astype(np.float32), block)
plugin.set_automation(numbers["Angle"], line)
plugin.set_automation(numbers["Touch"], np.ones_like(line))
engine.load_graph([(plugin, [])])
engine.render(len(line) / 48_000)
np.save(out, engine.get_audio().T[:len(line)])
"""


def test_state_of_dawdreamer_opens_in_a_fresh_process(daw, vst3, timelines, presets, tmp_path):
    engine = daw.RenderEngine(48_000, BLOCK)
    plugin = engine.make_plugin_processor("first", vst3)
    numbers = {one["name"]: one["index"] for one in plugin.get_parameters_description()}
    engine.load_graph([(plugin, [])])
    plugin.set_parameter(numbers["Timeline"], 1.0)
    plugin.set_parameter(numbers["Preset"], 0.5)
    engine.render(0.05)
    plugin.set_parameter(numbers["Tactor gain"], 0.7)
    engine.render(0.05)
    plugin.save_state(str(tmp_path / "state"))
    np.save(tmp_path / "places.npy", PLACES)
    out = tmp_path / "out.npy"
    in_a_fresh_process(DAWDREAMER, vst3, tmp_path / "state", out, tmp_path / "places.npy", BLOCK)
    low, high = -60.0, 12.0
    gain = low + float(np.float32(0.7)) * (high - low)
    changed = presets["bristles"].with_changes({"tactor.gain_db": gain})
    expected = natively(timelines["second half"], changed, 48_000, swept(), FRAMES)
    assert np.abs(expected).max(axis=0).min() > 0.01
    assert np.array_equal(np.load(out), expected)


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
    count = len(["theta2", "touching", "timeline", "preset", "follow", *parameter_ids()])
    assert f"CLAP|Match!|0:1|1:0|{count}:0|EXT,RT|{path}|0|" in scanned(QTRACTOR, path, tmp_path)


# a mark, for which no plugin is built
@pytest.mark.skipif(
    not ARDOUR.exists() or not shutil.which("ardour7-lua"),
    reason="needs Ardour: apt-get install ardour",
)
def test_ardour_lists_the_vst3(vst3, tmp_path):
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
