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
import atexit, gc, json, os, signal, subprocess, sys, time
import jack
import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream_opener import StreamOpener
from overview_dsp.live.session.commands import execute, poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch

said = []

def play(seconds, until=lambda: False):
    # the time until the condition holds
    began = time.monotonic()
    while time.monotonic() - began < seconds and not until():
        said.extend(poll(player).messages)
        time.sleep(0.02)
    return round(time.monotonic() - began, 2)

def begin(**keywords):
    return Player(
        ov.load_timeline("world-cup-final-2018"), PresetWatch("football"),
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
        assert [line for line in report["said"] if not line.startswith("output ")] == []
        assert not any("disconnected" in line for line in report["said"]), report["said"]


def test_changes_of_the_output_leave_nothing_behind():
    check_changes(10)


@pytest.mark.soak
def test_a_hundred_changes_of_the_output_leave_nothing_behind():
    check_changes(100)


FREEZE = (
    BEGIN
    + """
name = os.environ["JACK_DEFAULT_SERVER"]
server = subprocess.Popen(
    f"jackd -n {name} -r -d dummy -r 48000 -p 256 -C 2 -P 2".split(),
    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
)

def end_server():
    # killed, it would leave its place in the table of servers
    server.terminate()
    server.send_signal(signal.SIGCONT)
    server.wait()

atexit.register(end_server)  # first, so that it runs after PortAudio has ended
look = ["jack_wait", "-c"]
while not subprocess.run(look, capture_output=True).stdout.startswith(b"run"):
    time.sleep(0.1)
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
