"""Simulated session: a user, a knob whose own board runs the surface, a faulty wire, a host.

It is for `measure_knob.py` and the tests. The board is `simulated_board.py`. The host is the part
of `overview play` that exchanges data with it, and an engine where the sound is measured.
"""

from __future__ import annotations

import ctypes
import math
import random
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import simulated_board
from simulated_board import BoardMotor
from simulated_motor import Fingers

import overview_dsp as ov
from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.sensors.frames import FrameDecoder
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import Counters
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.devices.sensors.touch_detection import DiskState, TouchRules

BAUD = 1_000_000
TICK_S = 0.002
TURN = math.pi
NOISE_RAD = 1e-4
LOSS = 0.3
JITTER = 0.5
"""Jitter relative to the delay; another 1 ms is added."""


class Wire:
    """One direction of a wire with delay, jitter and loss; frames stay in order."""

    def __init__(self, delay_s: float, loss: float, dice: random.Random) -> None:
        self._delay, self._jitter, self._loss = delay_s, JITTER * delay_s + 1e-3, loss
        self._dice = dice
        self._pending: deque[tuple[float, bytes]] = deque()

    def put(self, now: float, data: bytes) -> None:
        for frame in data.split(b"\0")[:-1]:
            if self._dice.random() >= self._loss:
                late = self._delay + self._jitter * self._dice.random()
                after = self._pending[-1][0] if self._pending else 0.0
                self._pending.append((max(after, now + late), frame + b"\0"))

    def take(self, now: float) -> bytes:
        out = b""
        while self._pending and self._pending[0][0] <= now:
            out += self._pending.popleft()[1]
        return out


@dataclass
class Course:
    """Values at the end of each step of the board, from the time when it has its surface."""

    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    returned: np.ndarray
    stored: np.ndarray
    disk: np.ndarray
    ready_after_s: float
    strike_times: dict[int, float]

    def greatest_rise(self, since: float = 0.0) -> float:
        """Return the greatest rise of returned plus stored energy after `since` (s), J."""
        total = (self.returned + self.stored)[self.time >= since]
        return float((total - np.minimum.accumulate(total)).max())


class Listener:
    """An engine that plays the board's reports."""

    RATE, BLOCK = 48_000, 128

    def __init__(self, timeline: ov.Timeline, preset: ov.Preset, sensor: Sensor) -> None:
        self._engine = ov.Engine(preset, timeline)
        self._engine.prepare(self.RATE, self.BLOCK)
        self._source = SensorSource(sensor, TouchRules.of(preset))
        self._out = np.zeros((self.BLOCK, 2), dtype=np.float32)
        self.strike_times: dict[int, float] = {}

    def receive(self, data: bytes, now: float) -> None:
        engine = self._engine
        disk = DiskState(None, engine.meters.cursor * math.pi)
        for event in self._source.feed(data, now, disk):
            engine.control(event.theta2, event.touching, None, "serial")
        while engine.sample_time < now * self.RATE:
            engine.process(self._out)
        strikes = engine.pop_strikes()
        for event, at in zip(strikes.event, strikes.time_s, strict=True):
            self.strike_times.setdefault(int(event), float(at))


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
    """Simulate a user who follows `path` (rad) once the board has its surface.

    With a `timeline`, an engine plays it in blocks of 128 frames.
    """
    motor = BoardMotor(hertz=hertz)
    begins = [math.inf]
    fingers = Fingers(lambda t: path(t - begins[0]) if t >= begins[0] else 0.0, stiffness)
    dice = random.Random(1)
    to_board, to_host = Wire(delay_s, loss, dice), Wire(delay_s, loss, dice)
    loop, decoder = BoardLoop(sensor, BAUD), FrameDecoder(Counters())
    loop.render(surface, preset.values)
    listener = Listener(timeline, preset, sensor) if timeline is not None else None
    rows: list[tuple[float, ...]] = []
    tick, returned = 0, 0.0
    while motor.time < begins[0] + seconds:
        tick += 1
        now = tick * TICK_S
        while motor.time < now:
            to_host.put(motor.time, motor.loop(to_board.take(motor.time)))
            before = motor.angle
            torque = motor.torque
            motor.step(fingers.torque(motor))
            returned += torque * (motor.angle - before)
            since = motor.time - begins[0]
            if motor.ends_step and since > motor.dt:
                rows.append((since, motor.angle, torque, returned, motor.stored, motor.disk))
        received = to_host.take(now)
        if listener is not None:
            listener.receive(received, now)
        readings = decoder.feed(received)
        loop.receive([(now, one) for one in readings], now)
        if now < begins[0] + killed_at:
            to_board.put(now, loop.step(True, now))
        if loop.ready and begins[0] == math.inf:
            begins[0] = now + 0.6  # the torque towards the start rises for half a second
        if begins[0] == math.inf and now > 20.0:
            raise RuntimeError("the board has no surface after 20 s")
    columns = np.array(rows).T
    strikes = (
        {}
        if listener is None
        else {event: at - begins[0] for event, at in listener.strike_times.items()}
    )
    return Course(*columns, begins[0] - 0.6, strikes)


IDEAL = {"inertia": 5e-5}
REAL = {"inertia": 7e-5, "noise": NOISE_RAD, "late_s": 3e-4, "winding_s": 4e-4, "cogging": 3e-4,
        "cogs": 84.0}  # fmt: skip
"""A real knob: fingers of 2e-5 kg m2, a late and noisy encoder, a winding, a motor of 84 cogs."""

SETTLE_S = 0.7  # the torque towards the start rises for half a second


@dataclass
class Stroke:
    """Values at the end of each step of the board: rad, N m, J.

    `disk`: its position, 0 to 1. `felt`: torque at the fingers, against the hand. `returned`:
    energy that the motor gave. `stored`: energy of its pull. `knocks`: starts of knocks.
    """

    hertz: int
    angle: np.ndarray
    disk: np.ndarray
    torque: np.ndarray
    felt: np.ndarray
    returned: np.ndarray
    stored: np.ndarray
    knocks: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Time of each value, s."""
        return np.arange(1, len(self.angle) + 1) / self.hertz

    def greatest_rise(self, since: float = 0.0) -> float:
        """Return the greatest rise of returned plus stored energy after `since` (s), J."""
        total = (self.returned + self.stored)[round(since * self.hertz) :]
        return float((total - np.minimum.accumulate(total)).max())


def frames_for(surface: ov.Surface, preset: ov.Preset, sensor: Sensor) -> bytes:
    """Return what the host sends to a board until it has its surface."""
    loop, decoder, motor = BoardLoop(sensor, BAUD), FrameDecoder(Counters()), BoardMotor()
    loop.render(surface, preset.values)
    sent = b""
    while not loop.ready:
        frames = loop.step(True, motor.time)
        sent += frames
        until = motor.time + TICK_S
        while motor.time < until:
            received = motor.loop(frames)
            frames = b""
            motor.step(0.0)
            loop.receive([(motor.time, one) for one in decoder.feed(received)], motor.time)
    return sent


def stroke(
    frames: bytes,
    path: Callable[[np.ndarray], np.ndarray],
    seconds: float,
    knob: dict[str, float] = IDEAL,
    hertz: int = 4000,
    counts: int = 16384,
    stiffness: float = 0.1,
) -> Stroke:
    """Simulate a user whose target is `path` (rad at times), on a board that has its `frames`."""
    library = simulated_board.library(hertz, 8193, counts)
    board = ctypes.create_string_buffer(library.board_size())
    rig = simulated_board.Rig(friction=3e-4, damping=1e-5, stiffness=stiffness, hand_damping=4e-3,
                              step=2.0 * math.pi / counts, dice=1)  # fmt: skip
    for name, value in knob.items():
        setattr(rig, name, value)
    library.board_begin(board, 0.5 * rig.step)
    library.board_receive(board, frames, len(frames))
    before = round(SETTLE_S * hertz)
    time = np.arange(1 - before, round(seconds * hertz) + 1) / hertz
    targets = np.ascontiguousarray(path(np.maximum(time, 0.0)))
    rows = np.empty((len(targets), 7))
    library.rig_run(board, rig, targets.ctypes.data, len(targets), rows.ctypes.data)
    return Stroke(hertz, *rows[before:].T)


def glide(seconds: float, rest: float = 0.3) -> Callable[[float], float]:
    """Return a path from end to end at constant speed, with a slower tenth at each end."""

    def path(t: float) -> float:
        part = min(1.0, max(0.0, t / seconds))
        ease = 0.1
        if part < ease:
            angle = part * part / (2.0 * ease)
        elif part > 1.0 - ease:
            angle = 1.0 - ease - (1.0 - part) ** 2 / (2.0 * ease)
        else:
            angle = part - 0.5 * ease
        return TURN * angle / (1.0 - ease)

    return path
