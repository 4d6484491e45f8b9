"""The patches for Pd and SuperCollider say what the OSC input understands, and hear its answer."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from overview_dsp.data.timeline import Event
from overview_dsp.devices.controllers.control_messages import SetParameter, TouchEnded, TouchStarted
from overview_dsp.devices.controllers.osc_messages import OscReader, OscReport

PATCHES = Path(__file__).resolve().parents[3] / "examples" / "osc"
PATIENCE_S = 120.0
NO_SCREEN = {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1"}


@pytest.fixture
def port():
    """A player's port, as a socket that waits."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as player:
        player.bind(("127.0.0.1", 0))
        player.settimeout(PATIENCE_S)
        yield player


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@contextmanager
def running(log, *command, **environment):
    """A program without a screen, which writes to a file, until it isn't needed any more."""
    with log.open("wb") as out:
        process = subprocess.Popen(
            [*map(str, command)],
            stdout=out,
            stderr=subprocess.STDOUT,
            stdin=subprocess.PIPE,
            env={**os.environ, **NO_SCREEN, **environment},
            cwd=log.parent,
        )
        try:
            yield process
        finally:
            process.terminate()  # a sound server that is killed leaves its name behind
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            process.stdin.close()


def moves_until(player, enough):
    """What the reader makes of datagrams, until it is enough."""
    reader, moves = OscReader(), []
    while not enough(moves):
        moves += reader.read(player.recv(4096), time.monotonic())
    assert (reader.counters.unknown, reader.counters.rejected, reader.counters.clamped) == (0, 0, 0)
    return moves


def report(port, log, *words):
    """Say what a disk does until the program has written these words."""
    goal = Event(time_s=5340.0, kind="goal", label="1-0 Parris")
    deadline = time.monotonic() + PATIENCE_S
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        while not all(word in log.read_text(errors="replace") for word in words):
            assert time.monotonic() < deadline, log.read_text(errors="replace")
            for data in OscReport().due(0.0, 0.25, 0.0125, True, [(goal, 0.5)]):
                sender.sendto(data, ("127.0.0.1", port))
            time.sleep(0.2)


def test_the_patch_for_pd_plays_and_listens(port, tmp_path):
    if not shutil.which("pd"):
        pytest.skip("needs Pd: apt-get install puredata-core")
    listening, to, log = free_port(), port.getsockname()[1], tmp_path / "log"
    shown = "".join(
        f"#X obj 9 {9 + n} r {name};\n#X obj 99 {9 + n} print {name};\n"
        f"#X connect {2 * n} 0 {2 * n + 1} 0;\n"
        for n, name in enumerate(("cursor", "torque", "touching"))
    )
    (tmp_path / "shown.pd").write_text("#N canvas 0 0 450 300 12;\n" + shown)
    said = ("touch 1", "place 0.5", "parameter tactor.gain_db -6", "touch 0")
    sends = [("-send", f"from {listening}"), ("-send", f"to 127.0.0.1 {to}")]
    sends += [("-send", words) for words in said]
    patches = ("-open", PATCHES / "overview.pd", "-open", "shown.pd")
    command = ("pd", "-nogui", "-noaudio", "-stderr", *patches)
    with running(log, *command, *(word for pair in sends for word in pair)):
        moves = moves_until(port, lambda moves: TouchEnded("theta2") in moves)
        report(listening, log, "cursor: 0.25", "torque: 0.0125", "touching: 1", "event: goal")
    middle = TouchStarted("theta2", pytest.approx(1.5708, abs=1e-4))
    # a finger that is down says so again now and then
    news = [move for move, before in zip(moves, [None, *moves], strict=False) if move != before]
    assert news == [
        TouchStarted("theta2", 0.0),
        middle,
        SetParameter("tactor.gain_db", -6.0),
        TouchEnded("theta2"),
    ]


def test_the_patch_for_supercollider_plays_and_listens(port, tmp_path):
    if not shutil.which("sclang"):
        pytest.skip("needs SuperCollider: apt-get install supercollider-language")
    log = tmp_path / "log"
    patch = (PATCHES / "overview.scd").read_text(encoding="utf-8").partition("// a synth")[0]
    # blocks between parentheses are run one by one by hand
    script = (
        f"{patch};\n"
        + '("port" + NetAddr.langPort).postln; ~sweep.(0.2); ~set.("tactor.gain_db", -6);'
    )
    script += (
        "\nOSCdef(\\torque, { |message| (\"torque\" + message[1]).postln }, '/overview/torque');\n"
    )
    (tmp_path / "played.scd").write_text(script)
    with running(log, "sclang", "played.scd", OVERVIEW_OSC=str(port.getsockname()[1])):
        moves = moves_until(port, lambda moves: TouchEnded("theta2") in moves)
        (line,) = [line for line in log.read_text().splitlines() if line.startswith("port ")]
        report(int(line.split()[1]), log, "passed goal 1-0 Parris, strength 0.5", "torque 0.0125")
    turned = [move.theta2 for move in moves if isinstance(move, TouchStarted)]
    assert turned == sorted(turned)
    assert (turned[0], turned[-1]) == (0.0, pytest.approx(3.14159, abs=1e-4))
    assert SetParameter("tactor.gain_db", -6.0) in moves


def test_a_synth_of_scsynth_follows_the_disk(tmp_path):
    for program in ("sclang", "scsynth", "jackd"):
        if not shutil.which(program):
            pytest.skip(f"needs {program}: apt-get install supercollider jackd2")
    server, log = {"JACK_DEFAULT_SERVER": f"patches{os.getpid()}"}, tmp_path / "log"
    finger, synth = (PATCHES / "overview.scd").read_text(encoding="utf-8").split("// a synth")
    asked = '~synth !? { |synth| synth.get(\\place, { |at| ("placed" + at).postln }) }'
    script = f"{finger};\n// a synth{synth};\n" + '("port" + NetAddr.langPort).postln;\n'
    (tmp_path / "played.scd").write_text(f"{script}fork {{ loop {{ 0.5.wait; {asked} }} }}\n")
    sound = ("jackd", "-r", "-d", "dummy", "-r", "48000", "-p", "1024")
    with (
        running(tmp_path / "jack", *sound, **server),
        running(log, "sclang", "played.scd", **server),
    ):
        deadline = time.monotonic() + PATIENCE_S
        while "\nport " not in log.read_text(errors="replace"):
            assert time.monotonic() < deadline, log.read_text(errors="replace")
            time.sleep(0.2)
        (line,) = [line for line in log.read_text().splitlines() if line.startswith("port ")]
        report(int(line.split()[1]), log, "placed 0.25")
