"""Lines for people who cannot see the screen: what a key or a movement is answered with."""

from __future__ import annotations

import contextlib
import os
import random
import re
import sys
import time
import types

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.timeline.ticks import Half
from overview_dsp.live.screen import plain_mode
from overview_dsp.live.screen.position_report import PositionReport, event_text, match_minute
from overview_dsp.live.session.session import SessionState
from tests.cli.running import MATCH, environment

if sys.platform == "linux":
    from tests.live.terminal import Terminal

SERIES = ov.Timeline(
    "river",
    1000.0,
    (ov.Event(250.0, "large_rise", "+12 %"),),
    ov.Intensity(np.array([0.0, 100.0, 500.0, 900.0, 1000.0]), np.array([2, 8, 3.25, 5, 5]), "°C"),
    gaps=((600.0, 800.0),),
)


def test_a_position_is_a_moment_with_its_value_and_unit(opened):
    report = PositionReport(opened(SERIES))
    assert report.text(0.3) == "5:00, 5.625 °C."
    assert report.text(0.0) == "0:00, start, 2 °C. Lowest. Passed large rise, +12 %, highest."
    assert report.text(0.1) == "1:40, 8 °C. Highest."
    assert report.text(0.25) == "4:10, 6.219 °C. Large rise, +12 %."
    assert report.text(0.7) == "11:40, no data from 10:00 to 13:20."
    assert report.text(1.0) == "16:40, end, 5 °C."


def test_a_position_in_a_match_has_the_score_and_names_or_counts_what_was_passed(opened, match):
    player = opened(match)
    report = PositionReport(player)

    def at(time_s):
        return report.text(time_s / match.duration_s)

    assert at(60.0) == "1:00, 0 to 0."
    assert at(1650.0) == "27:30, 1 to 1. Goal, Perišić, Croatia. Passed 9 events."
    assert at(1700.0) == "28:20, 1 to 1."
    assert at(2300.0).startswith("38:20, 2 to 1. Passed 2 fouls, 1 near miss, 1 goal")
    assert at(5880.0).startswith("1:38:00, end, 4 to 2. Period, full time. Passed ")
    report.forget()
    assert at(60.0) == "1:00, 0 to 0."


def test_the_score_is_counted_by_sides_with_own_goals_and_corrections(opened):
    names = ("North", "South")
    events = (
        ov.Event(100.0, "own_goal", "Berg", side=2),
        ov.Event(200.0, "goal", "9-9 Lund", side=1),
        ov.Event(300.0, "yellow_card", "Friis (South)", side=2),
        ov.Event(400.0, "goal", side=2),
    )
    report = PositionReport(opened(ov.Timeline("North - South", 1000.0, events, sides=names)))
    assert report.text(0.05) == "0:50, 0 to 0."
    assert report.text(0.1) == "1:40, 0 to 1. Own goal, Berg, for South."
    assert report.text(0.2) == "3:20, 1 to 1. Goal, Lund, North."
    assert report.text(0.3) == "5:00, 1 to 1. Yellow card, Friis (South)."
    assert report.text(1.0) == "16:40, end, 1 to 2. Passed goal, South."
    # the goal was given to the other team, the last one withdrawn
    corrected = (ov.Event(100.0, "own_goal", "Berg", side=1), *events[1:3])
    report = PositionReport(opened(ov.Timeline("North - South", 1000.0, corrected, sides=names)))
    assert report.text(1.0) == "16:40, end, 2 to 0."
    report = PositionReport(opened(ov.Timeline("x", 1000.0, events[2:3], sides=names)))
    assert report.text(0.9) == "15:00, 0 to 0."
    # a goal of an unknown side: the labels tell the score, where they do
    report = PositionReport(opened(ov.Timeline("x", 1000.0, (*events[1:3], ov.Event(9.0, "goal")))))
    assert report.text(0.9) == "15:00, 9 to 9."


def test_events_that_are_close_in_a_long_timeline_are_each_passed_once(opened):
    times = {1.0e8: "strong", 1.0e8 + 600.0: "firm", 2.0e8: "mild"}
    events = tuple(ov.Event(time_s, kind) for time_s, kind in times.items())
    events += (ov.Event(2.0e8, "soft"),)
    report = PositionReport(opened(ov.Timeline("years", 4.0e8, events)))
    for position in (0.0, 1.0e8 / 4.0e8, 0.375, 0.5, 0.625, 1.0):
        report.text(position)
    texts = [report.text(one) for one in (0.0, 0.25, 0.375, 0.5, 0.625, 0.5, 0.25, 0.0)]
    for kind in ("strong", "firm", "mild", "soft"):
        assert sum(kind in one.casefold() for one in texts) == 2, (kind, texts)


def test_events_without_a_curve_and_times_without_data_are_told_apart(opened):
    events = (ov.Event(10.0, "strong", "first"), ov.Event(60.0, "firm"))
    report = PositionReport(opened(ov.Timeline("events", 100.0, events)))
    assert report.text(0.3) == "0:30.0."
    assert report.text(0.6) == "1:00.0. Firm."
    assert report.text(0.05) == "0:05.0. Passed strong, first."
    curve = ov.Intensity(np.array([10.0, 40.0]), np.array([1.0, 2.0]), "m")
    report = PositionReport(opened(ov.Timeline("part", 100.0, (), curve)))
    assert report.text(0.5) == "0:50.0, no data."
    assert report.text(0.25).startswith("0:25.0, 1.5 m.")


class Typing:
    """A session of lines whose keys and time a test gives."""

    def __init__(self, player, address=""):
        self.player, self.lines, self.now = player, [], 100.0
        self.session = plain_mode.LineSession(player, self.lines.append, address)

    def press(self, *keys, seconds=1.0):
        """The lines that these keys are answered with within so long."""
        self.lines.clear()
        for key in keys:
            self.session.press(key)
            self.pass_time(0.03)
        self.pass_time(seconds)
        return list(self.lines)

    def pass_time(self, seconds):
        for _ in range(max(1, round(seconds / 0.03))):
            self.now += 0.03
            for line in plain_mode.poll(self.player).messages:
                self.session.say(line)
            self.session.update(self.now)
            time.sleep(0.001)


def test_each_key_of_the_help_is_answered_and_others_are_named(
    opened, match, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    typing = Typing(opened(match), "https://phone")
    assert typing.press("right") == ["0:59, 0 to 0."]
    # a held key: the newest four times a second, and the last
    lines = typing.press(*["right"] * 20)
    assert 3 <= len(lines) <= 5
    assert lines[-1].startswith("20:35, 1 to 0.")
    assert len(set(lines)) == len(lines)
    assert typing.press("end")[0].startswith("1:38:00, end, 4 to 2.")
    assert typing.press("right") == ["1:38:00, end, 4 to 2."]
    assert typing.press("]") == ["No next event."]
    typing.press("[")  # full time, which has a place of its own
    (line,) = typing.press("[")
    assert "Yellow card, Vrsaljko (Croatia)" in line
    (line,) = typing.press("w")
    assert re.search(r"1:34:30, 4 to 2\. Disk (not held|held by touch)\. ", line)
    assert typing.player.state.text in line
    (line,) = typing.press("escape")
    assert line.startswith("Released at 1:34:30")
    (line,) = typing.press("enter")
    assert line.startswith("Released at 1:34:30")
    # the disk is back: events lie after it
    (line,) = typing.press("]", seconds=1.0)
    assert "No event" not in line
    typing.press("escape")
    assert typing.press("z") == ["No key z. Press question mark."]
    assert typing.press("r") == ["https://phone"]
    assert typing.press("m") == ["clicks muted"]
    assert typing.press("m") == ["clicks on"]
    # the help itself, and all its keys
    lines = typing.press("?")
    assert all(line.isprintable() for line in lines)
    assert {line[:2] for line in lines} >= {"w:", "R:", "c:", "m,", "r:", "q:"}
    # one terminal sends DEL for backspace, another BS; other control characters are no text
    command = [*"gain", "space", *"tactorr", "\x08", *"x", "\x7f", "\x01", "space", *"-7", "enter"]
    forms = typing.press("c", *command)[0]
    assert "gain click|tactor DB" in forms
    assert typing.player.output.settings.tactor.gain_db == -7.0
    lines = typing.press("+")
    assert any(line.startswith("Window ") for line in lines)
    assert any(line == "Window 0:00 to 1:38:00." for line in typing.press("0"))
    assert any("recording" in line for line in typing.press("R"))
    typing.press("home")
    assert any("take saved" in line for line in typing.press("R"))
    assert "Replay." in typing.press("P")
    assert "No replay." in typing.press("P")
    assert any(line.startswith("now B") for line in typing.press("2"))


def test_the_event_that_a_key_goes_to_is_named_also_where_the_finger_is_on_it_already(
    opened, match
):
    typing = Typing(opened(match, "football"))
    assert typing.press("home") == ["0:00, start, 0 to 0. Period, kick-off."]
    assert typing.press("]") == ["0:09, 0 to 0. Period, kick-off."]
    assert typing.press("]") == ["2:55, 0 to 0. Foul (synthetic), France."]


@pytest.mark.parametrize(
    ("command", "answer"),
    [
        ("preset silk", "now silk.toml"),
        ("gain tactor -6", "tactor -6 dB"),
        ("gain click 3", "clicks 3 dB"),
        (
            "actuator c2",
            "output none (no sound), 48000 Hz, 256 frames, clicks on 1, tactor on 2, actuator c2",
        ),
    ],
)
def test_a_command_is_answered_by_what_is_so_now(opened, match, command, answer):
    typing = Typing(opened(match))
    assert "Preset plain.toml." in typing.press("w")[0]
    keys = ("space" if key == " " else key for key in command)
    assert answer in typing.press("c", *keys, "enter")
    if command == "preset silk":
        assert "Preset silk.toml." in typing.press("w")[0]


def test_a_replay_says_the_events_that_it_meets_and_no_mere_positions(opened, match):
    typing = Typing(opened(match))
    typing.press("right", "escape")  # the replay is no movement of this hand
    typing.player.loop.begin(ov.parse_gesture("sweep:1"), "sweep:1", False)
    first, *lines = typing.press(seconds=40.0)
    assert first == "Replay."
    assert sum("Passed" in line for line in lines) >= 3
    assert all(re.search(r"\. \w", line) for line in lines if line != "No replay."), lines


def test_the_figures_are_one_line_with_the_last_stop_and_the_input_beside_them(opened, match):
    player, said = opened(match), []
    source = types.SimpleNamespace(report=dict, status_text="osc:9000: 7 messages")
    player.say("a message in between")
    typing = Typing(player)
    typing.session = plain_mode.LineSession(player, said.append, "", source)
    typing.player.state = SessionState("paused", "", "paused: take.csv, ended")
    typing.session.press("i")
    message, figures, told = said
    assert (message, told) == ("a message in between", "osc:9000: 7 messages")
    assert figures.startswith(
        "Output none (no sound), 48000 Hz, 256 frames. From a movement to the output "
    )
    assert re.search(r" [\d.]+ ms: smoothing [\d.]+ \+ output [\d.]+\. Load ", figures)
    assert "0 blocks late, 0 underflows, 0 frames lost, 0 movements dropped. " in figures
    assert figures.endswith("(last stop: paused: take.csv, ended).")


def test_a_terminal_that_closes_while_a_command_is_typed_ends_the_session(
    opened, match, monkeypatch
):
    keys = ["c", "x", "\x1bq"]
    monkeypatch.setattr(
        plain_mode, "_raw_keys", lambda: contextlib.nullcontext(lambda: keys.pop(0))
    )
    said = []
    plain_mode.run(opened(match), None, lambda: False, said.append)
    assert said[-1] == "No command."


def follow(terminal, wanted, seconds=20.0):
    """Wait for a line; how long that took, s."""
    began = time.monotonic()
    terminal.wait_for(lambda: any(wanted(one) for one in lines_of(terminal)), seconds)
    return time.monotonic() - began


def lines_of(terminal):
    return terminal.shown.decode("utf-8", "replace").replace("\r\n", "\n").split("\n")[:-1]


def answer_keys(tmp_path, count, quickest, slowest):
    """Press that many keys and move as often by OSC; how long each line took."""
    import socket

    from tests.devices.controllers.osc_bytes import message

    surroundings = {**environment(), "XDG_STATE_HOME": str(tmp_path), "PYTHONUNBUFFERED": "1"}
    path = tmp_path / "river.json"
    ov.save_timeline(SERIES, path)
    port = 20_000 + os.getpid() % 10_000
    terminal = Terminal(
        ["play", path, "--preset", "plain", "--device", "none", "--screen", "lines", "--input",
         f"osc:{port}"], surroundings,
    )  # fmt: skip
    terminal.wait_for(lambda: b"q to quit" in terminal.shown)
    terminal.wait_for(lambda: not terminal.echoes)
    dice = random.Random(7)
    took, position = [], 0.0
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def expect(position):
        clock = f"{round(1000.0 * position) // 60}:{round(1000.0 * position) % 60:02d}"
        end = ", start" if position <= 0.0 else ", end" if position >= 1.0 else ""
        value = float(SERIES.intensity.at(np.array([1000.0 * position]))[0])

        def says_it(line):
            if 0.6 < position < 0.8:
                return line.startswith(f"{clock}, no data from 10:00 to 13:20.")
            found = re.match(rf"{clock}{end}, ([\d.]+) °C\.", line)
            # four digits
            return found is not None and abs(float(found[1]) - value) < 0.0006

        took.append(follow(terminal, says_it))
        del terminal.shown[:]

    moves = {"\x1b[C": 0.01, "\x1b[D": -0.01, "\x1b[1;2C": 0.1, "\x1b[1;2D": -0.1}
    for _ in range(count):
        key, step = dice.choice(list(moves.items()))
        position = min(max(position + step, 0.0), 1.0)
        terminal.press(key)
        expect(position)
        time.sleep(dice.uniform(quickest, slowest))
    terminal.press("\x1b")
    follow(terminal, lambda line: line.startswith("Released at"))
    del terminal.shown[:]
    for _ in range(count):
        position = round(dice.uniform(0.01, 0.99), 3)
        out.sendto(message("/overview/theta2", float(np.pi * position), 1), ("127.0.0.1", port))
        expect(position)
        time.sleep(dice.uniform(quickest, slowest))
    # at rest nothing is said
    time.sleep(0.5)
    assert lines_of(terminal) == []
    assert b"\x1b" not in terminal.shown
    terminal.press("q")
    assert terminal.end()[1] == 0
    out.close()
    took.sort()
    print(
        f"{len(took)} answers: median {took[len(took) // 2]:.3f}, worst {took[-1]:.3f} s; "
        f"{sum(one > 0.3 for one in took)} later than 0.3 s"
    )


needs_terminal = pytest.mark.skipif(
    sys.platform != "linux", reason="needs a pseudo-terminal of Linux"
)


@needs_terminal
def test_keys_and_movements_are_answered_with_value_and_unit(tmp_path):
    pytest.importorskip("pythonosc", reason="needs python-osc: pip install '.[osc]'")
    answer_keys(tmp_path, 5, 0.3, 0.4)


@needs_terminal
@pytest.mark.soak
def test_fifty_keys_and_fifty_movements_are_answered(tmp_path):
    answer_keys(tmp_path, 50, 0.3, 2.0)


@needs_terminal
@pytest.mark.parametrize("screen", ["lines", "full"])
def test_a_session_ends_after_its_seconds(tmp_path, screen):
    surroundings = {**environment(), "XDG_STATE_HOME": str(tmp_path)}
    terminal = Terminal(
        ["play", MATCH, "--device", "none", "--screen", screen, "--seconds", "1"], surroundings
    )
    assert terminal.process.wait(60.0) == 0
    assert terminal.echoes
    terminal.close()


def test_minutes_of_a_match_are_counted_from_one_and_added_time_after_45():
    halves = (Half(10.0, 2_890.0, 0, 45, "first half"), Half(2_890.0, 5_700.0, 45, 90, "second"))
    assert match_minute(halves, 0.0) == ("", "")
    assert match_minute(halves, 10.0) == ("1", "first half")
    assert match_minute(halves, 10.0 + 2_699.0) == ("45", "first half")
    assert match_minute(halves, 10.0 + 2_701.0) == ("45+1", "first half")
    assert match_minute(halves, 2_890.0) == ("46", "second")
    assert match_minute(halves, 5_700.0) == match_minute((), 1.0) == ("", "")


def test_the_date_of_an_event_is_not_taken_for_a_score():
    assert event_text(ov.Event(1.0, "trough", "trough 0.9, 2000-12-19")) == "trough 0.9, 2000-12-19"
    assert event_text(ov.Event(1.0, "goal", "2-1 Berg")) == "goal, Berg"
