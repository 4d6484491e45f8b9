"""However a session ends, in a real terminal with sound: soon, by itself, and with its take."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time

import pytest

import overview_dsp as ov
from tests.cli.running import MATCH, end_of_group
from tests.live import jack_server

if sys.platform == "linux":
    from tests.live.terminal import CLOSE_TIMEOUT_S, Terminal

pytestmark = [
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

RIGHT, LEFT = "\x1b[C", "\x1b[D"


def kill(name):
    def end(terminal):
        os.kill(terminal.process.pid, getattr(signal, name))
        return 128 + getattr(signal, name)

    return end


def quit_by_key(terminal):
    terminal.press("q")
    return 0


def close(terminal):
    terminal.close()
    return 128 + signal.SIGHUP


def freeze_and_terminate(terminal):
    terminal.frozen = True
    for _ in range(100):
        terminal.press(RIGHT)
        time.sleep(0.01)
    return kill("SIGTERM")(terminal)


def freeze_and_close(terminal):
    terminal.frozen = True
    for _ in range(100):
        terminal.press(LEFT)
        time.sleep(0.01)
    return close(terminal)


def suspend_and_interrupt(terminal):
    os.kill(terminal.process.pid, signal.SIGTSTP)
    time.sleep(0.7)
    os.kill(terminal.process.pid, signal.SIGCONT)
    time.sleep(0.7)
    return kill("SIGINT")(terminal)


def stop_and_interrupt(terminal):
    for name in ("SIGSTOP", "SIGCONT", "SIGCONT"):
        os.kill(terminal.process.pid, getattr(signal, name))
        time.sleep(0.5)
    return kill("SIGINT")(terminal)


def freeze_server_and_quit(terminal):
    terminal.server.send_signal(signal.SIGSTOP)
    terminal.wait_for(lambda: b"respond" in terminal.text)
    return quit_by_key(terminal)


def resize_and_hang_up(terminal):
    for size in ((20, 8), (200, 60), (80, 24)):
        terminal.resize(*size)
        os.kill(terminal.process.pid, signal.SIGWINCH)
        time.sleep(0.1)
    return kill("SIGHUP")(terminal)


ENDINGS = {
    "q": quit_by_key,
    "TERM": kill("SIGTERM"),
    "INT": kill("SIGINT"),
    "HUP": kill("SIGHUP"),
    "closed": close,
    "frozen": freeze_and_terminate,
    "frozen, closed": freeze_and_close,
    "suspended": suspend_and_interrupt,
    "stopped": stop_and_interrupt,
    "frozen server": freeze_server_and_quit,
    "resized": resize_and_hang_up,
    "KILL": kill("SIGKILL"),
}


def end_one(server, folder, name, seconds):
    """Play for so long, end it so; what is wrong with that, if anything."""
    take = folder / "take.csv"
    environment = {
        **server.environment,
        "XDG_STATE_HOME": str(folder / "state"),
        "XDG_CONFIG_HOME": str(folder / "config"),
    }
    terminal = Terminal(["play", MATCH, "--device", "system", "--record", take], environment)
    terminal.server = server.process
    began = terminal.wait_for(lambda: take.exists() and take.stat().st_size > 0)
    shown = terminal.wait_for(lambda: b"vibration" in terminal.text)
    until = shown + seconds
    while time.monotonic() < until:
        terminal.press(RIGHT)
        time.sleep(0.05)
    stopped = name in ("suspended", "stopped")
    ended = time.monotonic()
    wanted = ENDINGS[name](terminal)
    took, code = terminal.end()
    server.process.send_signal(signal.SIGCONT)
    wrong = []
    if "closed" not in name and name != "KILL" and not terminal.echoed:
        wrong.append("no echo")
    if name == "KILL":
        wanted = -signal.SIGKILL
    if took > CLOSE_TIMEOUT_S:
        wrong.append(f"took {took:.1f} s")
    if code != wanted:
        wrong.append(f"exit code {code}, not {wanted}")
    if not end_of_group(terminal.process.pid, 1.0):
        wrong.append("a process is left")
    ports = subprocess.run(["jack_lsp"], capture_output=True, text=True, env=server.environment)
    if "overview:" in ports.stdout:
        time.sleep(1.0)  # the server looks for clients that have died
        ports = subprocess.run(["jack_lsp"], capture_output=True, text=True, env=server.environment)
    if "overview:" in ports.stdout:
        wrong.append("a port is held")
    gesture = ov.load_gesture(take)
    if not stopped and gesture.duration_s < ended - began - 0.5:
        wrong.append(f"the take has {gesture.duration_s:.2f} of {ended - began:.2f} s")
    if len(gesture.time_s) < seconds / 0.05 * 0.5 - 10:
        wrong.append(f"the take has {len(gesture.time_s)} events")
    if name == "KILL" and not list((folder / "state").rglob("*.growing")):
        wrong.append("nothing says where the take is")
    return [f"{name} after {seconds:.2f} s: {one}" for one in wrong]


@pytest.fixture(scope="module")
def server():
    with jack_server.Server(period=512) as running:
        yield running


@pytest.mark.realtime
@pytest.mark.parametrize("name", ENDINGS)
def test_every_ending_is_soon_and_keeps_the_take(server, tmp_path, name):
    assert end_one(server, tmp_path, name, random.uniform(0.0, 1.0)) == []


@pytest.mark.soak
def test_a_hundred_endings_at_random_moments(server, tmp_path):
    dice = random.Random(18)
    wrong = []
    for number in range(100):
        folder = tmp_path / str(number)
        folder.mkdir()
        name = dice.choice(list(ENDINGS))
        wrong += end_one(server, folder, name, dice.uniform(0.0, 1.5))
    assert wrong == []
