"""What the examples of boards and the apps print, as published, while a device is turned twice.

Each has the place where its form is public. `python -m tests.devices.sensors.printed` counts how
many are followed, refused with the right reason, misread, or without an answer.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from overview_dsp.devices.controllers.control_map import parse_osc_map, write_map
from overview_dsp.devices.controllers.learning import DEVICE, OscLearner
from overview_dsp.devices.controllers.osc_messages import OscReader, encode_message
from overview_dsp.devices.sensors.profile import Sensor, parse_sensor
from overview_dsp.devices.sensors.setup import Setup
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.errors import InputError
from tests.devices.sensors.moving import RULES, G, course, turning
from tests.devices.sensors.shapes import RAD, joined, raw, xyz

RATE = 50.0
ROLL = course(RATE, (0, 0), (2.5, 0), (3.3, 170), (3.8, 170), (4.6, 0), (5.2, 0), (6.0, 168),
              (6.5, 168), (7.3, 0), (8.5, 0), (9.3, 120), (9.8, 120))  # fmt: skip
END_DEG = 120.0
MISREAD_DEG = 10.0

NO_ANSWER, MISREAD, FOLLOWED, REFUSED = "no answer", "misread", "followed", "refused"


@dataclass(frozen=True)
class Moved:
    """One sample: number, m/s², rad/s, magnetic field (uT), roll (deg), quaternion w x y z."""

    n: int
    a: np.ndarray
    g: np.ndarray
    m: np.ndarray
    roll: float
    q: tuple[float, float, float, float]
    yaw: float

    @property
    def xyzw(self) -> tuple[float, ...]:
        return (*self.q[1:], self.q[0])

    def phone(self, vector) -> list[float]:
        """A vector in the axes of a phone, whose y points to the fingers."""
        return [-float(vector[1]), float(vector[0]), float(vector[2])]

    @property
    def phone_xyzw(self) -> tuple[float, ...]:
        w, x, y, z = self.q
        return -y, x, z, w

    @property
    def rpy(self) -> list[float]:
        """Roll, pitch, yaw in degrees, -180 to 180."""
        return [math.remainder(self.roll, 360.0) + 0.01, 0.4 * math.sin(0.7 * self.n),
                math.remainder(self.yaw + 0.3 * math.sin(self.n), 360.0)]  # fmt: skip

    @property
    def ypr(self) -> list[float]:
        return self.rpy[::-1]

    @property
    def ms(self) -> int:
        return 5000 + round(1000 * self.n / RATE)


@cache
def moves(yaw: float = 20.0) -> tuple[Moved, ...]:
    acceleration, speed = turning(ROLL, RATE, noise=0.5, seed=4)
    dice = np.random.default_rng(5)
    found = []
    for n, (a, g, roll) in enumerate(zip(acceleration, speed, ROLL, strict=True)):
        half = 0.5 * (roll + 0.004 * dice.standard_normal())
        turned = math.radians(yaw + 0.1 * dice.standard_normal()) / 2
        cx, sx, cz, sz = math.cos(half), math.sin(half), math.cos(turned), math.sin(turned)
        c, s = math.cos(roll), math.sin(roll)
        field = np.array([20.0, -43.0 * s, -43.0 * c]) + 0.2 * dice.standard_normal(3)
        q = (cz * cx, cz * sx, sz * sx, sz * cx)
        found.append(Moved(n, a, g, field, math.degrees(roll), q, yaw))
    return tuple(found)


@dataclass(frozen=True)
class Printed:
    """One published form: its source, where it is public, and a sample's text or messages.

    `refused`: a word of the reason if it can't be followed. `yaw`: heading during the turn.
    """

    source: str
    where: str
    make: Callable[[Moved], str | list[tuple[str, Sequence[float]]]]
    refused: str = ""
    yaw: float = 20.0

    @property
    def is_osc(self) -> bool:
        return not isinstance(self.make(moves()[0]), str)


def three(numbers, digits: int = 2, apart: str = "\t") -> str:
    return joined(apart, numbers, digits)


def padded(value: float) -> str:
    return ("-" if value < 0 else " ") + f"{abs(value):08.2f}"


def icm(s: Moved) -> str:
    def group(numbers) -> str:
        return "[ " + ", ".join(map(padded, numbers)) + " ]"

    return (f"Scaled. Acc (mg) {group(1000 * s.a / G)}, Gyr (DPS) {group(s.g * RAD)}, "
            f"Mag (uT) {group(s.m)}, Tmp (C) {group([25.78])}")  # fmt: skip


def ximu3(*kinds: str) -> Callable[[Moved], str]:
    def line(s: Moved) -> str:
        numbers = {
            "Q": s.q, "A": s.rpy, "I": [*(s.g * RAD), *(s.a / G)], "L": [*s.q, *(0.01 * s.g)],
            "M": s.m / 47, "T": [31.5], "H": s.a / G, "E": [*s.q, *(0.01 * s.g)],
        }  # fmt: skip
        often = {"M": 5, "T": 20, "Q": 1, "I": 1}
        return "\r\n".join(
            f"{kind},{1000 * s.ms}," + ",".join(f"{value:.4f}" for value in numbers[kind])
            for kind in kinds if len(kinds) == 1 or s.n % often[kind] == 0
        )  # fmt: skip

    return line


def kris(s: Moved) -> str:
    mg, turn = 1000 * s.a / G, s.g * RAD
    return (
        f"ax = {mg[0]:.0f} ay = {mg[1]:.0f} az = {mg[2]:.0f} mg\r\n"
        f"gx = {turn[0]:.2f} gy = {turn[1]:.2f} gz = {turn[2]:.2f} deg/s\r\n"
        f"mx = {s.m[0]:.0f} my = {s.m[1]:.0f} mz = {s.m[2]:.0f} mG\r\n"
        "q0 = {:.2f} qx = {:.2f} qy = {:.2f} qz = {:.2f}\r\n".format(*s.q)
        + f"Yaw, Pitch, Roll: {joined(', ', s.ypr)}\r\nrate = 100.00 Hz"
    )


def fields(form: str, *names: str) -> Callable[[Moved], str]:
    return lambda s: form.format(*(getattr(s, name) for name in names))


LINEAR, WHICH = "without gravity", "a rate of turn, a magnetic field"
ONE_AXIS, RATES = "message of its own", "rate"

ADAFRUIT = "github.com/adafruit/"
SPARKFUN = "github.com/sparkfun/"
JROWBERG = "github.com/jrowberg/i2cdevlib Arduino/MPU6050/examples/MPU6050_DMP6"
XIMU3 = "github.com/xioTechnologies/x-IMU3-Software generate_data_messages.json"
RAZOR = "github.com/Razor-AHRS/razor-9dof-ahrs Razor_AHRS.ino"
GYROSC = "bitshapesoftware.com/instruments/gyrosc"
ZIGSIM = "github.com/1-10/zigsim"
NGIMU = "NGIMU User Manual 1.6, x-io Technologies"

PRINTED = (
    # --- quaternions
    *(Printed(f"SparkFun BNO080 Example1-RotationVector, heading {yaw:.0f}",
              SPARKFUN + "SparkFun_BNO080_Arduino_Library",
              lambda s: joined(",", [*s.xyzw, 3.14]) + ",", yaw=yaw)
      for yaw in (0.0, 20.0, 90.0, 180.0)),
    Printed("SparkFun BNO080, game rotation vector with time", SPARKFUN + "SparkFun_BNO080_Arduino_"
            "Library Example21", lambda s: f"{1000 * s.ms}\t" + joined("\t", s.xyzw)),
    *(Printed(f"quaternion w first, bare, heading {yaw:.0f}", ADAFRUIT + "Adafruit_AHRS",
              lambda s: joined(",", s.q, 4), yaw=yaw) for yaw in (0.0, 20.0, 90.0, 180.0)),
    *(Printed(f"quaternion w last, bare, heading {yaw:.0f}", "SparkFun_BNO08x_Arduino_Library",
              lambda s: joined(",", s.xyzw, 4), yaw=yaw) for yaw in (0.0, 20.0, 90.0, 180.0)),
    Printed("SparkFun BNO080, labels i j k real", SPARKFUN + "SparkFun_BNO080_Arduino_Library",
            lambda s: "Rotation Vector: i={:.2f} j={:.2f} k={:.2f} real={:.2f} accuracy=3.14"
            .format(*s.xyzw)),
    Printed("Adafruit BNO08x rotation vector", ADAFRUIT + "Adafruit_BNO08x examples/bno08x",
            lambda s: "Rotation Vector - r: {:.2f} i: {:.2f} j: {:.2f} k: {:.2f}".format(*s.q)),
    *(Printed(f"i2cdevlib MPU6050_DMP6 quat, heading {yaw:.0f}", JROWBERG,
              lambda s: "quat\t" + joined("\t", s.q), yaw=yaw) for yaw in (0.0, 180.0)),
    Printed("BNO055 quaternion printed x first", ADAFRUIT + "Adafruit_BNO055 rawdata (qX: ..)",
            lambda s: "qW: {:.4f} qX: {:.4f} qY: {:.4f} qZ: {:.4f}\t\t".format(*s.q)),
    *(Printed(f"a label and x y z w, heading {yaw:.0f}", "github.com/stm32duino/LSM6DSV16X "
              "Quaternions: x, y, z, w", lambda s: "Quaternion: " + joined(", ", s.xyzw, 4),
              yaw=yaw) for yaw in (0.0, 90.0, 180.0)),
    Printed("STM LSM6DSO16IS quaternion lines", "github.com/stm32duino/LSM6DSV16X",
            lambda s: "Quaternion: {3:.4f}, {0:.4f}, {1:.4f}, {2:.4f}".format(*s.xyzw)),
    Printed("SparkFun ICM-20948 DMP Quat9 in JSON", SPARKFUN + "SparkFun_ICM-20948_ArduinoLibrary "
            "Example6", lambda s: json.dumps(dict(zip(("quat_w", "quat_x", "quat_y", "quat_z"),
            (round(one, 3) for one in s.q), strict=True)))),
    Printed("SparkFun ICM-20948 DMP Q1 Q2 Q3", SPARKFUN + "SparkFun_ICM-20948_ArduinoLibrary "
            "Example6", lambda s: "Q1:{:.3f} Q2:{:.3f} Q3:{:.3f} Accuracy:122".format(*s.q[1:])),
    Printed("Arduino Nicla Sense ME rotation", "github.com/arduino/nicla-sense-me-fw "
            "SensorQuaternion.h", lambda s: "{:.4f},{:.4f},{:.4f},{:.4f}".format(*s.xyzw)),
    Printed("x-IMU3 Q", XIMU3, ximu3("Q")),
    Printed("x-IMU3 Q, heading 180", XIMU3, ximu3("Q"), yaw=180.0),
    Printed("x-IMU3 L, quaternion and linear acceleration", XIMU3, ximu3("L")),
    Printed("x-IMU3 I Q M T at their rates", XIMU3, ximu3("I", "Q", "M", "T")),
    Printed("quaternion and acceleration, bare", "github.com/kriswiner/BNO080",
            lambda s: joined(",", [*s.q, *s.a], 3)),
    # --- angles
    Printed("Razor #YPR=", RAZOR, lambda s: "#YPR=" + joined(",", s.ypr)),
    Printed("Razor #YPRAG=", RAZOR, lambda s: "#YPRAG=" + joined(",", [*s.ypr, *s.a, *s.g])),
    Printed("Razor #A-C= alone", RAZOR, lambda s: "#A-C=" + joined(",", s.a / G * 256),
            WHICH),
    Printed("i2cdevlib MPU6050_DMP6 ypr", JROWBERG, lambda s: "ypr\t" + joined("\t", s.ypr)),
    Printed("i2cdevlib MPU6050_DMP6 euler", JROWBERG, lambda s: "euler\t" + joined("\t", s.ypr)),
    Printed("i2cdevlib MPU6050_DMP6 areal", JROWBERG,
            lambda s: "areal\t" + joined("\t", 100 * s.g, 0), LINEAR),
    Printed("Adafruit BNO08x quaternion_yaw_pitch_roll", ADAFRUIT + "Adafruit_BNO08x",
            lambda s: f"{2500 + 3 * (s.n % 5)}\t3\t" + joined("\t", s.ypr)),
    Printed("status and three angles", ADAFRUIT + "Adafruit_BNO08x without the first column",
            lambda s: "3\t" + joined("\t", s.ypr)),
    Printed("SparkFun BNO08x euler in degrees", SPARKFUN + "SparkFun_BNO08x_Arduino_Library "
            "Example_09_Euler", lambda s: joined(",", s.rpy, 1)),
    Printed("three bare angles in radians", "github.com/jremington/MPU-6050-Fusion",
            lambda s: joined(",", np.radians(s.ypr), 3)),
    Printed("ypr in radians with a label", "github.com/jrowberg/i2cdevlib before * 180 / M_PI",
            lambda s: "ypr\t" + joined("\t", np.radians(s.ypr), 3)),
    Printed("Arduino Curie101 / Madgwick orientation", "github.com/arduino-libraries/MadgwickAHRS "
            "Visualize101.ino", lambda s: "Orientation: " + joined(" ", s.ypr)),
    Printed("hideakitai MPU9250 simple", "github.com/hideakitai/MPU9250",
            lambda s: "Yaw, Pitch, Roll: " + joined(", ", s.ypr)),
    Printed("x-IMU3 A", XIMU3, ximu3("A")),
    Printed("Adafruit BNO055 rawdata, euler", ADAFRUIT + "Adafruit_BNO055 rawdata",
            lambda s: xyz([s.ypr[0] % 360, *s.ypr[1:]], "X: {:.2f} Y: {:.2f} Z: {:.2f}\t\t"
                          "CALIBRATION: Sys=3 Gyro=3 Accel=1 Mag=0")),
    Printed("M5StickC AHRS", "github.com/m5stack/M5StickC examples IMU",
            lambda s: "{1:5.2f}   {0:5.2f}   {2:5.2f}   ".format(*s.rpy)),
    Printed("roll and pitch alone", "github.com/adafruit/Adafruit_LSM303 pitchrollheading",
            lambda s: "Roll: {:.2f}, Pitch: {:.2f}".format(*s.rpy)),
    # --- acceleration
    Printed("SparkFun BNO080 Example2-Accelerometer", SPARKFUN + "SparkFun_BNO080_Arduino_Library",
            lambda s: joined(",", [*s.a, 3]) + ","),
    Printed("Arduino_LSM9DS1 SimpleAccelerometer", "github.com/arduino-libraries/Arduino_LSM9DS1",
            lambda s: joined("\t", s.a / G)),
    Printed("Arduino_LSM9DS1 SimpleGyroscope", "github.com/arduino-libraries/Arduino_LSM9DS1",
            lambda s: joined("\t", s.g * RAD), WHICH),
    Printed("Arduino_LSM9DS1 SimpleMagnetometer", "github.com/arduino-libraries/Arduino_LSM9DS1",
            lambda s: joined("\t", s.m), WHICH),
    Printed("Arduino_BMI270 SimpleAccelerometer", "github.com/arduino-libraries/Arduino_BMI270_"
            "BMM150", lambda s: "Accelerometer data: \r\n" + joined("\t", s.a / G)),
    Printed("x-IMU3 I, gyroscope first", XIMU3, ximu3("I")),
    Printed("gyroscope then acceleration, bare", NGIMU + " /sensors as CSV",
            lambda s: joined(",", [*(s.g * RAD), *(s.a / G)], 4)),
    Printed("time, gyroscope, acceleration, bare", "github.com/sebhz/razor m0 log",
            lambda s: f"{s.ms}," + joined(",", [*(s.g * RAD), *(s.a / G)], 4)),
    Printed("SparkFun 9DoF Razor M0 log", SPARKFUN + "9DOF_Razor_IMU timeMS, ax.. mz",
            lambda s: f"{s.ms}, " + joined(", ", [*(s.a / G), *(s.g * RAD), *s.m])),
    Printed("bolderflight MPU9250 Basic_I2C", "github.com/bolderflight/invensense-imu",
            lambda s: joined("\t", [*s.a, *s.g, *s.m, 24.31], 6)),
    Printed("acceleration, temperature, gyroscope, raw", "github.com/jrowberg burst of 14 bytes",
            lambda s: raw(s).replace("\t", ",").replace(",", ",-2800,", 3)
            .replace(",-2800,", ",", 2)),
    Printed("SparkFun ICM-20948 Example1_Basics", SPARKFUN + "SparkFun_ICM-20948_ArduinoLibrary",
            icm),
    Printed("SparkFun LSM9DS1 basic", SPARKFUN + "SparkFun_LSM9DS1_Arduino_Library",
            lambda s: "G: " + joined(", ", s.g * RAD) + " deg/s\r\nA: " + joined(", ", s.a / G)
            + " g\r\nM: " + joined(", ", s.m / 100) + " gauss\r\nPitch, Roll: "
            + joined(", ", [s.rpy[1], s.rpy[0]]) + "\r\nHeading: 20.31"),
    Printed("SparkFun LSM6DS3 MinimalistExample", SPARKFUN + "SparkFun_LSM6DS3_Arduino_Library",
            lambda s: "\r\nAccelerometer:\r\n X = {:.4f}\r\n Y = {:.4f}\r\n Z = {:.4f}\r\n"
            "\r\nGyroscope:\r\n X = {:.4f}\r\n Y = {:.4f}\r\n Z = {:.4f}\r\n\r\nThermometer:\r\n "
            "Degrees C = 24.1\r\n Degrees F = 75.3".format(*(s.a / G), *(s.g * RAD))),
    Printed("SparkFun BMI270 Example1", SPARKFUN + "SparkFun_BMI270_Arduino_Library",
            lambda s: "Acceleration in g's\tX: {:.3f}\tY: {:.3f}\tZ: {:.3f}\tRotation in deg/sec\t"
            "X: {:.3f}\tY: {:.3f}\tZ: {:.3f}".format(*(s.a / G), *(s.g * RAD))),
    Printed("SparkFun MPU-9250 DMP printIMUData", SPARKFUN + "SparkFun_MPU-9250-DMP_Arduino",
            lambda s: "Accel: " + joined(", ", s.a / G) + " g\r\nGyro: " + joined(", ", s.g * RAD)
            + " dps\r\nMag: " + joined(", ", s.m) + f" uT\r\nTime: {s.ms} ms"),
    Printed("kriswiner MPU9250", "github.com/kriswiner/MPU9250", kris),
    Printed("Adafruit MPU6050 basic_readings", ADAFRUIT + "Adafruit_MPU6050",
            lambda s: "Acceleration " + xyz(s.a) + " m/s^2\r\nRotation " + xyz(s.g)
            + " rad/s\r\nTemperature: 24.31 degC"),
    Printed("Adafruit LSM6DSOX", ADAFRUIT + "Adafruit_LSM6DS",
            lambda s: "\t\tTemperature 24.31 deg C\r\n\t\tAccel X: {:.2f} \tY: {:.2f} \tZ: {:.2f} "
            "m/s^2 \r\n\t\tGyro X: {:.2f} \tY: {:.2f} \tZ: {:.2f} radians/s ".format(*s.a, *s.g)),
    Printed("Adafruit LIS3DH acceldemo", ADAFRUIT + "Adafruit_LIS3DH",
            lambda s: "X:  {:.0f} \tY:  {:.0f} \tZ:  {:.0f} \t\tX: {:.2f} \tY: {:.2f} \tZ: {:.2f} "
            "m/s^2 ".format(*(s.a / G * 4096), *s.a)),
    Printed("M5Stack MPU6886, three lines", "github.com/m5stack/M5StickC examples MPU6886",
            lambda s: "{:6.2f}  {:6.2f}  {:6.2f}      o/s\r\n {:5.2f}   {:5.2f}   {:5.2f} G"
            .format(*(s.g * RAD), *(s.a / G))),
    Printed("Teleplot, an axis a line", "github.com/nesnes/teleplot",
            lambda s: ">ax:{:.3f}\r\n>ay:{:.3f}\r\n>az:{:.3f}".format(*s.a)),
    Printed("Seeed XIAO nRF52840 Sense", "github.com/Seeed-Studio/Seeed_Arduino_LSM6DS3",
            lambda s: "\r\nAccelerometer:\r\n X1 = {:.4f}\r\n Y1 = {:.4f}\r\n Z1 = {:.4f}\r\n"
            "\r\nGyroscope:\r\n X1 = {:.4f}\r\n Y1 = {:.4f}\r\n Z1 = {:.4f}"
            .format(*(s.a / G), *(s.g * RAD))),
    Printed("micro:bit MicroPython get_values()", "microbit-micropython.readthedocs.io "
            "accelerometer: face up is z = -1024",
            lambda s: str(tuple(np.rint(-1024 * s.a / G).astype(int).tolist()))),
    Printed("micro:bit MakeCode writeValue", "makecode.microbit.org reference serial write-value",
            lambda s: "x:{:.0f}\r\ny:{:.0f}\r\nz:{:.0f}".format(*(-1024 * s.a / G))),
    Printed("Adafruit BNO055 VECTOR_LINEARACCEL, bare", ADAFRUIT + "Adafruit_BNO055",
            lambda s: joined("\t", 0.05 * s.g), WHICH),
    Printed("ESP8266 JSON with accel and gyro objects", "github.com/espressif mpu6050 examples",
            lambda s: json.dumps({"accel": dict(zip("xyz", map(float, s.a), strict=True)),
                                  "gyro": dict(zip("xyz", map(float, s.g), strict=True))})),
    Printed("MPU6050_tockn GetAllData", "github.com/tockn/MPU6050_tockn",
            lambda s: "=====\r\ntemp : 24.3\r\naccX : {:.2f}\taccY : {:.2f}\taccZ : {:.2f}\r\n"
            "gyroX : {:.2f}\tgyroY : {:.2f}\tgyroZ : {:.2f}\r\naccAngleX : {:.2f}\taccAngleY : "
            "{:.2f}\r\nangleX : {:.2f}\tangleY : {:.2f}\tangleZ : {:.2f}"
            .format(*(s.a / G), *(s.g * RAD), *s.rpy[:2], *s.rpy)),
    Printed("Pololu MinIMU-9 AHRS", "github.com/pololu/minimu-9-ahrs-arduino",
            lambda s: "!ANG:" + joined(",", s.rpy)),
    Printed("WitMotion JY901 Arduino", "github.com/WITMOTION JY901",
            lambda s: "Acc:" + joined(" ", s.a / G) + "\r\nGyro:" + joined(" ", s.g * RAD)
            + "\r\nAngle:" + joined(" ", s.rpy) + "\r\nMag:12 3 -400"),
    Printed("ESP-IDF mpu6050 component", "github.com/espressif/esp-bsp components/mpu6050",
            lambda s: f"I ({s.ms}) mpu6050 test: " + "acce_x:{:.2f}, acce_y:{:.2f}, acce_z:{:.2f}"
            .format(*(s.a / G))),
    Printed("STM32duino X-NUCLEO-IKS01", "github.com/stm32duino/X-NUCLEO-IKS01A3 HelloWorld",
            lambda s: "| Acc[mg]: {:.0f} {:.0f} {:.0f} | Gyr[mdps]: {:.0f} {:.0f} {:.0f} | "
            "Mag[mGauss]: 200 0 -430 |".format(*(s.a / G * 1e3), *(s.g * RAD * 1e3))),
    Printed("RTIMULib-Arduino", "github.com/richardstechnotes/RTIMULib-Arduino",
            lambda s: "Sample rate 100: roll:{:.3f}, pitch:{:.3f}, yaw:{:.3f}".format(*s.rpy)),
    Printed("CircuitPython BNO055 simpletest", ADAFRUIT + "Adafruit_CircuitPython_BNO055",
            lambda s: "Temperature: 24 degrees C\r\nAccelerometer (m/s^2): ({:.2f}, {:.2f}, {:.2f})"
            "\r\nGyroscope (rad/sec): ({:.3f}, {:.3f}, {:.3f})\r\nQuaternion: ({:.4f}, {:.4f}, "
            "{:.4f}, {:.4f})\r\nLinear acceleration (m/s^2): (0.0, 0.0, 0.01)\r\n"
            .format(*s.a, *s.g, *s.q)),
    Printed("CircuitPython BNO08x simpletest", ADAFRUIT + "Adafruit_CircuitPython_BNO08x",
            lambda s: "Rotation Vector Quaternion:\r\nI: {:.6f}  J: {:.6f} K: {:.6f}  Real: {:.6f}"
            "\r\n".format(*s.xyzw)),
    Printed("a sketch's own JSON", "BNO08x web socket sketches: id, x, y, z, w",
            lambda s: json.dumps({"id": "aa", **dict(zip("xyzw", (round(v, 3) for v in s.xyzw),
                                                          strict=True))})),
    Printed("bars between the numbers", "any sketch", lambda s: joined("|", s.a, 3)),
    # --- OSC
    *(Printed(f"GyrOSC /gyrosc/quat, heading {yaw:.0f}", GYROSC,
              lambda s: [("/gyrosc/quat", [s.q[0], *s.phone_xyzw[:3]])], yaw=yaw)
      for yaw in (0.0, 20.0, 180.0)),
    Printed("GyrOSC /gyrosc/gyro, radians", GYROSC,
            lambda s: [("/gyrosc/gyro", [math.radians(s.rpy[n]) for n in (1, 0, 2)])]),
    Printed("GyrOSC /gyrosc/rrate alone", GYROSC, lambda s: [("/gyrosc/rrate", s.g)], RATES),
    Printed("GyrOSC /gyrosc/grav", GYROSC, lambda s: [("/gyrosc/grav", s.phone(-s.a / G))]),
    *(Printed(f"ZIG SIM quaternion, heading {yaw:.0f}", ZIGSIM,
              lambda s: [("/ZIGSIM/me/quaternion", s.phone_xyzw)], yaw=yaw) for yaw in (0.0, 90.0)),
    Printed("ZIG SIM gyro alone", ZIGSIM, lambda s: [("/ZIGSIM/me/gyro", s.g)], RATES),
    Printed("ZIG SIM accel alone", ZIGSIM, lambda s: [("/ZIGSIM/me/accel", 0.05 * s.g)], RATES),
    Printed("TouchOSC /accxyz", "hexler.net/touchosc manual",
            lambda s: [("/accxyz", s.phone(s.a / G))]),
    Printed("NGIMU /quaternion", NGIMU, lambda s: [("/quaternion", s.q)]),
    Printed("NGIMU /sensors", NGIMU,
            lambda s: [("/sensors", [*(s.g * RAD), *(s.a / G), *s.m, 1013.2])]),
    Printed("NGIMU /euler", NGIMU, lambda s: [("/euler", s.rpy)]),
    Printed("NGIMU, all", NGIMU, lambda s: [("/sensors", [*(s.g * RAD), *(s.a / G), *s.m, 1013.2]),
            ("/quaternion", s.q), ("/temperature", [31.0])]),
    Printed("x-OSC /imu", "x-OSC User Manual, x-io Technologies",
            lambda s: [("/imu", [*(s.g * RAD), *(s.a / G), *(s.m / 100), 28.0])]),
    Printed("OSCulator /wii/1/accel/pry", "osculator.net manual: four numbers of 0 to 1",
            lambda s: [("/wii/1/accel/pry", [0.5, 0.5 + s.rpy[0] / 360, 0.5, 0.2])], RATES),
    Printed("Sensors2OSC, a message an axis", "github.com/SensorApps/Sensors2OSC",
            lambda s: [(f"/accelerometer/{axis}", [v]) for axis, v in
                       zip("XYZ", s.a, strict=True)], ONE_AXIS),
    Printed("multi-sense orientation, a message an axis", "Multi Sense OSC, Google Play",
            lambda s: [(f"/multisense/orientation/{name}", [v]) for name, v in
                       zip(("roll", "pitch", "yaw"), s.rpy, strict=True)], ONE_AXIS),
    Printed("oscHook /accelerometer", "oscHook, Google Play: m/s2",
            lambda s: [("/accelerometer", s.phone(s.a))]),
    Printed("an address that says nothing and a quaternion", "any app",
            lambda s: [("/data/motion/rotation", s.phone_xyzw)]),
    Printed("apple-silicon-accelerometer-osc", "github.com/olvvier/apple-silicon-accelerometer",
            lambda s: [("/accel", s.a / G), ("/gyro", s.g * RAD)]),
)  # fmt: skip


def pieces(one: Printed) -> list[bytes | list[bytes]]:
    """What is received of each sample: text, or datagrams."""
    if one.is_osc:
        return [[encode_message(address, [float(v) for v in values])
                 for address, values in one.make(s)] for s in moves(one.yaw)]  # fmt: skip
    return [(str(one.make(s)) + "\r\n").encode() for s in moves(one.yaw)]


def _outcome(one: SensorSource, data: list[bytes]) -> tuple[str, str]:
    """What becomes of text that is played: from the last turn on, theta2 follows."""
    said: list[str] = []
    one.feed(b"\n", 0.0)
    off = []
    for n, piece in enumerate(data):
        one.feed(piece, n / RATE)
        said += one.take_messages()
        if n / RATE > 8.0 and one.angle is not None:
            off.append(abs(one.angle.theta2 - ROLL[n]))
    if off and one.angle is not None and not one._stopped:
        worst = math.degrees(max(off))
        return (FOLLOWED, "") if worst < MISREAD_DEG else (MISREAD, f"{worst:.0f} deg; {said}")
    return (REFUSED, said[-1]) if said else (NO_ANSWER, "")


def played(one: Printed) -> tuple[str, str]:
    """The outcome without a profile."""
    return _outcome(SensorSource(Sensor(), RULES), pieces(one))  # type: ignore[arg-type]


def set_up(one: Printed) -> tuple[str, str]:
    """The outcome with the profile that `overview sensor setup` writes."""
    data = pieces(one)
    watched = Setup()
    watched.feed(b"\n", 0.0)
    for n, piece in enumerate(data):
        watched.feed(piece, n / RATE)  # type: ignore[arg-type]
        if watched.problem:
            return REFUSED, watched.problem
        if watched.done:
            break
    if not watched.done:
        return REFUSED, watched.failure
    try:
        text = watched.toml()
    except InputError as error:
        return REFUSED, str(error)
    sensor = parse_sensor(text, "mine", "mine.toml")
    found, why = _outcome(SensorSource(sensor, RULES), data)  # type: ignore[arg-type]
    return found, why or text


def learned(one: Printed) -> tuple[str, str]:
    """The outcome with the map that `overview osc learn PORT device` writes."""
    learner, control = OscLearner(DEVICE), None
    data = pieces(one)
    for n, datagrams in enumerate(data):
        for datagram in datagrams:
            learner.read(datagram, n / RATE)  # type: ignore[arg-type]
        control = control or learner.found(n / RATE)
    if control is None:
        return (REFUSED, learner.explanation) if learner.explanation else (NO_ANSWER, "")
    control = parse_osc_map(write_map((control,)), "learned")[0]  # as `play` reads it
    reader, off, theta2 = OscReader(controls=(control,)), [], None
    for n, datagrams in enumerate(data):
        for datagram in datagrams:
            for message in reader.read(datagram, n / RATE):  # type: ignore[arg-type]
                theta2 = getattr(message, "theta2", theta2)
        if n / RATE > 8.0 and theta2 is not None:
            off.append(abs(theta2 - ROLL[n]))
    worst = math.degrees(max(off)) if off else 999.0
    return (FOLLOWED, str(control)) if worst < MISREAD_DEG else (MISREAD, f"{worst:.0f} {control}")


def outcomes(one: Printed) -> dict[str, tuple[str, str]]:
    """The outcome of each way that a form may be read."""
    ways = {"learn": learned} if one.is_osc else {"play": played, "setup": set_up}
    found = {name: way(one) for name, way in ways.items()}
    for name, (kind, why) in found.items():
        # a profile or a map from the turn must be right, or have the right reason
        if kind == REFUSED and name != "play" and (not one.refused or one.refused not in why):
            found[name] = (NO_ANSWER, why)
        if kind == FOLLOWED and one.refused:
            found[name] = (MISREAD, why)
    return found


if __name__ == "__main__":
    counts: dict[tuple[str, str], int] = {}
    for one in PRINTED:
        for way, (kind, why) in outcomes(one).items():
            counts[way, kind] = counts.get((way, kind), 0) + 1
            if kind in (NO_ANSWER, MISREAD) or (way == "play" and kind == REFUSED):
                print(f"{way:6s} {kind:10s} {one.source}: {why[:150]!r}")
    print(len(PRINTED), "forms", counts)
