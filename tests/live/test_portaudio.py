"""The native callback through a real PortAudio stream on a headless JACK server."""

from __future__ import annotations

import json

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.live.session.loop import LONGEST_TAIL_S
from tests.live import jack_server

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

GESTURE = ov.pause(1.0) + ov.tap(0.95, 0.7)
PLAY = """
import json, sys, time
import jack
import numpy as np
import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings, SignalSettings, parse_channels
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.live.takes.takes import Recorder

path, block, kind, seconds = sys.argv[1], int(sys.argv[2]), sys.argv[3], float(sys.argv[4])
ways = [SignalSettings(parse_channels(one)) for one in sys.argv[5:]]
settings = OutputSettings(*ways) if ways else None
engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)
recorder = Recorder(engine, path.replace(".npy", ".csv"), {})
stream = OutputStream(engine, "system", block, settings, kind)
gesture = ov.pause(1.0) + ov.tap(0.95, 0.7)  # the recorder is on by then
for stamp, theta2, touching in zip(gesture.stamps(48_000), gesture.theta2, gesture.touching):
    engine.control(float(theta2), bool(touching), int(stamp))
stream.start()
client = jack.Client("recorder")
ports = [client.inports.register(f"in_{n}") for n in range(settings.channels if settings else 2)]
heard = np.zeros((round(seconds * 48_000), len(ports)), dtype=np.float32)
state = {"at": 0, "xruns": 0}

@client.set_process_callback
def record(frames):
    at = state["at"]
    count = min(frames, len(heard) - at)
    for channel, port in enumerate(ports):
        heard[at : at + count, channel] = port.get_array()[:count]
    state["at"] = at + count

@client.set_xrun_callback
def count(delay):
    state["xruns"] += 1

with client:
    for channel, port in enumerate(ports):
        client.connect(f"overview:out_{channel}", port)
    while state["at"] < len(heard):
        time.sleep(0.02)
meters = stream.meters
recorder.close()
stream.close()
np.save(path, heard)
print(json.dumps({**vars(meters), "late_events": engine.meters.late_events, **state}))
"""


def aligned(recorded, expected):
    """The recording from where the expected sound starts, by the first sample that is not zero."""
    first = int(np.flatnonzero(recorded.any(axis=1))[0])
    begin = int(np.flatnonzero(expected.any(axis=1))[0])
    late = first - begin
    # the recorder may have begun after the stream did
    missed = np.zeros((max(0, -late), recorded.shape[1]), dtype=np.float32)
    padded = np.concatenate([missed, recorded])
    return padded[max(0, late) :][: len(expected)]


@pytest.mark.parametrize("block", [64, 256, 1024])
def test_what_is_heard_is_the_offline_render_sample_for_sample(match, football, tmp_path, block):
    expected = ov.render(match, football, GESTURE, tail=1.0, trace=False).samples
    path = tmp_path / "heard.npy"
    # a run in which the machine lost a period, or the recorder (in Python) one, is repeated
    for _ in range(jack_server.ATTEMPTS):
        # the server's period is long, so that the recorder keeps up; PortAudio cuts it
        with jack_server.Server(period=512) as server:
            report = json.loads(server.run(PLAY, path, block, "native", 4.0))
        heard = aligned(np.load(path), expected)
        lost = report["underflows"] + report["xruns"]
        if lost == 0 and np.array_equal(heard, expected):
            break
    assert report["late_events"] == 0
    assert np.array_equal(heard, expected)
    take = ov.load_gesture(path.with_suffix(".csv"))
    replayed = ov.render(match, football, take, trace=False).samples
    assert np.array_equal(replayed[: len(expected)], expected)


def test_the_python_callback_plays_the_same(match, football, tmp_path):
    expected = ov.render(match, football, GESTURE, tail=1.0, trace=False).samples
    path = tmp_path / "heard.npy"
    for _ in range(jack_server.ATTEMPTS):
        with jack_server.Server(period=512) as server:
            server.run(PLAY, path, 256, "python", 4.0)
        heard = aligned(np.load(path), expected)
        # player and recorder share an interpreter here: periods are lost, and the run repeated
        if np.array_equal(heard, expected):
            break
    assert np.array_equal(heard, expected)


@pytest.mark.parametrize("kind", ["native", "python"])
def test_a_signal_is_heard_on_all_its_channels_sample_for_sample(match, football, tmp_path, kind):
    rendered = ov.render(match, football, GESTURE, tail=1.0, trace=False).samples
    expected = rendered[:, [0, 0, 1, 1]]
    path = tmp_path / "heard.npy"
    for _ in range(jack_server.ATTEMPTS):
        with jack_server.Server(period=512, outputs=4) as server:
            server.run(PLAY, path, 256, kind, 4.0, "1+2", "3+4")
        heard = aligned(np.load(path), expected)
        if np.array_equal(heard, expected):
            break
    assert np.array_equal(heard, expected)
    # a recording knows nothing of channels
    take = ov.load_gesture(path.with_suffix(".csv"))
    replayed = ov.render(match, football, take, trace=False).samples
    assert np.array_equal(replayed[: len(rendered)], rendered)


@pytest.mark.parametrize("kind", ["native", "python"])
def test_each_tactor_is_heard_on_its_channel_sample_for_sample(match, football, tmp_path, kind):
    rendered = ov.render(match, football, GESTURE, tail=1.0, trace=False, tactors=3).samples
    expected = rendered[:, [0, 1, 3, 2]]
    path = tmp_path / "heard.npy"
    for _ in range(jack_server.ATTEMPTS):
        with jack_server.Server(period=512, outputs=4) as server:
            server.run(PLAY, path, 256, kind, 4.0, "1", "2,4,3")
        heard = aligned(np.load(path), expected)
        if np.array_equal(heard, expected):
            break
    assert np.array_equal(heard, expected)


HELD = """
import ctypes, json, sys, time
import overview_dsp as ov
from overview_dsp.live.output.portaudio_stream import OutputStream

engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)
with OutputStream(engine, device="system", block_size=256, callback="native") as stream:
    engine.control(2.0, True)
    time.sleep(0.5)
    before = stream.meters.callbacks
    ctypes.PyDLL(None).usleep(2_000_000)  # one C call that keeps the interpreter locked
    during = stream.meters.callbacks - before
    print(json.dumps({"during": during, "due": 2.0 * 48_000 / 256}))
"""


def test_blocks_go_on_while_a_c_call_holds_the_interpreter_for_two_seconds():
    with jack_server.Server(period=256) as server:
        report = json.loads(server.run(HELD))
    assert report["during"] >= 0.99 * report["due"]


OPEN_AND_CLOSE = """
import gc, json, os, threading
import overview_dsp as ov
from overview_dsp.live.output.portaudio_stream import OutputStream

engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)

def state():
    gc.collect()
    fields = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return {
        "files": len(os.listdir("/proc/self/fd")),
        "threads": int(fields["Threads"]),
        "kb": int(fields["VmRSS"].split()[0]),
    }

def cycle(times):
    for _ in range(times):
        stream = OutputStream(engine, device="system", block_size=256)
        stream.start()
        stream.close()

cycle(10)
before = state()
cycle(int(__import__("sys").argv[1]))
print(json.dumps([before, state()]))
"""


def test_opening_and_closing_leaks_nothing():
    with jack_server.Server(period=256) as server:
        before, after = json.loads(server.run(OPEN_AND_CLOSE, 40))
    assert after["files"] == before["files"]
    assert after["threads"] == before["threads"]
    assert after["kb"] <= before["kb"] + 2000


DROPPED = """
import gc, time
import overview_dsp as ov
from overview_dsp.live.output import portaudio_library, portaudio_stream

engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)
portaudio_stream.OutputStream(engine, device="system", block_size=256).start()
del engine
gc.collect()
time.sleep(0.5)
(stream,) = portaudio_library.OPEN_STREAMS
print(stream.meters.callbacks)
"""


def test_a_stream_that_everyone_forgot_plays_on_safely():
    with jack_server.Server(period=256) as server:
        assert int(server.run(DROPPED)) > 20


DEVICES = """
import sys
from overview_dsp.cli import main
sys.argv = ["overview", "devices", "--json"]
main()
"""


def test_devices_lists_the_server_with_its_channels():
    with jack_server.Server(period=256) as server:
        found = json.loads(server.run(DEVICES))
    assert any(
        output["name"] == "system" and output["channels"] == 2 for output in found["outputs"]
    )


UNKNOWN = """
import overview_dsp as ov
from overview_dsp.live.output.portaudio_stream import OutputStream
engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 512)
try:
    OutputStream(engine, device="nowhere")
except ov.InputError as error:
    print(error)
"""


def test_an_unknown_device_gives_a_one_line_error():
    with jack_server.Server(period=256) as server:
        text = server.run(UNKNOWN)
    assert text.count("\n") == 1
    assert "nowhere" in text


SERVER_KILLED = """
import atexit, json, os, subprocess, sys, time
import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.session.player import Player
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.live.output.portaudio_library import rescan
from overview_dsp.live.session.presets import PresetWatch

servers = []
# registered first, so after PortAudio's own end
atexit.register(lambda: [server.kill() for server in servers])

def serve():
    name = os.environ["JACK_DEFAULT_SERVER"]
    command = f"jackd -n {name} -r -d dummy -r 48000 -p 256 -C 2 -P 2".split()
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    servers.append(server)
    time.sleep(2.0)
    return server

server = serve()
opened = []

def open_stream(engine, settings):
    if opened:
        rescan()
    opened.append(OutputStream(engine, "system", 256, settings))
    return opened[-1]

player = Player(
    ov.load_timeline("world-cup-final-2018"), PresetWatch("football"), open_stream,
    OutputSettings(), record=sys.argv[1],
)
said = []

def play(seconds):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        said.extend(player.poll().messages)
        time.sleep(0.02)

player.touch(0.9)
play(1.0)
server.kill()
server.wait()
play(3.0)
server = serve()
play(3.0)
status = player.poll()
player.close()
print(json.dumps({"said": said, "cursor": status.cursor, "touching": status.touching}))
"""


def test_a_killed_server_is_reported_and_playing_goes_on_when_it_is_back(tmp_path):
    path = tmp_path / "take.csv"
    report = json.loads(jack_server.run(SERVER_KILLED, path))
    assert [["disconnected" in line, "reconnected" in line] for line in report["said"]] == [
        [True, False],
        [False, True],
    ]
    assert not report["touching"]
    assert report["cursor"] < 0.3  # let go, it recoiled once the output was back
    assert len(ov.load_gesture(path).time_s) >= 2


REPLAY = """
import sys, time
import jack
import numpy as np
import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.session.player import Player
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.live.session.presets import PresetWatch

path, block = sys.argv[1], int(sys.argv[2])
player = Player(
    ov.load_timeline("world-cup-final-2018"), PresetWatch("football"),
    lambda engine, settings: OutputStream(engine, "system", block, settings),
    OutputSettings(), other=PresetWatch("plain"),
)
client = jack.Client("recorder")
ports = [client.inports.register(name) for name in ("click", "tactor")]
heard = np.zeros((30 * 48_000, 2), dtype=np.float32)
state = {"at": 0}

@client.set_process_callback
def record(frames):
    at = state["at"]
    count = min(frames, len(heard) - at)
    for channel, port in enumerate(ports):
        heard[at : at + count, channel] = port.get_array()[:count]
    state["at"] = at + count

with client:
    for channel, port in enumerate(ports):
        client.connect(f"overview:out_{channel}", port)
    time.sleep(0.2)
    player.loop.begin(ov.load_gesture(sys.argv[3]), "take")
    for number in range(2, 5):
        for channel, port in enumerate(ports):
            if not client.get_all_connections(port):  # a new activation may have lost it
                client.connect(f"overview:out_{channel}", port)
        player.choose_preset(number % 2 == 0)
        while player.loop.passes < number:
            player.poll()
            time.sleep(0.02)
    time.sleep(0.3)
player.close()
np.save(path, heard[: state["at"]])
"""


def onsets(heard):
    """The samples that sound after a fifth of a second of silence."""
    sounding = np.flatnonzero(heard.any(axis=1))
    return sounding[np.diff(sounding, prepend=-48_000) > 9_600]


@pytest.mark.parametrize("block", [64, 256, 1024])
def test_a_replayed_take_sounds_as_rendered_each_time(match, football, tmp_path, block):
    hand = tmp_path / "take.csv"
    ov.save_gesture(ov.pause(0.3) + ov.tap(0.8, 0.3), hand)
    gesture = ov.load_gesture(hand)
    # both presets have the map of the first
    share = football.number("surface.angle_map")
    plain = ov.load_preset("plain").with_value("surface.angle_map", share)
    renders = [
        ov.render(match, preset, gesture, trace=False).samples
        for preset in (football, plain, football)
    ]
    path = tmp_path / "heard.npy"
    exact = [False for _ in renders]
    # a pass in which the machine or the recorder, in Python, lost a period is repeated
    for _ in range(jack_server.ATTEMPTS):
        with jack_server.Server(period=1024) as server:
            server.run(REPLAY, path, block, hand)
        heard = np.load(path)
        after = 0
        for number, expected in enumerate(renders):
            # a disk that isn't at rest by then doesn't keep the loop
            part = expected[: round((gesture.duration_s + LONGEST_TAIL_S) * 48_000)]
            sounding = np.flatnonzero(part.any(axis=1))
            part = part[sounding[0] : sounding[-1] + 1]
            for first in onsets(heard):
                if first >= after and np.array_equal(heard[first : first + len(part)], part):
                    exact[number], after = True, first + len(part)
                    break
        if all(exact):
            break
    assert exact == [True, True, True]
