"""A sensor at 1000 Hz through a pseudo-terminal into a sounding engine, and all that goes wrong.

`OVERVIEW_SOAK_S` (1800 s) sets the length of the long version: a third of it.
"""

from __future__ import annotations

import importlib.util
import json
import os
from pathlib import Path

import numpy as np
import pytest

from tests.live import jack_server

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
    pytest.mark.skipif(
        importlib.util.find_spec("vqf") is None, reason="needs vqf: pip install '.[sensors]'"
    ),
]

DEVICE = Path(__file__).with_name("faulty_device.py")
LETS_GO = ("garbage", "stuck", "silence", "frozen", "disconnected")
"""Faults by which nothing is known of the hand any more."""

PLAY = """
import contextlib, json, os, subprocess, sys, threading, time
import overview_dsp as ov
from overview_dsp.live.inputs import threaded
from overview_dsp.live.inputs.threaded import EventClock
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.live.inputs.sensors import SensorInput
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.web.remote_inputs import SampleClock

device, link, seconds, block = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
events = []

class Noted(EventClock):
    def stamp(self, time_s, now):
        stamp = super().stamp(time_s, now)
        events.append((hand.report()["connections_lost"], time_s, stamp,
                       clock.time_of(max(stamp, now))))
        return stamp

threaded.EventClock = Noted
engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)
running = subprocess.Popen([sys.executable, device, link, seconds], stdout=subprocess.PIPE,
                           stdin=subprocess.PIPE, text=True)
assert running.stdout.readline() == "ready\\n"
with contextlib.suppress(OSError, AttributeError):
    # as the server, where that is allowed: this program's latency, not that of what else runs here
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
told = []
listening = threading.Thread(target=lambda: told.append(running.stdout.readline()))
listening.start()
clock = SampleClock(engine)
held, said = [], []
with OutputStream(engine, device="system", block_size=block) as stream:
    for _ in range(200):
        clock.update(time.monotonic())
        time.sleep(0.005)
    hand = SensorInput(engine, link, Sensor())
    while listening.is_alive():
        now = time.monotonic()
        clock.update(now)
        hand.poll(engine)
        said += [(now, line) for line in hand.take_messages()]
        held.append((now, engine.active_input is not None))
        time.sleep(0.01)
    time.sleep(0.5)
    report = hand.report()
    hand.close()
    time.sleep(0.2)
    left = engine.active_input
    meters, voice = stream.meters, engine.meters
running.communicate("")
print(json.dumps({
    "device": json.loads(told[0]), "held": held, "said": said, "report": report, "left": left,
    "events": events, "late": meters.late, "underflows": meters.underflows,
    "voice": {name: getattr(voice, name) for name in
              ("resets", "late_events", "dropped_events", "rejected_events", "clamped_events")},
}))
"""


def played(tmp_path, seconds, block=128):
    with jack_server.Server(period=block) as server:
        said = server.run(PLAY, DEVICE, tmp_path / "port", seconds, block, timeout=seconds + 300.0)
    return json.loads(said.splitlines()[-1])


def check(found):
    report, device = found["report"], found["device"]
    # no lost sample uncounted: what was understood and what is missing are all there were
    taken = sum(one["samples"] for one in device["connections"])
    counted = report["readings"] - report["repeated"] + report["lost"]
    assert counted == taken
    for name in ("damaged", "lost", "repeated", "clock_wraps"):
        assert report[name] > 0, name
    assert report["clock_restarts"] == 0
    unplugged = [one for one in device["faults"] if one["name"] == "disconnected"]
    assert report["connections_lost"] == len(unplugged)
    assert report["connected"]
    # seen, said once, let go, and taken hold of again
    lines = [line.partition(": ")[2] for _, line in found["said"]]
    for word, times in (
        ("damaged", 1), ("missing", 1), ("twice", 1), ("very same", 1 + len(unplugged)),
        ("disconnected", len(unplugged)), ("reconnected", len(unplugged)),
    ):  # fmt: skip
        there = sum(word in line for line in lines)
        assert 1 <= there <= times, (word, lines)
    times = np.array([one[0] for one in found["held"]])
    holding = np.array([one[1] for one in found["held"]])
    last = 0.0
    for fault in device["faults"]:
        before = holding[(times > last) & (times < fault["from"])]
        assert before[-1], fault
        during = holding[(times > fault["from"]) & (times < fault["to"] + 0.2)]
        if fault["name"] in LETS_GO:
            assert not during[-1 if fault["name"] == "disconnected" else slice(None)].all(), fault
        last = fault["to"]
    assert holding[-1]
    assert found["left"] is None
    voice = found["voice"]
    assert voice["resets"] == voice["dropped_events"] == voice["rejected_events"] == 0


def latencies_ms(found):
    """From a sample to where it acts on the output's clock, of all events outside of faults, ms."""
    began = [one["began"] for one in found["device"]["connections"]]
    faults = [(one["from"] - 0.1, one["to"] + 0.5) for one in found["device"]["faults"]]
    waits = []
    for connection, time_s, _, acts_at in found["events"]:
        taken_at = began[connection] + time_s
        if not any(start < taken_at < end for start, end in faults):
            waits.append(1e3 * (acts_at - taken_at))
    return np.array(waits)


def tell(found, seconds):
    waits = latencies_ms(found)
    report = found["report"]
    print(
        f"{seconds:.0f} s: {report['readings']} samples, {report['lost']} lost, "
        f"{report['damaged']} damaged, {report['repeated']} twice, "
        f"{report['connections_lost']} times unplugged; added latency of {len(waits)} events "
        + ", ".join(f"p{part} {np.percentile(waits, part):.2f}" for part in (50, 95, 99))
        + f" ms, highest {waits.max():.2f} ms; "
        f"late callbacks {found['late']}, underflows {found['underflows']}, {found['voice']}"
    )


def test_every_fault_is_seen_reported_once_and_survived_while_it_plays(tmp_path):
    found = played(tmp_path, 1.0)
    tell(found, found["held"][-1][0] - found["held"][0][0])
    check(found)


@pytest.mark.soak
def test_every_fault_is_survived_in_a_long_run(tmp_path):
    seconds = float(os.environ.get("OVERVIEW_SOAK_S", "1800")) / 3.0
    found = played(tmp_path, seconds)
    tell(found, seconds)
    check(found)
