"""Pads, phones and radios as ports: made-up devices, and apps that are played by the test."""

from __future__ import annotations

import http.client
import json
import math
import socket
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace

import pytest

import overview_dsp as ov
from overview_dsp.devices.sensors.packets import WitDecoder, packets_from_notification, wit_columns
from overview_dsp.devices.sensors.pads import framed
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.devices.sensors.reading import Counters
from overview_dsp.live.inputs.sensors import NamedInput
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.ports.bluetooth import UART, WITMOTION, BlePort
from overview_dsp.live.ports.pads import PadPort, find_pad
from overview_dsp.live.ports.phones import PhyphoxPort, PostPort
from overview_dsp.live.ports.port import PortLostError
from tests.devices.sensors.shapes import RATE, STATES, logger, phyphox
from tests.devices.sensors.test_pads import UNITS, dualsense


def until(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


# --- pads -----------------------------------------------------------------------------------------


class MadeHid:
    """The library with pads of the test's own."""

    def __init__(self, *pads, reports=()):
        self.pads, self.reports = list(pads), list(reports)
        self.written, self.closed, self.gone = [], 0, False

    def enumerate(self):
        return [
            {"vendor_id": vendor, "product_id": product, "product_string": name, "path": b"/dev/x"}
            for vendor, product, name in self.pads
        ]

    def device(self):
        return self

    def open_path(self, path):
        if path != b"/dev/x":
            raise OSError("open failed")

    def get_feature_report(self, number, length):
        return list(UNITS)

    def set_nonblocking(self, on):
        assert on  # else a read without a wait is one without an end

    def write(self, data):
        self.written.append(data)

    def read(self, length, timeout_ms):
        if self.gone:
            raise OSError("read error")
        return list(self.reports.pop(0)) if self.reports else []

    def close(self):
        self.closed += 1


DUALSENSE = (0x054C, 0x0CE6, "DualSense Wireless Controller")
LEFT, RIGHT = (0x057E, 0x2006, "Joy-Con (L)"), (0x057E, 0x2007, "Joy-Con (R)")


def test_a_pad_is_found_by_what_it_is_or_calls_itself():
    hid = MadeHid(DUALSENSE, LEFT, RIGHT, (0x046D, 0xC52B, "a mouse"))
    assert find_pad("dualsense", hid).kind == "dualsense"
    assert find_pad("wireless", hid).kind == "dualsense"
    assert find_pad("(R)", hid).kind == "joycon-right"
    assert find_pad("", MadeHid(LEFT)).kind == "joycon"
    for wanted, word in (("joy-con", "several"), ("xbox", "DualSense Wireless")):
        with pytest.raises(ov.InputError, match=word):
            find_pad(wanted, hid)
    with pytest.raises(ov.InputError, match="none"):
        find_pad("", MadeHid())


def test_a_pads_reports_come_with_its_units_and_its_loss_is_one():
    reports = [dualsense(s) for s in STATES[:3]]
    hid = MadeHid(DUALSENSE, reports=reports)
    port = PadPort("", hid)
    assert port.receive(0.05) == list(map(framed, (UNITS, *reports)))
    assert port.receive(0.05) == []
    hid.gone = True
    with pytest.raises(PortLostError, match="pad:"):
        port.receive(0.05)
    port.close()
    assert hid.closed == 1


def test_a_joy_con_is_told_to_say_how_it_moves():
    hid = MadeHid(RIGHT)
    PadPort("", hid)
    assert {data[0] for data in hid.written} == {1}
    factory, user = b"\x10\x20\x60\x00\x00\x18", b"\x10\x26\x80\x00\x00\x1a"
    assert [data[10:] for data in hid.written] == [factory, user, b"\x40\x01", b"\x03\x30"]


# --- phones ---------------------------------------------------------------------------------------


class Phone:
    """phyphox on a phone that is twisted."""

    def __init__(self, names=("accX", "accY", "accZ", "acc_time", "illum")):
        self.queued_commands = []
        phone = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def log_message(self, *arguments):
                pass

            def do_GET(self):
                body = phone.answer(self.path)
                self.send_response(200 if body is not None else 404)
                self.send_header("Content-Length", str(len(body or b"")))
                self.end_headers()
                self.wfile.write(body or b"")

        self.names = names
        self.began = time.monotonic()
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()
        self.address = f"http://127.0.0.1:{self.server.server_port}"

    def answer(self, path):
        self.queued_commands.append(path)
        if path == "/config":
            return json.dumps({"title": "x", "buffers": [{"name": n} for n in self.names]}).encode()
        if path == "/control?cmd=start":
            return b'{"result": true}'
        if path.startswith("/get?"):
            n = min(int((time.monotonic() - self.began) * RATE), len(STATES) - 1)
            return phyphox(STATES[n])
        return None

    def close(self):
        self.server.shutdown()
        self.server.server_close()


@pytest.fixture
def running(match, football):
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 4800)
    stream = NullStream(engine, 256)
    stream.start()
    yield engine
    stream.close()


def test_phyphox_is_started_and_asked_for_what_it_measures_and_holds_the_disk(running):
    phone = Phone()
    hand = NamedInput(running, "phyphox", phone.address, load_sensor("imu"), PhyphoxPort)
    until(lambda: running.active_input is not None)
    assert running.active_input[0] == "serial"
    assert phone.queued_commands[:2] == ["/config", "/control?cmd=start"]
    assert phone.queued_commands[2] == "/get?accX&accY&accZ&acc_time"
    report = hand.report()
    assert report["damaged"] == 0
    assert report["format"] == "an app's JSON"
    phone.close()
    hand.close()
    assert hand.report()["holding"] is False


def test_a_phone_that_cannot_be_asked_gives_a_one_line_error():
    phone = Phone(names=("illum",))
    for address, word in ((phone.address, "no accelerometer"), ("http://", "must be the URL"),
                          ("http://127.0.0.1:1", "remote access")):  # fmt: skip
        with pytest.raises(ov.InputError, match=word) as caught:
            PhyphoxPort(address)
        assert "\n" not in str(caught.value)
    phone.close()


def post(port, body, **headers):
    connection = http.client.HTTPConnection(*port.address, timeout=10)
    connection.request("POST", "/data", body, headers)
    status = connection.getresponse().status
    connection.close()
    return status


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@pytest.fixture
def posted():
    port = PostPort(str(free_port()))
    yield port
    port.close()


def test_an_apps_batches_are_lines_whatever_stands_in_them(posted):
    assert post(posted, b'{"a":\r\n 1}') == 200
    assert post(posted, b"{}") == 200
    until(lambda: len(posted._messages) == 2)
    assert posted.receive(0.05) == [b'{"a":   1}\n', b"{}\n"]
    assert posted.receive(0.05) == []
    assert post(posted, b"x" * 20_000) == 413
    assert posted.receive(0.05) == []


def test_sensor_logger_posts_and_holds_the_disk(running, posted):
    hand = NamedInput(running, "post", "x", load_sensor("imu"), lambda name: posted, 2.0)
    for state in STATES[1::2]:
        assert post(posted, logger(state, ("gravity",))) == 200
    until(lambda: hand.report()["theta2_rad"] is not None)
    until(lambda: abs(hand.report()["theta2_rad"] - math.radians(20.0)) < 0.1)
    hand.close()


# --- radio ----------------------------------------------------------------------------------------


def made_bleak(uuid, name="WT901BLE68", notifications=()):
    """The library with one sensor in reach."""
    device = SimpleNamespace(address="AA:BB", name=name)
    left = {}

    class Scanner:
        @staticmethod
        async def find_device_by_filter(is_wanted_device, timeout):
            advertised = SimpleNamespace(local_name=name)
            return device if is_wanted_device(device, advertised) else None

    class Client:
        def __init__(self, found, disconnected):
            left["now"] = lambda: disconnected(self)
            one = SimpleNamespace(uuid=uuid.upper())
            self.services = [SimpleNamespace(characteristics=[one])]

        async def __aenter__(self):
            return self

        async def __aexit__(self, *error):
            left["closed"] = True

        async def start_notify(self, which, take):
            for one in notifications:
                take(None, bytearray(one))

    return SimpleNamespace(BleakScanner=Scanner, BleakClient=Client), left


def wit_radio(state):
    serial = [round(x) for x in (*(state.a / 9.80665 * 2048), *(state.g * 57.29578 * 16.384))]
    return b"\x55\x61" + b"".join(n.to_bytes(2, "little", signed=True) for n in [*serial, 0, 0, 0])


def test_witmotion_by_radio_becomes_the_checked_packets_of_its_wire():
    sent = [wit_radio(s) for s in STATES[300:310]]
    bleak, left = made_bleak(WITMOTION, notifications=sent)
    port = BlePort("wt901", bleak)
    received = port.receive(0.05)
    assert received == list(map(packets_from_notification, sent))
    data = b"".join(received)
    counters = Counters()
    readings = WitDecoder(counters, wit_columns(data)).feed(data)
    assert len(readings) == 10
    assert readings[0]["ax"] == pytest.approx(STATES[300].a[0] / 9.80665, abs=1e-3)
    assert counters.damaged == 0
    left["now"]()
    until(lambda: left.get("closed"))
    with pytest.raises(PortLostError, match="out of range"):
        port.receive(0.05)
    port.close()


def test_a_bluetooth_uart_gives_the_bytes_of_a_serial_port():
    bleak, _ = made_bleak(UART, "board", [b"0.01,0.", b"02,0.99\n"])
    port = BlePort("AA:BB", bleak)
    assert port.receive(0.05) == [b"0.01,0.", b"02,0.99\n"]
    port.close()


@pytest.mark.parametrize(
    ("uuid", "wanted", "word"),
    [(UART, "other", "no such sensor found"), ("00002a00", "wt901", "no supported service")],
)
def test_a_sensor_that_cannot_be_heard_gives_a_one_line_error(uuid, wanted, word):
    bleak, _ = made_bleak(uuid)
    with pytest.raises(ov.InputError, match=word):
        BlePort(wanted, bleak)
