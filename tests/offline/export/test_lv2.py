"""An LV2 bundle plays the native engine's bits in lilv, and says truly what it holds."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.offline.export.plugin_bundle import parameter_ids
from tests.offline.export.plugin_playing import (
    DOWN,
    FRAMES,
    MIDI,
    PRESETS,
    ROW,
    TRANSPORT,
    TRANSPORTS,
    UP,
    VALUE,
    both_halves,
    followed,
    natively,
    preset_named,
    score,
    switched,
)
from tests.parameters import first_in_gate

HOST = Path(__file__).with_name("lv2_host.c")
BLOCK = 128
PORT_IDS = ["theta2", "touch", "follow", *parameter_ids(), "timeline"]
PORTS = {id: 3 + n for n, id in enumerate(PORT_IDS)}
SYSTEM_BUNDLES = Path("/usr/lib/lv2")


@pytest.fixture(scope="module")
def presets():
    return {name: preset_named(name) for name in PRESETS}


@pytest.fixture(scope="module")
def timelines(match):
    return both_halves(match)


@pytest.fixture(scope="module")
def bundle(timelines, presets, tmp_path_factory):
    folder = tmp_path_factory.mktemp("lv2")
    named = 'a "quoted" \\ name'
    return ov.export.build_plugin(timelines, [*presets.values()], "lv2", folder, name=named, seed=3)


@pytest.fixture(scope="module")
def host(tmp_path_factory):
    found = shutil.which("pkg-config") and subprocess.run(
        ["pkg-config", "--cflags", "--libs", "lilv-0"], capture_output=True, text=True
    )
    if not shutil.which("gcc") or not found or found.returncode:
        pytest.skip("needs gcc, pkg-config and lilv: apt-get install liblilv-dev pkg-config")
    program = tmp_path_factory.mktemp("host") / "lv2_host"
    command = ["gcc", "-std=gnu11", "-Wall", "-Wextra", "-Werror", str(HOST), "-o", str(program)]
    subprocess.run([*command, *found.stdout.split()], check=True, timeout=600)
    return program


def at_blocks(events, preset):
    """The score as control ports hear it: floats, and in each block the last of each.

    A preset's own value, rounded to a float on its way through the host, is its own.
    """
    heard = {}
    for kind, number, frame, value in events:
        if kind == VALUE:
            at = frame - frame % BLOCK
            if at == 0 and number not in ("theta2", "touch"):
                continue  # a voice begins with what its ports say, without a glide
            own, value = preset.values.get(number), float(np.float32(value))
            if isinstance(own, float) and value == np.float32(own):
                value = own
            heard[at, PORTS[number]] = (VALUE, number, at, value)
        else:
            heard[frame, len(PORTS), number] = (kind, number, frame, value)
    return [heard[at] for at in sorted(heard, key=lambda at: at[:2])]


def as_row(kind, number, frame, value):
    if kind == VALUE:
        return kind, PORTS[number], frame, value
    if kind in (MIDI, TRANSPORT):
        return kind, number, frame, value
    return kind, (0x90_00_7F if kind == DOWN else 0x80_00_00) | number << 8, frame, value


def started(host, bundle, *given, fails=False):
    """What the host says of a bundle."""
    command = [host, f"file://{bundle}/", *map(str, given)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert (done.returncode != 0) == fails, done.stderr
    assert fails or not done.stderr
    return done.stderr


@pytest.fixture
def play(bundle, host, tmp_path):
    def run(events, name, rate=48_000):
        rows = np.array([as_row(*event) for event in events], ROW)
        (tmp_path / "events").write_bytes(rows.tobytes())
        which, out = sorted(PRESETS).index(name), tmp_path / "out"
        started(host, bundle, which, "play", rate, BLOCK, FRAMES, tmp_path / "events", out)
        return np.fromfile(out, np.float32).reshape(-1, 2)

    return run


@pytest.mark.parametrize("rate", first_in_gate([12_345.678, 44_100, 48_000, 96_000], 2))
@pytest.mark.parametrize("name", PRESETS)
def test_ports_at_blocks_and_midi_at_any_frame_are_the_engines(match, presets, play, name, rate):
    # a wheel without a key would move what a port holds: a host's next change moves it back
    events = at_blocks(score()[:-1], presets[name])
    assert {DOWN, UP, MIDI} < {kind for kind, *_ in events}
    expected = natively(match, presets[name], rate, events)
    assert np.abs(expected).max(axis=0).min() > 0.01
    assert np.array_equal(play(events, name, rate), expected)


@pytest.mark.parametrize("name", PRESETS)
def test_the_angle_follows_the_transport_of_a_host(match, presets, play, name):
    expected = followed((0, match, presets[name]))
    assert np.array_equal(play([(VALUE, "follow", 0, 1.0), *TRANSPORTS], name), expected)
    assert not play(TRANSPORTS, name).any()


def test_a_transport_that_stopped_is_still_there_when_it_starts_again(match, presets, play):
    """A host may say no place as it stops and starts."""
    # it plays for 7206, 3590 and 1100 frames, and reaches the timeline's end 104 frames later
    plays = [(1, 1_024, 12_000), (0, 8_230, 4_794), (1, 16_411, 4_794), (0, 20_001, 1_204)]
    plays += [(1, 20_011, 1_204), (0, 21_111, 104), (1, 21_127, 104)]
    known = [(TRANSPORT, is_on, at, 5_880.0 - left / 48_000) for is_on, at, left in plays]
    expected = followed((0, match, presets["wells"]), transports=known)
    assert np.abs(expected).max() > 0.01
    said = [known[0], *((*event[:3], np.nan) for event in known[1:])]
    assert np.array_equal(play([(VALUE, "follow", 0, 1.0), *said], "wells"), expected)


def test_another_timeline_fades_in(timelines, presets, play):
    at = 70 * BLOCK
    early = [(VALUE, "theta2", 0, 0.25), (VALUE, "touch", 0, 1.0)]
    late = [(VALUE, "theta2", at + 8 * BLOCK * n, 0.25 + n / 64) for n in range(1, 24)]
    heard = play([*early, (VALUE, "timeline", at, 1.0), *late], "wells")
    images = [(0, timelines["match"]), (at, timelines["second half"])]
    named = [(frame, timeline, presets["wells"]) for frame, timeline in images]
    expected = switched(named, [*early, *late], FRAMES)
    assert np.abs(expected[at:]).max() > 0.01
    assert np.array_equal(heard, expected)


def test_any_values_leave_numbers(play):
    random = np.random.default_rng(5)
    wild = (np.nan, np.inf, -np.inf, 1e30, -1.0, 0.0, 1e-45, 1.0)
    ids = list(PORTS)
    events = [
        (VALUE, ids[random.integers(len(ids))], int(at), float(random.choice(wild)))
        for at in np.sort(random.integers(0, FRAMES, 2_000))
    ]
    heard = play(events, "wells")
    assert np.isfinite(heard).all()
    assert np.abs(heard).max() <= 1.0


@pytest.mark.parametrize("which", range(len(PRESETS)))
def test_every_function_bears_or_refuses_what_can_not_be(bundle, host, which):
    started(host, bundle, which, "probe")


def test_a_damaged_image_is_refused(bundle, host, timelines, presets, tmp_path):
    engine = ov.Engine(presets["viscous"], timelines["match"], seed=3)
    engine.prepare(48_000)
    image = ov.export.encode_engine(engine)
    library = (bundle / "plugin.so").read_bytes()
    begin, half = library.index(image), len(image) // 16 * 8
    random = np.random.default_rng(1).bytes(len(image))
    copy = shutil.copytree(bundle, tmp_path / bundle.name)
    for damaged in (bytes([image[0] ^ 1]), random, image[:half] + bytes(len(image) - half)):
        content = library[:begin] + damaged + library[begin + len(damaged) :]
        (copy / "plugin.so").write_bytes(content)
        which = sorted(PRESETS).index("viscous")
        assert "no instance" in started(host, copy, which, "probe", fails=True)


def test_the_description_of_the_plugin_is_valid(bundle):
    if not shutil.which("lv2_validate") or not shutil.which("sord_validate"):
        pytest.skip("needs lv2_validate: apt-get install lv2-dev sordi")
    done = subprocess.run(
        ["lv2_validate", *sorted(map(str, bundle.glob("*.ttl")))],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "LV2_PATH": str(SYSTEM_BUNDLES)},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 errors" in done.stdout + done.stderr


def uris_of(bundle):
    lines = (bundle / "manifest.ttl").read_text(encoding="ascii").splitlines()
    return [line.split()[0] for line in lines if "a lv2:Plugin" in line]


@pytest.mark.usefixtures("unoptimised", "without_tails")
def test_each_preset_is_a_plugin_of_a_name_that_other_data_keep(bundle, timelines, tmp_path):
    assert bundle.name == "a-quoted-name.lv2"
    uris = uris_of(bundle)
    assert uris == [f"<urn:overview-dsp:a-quoted-name.68d121fa:{name}>" for name in PRESETS]
    louder = preset_named("wells").with_changes({"tactor.gain_db": 3.0, "surface.friction": 1e-3})
    changed = [replace(louder, name="Tür & Tor"), louder]
    other = ov.export.build_plugin(
        timelines["second half"], changed, "lv2", tmp_path, name='a "quoted" \\ name'
    )
    door = "<urn:overview-dsp:a-quoted-name.68d121fa:T%C3%BCr%20%26%20Tor>"
    assert uris_of(other) == [door, uris[-1]]
    described = (bundle / "plugins.ttl").read_text(encoding="utf-8")
    for uri, name in zip(uris, PRESETS, strict=True):
        called = rf'doap:name "a \"quoted\" \\ name, {name}"'
        assert f"{uri} a lv2:InstrumentPlugin , lv2:Plugin ; {called}" in described
