"""An actuator on a live output: the samples of a render, and the same protection."""

from __future__ import annotations

import ctypes
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.live.output import settings as output_settings
from overview_dsp.live.output.settings import (
    OutputSettings,
    SignalSettings,
    load_settings,
    remembered_actuator,
    save_settings,
)
from overview_dsp.live.output.stream import NullStream, compile_python_path, connect, run_block
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from tests.profiles import share

FRAMES = 24_000
C2 = ov.load_actuator("c2")
LRA = ov.load_actuator("lra")


@pytest.fixture(scope="module")
def football(rigid_football):
    """Here: the actuator is driven at once."""
    return rigid_football


def ready(match, football, given):
    """An engine that has a tap and a release before it, connected to an output."""
    engine = ov.Engine(football, match)
    engine.prepare(48_000, FRAMES)
    connect(engine, given)
    engine.control(3.0, True, 0)
    engine.control(3.0, False, 12_000)
    return engine


def played(engine, sizes):
    out = np.ones((FRAMES, 2), dtype=np.float32)
    start = 0
    for size in [*sizes, FRAMES]:
        run_block(engine, out[start : start + size])
        start += size
        if start >= FRAMES:
            break
    return out


@pytest.fixture(scope="module")
def rendered(match, football):
    gesture = ov.tap(3.0 / np.pi, 0.25)
    with pytest.warns(ov.OverviewWarning):
        return {
            actuator.name: ov.render(
                match, football, gesture, tail=0.5, trace=False, actuator=actuator
            ).samples[:FRAMES]
            for actuator in (C2, LRA)
        }


@pytest.mark.parametrize("actuator", [C2, LRA], ids=["c2", "lra"])
@settings(max_examples=share(0.25))
@given(sizes=st.lists(st.integers(1, 3000), max_size=60))
def test_live_is_the_render_sample_for_sample_in_any_blocks(
    match, football, rendered, actuator, sizes
):
    live = played(ready(match, football, OutputSettings(actuator=actuator)), sizes)
    assert np.abs(live[:, 1]).max() > 0.1
    assert np.array_equal(live, rendered[actuator.name])


def test_the_native_callback_drives_with_the_same_bits(match, football, rendered):
    from overview_dsp.kernels.device.callback import native_callback

    engine = ready(match, football, OutputSettings(actuator=C2))
    call = ctypes.CFUNCTYPE(
        ctypes.c_int, *(2 * (ctypes.c_void_p,)), ctypes.c_ulong, ctypes.c_void_p, ctypes.c_ulong,
        ctypes.c_void_p,
    )(native_callback().address)  # fmt: skip
    out = np.empty((FRAMES, 2), dtype=np.float32)
    for start in range(0, FRAMES, 480):
        block = out[start : start + 480]
        assert call(None, block.ctypes.data, 480, None, 0, engine.memory.ctypes.data) == 0
    assert np.array_equal(out, rendered["c2"])


def test_no_gain_passes_the_peak_and_a_ceiling_takes_off_more(match, football):
    quiet = ov.Actuator(
        "quiet", "quiet", "quiet", {**C2.values, "drive.full_scale": 2.0, "drive.rated_rms": 0.1}
    )
    assert quiet.peak == 0.25
    for ceiling_db, highest in ((0.0, 0.25), (-20.0, 0.1)):
        loud = SignalSettings(2, gain_db=24.0, ceiling_db=ceiling_db)
        given = OutputSettings(tactor=loud, actuator=quiet)
        live = played(ready(match, football, given), [480] * 50)
        assert 0.5 * highest < np.abs(live[:, 1]).max() <= highest


def test_a_stream_that_compiles_first_keeps_its_actuator(match, football, rendered):
    engine = ready(match, football, OutputSettings(actuator=C2))
    compile_python_path(engine)
    assert np.array_equal(played(engine, []), rendered["c2"])


def test_an_output_that_comes_back_finds_its_actuator_warm_and_none_takes_it_off(match, football):
    engine = ready(match, football, OutputSettings(actuator=C2))
    played(engine, [])
    at = layout.L_ACTUATOR
    heat = engine.memory[at + layout.ACT_HEAT]
    assert heat > 0.0
    connect(engine, OutputSettings(actuator=C2))
    assert engine.memory[at + layout.ACT_HEAT] == heat
    assert engine.memory[at + layout.ACT_POSITION] == 0.0
    connect(engine, OutputSettings())
    assert not engine.memory[at : at + layout.ACT_SIZE].any()


def test_a_muted_tactor_is_braked_to_silence(match, football):
    engine = ready(match, football, OutputSettings(actuator=C2))
    out = np.ones((FRAMES, 2), dtype=np.float32)
    run_block(engine, out[:4800])
    OutputSettings(tactor=SignalSettings(2, mute=True), actuator=C2).write(engine.memory, 48_000)
    run_block(engine, out[4800:])
    assert np.abs(out[2400:4800, 1]).max() > 0.1
    assert not out[4800 + 960 + 9600 :, 1].any()


def test_a_devices_actuator_is_remembered_by_what_finds_it_again(tmp_path, monkeypatch):
    path = tmp_path / "outputs.json"
    monkeypatch.setattr(output_settings, "settings_file", lambda: path)
    assert remembered_actuator("pad") is None
    save_settings("pad", OutputSettings(actuator=C2))
    assert remembered_actuator("pad") == "c2"
    assert load_settings("pad") == OutputSettings()
    mine = tmp_path / "c2.toml"
    mine.write_text(
        'schema = 1\ntitle = "Mine"\ndescription = "mine"\n'
        "[resonance]\nfrequency_hz = 250\nq = 2\n[drive]\nrated_rms = 0.1\npeak = 0.3\n",
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    save_settings("pad", OutputSettings(actuator=ov.load_actuator("c2.toml")))
    assert remembered_actuator("pad") == str(mine)
    save_settings("pad", OutputSettings())
    assert remembered_actuator("pad") is None
    # kept by an earlier version
    path.write_text(path.read_text().replace(',\n  "actuator": null', ""))
    assert remembered_actuator("pad") is None
    assert load_settings("pad") == OutputSettings()


def test_a_session_reports_what_the_protection_did(match, football):
    hot = ov.Actuator(
        "hot", "hot", "hot", {**C2.values, "drive.duty": 0.01, "drive.burst_ms": 10.0}
    )
    with_it = OutputSettings(actuator=hot)
    player = Player(match, PresetWatch("football"), lambda e, s: NullStream(e, settings=s), with_it)
    try:
        player.touch(0.9)
        until = time.monotonic() + 20.0
        status = player.poll()
        while status.protected.reduction_db == 0.0 and time.monotonic() < until:
            time.sleep(0.05)
            status = player.poll()
    finally:
        player.close()
    assert status.settings.actuator is hot
    assert status.protected.reduction_db > 0.0
