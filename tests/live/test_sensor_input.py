"""A sensor into a running engine: through a made-up port, and through a pseudo-terminal."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.devices.sensors.frames import decode_frame
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.kernels import layout
from overview_dsp.live.inputs.sensors import SensorInput
from overview_dsp.live.inputs.threaded import EventClock
from overview_dsp.live.ports import serial
from overview_dsp.live.ports.serial import SerialPort
from tests.cli.running import overview
from tests.live import stepped
from tests.live.priority import urgently
from tests.live.stepped import SteppedPort, SteppedTime

ROOT = Path(__file__).resolve().parents[2]
KNOB = ROOT / "tools" / "simulated_knob.py"
needs_pty = pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")


def knob_module():
    spec = importlib.util.spec_from_file_location("simulated_knob", KNOB)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


POT = Sensor(columns=("t_ms", "pot"))
SERIAL = SOURCES.index("serial")


class Bench:
    """An engine run by hand, and a potentiometer on a made-up port, in a time made by hand."""

    def __init__(self, engine, clock):
        self.engine, self.clock = engine, clock
        self.opened = []
        self.refused = 0
        self.there = True
        self.refusal = ov.InputError("serial:made: no such port")
        self.input = SensorInput(engine, "made", POT, open_port=self._open)
        self.now_ms = 0
        self.port.step(b"\n")

    def _open(self, device, baud):
        if not self.there:
            self.refused += 1
            raise self.refusal
        self.opened.append(SteppedPort())
        return self.opened[-1]

    @property
    def port(self):
        return self.opened[-1]

    @property
    def written(self):
        """Events handed to the engine so far."""
        return int(self.engine.memory.view(np.int64)[layout.RING_WRITTEN + SERIAL])

    def send(self, data):
        """Ten milliseconds on, this is read."""
        self.clock.now += 0.01
        self.port.step(data)

    def read(self, value):
        """Ten milliseconds on, the potentiometer is there, of 1023."""
        self.now_ms += 10
        self.send(f"{self.now_ms},{value}\n".encode())

    def turn(self, place, samples=1):
        for _ in range(samples):
            self.read(round(1023 * place))
            self.run(0.01)

    def until(self, condition):
        """Let time go on, with nothing more to read, until something is so."""
        end = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < end, self.input.report()
            if self.input._port is self.port and not self.port.lost:
                self.send(b"")
            else:
                time.sleep(0.002)

    def run(self, seconds):
        for _ in range(round(seconds * 100)):
            self.engine.process(np.zeros((480, 2), dtype=np.float32))


@pytest.fixture
def bench(match, football, monkeypatch):
    clock = SteppedTime()
    stepped.use(clock, monkeypatch)
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 48_000)
    bench = Bench(engine, clock)
    yield bench
    bench.input.close()


def test_a_turned_knob_holds_the_disk_and_moves_it(bench):
    bench.turn(0.0, 3)
    assert bench.engine.active_input is None
    for place in (0.1, 0.3, 0.5, 0.5, 0.5):
        bench.turn(place, 5)
    bench.run(1.0)
    source, theta2 = bench.engine.active_input
    assert source == "serial"
    assert theta2 == pytest.approx(0.5 * math.pi, abs=0.01)
    assert bench.engine.meters.cursor == pytest.approx(0.5, abs=0.02)


def test_silence_and_unplugging_let_go_and_it_comes_back(bench):
    bench.turn(0.0, 2)
    bench.turn(0.5, 10)
    assert bench.engine.active_input[0] == "serial"
    bench.until(lambda: any("no data" in said for said in bench.input.take_messages()))
    bench.run(0.1)
    assert bench.engine.active_input is None
    bench.turn(0.9, 10)
    assert bench.engine.active_input[0] == "serial"
    bench.there = False
    bench.port.lost = True
    bench.until(lambda: any("disconnected" in said for said in bench.input.take_messages()))
    bench.run(0.1)
    assert bench.engine.active_input is None
    assert not bench.input.report()["connected"]
    assert "disconnected" in bench.input.status_text
    bench.there = True
    bench.until(lambda: any("reconnected" in said for said in bench.input.take_messages()))
    assert len(bench.opened) == 2
    assert bench.opened[0].closed
    bench.send(b"\n")
    bench.turn(0.1, 2)
    bench.turn(0.9, 10)
    assert bench.engine.active_input[0] == "serial"
    assert bench.input.report()["connections_lost"] == 1


def test_a_finger_and_the_knob_change_over_without_a_jump(bench):
    bench.turn(0.0, 2)
    for place in np.linspace(0.0, 0.8, 20):
        bench.turn(place, 2)
    bench.turn(0.8, 30)
    bench.engine.control(0.3 * math.pi, True)
    bench.run(0.05)
    assert bench.engine.active_input[0] == "touch"
    bench.turn(0.8, 5)
    bench.engine.control(0.3 * math.pi, False)
    bench.run(0.02)
    # the knob stands at 0.8 and takes over where the finger was
    assert bench.engine.active_input[0] == "serial"
    assert bench.engine.active_input[1] == pytest.approx(0.3 * math.pi, abs=0.05)
    bench.turn(0.8, 40)
    assert bench.engine.active_input[1] == pytest.approx(0.8 * math.pi, abs=0.01)


def test_a_saved_preset_changes_the_rules(bench, football):
    bench.turn(0.0, 2)
    bench.engine.set_preset(football.with_changes({"twist.engage_deg": 60.0}))
    bench.input.poll(bench.engine)
    bench.turn(0.2, 10)
    assert bench.engine.active_input is None
    bench.turn(0.5, 10)
    assert bench.engine.active_input is not None


def test_while_the_output_is_lost_no_stale_events_are_kept(bench):
    bench.turn(0.0, 2)
    bench.turn(0.5, 10)
    for n in range(80):  # the engine stands still
        bench.read(600 + n)
    waiting = bench.written
    bench.read(1023)
    assert bench.written == waiting
    bench.run(0.5)
    assert bench.engine.active_input[1] < 0.9 * math.pi
    bench.turn(1.0, 30)
    bench.run(0.2)
    assert bench.engine.active_input[1] == pytest.approx(math.pi, abs=0.01)


def test_a_release_while_the_output_is_lost_is_applied(bench):
    bench.turn(0.0, 2)
    bench.turn(0.5, 10)
    assert bench.engine.active_input[0] == "serial"
    for n in range(120):  # the engine stands still, and the knob is turned back to rest
        bench.read(511 if n < 80 else 0)
    bench.until(lambda: not bench.input.report()["holding"])
    bench.run(0.6)  # with what came before it was known that the engine stands still
    assert bench.engine.active_input is None


@pytest.mark.parametrize(
    ("sent", "said"),
    [
        # as another speed reads: bytes come, and none of them is a line
        (lambda bench: bytes(range(0, 256, 5)), "speed"),
        # one sample, again and again: the device hangs in its sending
        (lambda bench: f"{bench.now_ms},512\n".encode(), "repeated"),
    ],
)
def test_data_without_new_samples_release_the_disk_and_are_reported_once(bench, sent, said):
    bench.turn(0.0, 2)
    bench.turn(0.5, 10)
    assert bench.engine.active_input[0] == "serial"
    messages = []
    for _ in range(60):
        bench.send(sent(bench))
        bench.run(0.01)
        messages += bench.input.take_messages()
    assert bench.engine.active_input is None
    assert sum("disk released" in line for line in messages) == 1
    assert sum(said in line for line in messages) == 1
    bench.send(b"\n")
    bench.turn(0.9, 10)
    assert bench.engine.active_input[0] == "serial"


def test_a_device_is_found_again_by_its_usb_identity_and_no_other_in_its_place(bench, monkeypatch):
    here = {"made": "1:2:mine"}
    looked = []

    def ports():
        looked.append(here.copy())
        return [serial.PortInfo(a, "", b) for a, b in here.items()]

    monkeypatch.setattr(serial, "ports", ports)
    bench.input._identity = "1:2:mine"
    here.clear()
    here["made"] = "1:2:another"
    bench.port.lost = True
    bench.until(lambda: not bench.input.report()["connected"])
    looked.clear()
    bench.until(lambda: len(looked) > 3)
    assert len(bench.opened) == 1
    here["elsewhere"] = "1:2:mine"
    bench.until(lambda: bench.input.report()["connected"])
    assert bench.input.report()["port"] == "elsewhere"
    assert serial.find_device_again("elsewhere", "1:2:mine") == "elsewhere"
    assert serial.find_device_again("elsewhere", "") == "elsewhere"


def test_a_port_that_another_program_holds_is_reported_once_and_waited_for(bench):
    held = ov.InputError("serial:made: used by another program, such as a serial monitor")
    bench.refusal = held
    bench.there = False
    bench.port.lost = True
    bench.until(lambda: not bench.input.report()["connected"])
    bench.until(lambda: bench.refused > 3)
    messages = bench.input.take_messages()
    assert sum("used by another program" in line for line in messages) == 1
    bench.there = True
    bench.until(lambda: bench.input.report()["connected"])


def test_an_input_that_cannot_keep_up_discards_waiting_data(bench):
    bench.turn(0.0, 2)

    class Flood:
        """There is always more."""

        waiting = 4096

        def receive(self, wait_s):
            bench.clock.now += 0.01
            bench.now_ms += 1
            return [f"{bench.now_ms},512\n".encode() * 20]

        def close(self):
            pass

    bench.input._port = Flood()
    bench.until(lambda: bench.input.report()["overrun_bytes"] > 1000)
    bench.until(
        lambda: any("faster than they are read" in line for line in bench.input.take_messages())
    )


def test_one_long_interruption_discards_no_data(bench):
    bench.turn(0.0, 2)

    class Held:
        """Not read for a while; then everything is read, and more has come meanwhile."""

        def __init__(self):
            self.reads = 0

        @property
        def waiting(self):
            return 7 if self.reads < 4 else 0

        def receive(self, wait_s):
            self.reads += 1
            bench.clock.now += 0.2 if self.reads == 1 else 0.001
            bench.now_ms += 1
            return [f"{bench.now_ms},512\n".encode()]

        def close(self):
            pass

    port = bench.input._port = Held()
    bench.until(lambda: port.reads > 20)
    assert bench.input.report()["overrun_bytes"] == 0


def test_a_backlog_causes_no_delay_after_it_was_processed():
    clock = EventClock(48_000.0)
    for n in range(600):
        behind = 0.2 if n < 200 else 0.0
        now = round((n * 1e-3 + behind) * 48_000.0)
        clock.observe(n * 1e-3, now)
        stamp = clock.stamp(n * 1e-3, now)
        if n > 450:
            assert stamp - now <= 2 * 0.012 * 48_000.0 + 1


def test_an_overrun_is_discarded_and_counted(bench):
    bench.turn(0.0, 2)
    bench.send(b"12,12\n" * 20_000)
    assert bench.input.report()["overrun_bytes"] > 0
    assert "overrun bytes" in bench.input.status_text


@pytest.mark.parametrize("block", [64, 256, 1024])
def test_events_are_spread_as_the_sensor_took_them(block):
    """A sensor at 1000 Hz into blocks: stamps are even, and wait about as long as a block."""
    dice = np.random.default_rng(2)
    rate, drift = 48_000.0, 1.0 + 80e-6
    clock = EventClock(rate)
    waits, stamps = [], []
    for n in range(20_000):
        true = n * 1e-3
        arrival = true + 2e-3 + 1e-3 * dice.random()
        now = int(arrival * rate * drift // block) * block
        clock.observe(true, now)
        stamps.append(clock.stamp(true, now))
        waits.append(stamps[-1] - now)
    steps = np.diff(stamps[2000:])
    assert (steps >= 0).all()
    assert np.mean(steps) == pytest.approx(48.0, rel=1e-3)
    assert np.percentile(np.abs(steps - 48), 90) <= 0.1 * block + 2
    late = np.mean(np.array(waits[2000:]) < 0)
    assert late < 0.08
    median, highest = clock.added_latency_s
    assert median <= highest <= (block / rate) + 2.5e-3


def test_the_simulated_device_speaks_the_documented_frame():
    knob = knob_module()
    for n in range(300):
        dice = np.random.default_rng(n)
        acc, gyr = dice.integers(-30, 30, 3) * knob.G / 2.0, np.radians(dice.integers(-900, 900, 3))
        frame = knob.as_frame(n, 7 * n, acc, gyr)
        reading = decode_frame(frame[:-1])
        assert frame[-1] == 0
        assert reading["t_us"] == 7 * n
        assert reading["ax"] == max(-32768, min(32767, round(acc[0] / knob.G * 2048)))
        assert reading["gz"] == pytest.approx(math.degrees(gyr[2]) * 16.384, abs=0.51)


def test_the_simulated_device_imports_nothing_of_the_package():
    code = f"import sys; sys.argv=['x', '-h']; sys.path.insert(0, {str(KNOB.parent)!r})\n" + (
        "import simulated_knob\nprint([n for n in sys.modules if n.startswith('overview')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr


@pytest.fixture
def device(tmp_path):
    """Start simulated devices; each is named by a link of its own."""
    running = []

    def start(*arguments):
        link = tmp_path / f"knob{len(running)}"
        command = [sys.executable, str(KNOB), "imu", "--link", str(link), *map(str, arguments)]
        running.append(
            subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=urgently)
        )
        assert running[-1].stdout.readline().startswith(f"serial:{link}")
        return link

    yield start
    for process in running:
        process.terminate()
        process.wait()
        process.stdout.close()


PLAY = [sys.executable, "-m", "overview_dsp", "play", "world-cup-final-2018", "--device", "none"]


def played(*arguments):
    done = subprocess.run(
        [*PLAY, *map(str, arguments)], capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
        preexec_fn=urgently,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()], done.stderr


@pytest.mark.realtime
@needs_pty
@pytest.mark.parametrize("form", ["frames", "text", "json"])
def test_a_device_on_a_port_is_detected_played_and_recorded(
    device, tmp_path, form, match, football
):
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    take = tmp_path / "take.csv"
    lines, said = played("--input", f"serial:{device('--format', form)}", "--seconds", 8,
                         "--record", take)  # fmt: skip
    report = lines[-1]["summary"]["input"]
    assert {"frames": "binary", "text": "lines of ax", "json": "JSON"}[form] in report["format"]
    assert report["readings"] > 800
    assert (report["damaged"], report["lost"], report["implausible"]) == (0, 0, 0)
    assert any(line["touching"] and line["cursor"] > 0.3 for line in lines[:-1])
    assert "calibrating" in said
    assert "face up is" in said  # it lay still while it was calibrated
    print({name: report[name] for name in ("wait_p50_ms", "wait_p99_ms")})
    replay = ov.render(match, football, ov.load_gesture(take), sample_rate=8000)
    assert replay.trace.cursor.max() > 0.3


@pytest.mark.realtime
@needs_pty
def test_noise_on_the_wire_is_counted_and_does_not_stop_it(device):
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    port = device("--noise", 0.01, "--lose", 0.05, "--rate", 500)
    lines, _ = played("--input", f"serial:{port}", "--seconds", 7)
    report = lines[-1]["summary"]["input"]
    assert report["damaged"] > 50
    assert report["lost"] > 50
    assert report["readings"] > 1500
    assert any(line["touching"] for line in lines[:-1])


@needs_pty
def test_devices_says_what_a_port_speaks(device):
    told = device("--format", "json")
    found = overview("devices", "--json", "--serial", told, "--serial", "/dev/no-such-port")
    ports = {one["device"]: one["speaks"] for one in json.loads(found.out)["serial_ports"]}
    assert ports[str(told)] == "JSON lines"
    assert "no such port" in ports["/dev/no-such-port"]


@needs_pty
def test_a_port_is_held_by_one_program(device):
    path = str(device())
    port = SerialPort(path)
    try:
        with pytest.raises(ov.InputError, match="used by another program"):
            SerialPort(path)
    finally:
        port.close()


@pytest.mark.parametrize(
    "arguments",
    [
        ("--input", "serial:/dev/no-such-port"),
        ("--input", "serial:"),
        ("--input", "pad:,force"),
        ("--input", "serial:/dev/null,baud=96"),
        ("--input", "serial:/dev/null,sensor=imy"),
        ("--input", "serial:/dev/null,sensor=nowhere.toml"),
    ],
)
def test_wrong_options_give_a_one_line_error(arguments):
    done = overview("play", "world-cup-final-2018", "--device", "none", *arguments)
    assert done.code == 2
    assert len(done.errors) == 1


def test_a_machine_that_is_held_up_makes_some_events_late_and_not_all():
    clock = EventClock(48_000.0)
    for n in range(5000):
        held_up = 0.08 if n % 100 < 10 else 0.0
        now = round((n * 1e-3 + held_up) * 48_000.0)
        clock.observe(n * 1e-3, now)
        clock.stamp(n * 1e-3, now)
    assert clock.added_latency_s[1] <= 0.0121
