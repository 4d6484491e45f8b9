"""MIDI from an independent client, over the JACK server that needs no sound card."""

from __future__ import annotations

import importlib.util
import json

import pytest

from tests.live import jack_server

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
    pytest.mark.skipif(
        importlib.util.find_spec("rtmidi") is None,
        reason="needs python-rtmidi: pip install '.[midi]'",
    ),
]

KEYS = """
import time
import jack

class Keys:
    '''A MIDI keyboard on the server; it writes bytes.'''
    def __init__(self):
        self.client = jack.Client("keys", no_start_server=True)
        self.out = self.client.midi_outports.register("out")
        self.waiting = []
        self.client.set_process_callback(self.process)
        self.client.activate()

    def process(self, frames):
        self.out.clear_buffer()
        while self.waiting:
            self.out.write_midi_event(0, bytes(self.waiting.pop(0)))

    def send(self, *messages, wait=0.1):
        self.waiting.extend(messages)
        time.sleep(wait)

    def close(self):
        self.client.deactivate()
        self.client.close()
"""

PLAY = (
    KEYS
    + """
import json
import overview_dsp as ov
from overview_dsp.devices.controllers.midi_messages import MidiReader
from overview_dsp.live.inputs.controllers import ControllerInput
from overview_dsp.live.ports.midi import MidiPort, midi_ports
from overview_dsp.live.output.portaudio_stream import OutputStream

engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)
seen = {}
keys = Keys()
seen["ports"] = midi_ports()
with OutputStream(engine, device="system", block_size=256) as stream:
    hand = ControllerInput(engine, "midi", lambda: MidiPort("KEYS"),
                           lambda counters: MidiReader(counters=counters))
    holder = lambda: None if engine.active_input is None else list(engine.active_input)
    keys.send((0x90, 66, 100))
    until = time.monotonic() + 30.0
    while engine.settled_at is None and time.monotonic() < until:
        time.sleep(0.01)
    seen["tap"], seen["cursor"] = holder(), engine.meters.cursor
    keys.send((0x80, 66, 0), wait=0.3)
    seen["released"] = holder()
    for value in range(8192, 16384, 128):
        keys.send((0xE0, value & 0x7F, value >> 7), wait=0.01)
    time.sleep(0.4)
    seen["bent"] = holder()
    keys.send((0xE0, 0, 64), wait=0.6)
    seen["back"] = holder()
    keys.send((0x90, 80, 100), wait=0.3)
    seen["held"] = holder()
    keys.close()
    time.sleep(1.0)
    seen["disconnected"], seen["connected"] = holder(), hand.report()["connected"]
    keys = Keys()
    time.sleep(2.5)
    keys.send((0x90, 40, 100), wait=0.3)
    seen["again"] = holder()
    hand.poll(engine)
    seen["messages"], seen["report"] = hand.take_messages(), hand.report()
    hand.close()
    keys.close()
    seen["late"] = stream.meters.late
print(json.dumps(seen))
"""
)


def test_a_keyboard_taps_bends_is_unplugged_and_comes_back():
    with jack_server.Server(period=256) as server:
        seen = json.loads(server.run(PLAY).splitlines()[-1])
    assert "keys:out" in seen["ports"]
    assert seen["tap"] == ["midi", pytest.approx(3.14159 / 2, abs=1e-3)]
    assert seen["cursor"] == pytest.approx(0.5, abs=0.05)
    assert seen["released"] is None
    assert seen["bent"] == ["midi", pytest.approx(3.14159, abs=0.06)]
    assert seen["back"] is None
    assert seen["held"] is not None
    assert seen["disconnected"] is None
    assert not seen["connected"]
    assert seen["again"] == ["midi", pytest.approx(3.14159 * 4 / 60, abs=1e-3)]
    changes = [line.split(": ")[1].split(";")[0] for line in seen["messages"]]
    assert changes == ["disconnected", "reconnected"]
    assert seen["report"]["rejected"] == 0
    print(seen["report"])


LEARN = (
    KEYS
    + """
import subprocess, sys
keys = Keys()
command = [sys.executable, "-m", "overview_dsp", "midi", "learn", "keys", *sys.argv[1:]]
learning = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
print(learning.stderr.readline())
time.sleep(0.3)
for n in range(40):
    keys.send((0xB2, 7, 3 * n), wait=0.01)
print(*learning.communicate(timeout=60))
keys.close()
"""
)


def test_learning_writes_a_list_that_play_takes(tmp_path):
    path = tmp_path / "keys.toml"
    with jack_server.Server(period=256) as server:
        said = server.run(LEARN, "tactor.gain_db", "-o", path, "--low", -24, "--high", 0)
        assert "turn it to the right" in said
        assert "cc 7, channel 3, is tactor.gain_db" in said
        server.run(LEARN, "theta2", "-o", path)
        done = server.attempt(
            "-m",
            "overview_dsp",
            "play",
            "world-cup-final-2018",
            "--device",
            "none",
            "--seconds",
            1,
            "--input",
            f"midi:no-such,map={path}",
        )
    assert done.returncode == 2
    assert "no such port" in done.stderr
    text = path.read_text()
    assert text.count("[[control]]") == 1  # one control does one thing
    assert 'to = "theta2"' in text
