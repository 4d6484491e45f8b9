"""Devices that move in known ways, and what their sensors say."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.devices.sensors.touch_detection import TouchRules
from tests.devices.sensors.encoding import encode_frame

G = 9.80665
RULES = TouchRules(True, True, math.radians(4.0), math.radians(6.0), 0.2, 0.15)


def lines(rows) -> list[bytes]:
    """Rows of numbers as a device prints them."""
    return [(",".join(f"{value:.6g}" for value in row) + "\n").encode() for row in rows]


def frames(acceleration, turning, rate: float, start_us: int = 0) -> list[bytes]:
    """Six axes, m/s² and rad/s, as binary frames."""
    acc = np.rint(np.asarray(acceleration) / G * 2048).astype(int).tolist()
    gyr = np.rint(np.degrees(turning) * 16.384).astype(int).tolist()
    return [
        encode_frame(2, n, start_us + round(n / rate * 1e6), (*a, *g))
        for n, (a, g) in enumerate(zip(acc, gyr, strict=True))
    ]


def turning(roll, rate: float, pitch: float = 0.0, bias=(0.0, 0.0, 0.0), noise=0.0, seed=0):
    """What a device says whose roll (rad, an array) goes so, its pitch fixed: m/s², rad/s."""
    roll = np.asarray(roll)
    up = np.stack(
        [np.full(len(roll), math.sin(pitch)), math.cos(pitch) * np.sin(roll),
         math.cos(pitch) * np.cos(roll)], axis=1,
    )  # fmt: skip
    speed = np.zeros((len(roll), 3))
    speed[:, 0] = np.gradient(roll) * rate
    dice = np.random.default_rng(seed)
    return (
        G * up + noise * 0.05 * dice.standard_normal(up.shape),
        speed + np.asarray(bias) + noise * 0.002 * dice.standard_normal(up.shape),
    )


def course(rate: float, *places: tuple[float, float]) -> np.ndarray:
    """Degrees at times (s), joined by smooth steps: rad, one value a sample."""
    times, degrees = zip(*places, strict=True)
    t = np.arange(round(times[-1] * rate)) / rate
    at = np.clip(np.searchsorted(times, t, "right") - 1, 0, len(times) - 2)
    a, b = np.array(times)[at], np.array(times)[at + 1]
    part = (t - a) / (b - a)
    part = part * part * (3.0 - 2.0 * part)
    y = np.array(degrees, dtype=float)
    return np.radians(y[at] + (y[at + 1] - y[at]) * part)


def hand(rules: TouchRules = RULES, columns: tuple[str, ...] = (), **values) -> SensorSource:
    """A hand; values of the profile with `__` for a dot."""
    given = {id.replace("__", "."): value for id, value in values.items()}
    return SensorSource(Sensor(values=given, columns=columns), rules)


def fed(one: SensorSource, pieces, rate: float, start_s: float = 0.0):
    """All events, and the turn after each piece."""
    events, turns = [], []
    for n, piece in enumerate(pieces):
        events += one.feed(piece, start_s + n / rate)
        turns.append(one.angle)
    return events, turns
