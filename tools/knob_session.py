"""A hand, a knob whose own board runs the surface, a bad wire, the host: in a simulated clock.

For `measure_knob.py` and the tests. The board is `simulated_board.py`, the host the part of
`overview play` that speaks to it, and, where it is heard, an engine.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from simulated_board import BoardMotor
from simulated_motor import Hand

import overview_dsp as ov
from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.sensors.frames import FrameDecoder
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import Counters
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.devices.sensors.touching import TouchRules

BAUD = 1_000_000
TICK_S = 0.002
TURN = math.pi
LOSS = 0.3
JITTER = 0.5
"""Of the delay, and 1 ms."""


class Wire:
    """One way: frames arrive late, unevenly, in order, and some never do."""

    def __init__(self, delay_s: float, loss: float, dice: random.Random) -> None:
        self._delay, self._jitter, self._loss = delay_s, JITTER * delay_s + 1e-3, loss
        self._dice = dice
        self._under_way: deque[tuple[float, bytes]] = deque()

    def put(self, now: float, data: bytes) -> None:
        for frame in data.split(b"\0")[:-1]:
            if self._dice.random() >= self._loss:
                late = self._delay + self._jitter * self._dice.random()
                after = self._under_way[-1][0] if self._under_way else 0.0
                self._under_way.append((max(after, now + late), frame + b"\0"))

    def take(self, now: float) -> bytes:
        out = b""
        while self._under_way and self._under_way[0][0] <= now:
            out += self._under_way.popleft()[1]
        return out


@dataclass
class Course:
    """One value at the end of each step of the board, since it had its surface."""

    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    given: np.ndarray
    stored: np.ndarray
    disk: np.ndarray
    ready_after_s: float
    struck: dict[int, float]

    def greatest_rise(self, since: float = 0.0) -> float:
        """Of given and stored energy between any two moments after `since` (s), J."""
        total = (self.given + self.stored)[self.time >= since]
        return float((total - np.minimum.accumulate(total)).max())


class Ear:
    """The engine that plays what the board reports."""

    RATE, BLOCK = 48_000, 128

    def __init__(self, timeline: ov.Timeline, preset: ov.Preset, sensor: Sensor) -> None:
        self._engine = ov.Engine(preset, timeline)
        self._engine.prepare(self.RATE, self.BLOCK)
        self._source = SensorSource(sensor, TouchRules.of(preset))
        self._out = np.zeros((self.BLOCK, 2), dtype=np.float32)
        self.struck: dict[int, float] = {}

    def hear(self, data: bytes, now: float) -> None:
        engine = self._engine
        place = engine.meters.cursor * math.pi
        for event in self._source.feed(data, now, None, place):
            engine.control(event.theta2, event.touching, None, "serial")
        while engine.sample_time < now * self.RATE:
            engine.process(self._out)
        strikes = engine.pop_strikes()
        for event, at in zip(strikes.event, strikes.time_s, strict=True):
            self.struck.setdefault(int(event), float(at))


def simulate(
    surface: ov.Surface,
    preset: ov.Preset,
    sensor: Sensor,
    path: Callable[[float], float | None],
    seconds: float,
    delay_s: float = 0.0,
    loss: float = LOSS,
    killed_at: float = math.inf,
    hertz: int = 4000,
    stiffness: float = 0.1,
    timeline: ov.Timeline | None = None,
) -> Course:
    """A knob in a hand that goes along `path` (rad) once the board has its surface.

    With a `timeline` it is played too, by an engine in blocks of 128 frames.
    """
    motor = BoardMotor(hertz=hertz)
    begins = [math.inf]
    hand = Hand(lambda t: path(t - begins[0]) if t >= begins[0] else 0.0, stiffness)
    dice = random.Random(1)
    there, back = Wire(delay_s, loss, dice), Wire(delay_s, loss, dice)
    loop, decoder = BoardLoop(sensor, BAUD), FrameDecoder(Counters())
    loop.render(surface, preset.values)
    ear = Ear(timeline, preset, sensor) if timeline is not None else None
    rows: list[tuple[float, ...]] = []
    tick, given = 0, 0.0
    while motor.time < begins[0] + seconds:
        tick += 1
        now = tick * TICK_S
        while motor.time < now:
            back.put(motor.time, motor.loop(there.take(motor.time)))
            before = motor.angle
            torque = motor.torque
            motor.step(hand.torque(motor))
            given += torque * (motor.angle - before)
            if motor.ends_step and motor.time >= begins[0]:
                since = motor.time - begins[0]
                rows.append((since, motor.angle, torque, given, motor.stored, motor.disk))
        said = back.take(now)
        if ear is not None:
            ear.hear(said, now)
        readings = decoder.feed(said)
        loop.hear([(now, one) for one in readings], now)
        if now < begins[0] + killed_at:
            there.put(now, loop.step(True, now))
        if loop.ready and begins[0] == math.inf:
            begins[0] = now + 0.6  # the pull to the start rises for half a second
        if begins[0] == math.inf and now > 20.0:
            raise RuntimeError("the board has no surface after 20 s")
    columns = np.array(rows).T
    struck = {} if ear is None else {event: at - begins[0] for event, at in ear.struck.items()}
    return Course(*columns, begins[0] - 0.6, struck)


def glide(seconds: float, rest: float = 0.3) -> Callable[[float], float]:
    """From one end to the other at one pace, but for a tenth of it at each end."""

    def path(t: float) -> float:
        part = min(1.0, max(0.0, t / seconds))
        ease = 0.1
        if part < ease:
            way = part * part / (2.0 * ease)
        elif part > 1.0 - ease:
            way = 1.0 - ease - (1.0 - part) ** 2 / (2.0 * ease)
        else:
            way = part - 0.5 * ease
        return TURN * way / (1.0 - ease)

    return path
