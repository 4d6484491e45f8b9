"""The same hand again: each pass is the offline render, whatever was felt in between."""

from __future__ import annotations

import shutil
import time
from itertools import pairwise

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.library import preset_path
from overview_dsp.live.inputs.takes_and_lines import parse_command
from overview_dsp.live.output.reconnecting_stream import StreamOpener
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.session import loop, presets
from overview_dsp.live.session.commands import COMMANDS, poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from tests.live.kept_sound import KeptSound

RATE = 48_000
LOOK_S = 0.02


@pytest.fixture
def session(match, tmp_path, monkeypatch):
    """Makes a player on an output that keeps what it was given: both."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    made = []

    def make(preset="football", block_size=256, other=None, **given):
        outputs = []

        def open_stream(engine, settings):
            outputs.append(KeptSound(engine, block_size, settings))
            return outputs[-1]

        player = Player(
            match,
            PresetWatch(preset),
            open_stream,
            OutputSettings(),
            sample_rate=RATE,
            callback="python",
            other=None if other is None else PresetWatch(other),
            **given,
        )
        made.append(player)
        return player, outputs[0]

    yield make
    for player in made:
        player.close()


def wait(player, condition, sound=None, seconds=60.0):
    """Play and poll until a condition holds; what was said meanwhile.

    Without `sound` the output plays by itself, in real time.
    """
    said, until = [], time.monotonic() + seconds
    while time.monotonic() < until:
        said += poll(player).messages
        if condition():
            return said
        if sound is None:
            time.sleep(0.01)
        else:
            sound.play(LOOK_S)
    raise AssertionError(f"waited in vain; {said}")


def passes_begun(player, count):
    return lambda: poll(player).replay is not None and player.loop.passes >= count


def play_a_take(player, sound):
    """A hand over a part of the match, recorded from the first sample on."""
    for i in range(30):
        player.touch(0.1 + 0.02 * i)
        sound.play(LOOK_S)
        poll(player)
    player.release()
    poll(player)


def equals_render(heard, match, preset, gesture):
    """Whether a pass is the offline render, but for its end, which is faded."""
    rendered = ov.render(match, preset, gesture, RATE, tail=1.0, trace=False).samples
    length = min(len(rendered), len(heard) - round(0.1 * RATE))
    return length > 0.6 * RATE and np.array_equal(heard[:length], rendered[:length])


@pytest.mark.parametrize("block_size", [64, 256, 1024])
def test_each_pass_is_the_offline_render_with_another_preset_felt_in_between(
    session, match, football, tmp_path, block_size
):
    # two presets are compared on one map between time and angle
    plain = ov.load_preset("plain")
    plain = plain.with_value("surface.angle_map", football.number("surface.angle_map"))
    player, sound = session(block_size=block_size, other="plain", record=tmp_path / "take.csv")
    play_a_take(player, sound)
    said = []
    player.toggle_replay()
    wait(player, passes_begun(player, 1), sound)
    player.choose_preset(1)
    said += wait(player, passes_begun(player, 2), sound)
    player.choose_preset(0)
    said += wait(player, passes_begun(player, 3), sound)
    wait(player, passes_begun(player, 4), sound)
    player.close()
    gesture = ov.load_gesture(tmp_path / "take.csv")
    _, first, second, third, _ = sound.passes
    assert equals_render(first, match, football, gesture)
    assert equals_render(second, match, plain, gesture)
    assert equals_render(third, match, football, gesture)
    assert any("next pass: B, plain.toml" in line for line in said)
    assert player.engine.meters.late_events == 0


def test_a_saved_preset_file_applies_at_once_and_exactly_in_the_next_pass(
    session, match, tmp_path, monkeypatch
):
    monkeypatch.setattr(presets, "CHECK_EVERY_S", 0.0)
    mine = tmp_path / "mine.toml"
    shutil.copy(preset_path("plain"), mine)
    player, sound = session(str(mine), record=tmp_path / "take.csv")
    play_a_take(player, sound)
    player.toggle_replay()
    wait(player, passes_begun(player, 1), sound)
    before = ov.load_preset(str(mine))
    after = before.with_value("tactor.gain_db", before.number("tactor.gain_db") - 9.0)
    ov.presets.save(after, mine)
    wait(
        player,
        lambda: player.engine.preset.number("tactor.gain_db") == after.number("tactor.gain_db"),
        sound,
    )
    assert player.loop.passes == 1
    wait(player, passes_begun(player, 2), sound)
    # A is the file as it was, B as it is
    player.choose_preset(0)
    wait(player, passes_begun(player, 3), sound)
    wait(player, passes_begun(player, 4), sound)
    player.close()
    gesture = ov.load_gesture(tmp_path / "take.csv")
    passes = sound.passes
    assert equals_render(passes[2], match, ov.load_preset(str(mine)), gesture)
    assert equals_render(passes[3], match, before, gesture)


def test_a_preset_that_is_chosen_twice_changes_during_the_pass(session, tmp_path):
    player, sound = session(other="plain", record=tmp_path / "take.csv")
    play_a_take(player, sound)
    player.toggle_replay()
    wait(player, passes_begun(player, 1), sound)
    player.choose_preset(1)
    assert player.engine.preset.name == "football"
    player.choose_preset(1)
    wait(player, lambda: player.engine.preset.name == "plain", sound)
    assert player.loop.passes == 1


def test_a_take_that_was_zoomed_replays_and_renders_with_its_windows(session, match, football):
    player, sound = session()
    player.show(600.0, 3000.0)
    wait(player, lambda: player.window == (600.0, 3000.0), sound)
    player.toggle_take()
    play_a_take(player, sound)
    player.zoom(2.0, 0.5)
    play_a_take(player, sound)
    player.toggle_take()
    player.toggle_replay()
    wait(player, passes_begun(player, 2), sound)
    player.close()
    gesture = ov.load_gesture(player.takes.ended[0])
    assert gesture.changes[0].what == {"window": [600.0, 3000.0]}
    assert len(gesture.changes) == 2
    assert equals_render(sound.passes[1], match, football, gesture)


def test_a_take_begun_while_the_disk_rests_is_what_was_heard_to_the_bit(session, match, football):
    player, sound = session(other="plain")
    player.show(600.0, 3000.0)
    play_a_take(player, sound)
    player.choose_preset(1)
    player.use_preset("heart")
    wait(player, lambda: player.engine.preset.name == "heart", sound)
    player.choose_preset(0)
    wait(player, lambda: player.engine.preset.name == "football" and player.at_rest, sound)
    player.toggle_take()
    assert player.window == (600.0, 3000.0)
    player.touch(0.6)  # in the crossfade to that window
    play_a_take(player, sound)
    play_a_take(player, sound)
    player.close()
    (take,) = player.takes.ended
    assert player.takes.summaries == [f"take saved as {take}; its render is bit-identical"]
    assert equals_render(sound.passes[-1], match, football, ov.load_gesture(take))


def test_a_take_begun_while_the_disk_moves_says_that_it_is_not(session):
    player, sound = session()
    player.touch(0.7)
    wait(player, lambda: player.engine.meters.touching, sound)
    player.toggle_take()
    wait(player, lambda: player.at_rest, sound)
    player.toggle_take()
    (line,) = player.takes.summaries
    assert "bit-identical" not in line
    assert "the disk was touched or moving" in line


def test_takes_and_replays_alternate_and_replace_none(session):
    player, sound = session()
    player.toggle_replay()
    assert any("no take to replay" in line for line in poll(player).messages)
    for number in range(3):
        player.toggle_take()
        assert poll(player).recording is not None
        play_a_take(player, sound)
        player.toggle_replay()  # ends the take
        wait(player, passes_begun(player, 1), sound)
        assert poll(player).recording is None
        assert len(player.takes.ended) == number + 1
        player.touch(0.5)  # a hand of one's own ends it
        assert not player.loop.playing
        wait(player, lambda: player.engine.meters.touching, sound)
        player.release()
    assert len(set(player.takes.ended)) == 3
    assert all(len(ov.load_gesture(take).time_s) >= 30 for take in player.takes.ended)


def test_a_gesture_that_is_not_looped_is_played_once(session):
    player, sound = session()
    player.loop.begin(ov.tap(0.5, 0.2), "tap", repeats=False)
    wait(player, lambda: not player.loop.playing, sound)
    assert player.engine.meters.strikes > 0


def test_a_pass_ends_some_seconds_after_its_gesture_though_the_disk_never_rests(
    session, monkeypatch
):
    player, sound = session()
    monkeypatch.setattr(loop, "LONGEST_TAIL_S", 0.5)
    player.loop.begin(ov.tap(0.5, 0.2), "tap", repeats=False)
    seconds = ov.tap(0.5, 0.2).duration_s

    def poll_until(time_s):
        while player.engine.sample_time < time_s * player.engine.sample_rate:
            sound.play(0.02)
            player.loop.poll(at_rest=False)

    poll_until(seconds + 0.4)
    assert player.loop.playing
    poll_until(seconds + 0.6)
    assert not player.loop.playing


def test_queued_commands_are_executed_at_the_next_poll(session):
    player, sound = session(other="plain")
    player.queue_command("record")
    player.queue_command("record", "1")  # it is on already
    wait(player, lambda: player.takes.recording_path is not None, sound)
    player.queue_command("window", "600", "1200")
    wait(player, lambda: player.window == (600.0, 1200.0), sound)
    goal_s, end_s = player.timeline.event("goal", 1).time_s, player.timeline.duration_s
    for start, end, shown in (
        ("1:00", "5:00", (60.0, 300.0)),
        ("goal:1-60", "end", (goal_s - 60.0, end_s)),
    ):
        player.queue_command("window", start, end)
        wait(player, lambda shown=shown: player.window == shown, sound)
    player.queue_command("preset", "2")
    wait(player, lambda: player.engine.preset.name == "plain", sound)
    player.queue_command("record", "0")
    wait(player, lambda: player.takes.recording_path is None, sound)
    player.queue_command("replay", "1")
    wait(player, lambda: player.loop.playing, sound)
    player.queue_command("replay", "0")
    wait(player, lambda: not player.loop.playing, sound)
    player.queue_command("preset", "heart")
    wait(player, lambda: player.engine.preset.name == "heart", sound)
    for words, why in (
        (("window", "5"), "window 5: wrong number of arguments; must be window START END"),
        (("window", "x", "y"), "window x y: 'x' is not a moment; give seconds (90.5), m:ss"),
        (("window", "9", "1"), "window 9 1"),
        (("record", "on"), "'on' must be 0, 1 or left out"),
        (("preset", "nothing"), "no preset is called 'nothing'"),
    ):
        player.queue_command(*words)
        assert any(why in line for line in poll(player).messages), words


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("R\n", ("record",)),
        ("p", ("replay",)),
        ("1", ("preset", "1")),
        ("2\n", ("preset", "2")),
        ("window 0 600", ("window", "0", "600")),
        ("1 1", None),
        ("x", None),
        ("", None),
    ],
)
def test_lines_of_input_are_the_keys_too(line, words):
    assert parse_command(line) == words
    assert words is None or words[0] in COMMANDS


def above(signal, hz):
    """The part of a signal above a frequency, by a window that leaks less than -120 dB."""
    window = np.blackman(len(signal))
    spectrum = np.fft.rfft(signal * window)
    frequency = np.fft.rfftfreq(len(signal), 1.0 / RATE)
    loud = np.abs(spectrum[frequency <= hz]).max()
    return 20.0 * np.log10(np.abs(spectrum[frequency > hz]).max() / loud)


@pytest.mark.parametrize("moment", [0.31, 0.4003, 0.52])
def test_a_switch_within_a_pass_adds_no_click(match, moment):
    """The tactor's vibration, which has nothing above 2 kHz, while a hand moves on."""
    a = ov.load_preset("football")
    b = a.with_value("tactor.gain_db", -9.0).with_value("surface.friction", 2e-3)
    engine = ov.Engine(a, match)
    engine.prepare(RATE, RATE)
    sweep = ov.sweep(1.0, 0.2, 0.6)
    engine.control_all(sweep.theta2, sweep.touching, sweep.stamps(RATE), sweep.source)
    engine.set_preset(b, round(moment * RATE))
    out = np.zeros((RATE, 2), dtype=np.float32)
    engine.process(out)
    around = round(moment * RATE)
    assert above(out[around - 6000 : around + 6000, 1].astype(float), 2000.0) < -60.0


@pytest.mark.parametrize("seconds", [0.3, 0.4003, 0.65])
def test_a_pass_that_is_cut_off_while_it_sounds_adds_no_click(session, seconds):
    """By the next one, or by its end."""
    player, sound = session()
    player.loop.begin(ov.sweep(1.0), "sweep")
    sound.play(seconds)
    poll(player)
    player.loop.begin(ov.sweep(1.0), "again")
    sound.play(seconds)
    player.loop.stop()
    sound.play(0.2)
    player.close()
    passes = [one[:, 1].astype(float) for one in sound.passes[1:]]
    assert len(passes) == 3
    for before, after in pairwise(passes):
        around = np.concatenate([before[-6000:], after[:6000]])
        assert np.abs(before[-2000:]).max() > 0.01
        assert above(around, 2000.0) < -60.0


def test_output_rate_and_blocks_change_while_it_plays_and_a_refusal_changes_nothing(
    match, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    player = Player(
        match,
        PresetWatch("football"),
        StreamOpener("none", 256, "native"),
        OutputSettings(),
        record=tmp_path / "take.csv",
        callback="python",
    )
    try:
        player.touch(0.5)
        wait(player, lambda: poll(player).cursor > 0.45)
        player.queue_command("block-size", "64")
        wait(player, lambda: poll(player).block_size == 64)
        assert player.takes.recording_path is not None  # the same engine goes on
        before = poll(player).time_s
        player.queue_command("channels", "2", "1")
        wait(player, lambda: player.output.settings.click.channel == 2)
        player.queue_command("channels", "1+2", "3+4")
        wait(player, lambda: player.output.settings.channels == 4)
        assert player.output.settings.channels_text == "clicks on 1+2, tactor on 3+4"
        player.queue_command("actuator", "c2")
        wait(player, lambda: player.output.settings.actuator is not None)
        player.queue_command("gain", "click", "-3")
        player.queue_command("mute", "tactor")
        wait(player, lambda: player.output.settings.tactor.mute)
        assert player.output.settings.click.gain_db == -3.0
        player.queue_command("rate", "44100")
        wait(player, lambda: poll(player).sample_rate == 44_100)
        assert player.takes.recording_path is None
        assert ov.load_gesture(tmp_path / "take.csv").duration_s >= before - 0.1
        wait(player, lambda: poll(player).time_s > before)
        for words, why in (
            (("rate", "5"), "must be 1000 to 768000 Hz"),
            (("block-size", "-1"), "must be 0 to 8192"),
            (("channels", "1", "1"), "both use channel 1"),
            (("channels", "1", "2,"), "several numbers (3+4), those of each tactor (3,4), or 0"),
            (("actuator", "nothing"), "nothing"),
            (("gain", "left", "3"), "must be click or tactor"),
            (("dance",), "unknown command"),
        ):
            player.queue_command(*words)
            said = poll(player).messages
            assert any(why in line and words[0] in line for line in said), (words, said)
            now = poll(player).time_s
            wait(player, lambda now=now: poll(player).time_s > now)
            assert poll(player).sample_rate == 44_100
    finally:
        player.close()
