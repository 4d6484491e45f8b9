"""What common boards and apps send, made from their public formats while a device is twisted.

`python -m tests.devices.sensors.shapes` writes the table of them into docs/guide/sensors.md.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from overview_dsp.devices.sensors.decoders import DetectedFormat
from tests.devices.sensors.moving import course, hand, turning

RATE = 100.0
ROLL = course(
    RATE, (0, 0), (1.9, 0), (2.5, 75), (2.9, 75), (3.9, 160), (4.4, 160), (5.4, 20), (6.0, 20)
)
PAGE = Path(__file__).resolve().parents[3] / "docs" / "guide" / "sensors.md"
BEGIN, END = "<!-- shapes: python -m tests.devices.sensors.shapes -->\n", "<!-- end of shapes -->\n"
RAD = 180.0 / math.pi
G = 9.80665


@dataclass(frozen=True)
class State:
    """One sample: its number, m/s², rad/s, magnetic field (uT), roll (deg), quaternion w x y z."""

    n: int
    a: np.ndarray
    g: np.ndarray
    m: np.ndarray
    roll: float
    q: tuple[float, float, float, float]


@dataclass(frozen=True)
class Shape:
    """A source's shape, and what is to become of it.

    `said`: a word of the refusal, or empty if it is understood; `values`: of a sensor's file.
    """

    source: str
    make: Callable[[State], bytes]
    said: str = ""
    every: int = 1
    columns: tuple[str, ...] = ()
    before: bytes = b""


def states() -> Iterator[State]:
    acceleration, speed = turning(ROLL, RATE, noise=0.5, seed=4)
    dice = np.random.default_rng(5)
    for n, (a, g, roll) in enumerate(zip(acceleration, speed, ROLL, strict=True)):
        half = 0.5 * roll + 1e-4 * dice.standard_normal()
        field = np.array([20.0, 0.0, -43.0]) + 0.1 * dice.standard_normal(3)
        yaw = math.radians(20.0)
        cx, sx, cz, sz = math.cos(half), math.sin(half), math.cos(yaw), math.sin(yaw)
        yield State(n, a, g, field, math.degrees(roll), (cz * cx, cz * sx, sz * sx, sz * cx))


STATES = list(states())


def text(line: Callable[[State], str]) -> Callable[[State], bytes]:
    return lambda s: (line(s) + "\r\n").encode()


def few(numbers, digits: int = 2) -> list[str]:
    return [f"{number:.{digits}f}" for number in numbers]


def joined(apart: str, numbers, digits: int = 2) -> str:
    return apart.join(few(numbers, digits))


def counts(s: State, per_g: float = 16384.0, per_deg: float = 131.0) -> list[int]:
    return np.rint([*(s.a / G * per_g), *(s.g * RAD * per_deg)]).astype(int).tolist()


def raw(s: State, **ranges) -> str:
    return "\t".join(map(str, counts(s, **ranges)))


def xyz(v, form: str = "X: {:.2f}, Y: {:.2f}, Z: {:.2f}") -> str:
    return form.format(*v)


def tilt(s: State) -> float:
    """Roll from -180 to 180."""
    return math.remainder(s.roll, 360.0)


def ypr(s: State, place: int = 2) -> list[float]:
    """Three angles, the twist at `place`; the others quiver."""
    angles = [20.0 + 0.3 * math.sin(s.n), 0.4 * math.sin(0.7 * s.n), 0.3 * math.cos(0.9 * s.n)]
    angles[place] = tilt(s) + 0.01
    return angles


def wit(kind: int, numbers, unit: float) -> bytes:
    ints = [max(-32768, min(32767, round(n / unit * 32768.0))) for n in (*numbers, 0.0)[:4]]
    head = b"\x55" + bytes([kind]) + struct.pack("<4h", *ints)
    return head + bytes([sum(head) & 0xFF])


def teapot(s: State) -> bytes:
    q = [round(part * 16384) for part in s.q]
    return b"$\2" + struct.pack(">4h", *q) + bytes([0, s.n % 256]) + b"\r\n"


def logger(s: State, names: tuple[str, ...], android: float = 1.0) -> bytes:
    """A batch of two samples, the later one first."""
    if s.n == 0:
        return b""
    payload = []
    for one in (s, STATES[s.n - 1]):
        for name in names:
            vector = {"gyroscope": one.g, "accelerometer": 0.01 * one.a}.get(name, one.a)
            values = dict(zip("xyz", map(float, vector), strict=True))
            if name == "orientation":
                values = dict(zip(("qw", "qx", "qy", "qz"), one.q, strict=True))
            payload.append({"name": name, "time": 1_700_000_000_000_000_000 + one.n * 10_000_000,
                            "accuracy": 3, "values": values})  # fmt: skip
    said = {"messageId": s.n, "sessionId": "a", "deviceId": "b", "payload": payload}
    return (json.dumps(said) + "\n").encode()


def phyphox(s: State, acc: str = "acc", gyr: str = "") -> bytes:
    buffers = {f"{acc}{axis}": v for axis, v in zip("XYZ", s.a, strict=True)}
    if gyr:
        buffers |= {f"{gyr}{axis}": v for axis, v in zip("XYZ", s.g, strict=True)}
    buffers["acc_time"] = s.n / RATE
    buffer = {k: {"size": 0, "updateMode": "single", "buffer": [float(v)]}
              for k, v in buffers.items()}  # fmt: skip
    return (json.dumps({"buffer": buffer, "status": {"measuring": True}}) + "\n").encode()


ADAFRUIT = text(
    lambda s: (
        "Acceleration " + xyz(s.a) + " m/s^2\r\nRotation " + xyz(s.g) + " rad/s\r\n"
        "Temperature: 24.31 degC\r\n"
    )
)
BNO_ALL = "{:<8s}\tx= {:.2f} |\ty= {:.2f} |\tz= {:.2f}"
ARTEMIS = b"rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,imu_degC,output_Hz,\r\n"


def artemis(s: State) -> str:
    numbers = [*(1000.0 * s.a / G), *(s.g * RAD), *s.m, 26.1, 100.0]
    return f"09/14/2024,12:01:{s.n / RATE:05.2f}," + joined(",", numbers) + ","


def nine(s: State) -> list[float]:
    """m/s², deg/s, uT."""
    return [*s.a, *(s.g * RAD), *s.m]


GRAVITY, DO_SAY, FILE = "without gravity", "which number is which", "sensor="

SHAPES = (
    # --- i2cdevlib
    Shape("i2cdevlib MPU6050_raw", text(lambda s: "a/g:\t" + raw(s))),
    Shape("i2cdevlib MPU6050_raw, ±4 g", text(lambda s: "a/g:\t" + raw(s, per_g=8192.0))),
    Shape("i2cdevlib MPU6050_raw, binary", lambda s: struct.pack(">6h", *counts(s)), "Binary data"),
    Shape("i2cdevlib DMP6, ypr", text(lambda s: "ypr\t" + joined("\t", ypr(s)))),
    Shape("i2cdevlib DMP6, euler", text(lambda s: "euler\t" + joined("\t", ypr(s)))),
    Shape("i2cdevlib DMP6, quaternion", text(lambda s: "quat\t" + joined("\t", s.q))),
    Shape("i2cdevlib DMP6, areal",
          text(lambda s: "areal\t" + joined("\t", 100 * s.g, 0)), GRAVITY),
    Shape("i2cdevlib DMP6, aworld",
          text(lambda s: "aworld\t" + joined("\t", 100 * s.g, 0)), GRAVITY),
    Shape("i2cdevlib DMP6, teapot", teapot),
    # --- Adafruit
    Shape("Adafruit_MPU6050 basic_readings", ADAFRUIT),
    Shape("Adafruit_MPU6050 plotter", text(lambda s: joined(",", [*s.a, *s.g]))),
    Shape("Adafruit_LSM6DS", text(lambda s: "Accel X: " + xyz(s.a, "{:.2f} \tY: {:.2f} \tZ: {:.2f}")
          + " m/s^2\r\nGyro X: " + xyz(s.g, "{:.2f} \tY: {:.2f} \tZ: {:.2f}") + " radians/s")),
    Shape("Adafruit_LSM6DS, plotter form", text(lambda s: "Temp:24.1,Accel_X:"
          + xyz(s.a, "{:.2f},Accel_Y:{:.2f},Accel_Z:{:.2f}"))),
    Shape("Adafruit_ADXL345", text(lambda s: xyz(s.a, "X: {:.2f}  Y: {:.2f}  Z: {:.2f}  m/s^2 "))),
    Shape("Adafruit_BNO055 rawdata", text(lambda s: xyz(ypr(s), "X: {:.2f} Y: {:.2f} Z: {:.2f}")
          + "\t\tCALIBRATION: Sys=3 Gyro=3 Accel=1 Mag=0")),
    Shape("Adafruit_BNO055 webserial_3d", text(lambda s: "Orientation: " + joined(", ", ypr(s))
          + "\r\nQuaternion: " + joined(", ", s.q, 4) + "\r\nCalibration: 3, 3, 3, 1")),
    Shape("Adafruit_BNO055 sensorapi", text(lambda s: xyz(ypr(s),
          "X: {:.4f}\tY: {:.4f}\tZ: {:.4f}\tSys:3 G:3 A:0 M:1"))),
    Shape("Adafruit_BNO055 read_all_data", text(lambda s: "\r\n".join([
          BNO_ALL.format("Orient:", *ypr(s)), BNO_ALL.format("Gyro:", *s.g),
          BNO_ALL.format("Linear:", *(0.1 * s.g)), BNO_ALL.format("Mag:", *s.m),
          BNO_ALL.format("Accl:", *s.a), BNO_ALL.format("Gravity:", *s.a),
          "", "temperature: 26", "Calibration: Sys=3 Gyro=3 Accel=2 Mag=1", "--"]))),
    Shape("Adafruit_BNO055, linear acceleration alone",
          text(lambda s: BNO_ALL.format("Linear:", *(0.1 * s.g))), GRAVITY),
    Shape("Adafruit_BNO08x", text(lambda s: "Rotation Vector - r: "
          + "{:.2f} i: {:.2f} j: {:.2f} k: {:.2f}".format(*s.q))),
    Shape("Adafruit_AHRS", text(lambda s: "Raw: " + joined(", ", nine(s)) + "\r\nOrientation: "
          + joined(", ", ypr(s)) + "\r\nTook 4 ms")),
    Shape("Adafruit_AHRS, orientation alone",
          text(lambda s: "Orientation: " + joined(", ", ypr(s), 1))),
    Shape("Adafruit_AHRS calibration", text(lambda s: "Raw:" + ",".join(map(str, [*np.rint(
          8192 * s.a / G).astype(int), *np.rint(s.g * RAD * 16).astype(int), 200, 0, -430]))
          + "\r\nUni:" + joined(",", [*s.a, *s.g, *s.m]))),
    Shape("Adafruit_AHRS quaternion", text(lambda s: "Orientation: " + joined(", ", ypr(s), 1)
          + "\r\nQuaternion: " + joined(", ", s.q, 4))),
    # --- Serial Plotter, M5Stack, Arduino boards
    Shape("Serial Plotter, short labels", text(lambda s: xyz(s.a / G,
          "AX:{:.2f} AY:{:.2f} AZ:{:.2f}"))),
    Shape("Serial Plotter, six labels", text(lambda s: xyz(s.a / G,
          "AX:{:.2f},AY:{:.2f},AZ:{:.2f},") + xyz(s.g * RAD, "GX:{:.2f},GY:{:.2f},GZ:{:.2f}"))),
    Shape("Serial Plotter, accX", text(lambda s: xyz(s.a,
          "accX:{:.3f}\taccY:{:.3f}\taccZ:{:.3f}"))),
    Shape("Serial Plotter, roll pitch yaw", text(lambda s: xyz(ypr(s, 0),
          "Roll:{:.2f},Pitch:{:.2f},Yaw:{:.2f}"))),
    Shape("Serial Plotter, roll alone", text(lambda s: f"Roll:{tilt(s):.2f}")),
    Shape("Serial Plotter, user acceleration", text(lambda s: xyz(0.1 * s.g,
          "UserAccel X:{:.3f} Y:{:.3f} Z:{:.3f}")), GRAVITY),
    Shape("M5Stick", text(lambda s: "IMU A:" + joined(",", s.a / G) + " G:"
          + joined(",", s.g * RAD))),
    Shape("M5StickC", text(lambda s: xyz(s.a / G,
          "Acceleration: X={:.2f}, Y={:.2f}, Z={:.2f}"))),
    Shape("Arduino_LSM9DS1 SimpleAccelerometer", text(lambda s: joined("\t", s.a / G))),
    Shape("Arduino_LSM6DS3 SimpleGyroscope", text(lambda s: joined("\t", s.g * RAD)), DO_SAY),
    Shape("an unknown sketch", text(lambda s: f"T{s.n} v=3.1 n=" + joined("/", s.a)), DO_SAY),
    Shape("words and no number", text(lambda s: "waiting for sensor"), "no number"),
    Shape("a gyroscope with labels", text(lambda s: xyz(s.g, "gx:{:.3f} gy:{:.3f} gz:{:.3f}")),
          DO_SAY),
    Shape("Adafruit_LIS3DH", text(lambda s: xyz(s.a / G * 4096,
          "X:  {:.0f} \tY:  {:.0f} \tZ:  {:.0f}")
          + "\t\t" + xyz(s.a, "X: {:.2f} \tY: {:.2f} \tZ: {:.2f} m/s^2 "))),
    Shape("Arduino Nano 33, six numbers",
          text(lambda s: joined(",", [*(s.a / G), *(s.g * RAD)], 3))),
    Shape("micro:bit accelerometer", text(lambda s: str(tuple(np.rint(1000 * s.a / G).astype(int)
          .tolist())))),
    Shape("micro:bit, labelled", text(lambda s: xyz(1000 * s.a / G, "x:{:.0f} y:{:.0f} z:{:.0f}"))),
    Shape("MicroPython mpu6050 dictionary", text(lambda s: str(dict(zip(
          ("AcX", "AcY", "AcZ", "GyX", "GyY", "GyZ", "Tmp"), [*counts(s), 24], strict=True))))),
    # --- bare numbers
    Shape("three numbers, m/s²", text(lambda s: joined(",", s.a))),
    Shape("three raw numbers, ±8 g", text(lambda s: joined(" ", s.a / G * 4096, 0))),
    Shape("six raw numbers, ±2 g", text(raw)),
    Shape("six raw numbers, ±16 g", text(lambda s: raw(s, per_g=2048.0, per_deg=16.4))),
    Shape("nine numbers", text(lambda s: joined(",", [*nine(s)[:3], *s.g, *s.m]))),
    Shape("nine numbers that show no gravity",
          text(lambda s: joined(",", [*s.m, *(s.g * RAD), *s.a])), DO_SAY),
    Shape("quaternion, w first", text(lambda s: joined(",", s.q, 4))),
    Shape("quaternion, w last", text(lambda s: joined(",", [*s.q[1:], s.q[0]], 4))),
    Shape("three angles", text(lambda s: joined(",", ypr(s, 1)))),
    Shape("a clock and six numbers, not said which",
          text(lambda s: f"{10 * s.n}," + joined(",", [*s.a, *s.g])), DO_SAY),
    Shape("the same with columns of a file", text(lambda s: f"{10 * s.n};foo;"
          + joined(";", s.a)), columns=("t_ms", "_", "ax", "ay", "az")),
    Shape("a number without a point", text(lambda s: f"{512 + round(s.roll)}"), FILE),
    Shape("potentiometer with a label", text(lambda s: f"pot:{s.roll / 180 * 1023:.0f}")),
    # --- loggers and modules
    Shape("SparkFun OpenLog Artemis", text(artemis), before=ARTEMIS),
    Shape("SparkFun OpenLog Artemis, DMP", text(lambda s: f"09/14/2024,12:01:{s.n / RATE:05.2f},"
          + joined(",", s.q[1:], 4) + ",3,"),
          before=b"rtcDate,rtcTime,Q6_1,Q6_2,Q6_3,HeadAcc,\r\n"),
    Shape("WitMotion serial, 51 52 53", lambda s: wit(0x51, s.a / G, 16.0)
          + wit(0x52, s.g * RAD, 2000.0) + wit(0x53, ypr(s, 0), 180.0)),
    Shape("WitMotion serial, angles alone", lambda s: wit(0x53, ypr(s, 0), 180.0)),
    Shape("WitMotion serial, quaternion alone", lambda s: wit(0x59, s.q, 1.0)),
    Shape("WitMotion radio, 55 61", lambda s: b"\x55\x61" + struct.pack("<9h", *np.rint(np.clip([
          *(s.a / G * 2048), *(s.g * RAD * 16.384), *(np.array(ypr(s)) * 182)], -32768, 32767)
          ).astype(int).tolist()), "no check"),
    # --- phones
    Shape("phyphox /get, acceleration", phyphox),
    Shape("phyphox /get, and gyroscope", lambda s: phyphox(s, gyr="gyr")),
    Shape("phyphox /get, linear acceleration", lambda s: phyphox(s, acc="lin"), GRAVITY),
    Shape("Sensor Logger, TotalAcceleration and Gyroscope",
          lambda s: logger(s, ("gyroscope", "totalacceleration")), every=2),
    Shape("Sensor Logger, Gravity", lambda s: logger(s, ("gravity",)), every=2),
    Shape("Sensor Logger, Orientation", lambda s: logger(s, ("orientation",)), every=2),
    Shape("Sensor Logger, Accelerometer", lambda s: logger(s, ("accelerometer",)), GRAVITY, 2),
)  # fmt: skip


def sent(shape: Shape) -> list[tuple[bytes, float]]:
    """The pieces of a shape, each with the time it comes at (s)."""
    pieces = [(shape.make(s), s.n / RATE) for s in STATES[shape.every - 1 :: shape.every]]
    return [(b"\n" + shape.before, 0.0), *pieces]


@dataclass(frozen=True)
class Played:
    """What became of a shape: its format, messages each with its time (s), theta2 and true roll."""

    detected: DetectedFormat | None
    messages: list[tuple[float, str]]
    turns: np.ndarray
    damaged: int


@cache
def played(shape: Shape) -> Played:
    """A shape as it is played."""
    one = hand(columns=shape.columns)
    messages, turns = [], []
    for data, at in sent(shape):
        one.feed(data, at)
        messages += [(at, said) for said in one.take_messages()]
        true = ROLL[min(len(ROLL) - 1, round(at * RATE))]
        turns.append((at, math.nan if one.angle is None else one.angle.theta2, true))
    return Played(one._stream.detected, messages, np.array(turns), one.counters.damaged)


def example(shape: Shape) -> str:
    """How a shape looks, for the table."""
    made = shape.make(STATES[40 * shape.every + 1])
    try:
        lines = [" ".join(line.split()) for line in made.decode("ascii").splitlines()]
        if "teapot" in shape.source:
            raise ValueError
        looks = " ⏎ ".join(line for line in lines if line)
    except ValueError:
        looks = made.hex(" ")
    looks = looks if len(looks) <= 64 else looks[:63] + "…"
    return f"`{looks}`".replace("|", "\\|")


def table() -> str:
    """The table of the documentation."""
    rows = ["| source | what it sends | is |", "|---|---|---|"]
    for shape in SHAPES:
        result = played(shape)
        if shape.said:
            became = f"rejected: {REASONS[shape.said]}"
        else:
            became = str(result.detected)
        rows.append(f"| {shape.source} | {example(shape)} | {became} |")
    return "\n".join(rows) + "\n"


REASONS = {
    GRAVITY: "it lacks gravity, so up is unknown",
    "Binary data": "no check and no frame, as noise",
    DO_SAY: "reported with its two likeliest readings",
    FILE: "degrees, counts or a wiper: choose `sensor=`",
    "no check": "no check: its serial protocol has one",
    "no number": "no number in it",
}


def written(page: str) -> str:
    """The page with the table as it is now."""
    head, _, rest = page.partition(BEGIN)
    return head + BEGIN + "\n" + table() + "\n" + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    understood = sum(not shape.said for shape in SHAPES)
    print(f"{len(SHAPES)} shapes: {understood} understood, {len(SHAPES) - understood} refused")
