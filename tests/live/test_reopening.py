"""A session whose output is changed, frozen and stopped on a headless JACK server.

The long version makes 100 changes.
"""

from __future__ import annotations

import json

import pytest

from tests.live import jack_server

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

BEGIN = """
import atexit, gc, json, os, signal, subprocess, sys, tempfile, time
import jack
import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.reconnecting_stream import StreamOpener
from overview_dsp.live.session.commands import execute, poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch

os.chdir(tempfile.mkdtemp())  # takes
said = []

def play(seconds, until=lambda: False):
    # the time until the condition holds
    began = time.monotonic()
    while time.monotonic() - began < seconds and not until():
        said.extend(poll(player).messages)
        time.sleep(0.02)
    return round(time.monotonic() - began, 2)

def begin(preset="football", **keywords):
    return Player(
        ov.load_timeline("world-cup-final-2018"), PresetWatch(preset),
        StreamOpener("system", 256, "native"), OutputSettings(), **keywords,
    )
"""

CHANGES = (
    BEGIN
    + """
def state():
    gc.collect()
    fields = dict(line.split(":", 1) for line in open("/proc/self/status"))
    look = jack.Client("look")
    clients = []
    for name in ("overview", "overview-01", "overview-02", "PortAudio"):
        try:
            clients.append((name, bool(look.get_uuid_for_client_name(name))))
        except jack.JackError:
            pass
    ports = [port.name for port in look.get_ports("overview")]
    look.close()
    return {
        "files": len(os.listdir("/proc/self/fd")), "threads": int(fields["Threads"]),
        "clients": clients, "ports": ports,
    }

player = begin()
commands = [
    ("block-size", "64"), ("preset", "plain"), ("block-size", "1024"), ("device", "none"),
    ("device", "system"), ("preset", "football"), ("block-size", "256"), ("channels", "2", "1"),
    ("channels", "1", "2"), ("device", "system"),
]
play(0.3)
execute(player, "block-size", "256")
before = state()
for number in range(int(sys.argv[1])):
    execute(player, *commands[number % len(commands)])
    play(0.1)
play(0.5)
print(json.dumps({
    "before": before, "after": state(), "said": said,
    "active": player.output.playing, "callbacks": player.output.meters.callbacks,
}))
player.close()
"""
)


def check_changes(count):
    with jack_server.Server(period=256) as server:
        done = server.attempt("-c", CHANGES, count, timeout=60.0 + 5.0 * count)
        assert done.returncode == 0, done.stderr[-3000:]
        report = json.loads(done.stdout.splitlines()[-1])
        print(f"{count} changes: before {report['before']}, after {report['after']}")
        assert report["after"] == report["before"]
        assert report["active"]
        # none failed
        assert [line for line in report["said"] if not line.startswith(("output ", "now "))] == []
        assert not any("disconnected" in line for line in report["said"]), report["said"]


def test_changes_of_the_output_leave_nothing_behind():
    check_changes(10)


@pytest.mark.soak
def test_a_hundred_changes_of_the_output_leave_nothing_behind():
    check_changes(100)


SERVER = (
    BEGIN
    + """
def start_server():
    global server
    name = os.environ["JACK_DEFAULT_SERVER"]
    server = subprocess.Popen(
        f"jackd -n {name} -r -d dummy -r 48000 -p 256 -C 2 -P 2".split(),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )
    look = ["jack_wait", "-c"]
    while not subprocess.run(look, capture_output=True).stdout.startswith(b"run"):
        assert server.poll() is None, "jackd did not start"
        time.sleep(0.1)

def end_server():
    # killed, it would leave its place in the table of servers
    server.terminate()
    server.send_signal(signal.SIGCONT)
    server.wait()

atexit.register(lambda: end_server())  # first, so that it runs after PortAudio has ended
start_server()
"""
)

FREEZE = (
    SERVER
    + """
player = begin()
heard = jack.Client("hand")
inputs = [heard.inports.register(one) for one in ("left", "right")]
report = {}
with heard:
    for number, port in enumerate(inputs):
        heard.connect(f"overview:out_{number}", port)
    player.touch(0.7)
    play(0.5)
    os.kill(server.pid, signal.SIGSTOP)
    report["reported_s"] = play(30.0, lambda: not player.output.playing)
    report["touching"] = player.poll().touching
    play(2.0)
    os.kill(server.pid, signal.SIGCONT)
    report["used_s"] = play(30.0, lambda: player.output.playing)
    before = player.output.meters.callbacks
    play(30.0, lambda: player.output.meters.callbacks > before + 100)
    report["callbacks"] = player.output.meters.callbacks - before
    report["connected"] = [
        [one.name for one in heard.get_all_connections(port)] for port in inputs
    ]
report["said"] = list(said)
if "frozen" in sys.argv[1]:
    os.kill(server.pid, signal.SIGSTOP)
if "reported" in sys.argv[1]:
    play(30.0, lambda: not player.output.playing)
began = time.monotonic()
player.close()
report["closed_s"] = round(time.monotonic() - began, 2)
if sys.argv[1] == "server gone":
    end_server()
print(json.dumps(report), flush=True)
"""
)


@pytest.mark.parametrize("ending", ["alive", "frozen", "frozen, reported", "server gone"])
def test_a_frozen_server_is_reported_and_used_again_with_its_connections(ending):
    report = json.loads(jack_server.run(FREEZE, ending))
    print(ending, report)
    assert not report["touching"]
    assert ["respond" in line or "reconnected" in line for line in report["said"]] == [True, True]
    assert report["callbacks"] > 100
    assert report["connected"] == [["overview:out_0"], ["overview:out_1"]]


FROZEN_NOW = (
    SERVER
    + """
player = begin()
play(0.5)
play(10.0, lambda: player.at_rest)
os.kill(server.pid, signal.SIGSTOP)
began = time.monotonic()
if sys.argv[1] == "close":
    player.close()
else:
    execute(player, *sys.argv[1].split())
took = time.monotonic() - began
said = player.take_messages()
print(json.dumps({"took_s": took, "playing": player.output.playing, "said": said}))
player.close()
"""
)


@pytest.mark.parametrize("command", ["close", "record", "block-size 64", "device system"])
def test_no_command_waits_for_a_server_that_has_just_frozen(command):
    report = json.loads(jack_server.run(FROZEN_NOW, command))
    print(command, report)
    assert report["took_s"] < 3.0
    if command != "close":
        assert not report["playing"]
        assert report["said"][0].startswith("output system doesn't respond; disk released")


RESTARTED = (
    SERVER
    + r"""
import jack

def start_client(name, connected):
    # in a process of its own, as the library of this one would end it with its server
    code = (
        "import jack, sys, time\n"
        f"client = jack.Client({name!r})\n"
        "ins = [client.inports.register(one) for one in ('left', 'right')]\n"
        "outs = [client.outports.register(one) for one in ('out_0', 'out_1')]\n"
        "client.activate()\n"
        f"for number in range({connected}):\n"
        "    client.connect(f'overview:out_{number}', ins[number])\n"
        "    client.disconnect(f'overview:out_{number}', f'system:playback_{number + 1}')\n"
        "print(client.name, flush=True)\n"
        "time.sleep(100)\n"
    )
    other = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    atexit.register(other.kill)
    assert other.stdout.readline().strip() == name
    return other

player = begin()
play(10.0, lambda: player.at_rest)
hand = start_client("hand", 2)
player.toggle_take()  # restarts the engine, by which the connections are read
end_server()
hand.kill()
start_server()
if sys.argv[1] == "taken":
    start_client("overview", 0)
play(10.0, lambda: not player.output.playing)
play(60.0, lambda: player.output.playing)
before = player.output.meters.callbacks
play(30.0, lambda: player.output.meters.callbacks > before + 100)
ports = subprocess.run(["jack_lsp", "-c"], capture_output=True, text=True).stdout
print(json.dumps({
    "ports": ports, "callbacks": player.output.meters.callbacks - before, "said": said,
}), flush=True)
player.close()
"""
)


@pytest.mark.parametrize(("name", "client"), [("free", "overview"), ("taken", "overview-01")])
def test_a_session_sounds_after_a_restart_of_its_server(name, client):
    report = json.loads(jack_server.run(RESTARTED, name).splitlines()[-1])
    print(report)
    assert report["callbacks"] > 100
    # its connections are gone, and nobody would hear it without the default ones
    for number in (0, 1):
        connected = f"{client}:out_{number}\n   system:playback_{number + 1}\n"
        assert connected in report["ports"]
    (line,) = [line for line in report["said"] if "not reconnected to" in line]
    assert "hand:left, hand:right" in line


CONNECTED = (
    BEGIN
    + """
football = ov.load_preset("football")
# at rest within a second
quick = football.with_changes(
    {"disk.k1": 5.0 * football.number("disk.k1"), "clutch.max_speed_ratio": 0.0}
)
ov.presets.save(quick, "quick.toml")
player = begin("quick.toml", other=PresetWatch("quick.toml"))
heard = jack.Client("hand")
inputs = [heard.inports.register(one) for one in ("left", "right")]
report, lost, longest = {}, [], 0.0

def check(what):
    names = [[one.name for one in heard.get_all_connections(port)] for port in inputs]
    default = heard.get_all_connections("system:playback_1")
    report[what] = report.get(what, 0) + 1
    if names != [["overview:out_0"], ["overview:out_1"]] or default:
        lost.append((what, report[what], names, [one.name for one in default]))

with heard:
    for number, port in enumerate(inputs):
        heard.connect(f"overview:out_{number}", port)
        heard.disconnect(f"overview:out_{number}", f"system:playback_{number + 1}")
    check("start")
    passes, others = int(sys.argv[1]), int(sys.argv[2])
    for _ in range(others):
        play(30.0, lambda: player.at_rest)
        began = time.monotonic()
        player.toggle_take()
        longest = max(longest, time.monotonic() - began)
        assert player.takes.recording_path is not None
        check("restart")
        player.tap(0.2)
        play(0.2)
        player.toggle_take()
    for _ in range(others):
        player.toggle_replay()
        assert player.loop.playing
        check("replay")
        play(0.1)
        player.toggle_replay()
        check("replay")
    player.loop.begin(ov.tap(0.2, 0.05), "tap")
    for number in range(others):
        for _ in range(2):  # the second time at once
            player.choose_preset(number % 2)
        before = player.loop.passes
        player.choose_preset(1 - number % 2)
        play(30.0, lambda: player.loop.passes > before)
        check("comparison")
    while player.loop.passes < passes:
        before = player.loop.passes
        play(30.0, lambda: player.loop.passes > before)
        check("pass")
    player.loop.stop()
    for size in ("64", "256"):
        execute(player, "block-size", size)
        check("block size")
print(json.dumps({"checked": report, "lost": lost, "longest_s": round(longest, 3)}))
player.close()
"""
)


def check_connections(passes, others):
    with jack_server.Server(period=256) as server:
        seconds = 120.0 + 5.0 * passes + 10.0 * others
        report = json.loads(server.run(CONNECTED, passes, others, timeout=seconds))
    print(report)
    assert report["lost"] == []
    assert report["checked"]["pass"] >= passes - 2 * others - 2


def test_a_connection_made_by_hand_survives_passes_restarts_replays_and_comparisons():
    check_connections(6, 2)


@pytest.mark.soak
def test_a_connection_made_by_hand_survives_twenty_of_each_and_fifty_passes():
    check_connections(95, 20)
