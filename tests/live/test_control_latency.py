"""From `engine.control` to the first changed sample, in samples, through a real stream."""

from __future__ import annotations

import json

import numpy as np
import pytest

from overview_dsp.measure.bench.live.latency import HOLD, TAP_POSITION, probe, strike_delay
from overview_dsp.units import HALF_TURN
from tests.live import jack_server
from tests.live.test_portaudio import aligned

TAPS = """
import json, random, sys, time
from dataclasses import asdict
import jack
import numpy as np
from overview_dsp.measure.bench.live.latency import probe, strike_delay, tap_while_playing
from overview_dsp.live.output.portaudio_stream import OutputStream

path, block, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
chance = random.Random(block)
delay = strike_delay()
engine = probe()
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
    engine = probe()
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


def test_the_probes_first_changed_sample_is_the_taps_own():
    for offset in (0, 1, 37, 64, 300):
        engine = probe()
        out = np.zeros((8192, 2), dtype=np.float32)
        engine.process(out)
        engine.control(TAP_POSITION * HALF_TURN, True, 8192 + offset)
        engine.process(out)
        assert np.flatnonzero(out.any(axis=1))[0] == offset
        struck = engine.pop_strikes().time_s[0] * 48_000 - 8192 - offset
        assert abs(struck - strike_delay()) < 0.01
