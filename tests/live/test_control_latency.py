"""From `engine.control` to the first changed sample, in samples, through a real stream."""

from __future__ import annotations

import json

import numpy as np
import pytest

from overview_dsp.units import HALF_TURN
from tests.live import jack_server
from tests.live.test_portaudio import aligned
from tools.bench.live.latency import HOLD, TAP_POSITION, probe_engine, strike_delay

TAPS = """
import json, random, sys, time
from dataclasses import asdict
import jack
import numpy as np
from tools.bench.live.latency import probe_engine, strike_delay, tap_while_playing
from overview_dsp.live.output.portaudio_stream import OutputStream

path, block, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
chance = random.Random(block)
delay = strike_delay()
engine = probe_engine()
stream = OutputStream(engine, device="system", block_size=block)
stream.start()
client = jack.Client("recorder")
ports = [client.inports.register(name) for name in ("click", "tactor")]
heard = np.zeros((round((count + 2) * 48_000), 2), dtype=np.float32)
state = {"at": 0, "xruns": 0}

@client.set_process_callback
def record(frames):
    at = state["at"]
    many = min(frames, len(heard) - at)
    for channel, port in enumerate(ports):
        heard[at : at + many, channel] = port.get_array()[:many]
    state["at"] = at + many

@client.set_xrun_callback
def xrun(delay):
    state["xruns"] += 1

with client:
    for channel, port in enumerate(ports):
        client.connect(f"overview:out_{channel}", port)
    time.sleep(0.3)
    taps = []
    for _ in range(count):
        time.sleep(chance.uniform(0.0, 0.05))
        taps.append(asdict(tap_while_playing(engine, delay)))
underflows = stream.meters.underflows
stream.close()
np.save(path, heard[: state["at"]])
print(json.dumps({"taps": taps, "underflows": underflows, "xruns": state["xruns"]}))
"""


def rendered(taps):
    """The probe offline, each tap at the sample that the strike log gave."""
    engine = probe_engine()
    frames = taps[-1]["after"] + 2 * HOLD
    for tap in taps:
        engine.control(TAP_POSITION * HALF_TURN, True, tap["applied"])
        engine.control(TAP_POSITION * HALF_TURN, False, tap["after"] + HOLD)
    out = np.zeros((frames, 2), dtype=np.float32)
    for first in range(0, frames, 8192):
        engine.process(out[first : first + 8192])
    return out


@pytest.mark.realtime
@pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL)
@pytest.mark.parametrize("block", [64, 256, 1024])
def test_a_tap_changes_a_sample_of_the_next_block_at_the_latest(tmp_path, block):
    path = tmp_path / "heard.npy"
    # a run in which the machine lost a period, or the recorder (in Python) one, is repeated
    for _ in range(jack_server.ATTEMPTS):
        with jack_server.Server(period=512) as server:
            report = json.loads(server.run(TAPS, path, block, 6))
        taps = report["taps"]
        for tap in taps:
            assert tap["before"] <= tap["applied"] <= tap["after"] + block
        # that those are the samples at which the output changed, the output itself says
        expected = rendered(taps)
        assert int(np.flatnonzero(expected.any(axis=1))[0]) == taps[0]["applied"]
        heard = aligned(np.load(path), expected)
        same = np.array_equal(heard[: len(expected)], expected[: len(heard)])
        if report["underflows"] == 0 and report["xruns"] == 0 and same:
            break
    assert same
    assert len(heard) >= taps[-1]["applied"] + HOLD


MESSAGES = """
import json, random, socket, sys, time
import numpy as np
import overview_dsp as ov
from overview_dsp.devices.controllers.osc_messages import OscReader
from overview_dsp.live.inputs.controllers import ControllerInput
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.live.ports.osc import OscPort
from tests.devices.controllers.osc_bytes import message

block, count = int(sys.argv[1]), int(sys.argv[2])
chance = random.Random(block)
engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(48_000, 8192)
out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
with OutputStream(engine, device="system", block_size=block) as stream:
    hand = ControllerInput(engine, "osc", lambda: OscPort("9127"), OscReader)
    time.sleep(0.5)
    sent, applied, seen = [], [], 0
    for number in range(count):
        time.sleep(chance.uniform(0.002, 0.012))
        sent.append(engine.sample_time)
        out.sendto(message("/overview/theta2", 1.0 + 1e-3 * number, 1), ("127.0.0.1", 9127))
    time.sleep(0.5)
    events, _ = engine.pop_applied(0)
    report, underflows = hand.report(), stream.meters.underflows
    hand.close()
# beyond the block after the one that may have begun
extra = np.maximum(events["sample"][:count] - np.array(sent[: len(events)]) - block, 0) / 48.0
print(json.dumps({
    "applied": len(events), "p50": float(np.median(extra)), "underflows": underflows,
    "p99": float(np.percentile(extra, 99)), "worst": float(extra.max()), **report,
}))
"""


@pytest.mark.realtime
@pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL)
@pytest.mark.parametrize("block", [64, 256, 1024])
def test_osc_messages_are_not_held_back(block):
    count = 400
    with jack_server.Server(period=block) as server:
        report = json.loads(server.run(MESSAGES, block, count))
    print(
        f"{block} frames: {report['applied']} of {count} applied, beyond the next block when sent "
        f"p50 {report['p50']:.2f}, p99 {report['p99']:.2f}, worst {report['worst']:.2f} ms; own "
        f"p99 {report['wait_p99_ms']} ms; {report['underflows']} underflows"
    )
    assert report["applied"] == count
    assert report["wait_p99_ms"] == 0.0


def test_the_probes_first_changed_sample_is_the_taps_own():
    for offset in (0, 1, 37, 64, 300):
        engine = probe_engine()
        out = np.zeros((8192, 2), dtype=np.float32)
        engine.process(out)
        engine.control(TAP_POSITION * HALF_TURN, True, 8192 + offset)
        engine.process(out)
        assert np.flatnonzero(out.any(axis=1))[0] == offset
        struck = engine.pop_strikes().time_s[0] * 48_000 - 8192 - offset
        assert abs(struck - strike_delay()) < 0.01
