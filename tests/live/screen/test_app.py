"""The terminal application, driven without a terminal over a real engine that nobody hears."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import select
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from textual.screen import ModalScreen
from textual.widgets import Static

import overview_dsp as ov
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.output import stream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.screen import PlayApp, plain_mode
from overview_dsp.live.screen import app as app_module
from overview_dsp.live.screen.terminal import TerminalWriter
from overview_dsp.live.screen.timeline_view import TimelineView
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch


@pytest.fixture(autouse=True)
def terminal(monkeypatch):
    """A dark terminal of 256 colours."""
    for name, value in {"TERM": "xterm-256color", "COLORFGBG": "15;0", "LC_ALL": "C.UTF-8"}.items():
        monkeypatch.setenv(name, value)
    for name in ("NO_COLOR", "COLORTERM"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def player(match):
    player = Player(
        match,
        PresetWatch("football"),
        lambda engine, settings: NullStream(engine, 256, settings),
        OutputSettings(),
        callback="python",
    )
    yield player
    player.close()


def run(coroutine):
    """What a coroutine returns, in a thread: a browser's driver may keep this one's event loop."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result()


def drive(player, script, size=(100, 30), **given):
    """Run `script(app, pilot)` in the application; what it returns."""

    async def inside():
        app = PlayApp(player, **given)
        async with app.run_test(size=size) as pilot:
            await pilot.pause(0.2)
            # a busy machine may take longer to lay the screen out
            assert await until(pilot, lambda: app.query_one(TimelineView).size.width > 0)
            result = await script(app, pilot)
        assert app.failure is None
        return result

    return run(inside())


async def until(pilot, condition, seconds=15.0):
    for _ in range(round(seconds / 0.05)):
        await pilot.pause(0.05)
        if condition():
            return True
    return False


def rows(app):
    """The rows of the screen."""
    return [strip.text for strip in app.screen._compositor.render_strips()]


def shows(app, words):
    """Whether words are on the screen."""
    return any(words in row for row in rows(app))


def applied(player):
    """What the hand did so far: (touching, place) of each event the kernel applied."""
    events, _ = player.engine.pop_applied(0)
    return [(bool(event["touching"]), event["theta2"] / np.pi) for event in events]


def cursor(player):
    return player.engine.meters.cursor


def test_a_drag_pulls_the_disk_and_letting_go_recoils_it(player):
    async def script(app, pilot):
        await pilot.mouse_down(TimelineView, offset=(10, 5))
        for x in range(10, 80, 5):
            await pilot.hover(TimelineView, offset=(x, 5))
        place = app.query_one(TimelineView).position(75)
        assert 0.74 < place < 0.77
        assert await until(pilot, lambda: abs(cursor(player) - place) < 0.01)
        assert player.engine.meters.touching
        await pilot.pause(0.3)
        await pilot.mouse_up(TimelineView, offset=(75, 5))
        assert await until(pilot, lambda: cursor(player) < 0.3)
        assert not player.engine.meters.touching

    drive(player, script)


def test_a_click_is_a_tap_that_goes_all_the_way(player, monkeypatch):
    cursors = []  # after each block: the disk is at the click for less than a pause of the pilot

    def run_block(engine, out):
        over = run_one(engine, out)
        cursors.append(cursor(player))
        return over

    run_one = stream.run_block
    monkeypatch.setattr(stream, "run_block", run_block)

    async def script(app, pilot):
        place = app.query_one(TimelineView).position(50)
        assert 0.49 < place < 0.52
        await pilot.click(TimelineView, offset=(50, 5))
        assert await until(pilot, lambda: applied(player)[-1:] == [(False, pytest.approx(place))])
        down, up = player.engine.pop_applied(0)[0]
        assert (bool(down["touching"]), bool(up["touching"])) == (True, False)
        # however short it was, the disk goes all the way
        assert await until(pilot, lambda: abs(max(cursors) - place) < 0.01)
        assert not player.engine.meters.touching
        assert await until(pilot, lambda: cursor(player) < 0.2)
        assert abs(max(cursors) - place) < 0.01

    drive(player, script)


def test_the_keys_move_tap_and_let_go(player):
    async def script(app, pilot):
        await pilot.press("end")
        assert await until(pilot, lambda: cursor(player) > 0.99)
        await pilot.press("shift+left", "left")
        assert await until(pilot, lambda: abs(cursor(player) - 0.89) < 0.005)
        await pilot.press("space")
        assert await until(pilot, lambda: not player.engine.meters.touching)
        before = len(applied(player))
        await pilot.press("enter")
        assert await until(pilot, lambda: (True, pytest.approx(0.89)) in applied(player)[before:])
        await pilot.press("escape", "home")
        assert await until(pilot, lambda: cursor(player) < 0.01)

    drive(player, script)


def test_keys_that_come_faster_than_the_screen_all_count(player):
    async def script(app, pilot):
        player.touch(0.5)
        for _ in range(10):
            app.action_press("right")
        # the finger is exact; how near the disk comes depends on when each key reached it
        assert await until(pilot, lambda: applied(player)[-1] == (True, pytest.approx(0.6)))
        assert await until(pilot, lambda: abs(cursor(player) - 0.6) < 0.02)

    drive(player, script)


def test_bracket_keys_move_from_event_to_event(player):
    async def script(app, pilot):
        await pilot.press("right_square_bracket")
        first = player.engine.surface.position[0]
        assert await until(pilot, lambda: abs(cursor(player) - first) < 0.002)
        await pilot.press("right_square_bracket", "right_square_bracket")
        await pilot.press("left_square_bracket")
        second = player.engine.surface.position[1]
        assert await until(pilot, lambda: abs(cursor(player) - second) < 0.002)

    drive(player, script)


def test_zooming_keeps_the_moment_under_the_disk(player):
    async def script(app, pilot):
        player.touch(0.4)
        assert await until(pilot, lambda: abs(cursor(player) - 0.4) < 0.0002)
        moment = player.time_at(cursor(player))
        for _ in range(4):
            await pilot.press("plus")
            await pilot.pause(0.1)
        # a window waits while two surfaces fade
        width = pytest.approx(player.timeline.duration_s / 1.5**4)
        assert await until(pilot, lambda: player.window[1] - player.window[0] == width)
        assert player.time_at(player.pointer.position) == pytest.approx(moment, abs=5.0)
        assert await until(pilot, lambda: abs(player.time_at(cursor(player)) - moment) < 5.0)
        assert len(player.engine.surface.position) == len(
            player.active_window.window_timeline.events
        )
        goals = [
            event.label
            for event in player.active_window.window_timeline.events
            if "goal" in event.kind
        ]
        assert 0 < len(goals) < 6
        await pilot.press("0")
        assert await until(pilot, lambda: player.window == (0.0, player.timeline.duration_s))

    drive(player, script)


def test_mutes_silence_what_they_name(player):
    async def script(app, pilot):
        await pilot.press("m", "t")
        await pilot.pause(0.2)
        assert (player.output.settings.click.mute, player.output.settings.tactor.mute) == (
            True,
            True,
        )
        player.poll()
        player.touch(0.9)
        await until(pilot, lambda: cursor(player) > 0.8)
        assert app._status.peak_tactor == 0.0
        assert app._status.peak_click == 0.0
        assert await until(pilot, lambda: shows(app, "muted  clicks muted"))
        await pilot.press("t")

        def felt():
            player.touch(0.1 if player.pointer.position > 0.5 else 0.9)
            return app._status.peak_tactor > 0.1

        assert await until(pilot, felt)

    drive(player, script)


@pytest.mark.parametrize("size", [(20, 8), (80, 24), (200, 50)])
def test_the_timeline_fits_any_terminal_and_shows_finger_and_disk(player, size):
    async def script(app, pilot):
        player.touch(1.0)
        await until(pilot, lambda: cursor(player) > 0.99)
        await pilot.resize_terminal(*size)
        await pilot.pause(0.2)
        view = app.query_one(TimelineView)
        assert await until(pilot, lambda: view._drawn is not None and len(view.rows) > 2)
        lines = ["".join(s.text for s in view.render_line(y)) for y in range(view.size.height)]
        assert all(len(line) == size[0] - 38 * (size[0] >= 112) for line in lines)
        # three cells of the disk in the groove, and a line for the finger
        assert [token for _, token in view.rows[view._groove]].count("disk") == 3
        assert any(cell in row for row in view.rows for cell in [("┃", "hand"), ("╋", "hand")])
        player.release()
        await until(pilot, lambda: not player.engine.meters.touching)

    drive(player, script)


def test_the_help_has_no_attribute_of_textuals():
    """Textual's own `_closed` would end its messages."""
    added = set(vars(app_module.TextScreen("text"))) - set(vars(ModalScreen()))
    assert added == {"_text", "_dismissed"}


def test_help_explains_the_keys_and_any_key_closes_it(player):
    async def script(app, pilot):
        await pilot.press("question_mark")
        await pilot.pause(0.1)
        assert "recoils" in str(app.screen.query_one("Static").render())
        await pilot.press("x")
        await pilot.pause(0.1)
        assert app.screen is app.screen_stack[0]

    drive(player, script)


def test_the_output_line_names_the_actuator_and_what_is_taken_back(match):
    player = Player(
        match,
        PresetWatch("football"),
        lambda engine, settings: NullStream(engine, 256, settings),
        OutputSettings(actuator=ov.load_actuator("c2")),
        callback="python",
    )

    async def script(app, pilot):
        await pilot.press("i")
        assert await until(pilot, lambda: shows(app, "latency"))
        return str(app.screen.query_one(Static).render())

    try:
        assert "c2 -0.0 dB" in drive(player, script).splitlines()
    finally:
        player.close()


def test_the_address_for_a_phone_is_shown_and_its_picture_on_a_key(player):
    async def script(app, pilot):
        shown = app.query_one("#invitation", Static)
        assert "open https://10.0.0.2:8765/#token=x" in str(shown.render())
        await pilot.press("r")
        assert "a QR code" in str(app.screen.query_one(Static).render())
        await pilot.press("x")
        assert len(app.screen_stack) == 1

    drive(player, script, invitation="open https://10.0.0.2:8765/#token=x\na QR code")


def test_without_a_server_there_is_no_address(player):
    async def script(app, pilot):
        assert not app.query("#invitation")
        await pilot.press("r")
        assert len(app.screen_stack) == 1

    drive(player, script)


class CountingHand(Input):
    """A sensor that has counted something and has something to say."""

    status_text = "serial:made: binary frames, 90°; 7 readings, 2 damaged"

    def __init__(self):
        self._messages = ["hold it still"]

    def poll(self, engine):
        pass

    def is_over(self, engine):
        return False

    def take_messages(self):
        said, self._messages = tuple(self._messages), []
        return said

    def report(self):
        return {"wait_p50_ms": 1.0, "wait_p99_ms": 2.5}


def test_an_inputs_counters_and_messages_are_on_the_screen(player):
    async def inside():
        app = PlayApp(player, CountingHand())
        async with app.run_test(size=(100, 30)) as pilot:
            assert await until(pilot, lambda: shows(app, "hold it still"))
            assert await until(pilot, lambda: shows(app, "serial:made"))
            await pilot.press("i")
            assert await until(pilot, lambda: shows(app, "7 readings, 2 damaged"))
            output = 1e3 * app._status.stream.latency_s
            path = f"latency {2.5 + 8.0 + output:.1f} ms: input 2.5 + smoothing 8.0 + output"
            assert shows(app, path)

    run(inside())


def test_a_message_disappears_after_its_time(player, monkeypatch):
    monkeypatch.setattr(app_module, "MESSAGE_S", 0.5)

    async def inside():
        app = PlayApp(player, CountingHand())
        async with app.run_test(size=(100, 30)) as pilot:
            assert await until(pilot, lambda: shows(app, "hold it still"))
            assert await until(pilot, lambda: not shows(app, "hold it still"))

    run(inside())


def test_the_load_of_the_callbacks_is_a_key_away(player):
    async def script(app, pilot):
        assert await until(pilot, lambda: app._status is not None)
        before = app._status.stream.longest_s
        await pilot.press("i")
        text = str(app.screen.query_one(Static).render())
        assert "DSP load" in text
        longest = float(re.search(r"max (\d+) µs", text)[1])
        assert 1e6 * before - 1 <= longest <= 1e6 * app._status.stream.longest_s + 1
        assert 0.0 < app._status.stream.load < 5.0
        assert f"{app._status.block_size} frames" in text

    drive(player, script)


@pytest.mark.parametrize("size", [(80, 24), (200, 60)])
def test_torque_and_vibration_scroll_below_the_timeline_and_signs_are_explained(player, size):
    async def script(app, pilot):
        signals = app.query_one("#signals")

        def felt():
            player.touch(0.1 if player.pointer.position > 0.5 else 0.9)
            lines = [signals.render_line(y).text[11 : signals.size.width - 31] for y in (0, 1)]
            return all(set(line) & set("▁▂▃▄▅▆▇") for line in lines)

        assert await until(pilot, felt)
        lines = [signals.render_line(y).text for y in (0, 1)]
        assert all(len(row) == signals.size.width for row in lines)
        assert lines[0].startswith(" torque")
        assert lines[1].startswith(" vibration")
        assert await until(pilot, lambda: re.search(r"−\d+ dB 250 Hz|silent", rows(app)[-3]))
        assert shows(app, "● goal 5")
        assert shows(app, "█ crowd  █ ahead")
        assert app.query_one(TimelineView).size.height >= 8
        assert app.query_one("#keys").region.bottom == size[1]
        await pilot.press("question_mark")
        await pilot.pause(0.1)
        assert "goal" in str(app.screen.query_one("Static").render())

    drive(player, script, size=size)


def test_the_keys_of_takes_replays_and_presets(player, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    async def script(app, pilot):
        await pilot.press("R")
        assert await until(pilot, lambda: player.takes.recording_path is not None)
        await pilot.press("end")
        assert await until(pilot, lambda: cursor(player) > 0.9)
        await pilot.press("R")
        assert await until(pilot, lambda: player.takes.recording_path is None)
        await pilot.press("p")
        assert await until(pilot, lambda: player.loop.playing)
        await pilot.press("1")
        assert await until(pilot, lambda: shows(app, "next pass"))
        await pilot.press("p")
        assert await until(pilot, lambda: not player.loop.playing)
        assert len(list(tmp_path.glob("take-*.csv"))) == 1

    drive(player, script)


def test_a_command_may_be_typed_and_chosen(player):
    async def script(app, pilot):
        await pilot.press("c")
        await pilot.pause(0.5)
        await pilot.press(*"gain", "space", *"tactor", "space", "minus", "7")
        await pilot.pause(0.5)
        await pilot.press("down", "enter")
        assert await until(pilot, lambda: player.output.settings.tactor.gain_db == -7.0)

    drive(player, script)


def test_lines_say_the_position_and_the_event_and_take_the_same_keys(player, monkeypatch):
    surface = player.engine.surface
    goal = next(
        place
        for place, event in zip(surface.position, surface.event, strict=True)
        if player.active_window.window_timeline.events[event].kind == "goal"
    )
    keys = ["?", "m"]
    said = []

    def read():
        if keys:
            return keys.pop(0)
        player.touch(float(goal))
        time.sleep(0.02)
        return "q" if any("Goal" in line for line in said[2:]) else ""

    @contextlib.contextmanager
    def reading():
        yield read

    monkeypatch.setattr(plain_mode, "_raw_keys", reading)
    began = time.monotonic()
    plain_mode.run(player, None, lambda: time.monotonic() - began > 20.0, said.append)
    assert said[0].startswith(player.timeline.title)
    assert said[1].startswith("Left and Right")
    assert "clicks muted" in said
    assert any("Goal" in line for line in said[2:])
    assert player.output.settings.click.mute


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("\x1b[C\x1b[1;2D", ["right", "shift+left"]),
        ("\x1b", ["escape"]),
        ("\x1b[", ["escape", "["]),
        ("\x1b[A]\x1b[15~", ["of that name", "]", "of that name"]),
        ("R \r]", ["R", "space", "enter", "]"]),
        ("\x1b[H\x1b[4~", ["home", "end"]),
        ("\x03", ["q"]),
    ],
)
def test_keys_are_told_from_what_a_terminal_sends(text, keys):
    assert list(plain_mode.parse_keys(text)) == keys


class Pipe:
    """A terminal that reads nothing until it is let."""

    def __init__(self):
        self.reader, self.writer = os.pipe()

    def fileno(self):
        return self.writer


def test_a_terminal_that_reads_nothing_holds_nobody_up_and_is_drawn_anew_later():
    file = Pipe()
    writer = TerminalWriter(file)
    writer.start()
    for _ in range(200):
        writer.write("x" * 4096)  # a pipe holds 64 kB
    writer.write("\x1b[?25h")
    writer.stop()
    assert writer.is_alive()
    assert not writer.pop_skipped()
    read = b""
    while not read.endswith(b"\x1b[?25h"):
        assert select.select([file.reader], [], [], 30.0)[0]
        read += os.read(file.reader, 65_536)
    writer.join(10.0)
    assert len(read) < 200 * 4096
    assert writer.pop_skipped()
    os.close(file.reader)
    os.close(file.writer)


def test_a_terminal_that_has_gone_is_noticed():
    file = Pipe()
    os.close(file.reader)
    writer = TerminalWriter(file)
    writer.start()
    writer.write("x")
    writer.join(5.0)
    assert writer.closed
    writer.stop()
    os.close(file.writer)


@pytest.mark.parametrize("size", [(80, 24), (40, 12)])
def test_help_quit_and_the_way_to_move_are_on_screens_of_any_size(player, size, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    moment = re.compile(r"\b(0:[3-5]\d|1:[0-3]\d)\b")

    async def script(app, pilot):
        assert await until(pilot, lambda: shows(app, "hold →"))
        idle = " No input  nothing touches the disk"
        assert await until(pilot, lambda: rows(app)[-2].startswith(idle))
        assert rows(app)[-1].endswith("? help  q quit ")
        assert all(len(row) == size[0] for row in rows(app))
        await pilot.press("right")
        assert await until(pilot, lambda: rows(app)[-2].startswith(" Running  by touch"))
        # the way to move is known; what to do next is beside it
        assert await until(pilot, lambda: not shows(app, "hold →"))
        assert " Esc release " in rows(app)[-1]
        # value and moment
        assert await until(pilot, lambda: moment.search(rows(app)[1]))
        value = " █▀█    █▀█ " if size[1] >= 20 else " 0-0  "
        assert rows(app)[1].startswith(value)
        await pilot.press("question_mark")
        assert await until(pilot, lambda: shows(app, "drag"))
        await pilot.press(*["pagedown"] * 5)
        assert await until(pilot, lambda: shows(app, "Any key closes"))
        # a second key comes before the help is gone
        await pilot.press("x", "x")
        assert await until(pilot, lambda: not shows(app, "Any key closes"))

    drive(player, script, size=size)
