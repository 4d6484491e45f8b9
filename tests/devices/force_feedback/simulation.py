"""The whole loop in a simulated clock: hand, knob, wire, sensor, engine, motor loop."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import overview_dsp as ov
from overview_dsp.devices.force_feedback.motion import MeanTorque
from overview_dsp.devices.force_feedback.motor_loop import MotorLoop
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.devices.sensors.touch_detection import DiskState, TouchRules

RATE, BLOCK = 48_000, 128
TICK_S = 1e-3
ROOT = Path(__file__).resolve().parents[3]


def motor_module():
    spec = importlib.util.spec_from_file_location(
        "simulated_motor", ROOT / "tools" / "simulated_motor.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


sim = motor_module()


@dataclass
class Course:
    """One value a millisecond."""

    time: list = field(default_factory=list)
    angle: list = field(default_factory=list)
    torque: list = field(default_factory=list)
    put_in: list = field(default_factory=list)
    given: list = field(default_factory=list)
    hand_work: list = field(default_factory=list)
    credit: list = field(default_factory=list)

    def arrays(self):
        return {name: np.array(values) for name, values in vars(self).items()}


def simulate(preset, timeline, sensor, path, seconds, delay_s=0.0, naive=False, motor=None, **hand):
    """Run it; `naive` sends the torque as it is. The course as arrays, the motor, the loop."""
    engine = ov.Engine(preset, timeline)
    engine.prepare(RATE, BLOCK)
    motor = sim.Motor() if motor is None else motor
    session = sim.Session(motor, sim.Fingers(path, **hand), delay_s)
    loop, tap = MotorLoop(sensor), MeanTorque()
    if naive:
        per = sensor.number("motor.nm_per_unit")
        loop._controller.step = lambda wanted, *_: max(
            -per * motor.limit, min(per * motor.limit, wanted)
        )
    reader = SensorSource(sensor, TouchRules.of(preset))
    out = np.zeros((BLOCK, 2), dtype=np.float32)
    course, sent = Course(), b""
    for tick in range(round(seconds / TICK_S)):
        now = (tick + 1) * TICK_S
        received = session.exchange(now, sent)
        disk = DiskState(None, engine.meters.cursor * np.pi)
        for event in reader.feed(received, now, disk):
            engine.control(event.theta2, event.touching, None, "serial")
        while engine.sample_time < now * RATE:
            engine.process(out)
        loop.receive(reader.samples, now)
        sent = loop.step(tap.update(engine.torque_integral, now), now)
        course.time.append(now)
        course.angle.append(motor.angle)
        course.torque.append(motor.torque)
        course.put_in.append(motor.absorbed)
        course.given.append(motor.returned)
        course.hand_work.append(motor.user_work)
        course.credit.append(loop.observer.credit)
    return course.arrays(), motor, loop
