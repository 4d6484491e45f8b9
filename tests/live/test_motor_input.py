"""A motor knob into a running engine and back: through a made-up port, and through a real one."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.live.inputs.sensors import MotorInput
from tests.cli.running import overview
from tests.live import stepped
from tests.live.priority import urgently
from tests.live.stepped import SteppedPort, SteppedTime
from tests.live.test_sensor_input import KNOB, PLAY, ROOT, needs_pty, played

SENSOR = load_sensor("simplefoc")


def line_fits(data):
    """A port that never blocks, and a Commander whose buffer has 20 characters."""
    assert all(len(line) < 20 for line in data.split(b"\n"))
    return True


class MotorPort(SteppedPort):
    """Keeps what is written, with its time."""

    def __init__(self, clock):
        super().__init__()
        self._clock = clock
        self.written = []
        self.targets = []

    def write(self, data):
        self.written.append((self._clock.now, data))
        self.targets += [
            float(line[1:])
            for line in data.decode().split()
            if line[1] in "-0123456789" and line[0] == "M"
        ]
        return line_fits(data)

    def lines(self):
        return b"".join(data for _, data in self.written).decode().splitlines()


class Bench:
    """An engine run by hand, and a motor that says its angle every millisecond of its time."""

    def __init__(self, engine, clock):
        self.engine, self.clock = engine, clock
        self.there = True
        self.input = MotorInput(engine, "made", SENSOR, open_port=self._open)
        self.angle = 0.0

    def _open(self, *_):
        if not self.there:
            raise ov.InputError("serial:made: no such port")
        self.port = MotorPort(self.clock)
        return self.port

    def turn(self, speed, seconds):
        """Turn at `speed` (rad/s), the engine kept in time with it."""
        for done in range(1, round(seconds * 1000) + 1):
            self.clock.now += 1e-3
            self.angle += speed * 1e-3
            applied = self.targets()[-1:] or [0.0]
            self.port.step(f"{applied[0]:.4f}\t{self.angle:.4f}\r\n".encode())
            if done % 5 == 0:
                self.engine.process(np.zeros((round(0.005 * RATE), 2), dtype=np.float32))

    def targets(self):
        return self.port.targets[:]


RATE = 8_000


@pytest.fixture
def bench(match, football, monkeypatch):
    clock = SteppedTime()
    stepped.use(clock, monkeypatch)
    engine = ov.Engine(football, match)
    engine.prepare(RATE, 48_000)
    bench = Bench(engine, clock)
    yield bench
    bench.input.close()


def test_a_turning_knob_is_braked_and_a_resting_one_is_not(bench):
    bench.turn(0.0, 0.4)
    assert not any(bench.targets())
    assert bench.port.lines()[:6] == ["@0", "MC0", "M0", "MMS1000001", "MMD10", "ME1"]
    bench.turn(3.0, 0.8)
    assert bench.engine.active_input[0] == "serial"
    assert min(bench.targets()) < -0.05
    assert max(bench.targets()) == 0.0
    bench.turn(0.0, 0.3)
    assert bench.targets()[-1] == 0.0
    report = bench.input.report()["force"]
    assert report["alive"]
    assert "mN·m" in bench.input.status_text


def test_silence_zeroes_the_torque_within_50_ms_and_lets_go(bench):
    bench.turn(0.0, 0.3)
    bench.turn(3.0, 0.6)
    assert bench.targets()[-1] < 0.0
    silent_at = bench.clock.now
    messages = ()
    while not any("no data from the motor" in said for said in messages):
        assert bench.clock.now < silent_at + 2.0
        bench.clock.now += 0.002
        bench.port.step()
        messages = bench.input.take_messages()
    bench.engine.process(np.zeros((800, 2), dtype=np.float32))
    assert bench.engine.active_input is None
    last = max(at for at, data in bench.port.written if not data.endswith(b"M0.0000\n"))
    assert last <= silent_at + 0.05
    assert bench.targets()[-1] == 0.0


def test_another_hand_that_holds_the_disk_does_not_turn_the_motor(bench):
    bench.turn(0.0, 0.3)
    bench.turn(3.0, 0.4)
    bench.engine.control(0.5, True)
    bench.turn(3.0, 0.1)
    bench.port.targets.clear()
    bench.turn(3.0, 0.2)
    assert bench.engine.active_input[0] == "touch"
    assert not any(bench.targets())


def test_the_motor_has_no_torque_and_no_power_after_the_end(bench):
    bench.turn(0.0, 0.2)
    bench.input.close()
    assert bench.port.lines()[-2:] == ["M0", "ME0"]
    assert bench.port.closed


def until(condition):
    """Wait for the input's thread."""
    end = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.002)


def test_an_unplugged_motor_is_begun_with_again_when_it_is_back(bench):
    bench.turn(0.0, 0.3)
    bench.turn(3.0, 0.3)
    bench.there = False
    gone, bench.port.lost = bench.port, True
    until(lambda: gone.closed)
    assert "no force" in bench.input.status_text
    bench.there = True
    until(lambda: bench.port is not gone)
    bench.turn(0.0, 0.3)
    assert bench.port.lines()[0] == "@0"
    assert not any(bench.targets())
    bench.turn(3.0, 0.6)
    assert min(bench.targets()) < 0.0


def test_a_motor_that_reports_too_seldom_is_reported_once(bench):
    for n in range(140):
        bench.clock.now += 0.02
        bench.port.step(f"0.0000\t{0.001 * n:.4f}\r\n".encode())
    said = [one for one in bench.input.take_messages() if "reports per second" in one]
    assert len(said) == 1
    assert "motor.downsample" in said[0]


class BoardBench:
    """An engine run by hand, and a knob whose own board runs the surface."""

    def __init__(self, engine, clock):
        self.engine, self.clock = engine, clock
        self.motor = board_module().BoardMotor()
        self.input = MotorInput(engine, "made", SENSOR, 1_000_000, open_port=self._open)
        self.torques = []

    def _open(self, *_):
        self.port = SteppedPort()
        self.sent = b""
        self.port.write = self._write
        return self.port

    def _write(self, data):
        self.sent += data
        return True

    def turn(self, speed, seconds):
        """Turn at `speed` (rad/s), the engine kept in time with it."""
        motor = self.motor
        for _ in range(round(seconds * 500)):
            self.clock.now += 0.002
            sent, self.sent, said = self.sent, b"", b""
            for _ in range(16):
                said += motor.loop(sent)
                sent = b""
                motor.angle += speed * motor.dt
                motor.time += motor.dt
            self.torques.append(motor.torque)
            self.port.step(said)
            self.engine.process(np.zeros((round(0.002 * RATE), 2), dtype=np.float32))


def board_module():
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import simulated_board
    finally:
        sys.path.pop(0)
    if simulated_board.compiler() is None:
        pytest.skip("needs a C compiler")
    return simulated_board


@pytest.fixture
def board(match, football, monkeypatch):
    clock = SteppedTime()
    stepped.use(clock, monkeypatch)
    engine = ov.Engine(football, match)
    engine.prepare(RATE, 48_000)
    bench = BoardBench(engine, clock)
    yield bench
    bench.input.close()


def test_a_knob_that_runs_the_surface_itself_is_given_it_and_played(board):
    board.turn(0.0, 1.2)
    assert board.motor.table == 1
    assert not any(board.torques)
    board.turn(1.0, 1.0)
    assert min(board.torques) < -1e-3
    assert max(board.torques) <= 0.0
    assert board.engine.active_input[0] == "serial"
    assert board.engine.meters.cursor == pytest.approx(board.motor.disk, abs=0.02)
    report = board.input.report()
    assert (report["damaged"], report["lost"]) == (0, 0)
    assert (report["force"]["on_board"], report["force"]["ready"]) == (True, True)
    assert "computed on its board" in board.input.status_text


def test_a_changed_surface_and_another_hand_reach_the_board(board, football):
    board.turn(0.0, 1.0)
    board.turn(1.0, 0.4)
    board.engine.set_preset(football.with_changes({"surface.friction": 8e-4}))
    board.turn(0.0, 0.6)
    assert board.motor.table == 2
    board.engine.control(0.2, True)
    board.turn(1.0, 0.1)
    board.torques.clear()
    board.turn(1.0, 0.1)
    assert board.engine.active_input[0] == "touch"
    assert not any(board.torques)


def test_the_board_is_told_at_the_end(board):
    board.turn(0.0, 1.0)
    board.turn(1.0, 0.4)
    board.sent = b""
    board.input.close()
    assert board.motor.torque < 0.0
    board.motor.loop(board.sent)
    for _ in range(160):  # 20 ms, less than its own silence takes
        board.motor.loop(b"")
    assert board.motor.torque == 0.0


@pytest.fixture
def motor(tmp_path):
    """Start simulated motors; the port of each, and what it told at its end."""
    running = []

    def start(*arguments):
        link = tmp_path / f"motor{len(running)}"
        command = [sys.executable, str(KNOB), "motor", "--link", str(link), *map(str, arguments)]
        running.append(
            subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=urgently)
        )
        assert running[-1].stdout.readline().startswith(f"serial:{link}")
        return link

    def told():
        process = running[-1]
        process.send_signal(signal.SIGINT)
        return json.loads(process.communicate(timeout=20)[0].splitlines()[-1])

    start.told = told
    yield start
    for process in running:
        process.terminate()
        process.wait()
        process.stdout.close()


FORCE = "sensor=simplefoc,force"


@pytest.mark.realtime
@needs_pty
@pytest.mark.parametrize("delay_ms", [0, 20])
def test_the_loop_closes_over_a_port_and_gives_the_hand_nothing(motor, delay_ms):
    port = motor("--delay-ms", delay_ms)
    lines, _ = played("--input", f"serial:{port},{FORCE}", "--seconds", 9)
    force = lines[-1]["summary"]["input"]["force"]
    told = motor.told()
    print(force, told)
    assert force["absorbed_mj"] > 0.5
    assert force["returned_mj"] <= force["absorbed_mj"] + force["friction_mj"]
    assert force["absorbed_mj"] == pytest.approx(told["absorbed_mj"], rel=0.25)
    assert told["returned_mj"] <= told["absorbed_mj"]
    assert told["user_mj"] > told["absorbed_mj"]
    assert not told["enabled"]
    assert told["target"] == 0.0
    assert lines[-1]["summary"]["block_size"] == 128


@pytest.mark.realtime
@needs_pty
def test_a_board_that_renders_the_surface_receives_it_over_a_port_and_brakes(motor):
    board_module()
    port = motor("--board", "--delay-ms", 5)
    lines, _ = played("--input", f"serial:{port},{FORCE},baud=1000000", "--seconds", 10)
    report = lines[-1]["summary"]["input"]
    told = motor.told()
    print(report, told)
    assert report["force"]["on_board"]
    assert report["force"]["ready"]
    assert report["damaged"] == 0
    assert any(line["input"]["force"]["torque_nm"] < -1e-3 for line in lines[:-1])
    assert any(line["touching"] and line["cursor"] > 0.5 for line in lines[:-1])
    assert told["absorbed_mj"] > 0.5
    assert told["user_mj"] > 0.0


@pytest.mark.realtime
@needs_pty
def test_a_knob_that_is_held_lies_still_over_a_port(motor):
    port = motor("--movement", "hold", "--delay-ms", 20)
    lines, _ = played("--input", f"serial:{port},{FORCE}", "--seconds", 7)
    assert lines[-1]["summary"]["input"]["force"]["commands"] > 500
    assert motor.told()["moved_deg"] < 0.2


@needs_pty
def test_a_host_that_is_killed_leaves_no_torque(motor):
    """The device's own duty: nothing tells it to stop."""
    port = motor("--movement", "sweep")
    process = subprocess.Popen(
        [*PLAY, "--input", f"serial:{port},{FORCE}"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
    )  # fmt: skip
    try:
        until = time.monotonic() + 60.0
        for line in process.stdout:
            assert time.monotonic() < until
            if json.loads(line)["input"]["force"]["torque_nm"] != 0.0:
                break
    finally:
        process.kill()
        process.communicate()
    time.sleep(0.3)
    told = motor.told()
    assert told["silences"] >= 1
    assert told["target"] == 0.0


@pytest.mark.realtime
@needs_pty
def test_a_silent_motor_is_released(motor):
    port = motor("--mute", 4)
    lines, said = played("--input", f"serial:{port},{FORCE}", "--seconds", 9)
    force = lines[-1]["summary"]["input"]["force"]
    assert force["silences"] >= 1
    assert not force["alive"]
    assert force["torque_nm"] == 0.0
    assert not lines[-2]["touching"]
    assert "no data from the motor for 40 ms" in said


@pytest.mark.parametrize(
    "arguments",
    [
        ("--input", "pad:,force"),
        ("--input", "sweep:2,force"),
        ("--input", "serial:/dev/null,force"),
        ("--input", "serial:/dev/null,force=yes,sensor=simplefoc"),
        ("--input", "serial:/dev/null,sensor=imu,force"),
        ("--input", "serial:/dev/no-such-port,sensor=simplefoc,force"),
    ],
)
def test_wrong_options_give_a_one_line_error(arguments):
    done = overview("play", "world-cup-final-2018", "--device", "none", *arguments)
    assert done.code == 2
    assert len(done.errors) == 1
