"""A crowd that is heard: a sound input of a headless JACK server, fed by an independent client."""

from __future__ import annotations

import json

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from tests.live import jack_server

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

CROWD = """
import json, subprocess, sys, time
import jack
import numpy as np

sound = np.load(sys.argv[1])
command = [sys.executable, "-m", "overview_dsp", "play", "--follow", "audio:system", "--device",
           "none", "--screen", "json", "--seconds", sys.argv[2], "--record", sys.argv[3]]
playing = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
client = jack.Client("crowd", no_start_server=True)
out = client.outports.register("out")
at = 0

@client.set_process_callback
def process(frames):
    global at
    block = sound[at : at + frames]
    port = out.get_array()
    port[:] = 0.0
    port[: len(block)] = block
    at += frames

first = None
with client:
    until = time.monotonic() + 60.0
    ports = []
    while len(ports) < 2 and playing.poll() is None and time.monotonic() < until:
        ports = [p for p in client.get_ports(is_audio=True, is_input=True)
                 if not p.name.startswith(("system:", "crowd:"))]
        time.sleep(0.01)
    for port in ports:
        for other in client.get_all_connections(port):
            client.disconnect(other, port)
    at, names = 0, [port.name for port in ports]
    for port in ports:
        client.connect(out, port)
    printed, said = playing.communicate(timeout=120)
print(json.dumps({"ports": names, "following": [json.loads(line).get("following")
                                for line in printed.splitlines()],
                  "said": said, "code": playing.returncode}))
"""


def test_cheers_of_a_sound_input_are_those_of_the_file_of_it(tmp_path):
    rate, seconds = 48_000, 40
    dice = np.random.default_rng(3)
    time_s = np.arange(seconds * rate) / rate
    level = np.full(len(time_s), 0.01)
    for peak_s in (14.0, 28.0):  # with a definite top, so that its time is one
        level += 0.25 * np.exp(-0.5 * ((time_s - peak_s) / 1.0) ** 2)
    sound = (level * dice.standard_normal(len(level))).clip(-1.0, 1.0).astype(np.float32)
    np.save(tmp_path / "crowd.npy", sound)
    take = tmp_path / "take.csv"
    with jack_server.Server(period=1024) as server:
        heard = json.loads(
            server.run(CROWD, tmp_path / "crowd.npy", 44, take, timeout=300.0).splitlines()[-1]
        )
    assert heard["code"] == 0, heard["said"]
    assert len(heard["ports"]) == 2
    told = {}
    for change in ov.load_gesture(take).changes:
        grown = change.what.get("timeline", {})
        for one in grown.get("gone", ()):
            told.pop((one["time_s"], one["kind"]))
        told |= {(one["time_s"], one["kind"]): one for one in grown.get("new", ())}
    soundfile.write(tmp_path / "crowd.wav", sound, rate, subtype="FLOAT")
    events = ov.load_timeline(tmp_path / "crowd.wav").events
    read = [event.time_s for event in events if event.kind == "cheer"]
    played = sorted(time_s for time_s, kind in told if kind == "cheer")
    # where it begins, out of silence, is a burst of its own
    assert len(read) == len(played) == 2
    late = np.array(played) - np.array(read)
    print("cheers heard at", played, "and read at", read)
    assert np.ptp(late) < 0.5
    assert np.abs(late).max() < 5.0  # the listening and the crowd don't begin together
    words = [one for one in heard["following"] if one]
    assert words[-1].startswith(("data until 0:4", "data until 0:3"))
