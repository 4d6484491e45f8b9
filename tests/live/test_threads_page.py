"""The threads of a session are those that docs/explanation/threads.md lists."""

from __future__ import annotations

import ast
import re
import socket
import threading
from pathlib import Path

import overview_dsp as ov
from overview_dsp.devices.controllers.osc_messages import OscReader
from overview_dsp.live.inputs.controllers import ControllerInput
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.ports.osc import OscOut, OscPort
from overview_dsp.live.screen.terminal import TerminalWriter
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("live", "web", "data/feeds", "cli/signals.py")


def listed():
    """The names in the second column of the table."""
    page = (ROOT / "docs/explanation/threads.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in page.splitlines() if line.startswith("| ")]
    return {name for row in rows for name in re.findall(r"`([^`]+)`", row[2])}


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return str(one.getsockname()[1])


def test_each_named_thread_of_the_source_is_listed_and_each_listed_one_exists():
    named = set()
    for package in PACKAGES:
        path = ROOT / "overview_dsp" / package
        for file in path.rglob("*.py") if path.is_dir() else [path]:
            text = file.read_text(encoding="utf-8")
            named |= set(re.findall(r'super\(\).__init__\(daemon=True, name="([^"]+)"', text))
            for call in ast.walk(ast.parse(text)):
                if isinstance(call, ast.Call) and ast.unparse(call.func).endswith("Thread"):
                    names = [one.value for one in call.keywords if one.arg == "name"]
                    assert names, f"{file}:{call.lineno}: a thread without a name"
                    named |= {one.value for one in names if isinstance(one, ast.Constant)}
    by_address = {one for one in listed() if ":" in one or one.startswith("osc out")}
    assert named == listed() - by_address


def test_the_threads_of_a_session_are_listed(match, tmp_path):
    before = set(threading.enumerate())
    player = Player(
        match,
        PresetWatch("football"),
        lambda engine, settings: NullStream(engine, 256, settings),
        OutputSettings(),
        callback="python",
        record=tmp_path / "take.csv",
    )
    closing = [player.close]
    try:
        reader = ControllerInput(player.engine, "osc", lambda: OscPort(free_port()), OscReader)
        closing.append(reader.close)
        closing.append(OscOut(player.engine, free_port()).close)
        out = (tmp_path / "terminal").open("w")
        closing.append(out.close)
        writer = TerminalWriter(out)
        writer.start()
        closing.append(writer.stop)
        running = {one.name for one in set(threading.enumerate()) - before}
    finally:
        for close in reversed(closing):
            close()
    assert len(running) == 5
    kinds = {name.partition(":")[0] if ":" in name else name for name in listed()}
    for name in running:
        kind = "osc out ADDRESS" if name.startswith("osc out") else name.partition(":")[0]
        assert kind in kinds | listed(), name
    assert ov.load_gesture(tmp_path / "take.csv").duration_s >= 0.0
