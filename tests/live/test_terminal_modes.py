"""A terminal gets its modes back however a session is stopped, continued or ended.

The long version ends 30 sessions by each signal while they start.
"""

from __future__ import annotations

import os
import random
import re
import signal
import sys
import time

import pytest

import overview_dsp as ov
from tests.cli.running import MATCH, end_of_group, environment

if sys.platform == "linux":
    from tests.live.terminal import Terminal
else:
    pytest.skip("needs a pseudo-terminal of Linux", allow_module_level=True)

PLAY = ["play", MATCH, "--device", "none"]
UNCOLOURED = {0, 1, 7, 22, 27, 39, 49}
"""Styles without a colour: bold, reversed, the terminal's own colours."""

STOPS = {
    "CONT": ["SIGCONT"],
    "STOP": ["SIGSTOP", "SIGCONT"],
    "STOP twice": ["SIGSTOP", "SIGCONT", "SIGSTOP", "SIGCONT"],
    "TSTP": ["SIGTSTP", "SIGCONT"],
}


@pytest.fixture
def surroundings(tmp_path):
    return {
        **environment(),
        "XDG_STATE_HOME": str(tmp_path / "state"),
        "XDG_CONFIG_HOME": str(tmp_path / "config"),
    }


def stopped(pid):
    with open(f"/proc/{pid}/stat") as file:
        return file.read().rpartition(")")[2].split()[0] == "T"


def send(terminal, names):
    pid = terminal.process.pid
    for name in names:
        os.kill(pid, getattr(signal, name))
        if name != "SIGCONT":
            terminal.wait_for(lambda: stopped(pid))
            yield


def shows(terminal, screen, muted):
    """Whether the clicks are muted, or aren't, by what was shown last."""
    if screen == "lines":
        return terminal.shown.rstrip().endswith(b"clicks muted" if muted else b"clicks on")
    # the message, for ten seconds, and the level of the vibration
    if muted:
        return b"clicks muted" in terminal.shown
    return b"clicks on" in bytes(terminal.shown).rpartition(b"[?1049h")[2]


@pytest.mark.parametrize("screen", ["full", "lines"])
def test_a_session_that_was_stopped_and_continued_gives_the_terminal_back(surroundings, screen):
    terminal = Terminal([*PLAY, "--screen", screen], surroundings)
    shown = b"vibration" if screen == "full" else b"q to quit"
    terminal.wait_for(lambda: shown in terminal.shown)
    terminal.wait_for(lambda: not terminal.echoes)
    time.sleep(0.5)
    threads = terminal.threads
    for number, (name, signals) in enumerate(STOPS.items()):
        del terminal.shown[:]
        for _ in send(terminal, signals):
            # as the shell that has the terminal meanwhile
            assert terminal.echoes == (name == "TSTP"), name
        if screen == "full":  # drawn anew; what was typed before is discarded
            terminal.wait_for(lambda: b"torque" in terminal.shown.rpartition(b"[?1049h")[2])
        terminal.wait_for(lambda: not terminal.echoes)
        # a key is read, and once
        terminal.press("m")
        terminal.wait_for(lambda muted=number % 2 == 0: shows(terminal, screen, muted))
        terminal.wait_for(lambda: terminal.threads == threads)
    terminal.press("q")
    _, code = terminal.end()
    assert code == 0
    assert terminal.echoed


def end_while_starting(surroundings, name, seconds):
    """Send a signal so long after the start; what is wrong with the end, if anything."""
    terminal = Terminal(PLAY, surroundings)
    time.sleep(seconds)
    os.kill(terminal.process.pid, getattr(signal, name))
    took, code = terminal.end()
    wrong = []
    # before the program has its own handlers, the signal ends Python
    if code not in (128 + getattr(signal, name), -getattr(signal, name)):
        wrong.append(f"exit code {code} after {took:.1f} s")
    if not terminal.echoed:
        wrong.append("no echo")
    if b"in main\r\n" in terminal.shown:  # a traceback of the program; Python has its own before
        wrong.append(terminal.shown.decode(errors="replace")[-1500:])
    if not end_of_group(terminal.process.pid, 3.0):
        wrong.append("a process is left")
    return [f"{name} after {seconds:.2f} s: {one}" for one in wrong]


@pytest.mark.parametrize(("name", "seconds"), [("SIGHUP", 0.6), ("SIGTERM", 1.2), ("SIGINT", 2.0)])
def test_a_signal_while_a_session_starts_gives_the_terminal_back(surroundings, name, seconds):
    assert end_while_starting(surroundings, name, seconds) == []


@pytest.mark.soak
def test_ninety_signals_while_sessions_start(surroundings):
    dice = random.Random(3)
    wrong = []
    for name in ("SIGHUP", "SIGTERM", "SIGINT") * 30:
        wrong += end_while_starting(surroundings, name, dice.uniform(0.0, 4.0))
    assert wrong == []


@pytest.mark.parametrize("screen", ["full", "lines"])
def test_texts_of_a_file_cannot_control_the_terminal(surroundings, tmp_path, screen):
    events = [ov.Event(float(at), "goal", f"one {at}\x1b[2Jtwo") for at in range(1, 5)]
    match = ov.Timeline(duration_s=5.0, events=events, title="start\x1b]0;title\x07")
    ov.save_timeline(match, tmp_path / "match.json")
    arguments = ["play", tmp_path / "match.json", "--device", "none", "--screen", screen]
    terminal = Terminal(arguments, surroundings)
    terminal.wait_for(lambda: b"start ]0;title" in terminal.shown)
    for _ in range(5):
        terminal.press("]")  # to the next event
        time.sleep(0.3)
    terminal.wait_for(lambda: b"[2Jtwo" in re.sub(rb"\x1b\[[\d;]*m", b"", terminal.shown))
    assert b"\x1b[2Jtwo" not in terminal.shown
    assert b"\x1b]0;title" not in terminal.shown
    terminal.press("q")
    assert terminal.end()[1] == 0


def test_without_colours_without_utf8_and_in_a_dumb_terminal_a_session_plays(surroundings):
    colourless = {**surroundings, "NO_COLOR": "1", "LC_ALL": "C"}
    terminal = Terminal(PLAY, colourless, size=(40, 12))
    terminal.wait_for(lambda: b"quit" in terminal.shown and b"Drag, or" in terminal.shown)
    terminal.press("\x1b[C")
    terminal.wait_for(lambda: b"release" in terminal.shown)
    shown = terminal.shown.decode("ascii")  # nothing else
    numbers = {
        int(one) for text in re.findall(r"\x1b\[([\d;]*)m", shown) for one in text.split(";") if one
    }
    assert numbers <= UNCOLOURED
    assert "help" in shown
    terminal.press("q")
    assert terminal.end()[1] == 0
    terminal = Terminal(PLAY, surroundings, kind="dumb")
    terminal.wait_for(lambda: b"q to quit" in terminal.shown)
    terminal.press("q")
    assert terminal.end()[1] == 0
    assert b"\x1b" not in terminal.shown
