"""The terminal is asked for its background, and given back; an answer is never read as keys."""

from __future__ import annotations

import array
import os
import select
import sys
import threading
import time

import pytest

from overview_dsp.live.screen import terminal as module
from overview_dsp.live.screen.terminal import QUERY, Parser, ask_background, background_of
from overview_dsp.live.screen.timeline_view import Skin
from tests.cli.running import MATCH, environment

if sys.platform == "linux":
    import fcntl
    import termios

    from tests.live.terminal import Terminal
else:
    pytest.skip("needs a pseudo-terminal of Linux", allow_module_level=True)

COLOURS = {"TERM": "xterm-256color", "LC_ALL": "C.UTF-8"}
WHITE, BLACK = "\x1b]11;rgb:ffff/ffff/ffff\x1b\\", "\x1b]11;rgb:00/00/00\x07"


def waiting(file):
    """How many bytes wait to be read."""
    count = array.array("i", [0])
    fcntl.ioctl(file, termios.FIONREAD, count)
    return count[0]


@pytest.fixture
def asked(monkeypatch):
    """A function that asks a terminal which answers after a time, or not; what it was asked."""

    def ask(answer, after_s=0.0, given=COLOURS):
        ours, theirs = os.openpty()
        with open(theirs, "r+b", buffering=0) as file:
            for name in ("__stdin__", "__stderr__"):
                monkeypatch.setattr(sys, name, file)
            question = []

            def terminal():
                if select.select([ours], [], [], 1.0)[0]:
                    question.append(os.read(ours, 100))
                    time.sleep(after_s)
                    for part in answer:
                        os.write(ours, part.encode())
                        time.sleep(0.01)

            thread, before = threading.Thread(target=terminal), termios.tcgetattr(theirs)
            thread.start()
            began = time.monotonic()
            found = ask_background(given)
            took, left = time.monotonic() - began, waiting(theirs)
            assert termios.tcgetattr(theirs) == before
            thread.join()
        os.close(ours)
        return found, question, took, left

    return ask


@pytest.mark.parametrize(
    ("answer", "background"),
    [
        ([WHITE], "light"),
        ([BLACK], "dark"),
        ([WHITE[:9], WHITE[9:-1], WHITE[-1]], "light"),
        (["\x1b]11;rgba:2828/2828/2828/ffff\x07"], "dark"),
        (["\x1b]11;no colour\x07"], ""),
    ],
)
def test_the_answer_tells_light_from_dark_and_is_read_as_a_whole(
    asked, answer, background, monkeypatch
):
    monkeypatch.setattr(module, "ANSWER_WITHIN_S", 5.0)  # a busy machine
    found, question, took, left = asked(answer)
    assert found == background
    assert question == [QUERY]
    assert left == 0
    assert took < 4.0


def test_a_terminal_that_does_not_answer_costs_a_tenth_of_a_second(asked):
    found, question, took, left = asked([])
    assert (found, question, left) == ("", [QUERY], 0)
    assert took >= 0.1
    assert asked([WHITE], after_s=0.4)[0] == ""


@pytest.mark.parametrize(
    "given", [{"NO_COLOR": "1"}, {"TERM": "dumb"}, {"TERM": "linux"}, {"LC_ALL": "C"}]
)
def test_a_terminal_without_colours_or_utf8_is_not_asked(asked, given):
    assert asked([WHITE], given={**COLOURS, **given})[:2] == ("", [])


def test_colours_are_those_of_the_answer_or_else_of_the_environment():
    light, dark, unknown = {"COLORFGBG": "0;15"}, {"COLORFGBG": "15;0"}, {}
    shown = {
        (name, answer): (skin.name, skin.theme)
        for name, given in (("light", light), ("dark", dark), ("", unknown))
        for answer in ("light", "dark", "")
        for skin in [Skin({**COLOURS, **given}, None, answer)]
    }
    for (name, answer), found in shown.items():
        known = answer or name
        assert found == (known or "dark", f"ansi-{known}" if known else "textual-dark")
    assert Skin({}, "standard", "light").name == "sixteen"
    assert Skin({"NO_COLOR": ""}, None, "light").name == "none"
    assert background_of("rgb:f/f/f") == "light"
    assert background_of("rgb:8/0/0") == background_of("rgb:0000/0000/ffff") == "dark"


def test_keys_around_a_late_answer_are_read_and_its_parts_are_not():
    parser = Parser()
    read = [
        getattr(message, "key", None)
        for part in ("a", WHITE, f"b{BLACK}c", WHITE[:12], WHITE[12:-1], f"{WHITE[-1]}d")
        for message in parser.feed(part)
    ]
    assert read == ["a", "b", "c", "d"]
    assert list(parser.feed("")) == []


@pytest.mark.parametrize("answer", [WHITE, BLACK])
def test_a_session_whose_terminal_answers_late_gets_no_keys_from_it(tmp_path, answer):
    surroundings = {**environment(), **COLOURS, "XDG_STATE_HOME": str(tmp_path)}
    surroundings.pop("COLORFGBG", None)
    terminal = Terminal(["play", MATCH, "--device", "none"], surroundings)
    terminal.wait_for(lambda: b"vibration" in terminal.shown and b"Drag here" in terminal.text)
    assert QUERY in terminal.shown
    terminal.press(answer[:12])
    time.sleep(0.3)
    terminal.press(answer[12:])
    time.sleep(1.0)
    assert b"by touch" not in terminal.text  # as after ], which goes to an event
    terminal.press("m")
    terminal.wait_for(lambda: b"clicks muted" in terminal.text)
    terminal.press("q")
    assert terminal.end()[1] == 0
    assert terminal.echoed


def test_a_session_on_a_light_background_has_its_colours(tmp_path):
    surroundings = {**environment(), **COLOURS, "XDG_STATE_HOME": str(tmp_path)}
    for name in ("COLORFGBG", "COLORTERM"):
        surroundings.pop(name, None)
    for answer, shown, other in ((WHITE, b"38;5;26m", b"38;5;75"), ("", b"38;5;75m", b"38;5;26m")):
        terminal = Terminal(["play", MATCH, "--device", "none"], surroundings)
        terminal.wait_for(lambda screen=terminal.shown: QUERY in screen)
        terminal.press(answer)
        terminal.wait_for(lambda screen=terminal.shown, shown=shown: shown in screen)
        assert other not in terminal.shown
        terminal.press("q")
        assert terminal.end()[1] == 0
        assert terminal.echoed
