"""A DualSense as sensor and actuator in one: its reports turn the disk, both its coils vibrate."""

from __future__ import annotations

import json

import pytest

import overview_dsp as ov
from tests.devices.sensors.shapes import STATES
from tests.devices.sensors.test_pads import UNITS, dualsense
from tests.live import jack_server

pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

HID = '''
"""hidapi with a pad that says the reports of a file, a hundred a second."""
import json, time

reports = [bytes.fromhex(one) for one in json.load(open({path!r}))]
began = None
told = 0

def enumerate():
    return [{{"vendor_id": 0x054C, "product_id": 0x0CE6, "product_string": "DualSense",
             "path": b"x"}}]

class device:
    def open_path(self, path): pass
    def set_nonblocking(self, on): pass
    def close(self): pass

    def get_feature_report(self, number, length):
        return list(reports[0])

    def read(self, length, timeout_ms):
        global began, told
        began = began or time.monotonic()
        if told >= min(int((time.monotonic() - began) * 100.0), len(reports) - 1):
            time.sleep(0.002 if timeout_ms else 0.0)
            return []
        told += 1
        return list(reports[told])
'''

# the pad's sound card, as PortAudio finds it: four channels under the pad's name
PLAY = """
import json, subprocess, sys
import jack
import numpy as np

client = jack.Client("DualSense Wireless Controller", no_start_server=True)
ports = [client.inports.register(f"in_{n}") for n in range(4)]
loudest = np.zeros(4)
apart = np.zeros(2)

@client.set_process_callback
def process(frames):
    block = np.stack([port.get_array() for port in ports])
    np.maximum(loudest, np.abs(block).max(axis=1), out=loudest)
    np.maximum(apart, np.abs(block[::2] - block[1::2]).max(axis=1), out=apart)

with client:
    playing = subprocess.run(
        [sys.executable, "-m", "overview_dsp", "play", "world-cup-final-2018", "--input", "pad:",
         "--device", "pad", "--seconds", "12", "--screen", "json"], capture_output=True, text=True)
    devices = subprocess.run(
        [sys.executable, "-m", "overview_dsp", "devices", "--listen", "0"],
        capture_output=True, text=True)
summary = playing.stdout.splitlines() and json.loads(playing.stdout.splitlines()[-1])["summary"]
print(json.dumps({"loudest": loudest.tolist(), "apart": apart.tolist(), "said": playing.stderr,
                  "code": playing.returncode, "devices": devices.stdout, "summary": summary}))
"""


def test_a_dualsense_is_turned_and_both_its_coils_vibrate(tmp_path):
    reports = [UNITS, *(dualsense(state) for state in STATES)]
    (tmp_path / "reports.json").write_text(json.dumps([one.hex() for one in reports]))
    (tmp_path / "hidraw.py").write_text(HID.format(path=str(tmp_path / "reports.json")))
    with jack_server.Server(period=512, outputs=4) as server:
        before = server.environment.get("PYTHONPATH", "")
        server.environment["PYTHONPATH"] = f"{tmp_path}:{before}"
        server.environment["XDG_CONFIG_HOME"] = str(tmp_path)
        heard = json.loads(server.run(PLAY, timeout=300.0).splitlines()[-1])
    assert heard["code"] == 0, heard["said"]
    report = heard["summary"]["input"]
    assert report["readings"] > 500
    assert report["damaged"] == 0
    assert len(heard["summary"]["events"]) > 10  # events that the disk passed
    left, right, left_coil, right_coil = heard["loudest"]
    assert heard["apart"] == [0.0, 0.0]
    assert 0.01 < left == right <= 1.0
    peak = ov.load_actuator("dualsense").values["drive.peak"]
    assert 0.05 < left_coil == right_coil <= peak
    plays = "clicks on 1+2, tactor on 3+4, actuator dualsense"
    assert (
        f"note: DualSense Wireless Controller (JACK Audio Connection Kit) is a pad: {plays}"
        in (heard["said"])
    )
    assert f"\n       plays {plays}\n" in heard["devices"]
    assert not (tmp_path / "overview-dsp").exists()  # nothing was chosen: nothing is remembered
