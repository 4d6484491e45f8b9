"""Several tactors: which one vibrates, and live equal to offline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels.device import router
from overview_dsp.kernels.device.callback import native_callback
from overview_dsp.live.output.settings import parse_channels
from overview_dsp.live.output.stream import connect, run_block

RATE = 8000


def routed(routing, **tactors):
    preset = ov.load_preset("football")
    kinds = {
        name: replace(kind, tactor=tactors.get(name, "all")) for name, kind in preset.kinds.items()
    }
    return replace(preset, values={**preset.values, "tactor.routing": routing}, kinds=kinds)


@pytest.fixture(scope="module")
def match():
    events = [ov.Event(20.0 * n, kind, side=side) for n, kind, side in
              ((1, "goal", 1), (2, "red_card", 2), (3, "goal", 2), (4, "foul", 1))]  # fmt: skip
    return ov.Timeline("", 100.0, tuple(events))


def render(match, preset, tactors, gesture="sweep:4", **rest):
    return ov.render(match, preset, gesture, RATE, tactors=tactors, **rest)


def energy_at(result, match, index):
    """Return each tactor's energy while the disk is near an event on its way out."""
    position = result.engine.surface.position[index]
    near = np.abs(result.trace.cursor - position) < 0.004
    near &= np.arange(len(near)) < np.argmax(result.trace.cursor)
    return (result.samples[near, 1:].astype(float) ** 2).sum(axis=0)


def test_one_tactor_is_the_render_as_it_was(match):
    once, again = (
        ov.render(match, "football", "sweep:1", RATE),
        render(match, "football", 1, "sweep:1"),
    )
    assert once.samples.shape[1] == 2
    assert np.array_equal(once.samples, again.samples)


def test_a_position_is_felt_between_its_two_tactors_with_the_power_of_one(match):
    whole = ov.render(match, "football", "sweep:4", RATE)
    split = render(match, "football", 4)
    assert np.array_equal(split.samples[:, 0], whole.samples[:, 0])
    assert np.array_equal(split.trace.theta1, whole.trace.theta1)
    place = np.clip(whole.trace.cursor, 0.0, 1.0) * 3.0
    expected = np.sqrt(np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(4))))
    # weights follow within their smoothing of 3 ms while the disk is slow
    slow = np.abs(np.gradient(place)) < 3.0 / RATE
    far = np.abs(split.samples[:, 1:] - expected * whole.samples[:, 1:])[slow]
    assert slow.mean() > 0.5
    assert far.max() < 0.06 * np.abs(whole.samples[:, 1]).max()
    power = (split.samples[:, 1:].astype(float) ** 2).sum() / (whole.samples[:, 1] ** 2.0).sum()
    assert power == pytest.approx(1.0, abs=0.03)


def test_a_kind_is_felt_by_its_tactor_and_the_surface_by_all(match):
    result = render(match, routed("kind", goal="2", red_card="8"), 3)
    goal, card, second_goal, foul = (energy_at(result, match, index) for index in range(4))
    for strong, tactor in ((goal, 1), (second_goal, 1), (card, 2)):  # 8 is the last one of three
        assert strong[tactor] > 0.9 * strong.sum()  # the surface beside it is felt by all
    assert foul == pytest.approx(np.full(3, foul.mean()), rel=0.03)


def test_a_team_is_felt_by_its_tactor(match):
    result = render(match, routed("team"), 2)
    for index, side in enumerate((1, 2, 2, 1)):
        energy = energy_at(result, match, index)
        assert energy[side - 1] > 0.9 * energy.sum(), index


def test_a_notebook_shows_and_plays_eight_tactors(match):
    page = render(match, "football", 8, "sweep:1")._repr_html_()
    assert "<audio" in page


def test_flac_holds_seven_tactors_and_says_so(match, tmp_path):
    with pytest.raises(ov.InputError, match=r"can't hold 9 channels .* use wav, or another rate"):
        render(match, "football", 8, "sweep:1").save(tmp_path / "arm.flac")
    render(match, "football", 7, "sweep:1").save(tmp_path / "arm.flac")


def test_silence_is_silence_on_every_tactor(match):
    samples = render(match, "football", 8).samples
    assert not samples[-200:].any()
    assert (np.abs(samples[:, 1:]).max(axis=0) > 0.0).all()


def live(preset, match, block, native, delay_ms=0.0, channels=((2,), (4, 6), (3,))):
    """Play a gesture as a stream does; return its samples, float32 (frames, 6)."""
    engine = ov.Engine(preset, match)
    engine.prepare(RATE, 512)
    settings = ov.live.OutputSettings().changed(tactor={"channel": channels, "delay_ms": delay_ms})
    assert connect(engine, settings) == settings.channels
    gesture = ov.sweep(1.0)
    engine.control_all(gesture.theta2, gesture.touching, gesture.stamps(RATE), gesture.source)
    memory = engine.memory
    blocks = []
    call = native_callback()
    for _ in range(2 * RATE // block):
        out = np.zeros((block, settings.channels), np.float32)
        if native:
            call.ctypes(out.ctypes.data, out.ctypes.data, block, None, 0, memory.ctypes.data)
        else:
            run_block(engine, out)
        blocks.append(out)
    return np.concatenate(blocks)


@pytest.mark.parametrize("block", [37, 64, 256])
@pytest.mark.parametrize("native", [False, True])
def test_a_stream_equals_the_render(match, block, native):
    preset = routed("kind", goal="2", red_card="3")
    played = live(preset, match, block, native)
    rendered = render(match, preset, 3, "sweep:1").samples[: len(played)]
    played = played[: len(rendered)]
    assert np.array_equal(played[:, [0, 1, 3, 2]], rendered)
    assert np.array_equal(played[:, 5], played[:, 3])
    assert not played[:, 4].any()


def test_a_delay_keeps_signal_and_tactor_together(match):
    at_once, late = (live(routed("position"), match, 64, True, ms) for ms in (0.0, 10.0))
    frames = RATE // 100
    for channel in (1, 2, 3):
        assert np.array_equal(late[frames:, channel], at_once[:-frames, channel])


def test_a_switch_of_preset_changes_no_bit_with_the_block(match):
    def played(block):
        engine = ov.Engine(routed("position"), match)
        engine.prepare(RATE, 512)
        connect(engine, ov.live.OutputSettings().changed(tactor={"channel": ((2,), (3,))}))
        engine.control(1.0, True)
        engine.set_preset(routed("team"), sample_time=1234)
        out = np.zeros((4096, 3), np.float32)
        for start in range(0, len(out), block):
            run_block(engine, out[start : start + block])
        return out

    first = played(64)
    assert np.array_equal(first, played(128))
    assert np.array_equal(first, played(512))
    assert not np.array_equal(first[1234:, 1], first[1234:, 2])


@pytest.mark.parametrize(
    ("text", "channel"),
    [("0", 0), ("3", 3), ("3+4", (3, 4)), ("3,4", ((3,), (4,))), ("3+5,4", ((3, 5), (4,)))],
)
def test_channels_are_typed(text, channel):
    assert parse_channels(text) == channel


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("3,3", "listed twice"),
        ("0,3", "1 is the first"),
        ("1,2,3,4,5,6,7,8,9", "at most 8"),
        ("3,", "number"),
    ],
)
def test_wrong_channels_are_refused(text, part):
    with pytest.raises(ov.InputError, match=part):
        parse_channels(text)


def test_clicks_are_not_split():
    with pytest.raises(ov.InputError, match="one signal"):
        ov.live.OutputSettings(ov.live.SignalSettings(((1,), (2,))), ov.live.SignalSettings(3))


def test_settings_of_several_tactors_are_kept(tmp_path, monkeypatch):
    from overview_dsp.live.output import settings

    monkeypatch.setattr(settings, "settings_file", lambda: tmp_path / "outputs.json")
    chosen = ov.live.OutputSettings().changed(tactor={"channel": ((3,), (4, 5))})
    settings.save_settings("pad", chosen)
    assert settings.load_settings("pad") == chosen
    assert chosen.channels_text == "clicks on 1, tactors on 3, 4+5"


@pytest.mark.parametrize("count", [0, 9, 2.0])
def test_a_wrong_number_of_tactors_is_refused(match, count):
    with pytest.raises(ov.InputError, match="tactors"):
        ov.render(match, "football", "sweep:1", RATE, tactors=count)


def test_a_stream_that_opens_again_begins_where_the_disk_is(match):
    engine = ov.Engine(ov.load_preset("football"), match)
    engine.prepare(RATE, 512)
    settings = ov.live.OutputSettings().changed(tactor={"channel": ((2,), (3,))})
    connect(engine, settings)
    engine.control(3.0, True)
    for _ in range(40):
        run_block(engine, np.zeros((512, 3), np.float32))
    before = engine.router.memory[router.WEIGHTS :][:2].copy()
    connect(engine, settings)
    assert before[1] > 0.9
    assert engine.router.memory[router.WEIGHTS :][:2] == pytest.approx(before, abs=1e-3)


def test_a_page_has_one_tactor(match):
    engine = ov.Engine(ov.load_preset("football"), match)
    engine.prepare(RATE, 512)
    settings = ov.live.OutputSettings().changed(tactor={"channel": ((2,), (3,))})
    with pytest.raises(ov.InputError, match="one tactor"):
        ov.export.encode_engine(engine, settings)


@pytest.mark.parametrize("channel", [(), ((), (3,)), ([], [])])
def test_a_tactor_without_a_channel_is_refused(channel):
    with pytest.raises(ov.InputError, match="empty"):
        ov.live.SignalSettings(channel)
