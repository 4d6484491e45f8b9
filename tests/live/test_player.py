"""A live session without a device: hand, zoom, presets that change under it, faults, recording."""

from __future__ import annotations

import time
from types import SimpleNamespace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.library import preset_path
from overview_dsp.live.inputs.takes_and_lines import TakeInput, TextLineInput, parse_line
from overview_dsp.live.output import reconnecting_stream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.signal.surface.angle_map import AngleMap


class Outputs:
    """Silent outputs that can be taken away and given back."""

    def __init__(self):
        self.there = True
        self.streams = []

    def __call__(self, engine, settings):
        if not self.there:
            raise ov.InputError("no audio output")
        self.streams.append(NullStream(engine, 256, settings))
        return self.streams[-1]


@pytest.fixture
def outputs():
    return Outputs()


@pytest.fixture
def make(match, outputs, tmp_path):
    made = []

    def player(preset="football", **keywords):
        made.append(
            Player(
                match,
                PresetWatch(preset),
                outputs,
                OutputSettings(),
                callback="python",
                **keywords,
            )
        )
        return made[-1]

    yield player
    for one in made:
        one.close()


def wait(player, condition, seconds=5.0):
    """Poll until `condition(status)`; the messages said meanwhile."""
    said = []
    for _ in range(round(seconds / 0.02)):
        status = player.poll()
        said += status.messages
        if condition(status):
            return said
        time.sleep(0.02)
    raise AssertionError(f"waited in vain: {status}")


def test_a_recorded_session_renders_to_the_same_sound(make, match, football, tmp_path):
    path = tmp_path / "take.csv"
    player = make(record=path)
    player.touch(0.4)
    wait(player, lambda status: abs(status.cursor - 0.4) < 0.01)
    player.zoom(3.0, 0.4)
    player.engine.set("tactor.gain_db", -12.0)
    wait(player, lambda status: status.time_s > 0.8)
    player.tap(0.9)
    wait(player, lambda status: status.cursor > 0.85)
    player.close()
    result = ov.render(match, football, ov.load_gesture(path), tail="none")
    # the same disk in the same place: every bit of the state agrees
    assert result.trace.cursor[player.engine.sample_time - 1] == player.engine.meters.cursor
    assert result.engine.meters.strikes == player.engine.meters.strikes


def test_a_saved_preset_is_felt_and_a_broken_one_reported_while_the_last_good_plays(make, tmp_path):
    path = tmp_path / "mine.toml"
    good = preset_path("football").read_text()
    path.write_text(good)
    height = ov.load_preset("football").kinds["goal"].height
    player = make(str(path))
    wait(player, lambda status: status.time_s > 0.1)
    highest = player.engine.surface.friction.max()
    path.write_text(good.replace(f"height = {height:g}", f"height = {2.0 * height:g}"))
    said = wait(player, lambda status: player.engine.preset.kinds["goal"].height == 2.0 * height)
    assert player.engine.surface.friction.max() == pytest.approx(2.0 * highest, rel=0.05)
    path.write_text("this is no preset [")
    said = []
    for _ in range(30):
        said += player.poll().messages
        time.sleep(0.02)
    assert any("mine.toml" in line and "the previous version stays active" in line for line in said)
    assert player.engine.preset.kinds["goal"].height == 2.0 * height
    path.write_text(good)
    said = wait(player, lambda status: player.engine.preset.kinds["goal"].height == height)


def test_a_preset_file_that_is_deleted_is_reported_once_and_read_again_later(make, tmp_path):
    path = tmp_path / "mine.toml"
    good = preset_path("football").read_text()
    path.write_text(good)
    player = make(str(path))
    path.unlink()
    said = wait(player, lambda status: any("deleted" in line for line in status.messages))
    assert "mine.toml" in said[-1]
    assert "the previous version stays active" in said[-1]
    for _ in range(70):
        assert player.poll().messages == ()
        time.sleep(0.02)
    height = ov.load_preset("football").kinds["goal"].height
    path.write_text(good.replace(f"height = {height:g}", f"height = {2.0 * height:g}"))
    wait(player, lambda status: any("read again" in line for line in status.messages))


def test_zooming_stays_within_the_timeline_and_keeps_the_moment(make):
    player = make("plain")
    whole = player.timeline.duration_s
    for about in (0.0, 0.5, 1.0):
        player.show(0.0, whole)
        wait(player, lambda status: player.window == (0.0, whole))
        for _ in range(60):
            player.zoom(1.5, about)
            player.poll()
        wait(player, lambda status: player.window[1] - player.window[0] == pytest.approx(0.5))
        start, end = player.window
        assert 0.0 <= start < end <= whole
        assert start + (end - start) * about == pytest.approx(whole * about, abs=1e-6)
        player.zoom(1e-9, about)
        wait(player, lambda status: player.window == (0.0, whole))
    with pytest.raises(ov.InputError):
        player.show(5.0, 1.0)


@pytest.mark.parametrize("about", [0.2, 0.4, 0.5, 0.9])
def test_a_zoom_keeps_the_moment_under_a_finger_whatever_events_the_window_has(make, about):
    player = make()
    player.touch(about)
    moment = player.time_at(about)
    for n in range(1, 9):
        player.zoom(1.5, player.pointer.position)
        width = pytest.approx(player.timeline.duration_s / 1.5**n)
        wait(player, lambda status, width=width: player.window[1] - player.window[0] == width)
        assert abs(player.pointer.position - about) < 0.06 * n
        assert player.time_at(player.pointer.position) == pytest.approx(moment, abs=0.05)
    wait(player, lambda status: abs(player.time_at(status.cursor) - moment) < 5.0)


@pytest.mark.parametrize("about", [0.2, 0.4, 0.5, 0.9])
def test_a_zoom_keeps_its_time_as_near_as_any_window_of_that_length_can(
    make, match, football, about
):
    player = make()

    def away(start, end):
        shown = AngleMap.of(match.window(start, end), football)
        return abs(float(shown.position_of(moment - start)) - about)

    for _ in range(5):
        before, moment = player.window, player.time_at(about)
        player.zoom(1.5, about)
        wait(player, lambda status, before=before: player.window != before)
        start, end = player.window
        width = end - start
        starts = np.linspace(max(moment - width, 0.0), min(moment, match.duration_s - width), 40)
        assert away(start, end) < min(away(one, one + width) for one in starts) + 1e-5


def test_another_preset_moves_no_position_during_a_touch(make):
    player = make()
    places = player.engine.surface.angle_map.events
    player.touch(0.5)
    wait(player, lambda status: status.touching)
    player.use_preset("plain")
    wait(player, lambda status: player.engine.preset.name == "plain")
    assert np.array_equal(player.engine.surface.angle_map.events, places)
    moment = player.time_at(0.5)
    assert moment != 0.5 * player.timeline.duration_s
    player.release()
    wait(player, lambda status: player.engine.surface.angle_map.is_linear)
    assert player.engine.preset == ov.load_preset("plain")
    assert player.time_at(0.5) == 0.5 * player.timeline.duration_s


def test_two_presets_are_compared_on_one_map(make):
    player = make(other=PresetWatch("plain"))
    places = player.engine.surface.angle_map.events
    assert not player.engine.surface.angle_map.is_linear
    player.choose_preset(1)
    wait(player, lambda status: player.engine.preset.name == "plain")
    assert np.array_equal(player.engine.surface.angle_map.events, places)


def test_without_the_map_no_preset_has_one(match, outputs):
    player = Player(
        match, PresetWatch("football", linear=True), outputs, OutputSettings(), callback="python"
    )
    assert player.engine.surface.angle_map.is_linear
    player.use_preset("football-stadium")
    wait(player, lambda status: player.engine.preset.name == "football-stadium")
    assert player.engine.surface.angle_map.is_linear
    player.close()


def test_a_lost_output_lets_go_is_reported_and_comes_back(make, outputs):
    player = make()
    player.touch(0.8)
    wait(player, lambda status: status.cursor > 0.75)
    outputs.there = False
    outputs.streams[-1].close()
    said = wait(player, lambda status: status.messages != ())
    assert any("disconnected;" in line for line in said)
    player.touch(0.9)
    assert not player.poll().touching  # nothing is felt where nothing plays
    outputs.there = True
    said = wait(player, lambda status: status.messages != (), 4.0)
    assert any("reconnected" in line for line in said)
    wait(player, lambda status: not status.touching and status.cursor < 0.3)
    player.touch(0.5)
    wait(player, lambda status: abs(status.cursor - 0.5) < 0.02)


def test_a_session_that_was_suspended_says_nothing_of_its_output(make, outputs, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(reconnecting_stream, "time", SimpleNamespace(monotonic=lambda: now[0]))
    player = make()
    stream = outputs.streams[-1]
    stream.close()
    monkeypatch.setattr(NullStream, "active", True)  # it only stands still

    def said(seconds):
        now[0] += seconds
        return [line for line in player.poll().messages if "disconnected;" in line]

    assert said(0.1) == []
    assert said(60.0) == []  # suspended for a minute
    assert [line for _ in range(4) for line in said(0.2)] == []
    assert len([line for _ in range(4) for line in said(0.2)]) == 1


def test_a_take_plays_sample_by_sample(make, match, football, tmp_path):
    path = tmp_path / "again.csv"
    player = make(record=path)
    gesture = ov.sweep(0.5) + ov.tap(0.8, 0.3)
    hand = TakeInput(gesture)
    until = time.monotonic() + 60.0
    while not hand.is_over(player.engine):
        assert time.monotonic() < until
        hand.poll(player.engine)
        player.poll()
        time.sleep(0.02)
    player.close()
    again = ov.load_gesture(path)
    stamps = again.stamps(48_000)[: len(gesture.time_s)]
    assert np.array_equal(stamps - stamps[0], gesture.stamps(48_000))
    assert np.array_equal(again.theta2[: len(gesture.theta2)], gesture.theta2)


@pytest.mark.parametrize(
    ("line", "event"),
    [
        ("1.5 1\n", (1.5, True)),
        ("0.25,0", (0.25, False)),
        ("1.5", None),
        ("x 1", None),
        ("nan 1", None),
        ("1 2", None),
        ("1 1 1", None),
    ],
)
def test_a_line_of_input_is_an_angle_and_a_touch(line, event):
    assert parse_line(line) == event


def test_lines_of_input_move_the_disk_and_their_end_lets_go(make):
    player = make()

    def lines():
        yield "rubbish\n"
        yield "2.0 1\n"
        time.sleep(2.0)
        yield "\n"

    hand = TextLineInput(lines(), player.engine)
    wait(player, lambda status: status.cursor > 0.6)
    wait(player, lambda status: not status.touching)
    assert hand.is_over(player.engine)
    assert (hand.rejected, hand.first_rejected) == (1, "line 1: 'rubbish'")


def test_going_from_event_to_event_takes_the_window_along(make):
    player = make()
    goals = [event.time_s for event in player.timeline.events]
    player.show(goals[0], goals[1] - 1.0)
    wait(player, lambda status: player.window[0] == goals[0])
    for _ in range(200):
        player.go_to_event(1, 1.0)
        player.poll()
        start, end = player.window
        if start <= goals[1] <= end:
            break
    assert player.time_at(player.pointer.position) == pytest.approx(goals[1])
    player.go_to_event(-1, player.pointer.position)
    assert player.time_at(player.pointer.position) < goals[1]


def test_zooming_out_gives_back_the_timeline_without_ticks(make):
    player = make()
    before, whole = player.engine.timeline, player.timeline.duration_s
    for start, end in ((0.0, 600.0), (0.0, whole)):
        player.show(start, end)
        wait(player, lambda status, end=end: player.window == (0.0, end))
        assert ("minute" in player.engine.timeline.kinds()) == (end < whole)
    assert player.engine.timeline == before


def test_what_a_person_should_know_of_a_zoom_is_reported(make):
    from dataclasses import replace

    player = make()
    player.active_window.timeline = replace(player.timeline, gaps=((1000.0, 1001.0),))
    player.show(0.0, 3000.0)
    said = wait(player, lambda status: player.window == (0.0, 3000.0))
    assert any("too narrow" in line for line in said + list(player.poll().messages))
