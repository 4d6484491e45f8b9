"""A DualSense as sensor and actuator in one: its reports turn the disk, its channel 3 vibrates."""

from __future__ import annotations

import json

import numpy as np
import pytest

import overview_dsp as ov
from tests.live import jack_server
from tests.sensors.shapes import STATES
from tests.sensors.test_pads import UNITS, dualsense

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

PLAY = """
import json, subprocess, sys, time
import jack
import numpy as np

playing = subprocess.Popen(
    [sys.executable, "-m", "overview_dsp", "play", "world-cup-final-2018", "--input", "pad:",
     "--device", "system", "--click-channel", "1", "--tactor-channel", "3", "--actuator",
     "dualsense", "--seconds", "12", "--json"],
    stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
client = jack.Client("coils", no_start_server=True)
ports = [client.inports.register(f"in_{n}") for n in range(4)]
loudest = np.zeros(4)

@client.set_process_callback
def process(frames):
    for n, port in enumerate(ports):
        loudest[n] = max(loudest[n], float(np.abs(port.get_array()).max()))

with client:
    while playing.poll() is None:
        for n, port in enumerate(ports):
            for source in client.get_ports(f"PortAudio:out_{n}"):
                try:
                    if not client.get_all_connections(port):
                        client.connect(source, port)
                except jack.JackError:
                    pass  # it isn't there yet, or any more
        time.sleep(0.05)
    printed, said = playing.communicate()
print(json.dumps({"loudest": loudest.tolist(), "said": said, "code": playing.returncode,
                  "summary": json.loads(printed.splitlines()[-1])["summary"]}))
"""


def test_a_dualsense_is_turned_and_vibrates_on_its_third_channel(tmp_path):
    reports = [UNITS, *(dualsense(state) for state in STATES)]
    (tmp_path / "reports.json").write_text(json.dumps([one.hex() for one in reports]))
    (tmp_path / "hidraw.py").write_text(HID.format(path=str(tmp_path / "reports.json")))
    with jack_server.Server(period=512, outputs=4) as server:
        before = server.environment.get("PYTHONPATH", "")
        server.environment["PYTHONPATH"] = f"{tmp_path}:{before}"
        heard = json.loads(server.run(PLAY, timeout=300.0).splitlines()[-1])
    assert heard["code"] == 0, heard["said"]
    report = heard["summary"]["input"]
    assert report["readings"] > 500
    assert report["damaged"] == 0
    assert len(heard["summary"]["happened"]) > 10  # events that the disk passed
    click, second, third, fourth = heard["loudest"]
    assert (second, fourth) == (0.0, 0.0)
    assert 0.01 < click <= 1.0
    assert 0.05 < third <= ov.load_actuator("dualsense").values["drive.peak"]
    assert np.isfinite(heard["loudest"]).all()
