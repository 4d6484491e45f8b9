"""Ten minutes of automation, rendered by audio workstations, are the engine's bits."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from tests.offline.export.plugin_playing import VALUE, natively

pytestmark = pytest.mark.soak

RATE = 48_000
FILM_S = 600
SCRIPT = Path(__file__).with_name("film.lua")
ARDOUR_CYCLE = 1024
"""Ardour sets values when a cycle begins."""

ARDOUR_PREROLL = 2 * RATE
"""An export is preceded by two seconds, and by some cycles more: the plugin plays from there on."""

BEGINS_S = 120.0
"""Within how long an export has written something."""

HEADER_BYTES = 4096
"""More than a sound file without sound."""

TICK = 25
"""Frames at 48 kHz that are whole ticks of Ardour's beats, of which its automation is made."""


def watched(frames):
    """A finger through the film: it follows, lingers, goes back and lets go; floats, at frames."""
    random = np.random.default_rng(7)
    turned = np.linspace(0.0, 1.0, len(frames))
    turned += 0.02 * np.cumsum(random.normal(0.0, 0.02, len(frames)))
    places = np.clip(turned, 0.0, 1.0).astype(np.float32)
    lifts = np.sort(random.choice(frames[1:], 20, replace=False)).tolist()
    touches = [(0, 1.0), *((at, float(n % 2)) for n, at in enumerate(lifts))]
    return list(zip(frames, places.tolist(), strict=True)), touches


def events_of(places, touches, heard):
    """What a plugin hears, at frames that `heard` makes of those of the automation."""
    both = [("theta2", at, place) for at, place in places]
    both += [("touch", at, touch) for at, touch in touches]
    # the ports of a block are set before it, the angle's first
    rows = [(heard(at), name == "touch", at, name, value) for name, at, value in both]
    return [(VALUE, name, frame, value) for frame, _, _, name, value in sorted(rows)]


def run(command, env, folder, sound=None):
    """Run one of Ardour's programs, which end with 0 unless they crash.

    Before the first sample of an export, its main thread (in `Butler::wait_until_finished`) and the
    one that fetches from disk (in `Session::butler_transport_work`) may wait for each other for
    ever, on a busy machine one time in five, whatever the session holds. Then it is begun again.
    """
    for _ in range(8):
        piped = {"text": True, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        process = subprocess.Popen(command, env=env, cwd=folder, **piped)
        try:
            said, _ = process.communicate(timeout=BEGINS_S)
        except subprocess.TimeoutExpired:
            if sound and (not sound.exists() or sound.stat().st_size < HEADER_BYTES):
                continue
            said, _ = process.communicate(timeout=3600)
        finally:
            process.kill()
            process.wait()
        assert (process.returncode, "Error" in said) == (0, False), said
        return
    pytest.fail(f"{command[0]} never began")


def test_ten_minutes_in_ardour_are_the_engines_bits(match, football, tmp_path):
    if not shutil.which("ardour7-lua"):
        pytest.skip("needs Ardour: apt-get install ardour")
    bundle = ov.export.build_plugin(match, football, "lv2", tmp_path / "lv2", name="film", seed=3)
    (uri,) = re.findall(r"<(urn:[^>]+)> a lv2:Plugin", (bundle / "manifest.ttl").read_text())
    # none where two cycles meet
    frames = [0, *range(700, (FILM_S - 1) * RATE, 14 * ARDOUR_CYCLE)]
    places, touches = watched([at - at % TICK for at in frames])
    rows = [f"0 {place!r} {at}" for at, place in places]
    rows += [f"1 {touch!r} {at}" for at, touch in touches]
    (tmp_path / "events.txt").write_text("\n".join(rows) + "\n")
    env = {**os.environ, "HOME": str(tmp_path), "LV2_PATH": str(tmp_path / "lv2")}
    env |= {"FILM_FOLDER": str(tmp_path), "FILM_URI": uri}
    for name in ("PYTHONPATH", "LD_PRELOAD"):
        env.pop(name, None)

    run(["ardour7-lua", str(SCRIPT)], env, tmp_path)
    session = tmp_path / "session" / "film.ardour"
    saved = session.read_text()
    assert saved.count("<Locations/>") == 1
    superclock = 282_240_000
    whole = f'<Location id="9000" name="session" start="a0" end="a{FILM_S * superclock}"'
    whole += ' flags="IsSessionRange" locked="0" timestamp="0" cue="0"/>'
    session.write_text(saved.replace("<Locations/>", f"<Locations>{whole}</Locations>"))
    film = tmp_path / "film.wav"
    export = ["ardour7-export", "-b", "float", "-o", str(film), str(session.parent), "film"]
    run(export, env, tmp_path, film)
    heard, rate = soundfile.read(film, dtype="float32")
    assert (rate, heard.shape) == (RATE, (FILM_S * RATE, 2))
    begins = -ARDOUR_PREROLL % ARDOUR_CYCLE  # a cycle of the export

    def cycle(at):
        return begins - (begins - at) // ARDOUR_CYCLE * ARDOUR_CYCLE

    for cycles in range(64):
        earlier = ARDOUR_PREROLL + cycles * ARDOUR_CYCLE
        events = events_of(places, touches, lambda at, p=earlier: at and p + cycle(at))
        some = [event for event in events if event[2] < earlier + RATE]
        if np.array_equal(
            heard[:RATE], natively(match, football, RATE, some, earlier + RATE)[earlier:]
        ):
            break
    else:
        pytest.fail("another sound from the first second on")
    expected = natively(match, football, RATE, events, earlier + FILM_S * RATE)[earlier:]
    assert np.abs(expected).max(axis=0).min() > 0.1
    assert np.count_nonzero(heard != expected) == 0


def test_ten_minutes_in_dawdreamer_are_the_engines_bits(match, football, tmp_path):
    daw = pytest.importorskip("dawdreamer", reason="needs DawDreamer: pip install dawdreamer")
    plugin = ov.export.build_plugin(match, football, "vst3", tmp_path, name="film", seed=3)
    block, frames = 512, FILM_S * RATE
    places, touches = watched(list(range(0, (FILM_S - 1) * RATE, 14_425)))
    lines = {"Angle": places, "Touch": touches}
    engine = daw.RenderEngine(RATE, block)
    film = engine.make_plugin_processor("film", str(plugin))
    numbers = {one["name"]: one["index"] for one in film.get_parameters_description()}
    for name, points in lines.items():
        line = np.zeros(frames, np.float32)
        for at, value in points:
            line[at:] = value
        film.set_automation(numbers[name], line)
    engine.load_graph([(film, [])])
    engine.render(FILM_S)
    heard = engine.get_audio().T[:frames]
    expected = natively(
        match,
        football,
        RATE,
        events_of(places, touches, lambda at: -(-at // block) * block),
        frames,
    )
    assert np.abs(expected).max(axis=0).min() > 0.1
    assert np.count_nonzero(heard != expected) == 0
