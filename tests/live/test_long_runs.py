"""Long runs: many openings, half an hour of play, the load test with its table.

`OVERVIEW_SOAK_S` sets the length of play (default 1800 s); the load test's windows follow it.
"""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from tests.live import jack_server
from tests.live.test_portaudio import OPEN_AND_CLOSE
from tools.bench.live.latency import LatencyResult
from tools.bench.live.table import BLOCKS, LoadRow, Report, latency_table, load_table

pytestmark = [
    pytest.mark.soak,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

SECONDS = float(os.environ.get("OVERVIEW_SOAK_S", "1800"))
GROWN_KB = 2000


def test_200_openings_leak_no_descriptor_thread_or_memory():
    with jack_server.Server(period=256) as server:
        before, after = json.loads(server.run(OPEN_AND_CLOSE, 200, timeout=600.0))
    print(f"before {before}\nafter  {after}")
    assert after["files"] == before["files"]
    assert after["threads"] == before["threads"]
    assert after["kb"] <= before["kb"] + GROWN_KB


PLAY = """
import json, os, random, sys, time
import numpy as np
import overview_dsp as ov
from overview_dsp.live.output.portaudio_stream import OutputStream

seconds = float(sys.argv[1])
rate, block = 48_000, 256
chance = random.Random(1)
# springs ten times as stiff: at rest within seconds, to a millionth of a sample
football = ov.load_preset("football").with_changes({"disk.k1": 0.0036, "disk.k2": 0.015})
engine = ov.Engine(football, ov.load_timeline("world-cup-final-2018"))
engine.prepare(rate, 8192)
changed = {id: engine.preset.number(id) for id in ("tactor.gain_db", "surface.intensity_gain")}
# (time s, frames, underflows) ten times a second; filled, so that it takes its memory now
looks = np.full((round(11.0 * seconds) + 100, 3), -1.0)
looked = 0
gesture = ov.tap(0.95, 0.7) + ov.pause(1.0) + ov.sweep(1.5)

def state():
    fields = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return {
        "files": len(os.listdir("/proc/self/fd")),
        "threads": int(fields["Threads"]),
        "kb": int(fields["VmRSS"].split()[0]),
    }

def strikes_of_the_gesture():
    engine.pop_strikes()
    began = engine.sample_time + rate // 2
    for stamp, theta2, touching in zip(gesture.stamps(rate), gesture.theta2, gesture.touching):
        engine.control(float(theta2), bool(touching), began + int(stamp))
    time.sleep(0.5 + gesture.duration_s + 3.0)
    strikes = engine.pop_strikes()
    return {
        "sample": (strikes.time_s * rate - began).tolist(),
        "event": strikes.event.tolist(),
        "torque": strikes.torque.tolist(),
    }

def rest():
    # a hand at 0 takes the disk there sooner
    engine.control(0.0, True)
    time.sleep(3.0)
    engine.control(0.0, False)
    time.sleep(2.0)

def look():
    global looked
    meters = stream.meters
    if looked < len(looks):
        looks[looked] = time.monotonic(), meters.frames, meters.underflows
        looked += 1

def play_for(span):
    theta2, until, turn = 0.0, time.monotonic() + span, 0
    while time.monotonic() < until:
        turn += 1
        theta2 = min(max(theta2 + chance.gauss(0.0, 0.05), 0.0), 3.14159)
        if chance.random() < 0.005:
            theta2 = chance.uniform(0.0, 3.14159)
        engine.control(theta2, chance.random() > 0.01)
        if turn % 10 == 0:
            look()
        if turn % 100 == 0:
            engine.set("tactor.gain_db", chance.uniform(-12.0, 0.0))
        if turn % 1000 == 0:
            engine.set("surface.intensity_gain", chance.uniform(0.0, 2.0))
        time.sleep(0.01)
    for id, value in changed.items():
        engine.set(id, value)

states = []
with OutputStream(engine, device="system", block_size=block) as stream:
    time.sleep(1.0)
    rest()
    at_start = strikes_of_the_gesture()
    for _ in range(20):
        play_for(seconds / 20)
        states.append(state())
    rest()
    at_end = strikes_of_the_gesture()
    device, voice = stream.meters, engine.meters
print(json.dumps({
    "looks": looks[:looked].tolist(), "rate": rate,
    "at_start": at_start, "at_end": at_end, "states": states,
    "device": vars(device), "voice": {**vars(voice)},
}))
"""


def frames_per_second(looks):
    """How fast the device asks for frames, from (time s, frames, underflows) in rows.

    The server loses any length of time at an underflow, which no counter tells: one slope is fitted
    to all stretches without one, each with an offset of its own. The counter moves in blocks, which
    a fit to many looks evens out, and the difference of two doesn't.
    """
    covered = product = square = 0.0
    for lost in np.unique(looks[:, 2]):
        # about a loss the counter stands still before it is counted
        time, frames, _ = looks[looks[:, 2] == lost][2:-2].T
        if len(time) >= 10:
            covered += time[-1] - time[0]
            product += (time - time.mean()) @ (frames - frames.mean())
            square += (time - time.mean()) @ (time - time.mean())
    assert covered > 0.5 * (looks[-1, 0] - looks[0, 0]), "the server loses too much to tell"
    return product / square


def test_long_play_keeps_its_memory_its_clock_and_its_feel():
    with jack_server.Server(period=256) as server:
        report = json.loads(server.run(PLAY, SECONDS, timeout=2.0 * SECONDS + 300.0))
    looks = np.array(report["looks"])
    seconds, frames, underflows = looks[-1] - looks[0]
    asked_percent = 100.0 * frames / (seconds * report["rate"])
    drift_percent = 100.0 * (frames_per_second(looks) / report["rate"] - 1.0)
    print(
        f"{seconds:.1f} s, {asked_percent:.4f} % of the frames asked for, {underflows:.0f} "
        f"underflows; between them against the clock {drift_percent:+.4f} %"
    )
    print(f"device {report['device']}")
    for state in report["states"]:
        print(state)
    # memory: flat from the first tenth on
    early, late = report["states"][1], report["states"][-1]
    assert late["files"] == early["files"]
    assert late["threads"] == early["threads"]
    assert late["kb"] <= early["kb"] + GROWN_KB
    # clock
    assert abs(drift_percent) <= 0.05
    # state
    voice = report["voice"]
    assert voice["resets"] == voice["dropped_events"] == voice["late_events"] == 0
    assert np.isfinite([voice[name] for name in ("cursor", "torque", "envelope")]).all()
    # feel: the same gesture strikes the same events as hard, at the same samples
    start, end = report["at_start"], report["at_end"]
    assert len(start["event"]) > 10
    assert end["event"] == start["event"]
    np.testing.assert_allclose(end["torque"], start["torque"], rtol=1e-6)
    np.testing.assert_allclose(end["sample"], start["sample"], rtol=0.0, atol=1e-3)


def test_no_native_callback_is_late_under_load_and_next_to_nothing_is_lost():
    window = min(60.0, SECONDS / 30.0)
    bench = ("-m", "tools.bench", "--live", "--device", "system", "--json")
    with jack_server.Server(period=256) as server:
        found = json.loads(
            server.python(*bench, "--seconds", max(1.0, window), "--rounds", 5, timeout=7200.0)
        )
    found["load"] = [LoadRow(**row) for row in found["load"]]
    found["latency"] = [LatencyResult(**row) for row in found["latency"]]
    print(found.pop("date"), found.pop("machine"))
    report = Report(**found)
    print("\n".join(load_table(report)))
    native = [row for row in report.load if row.callback == "native"]
    assert all(row.late == 0 for row in native)
    assert all(row.lost_percent <= 0.3 for row in native)
    assert report.lost_ratio >= 20.0
    assert all(row.beyond == 0 for row in report.latency)


LATENCY = """
import json, sys
from dataclasses import asdict
from tools.bench.live.latency import measure_latency
print(json.dumps(asdict(measure_latency("system", int(sys.argv[1]), float(sys.argv[2])))))
"""


def test_a_tap_is_answered_within_a_block_at_every_block_size():
    rows = []
    for block in BLOCKS:
        # the server's period is the block, as on a sound card set to it
        with jack_server.Server(period=block) as server:
            rows.append(LatencyResult(**json.loads(server.run(LATENCY, block, SECONDS / 60.0))))
    report = Report(48_000, 256, SECONDS / 60.0, 1, [], 0.0, False, rows, 383, [])
    print("\n".join(latency_table(report)))
    assert all(row.beyond == 0 for row in rows)
