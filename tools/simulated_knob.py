"""Simulated device on a serial port, to try a sensor or a motor knob without hardware.

    python tools/simulated_knob.py imu
    python tools/simulated_knob.py imu recording.mat --format text --rate 200
    python tools/simulated_knob.py motor --movement jiggle --delay-ms 20
    overview devices --serial /tmp/simulated-knob
    overview play world-cup-final-2018 --input serial:/tmp/simulated-knob

`imu` is an inertial sensor in a hand. Without a recording it rests face up for two seconds, turns
face down and back, slowly and fast, by one wrist and by the other, and repeats. It also restarts
when its port is opened, as a board does. A recording is a `.mat` file with imu_acc (m/s²),
imu_gyr (rad/s) and sampling_rate, an `.npz` with acc, gyr and fs, or a CSV with columns such as
"Gyroscope X (deg/s)" and "Accelerometer X (g)".

It sends binary frames (`--format frames`), lines of six numbers (`text`, m/s² and rad/s) or lines
of JSON (`json`). Options simulate faults of real wires: `--noise` changes bytes, `--lose` omits
samples, `--burst` sends samples late and together, `--unplug` removes the port.

`motor` is a motor knob with SimpleFOC's Commander (`simulated_motor.py`). Its user sweeps, jiggles,
holds or flicks it, and its wire has a delay each way. Every second it prints angle, torque and
work. With `--board` the surface runs on the knob's own board (`simulated_board.py`, which needs a C
compiler), and the host only sends the surface.

    overview play world-cup-final-2018 --input serial:/tmp/simulated-knob,sensor=simplefoc,force

This program imports nothing of the package, so that both rely on the documented formats alone. It
needs a pseudo-terminal: Linux or macOS.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import math
import os
import random
import select
import struct
import sys
import time
from pathlib import Path

import numpy as np

LINK = "/tmp/simulated-knob"
G = 9.80665
REST_S = 2.0


# --- formats -------------------------------------------------------------------------------------


def check(data: bytes) -> int:
    """Return the CRC-16/X-25, computed bit by bit."""
    register = 0xFFFF
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ (0x8408 if register & 1 else 0)
    return register ^ 0xFFFF


def stuffed(payload: bytes) -> bytes:
    """Return the COBS encoding: each zero, and the end, as the distance from the one before."""
    out = bytearray(b"\0")
    code_at = 0
    for byte in payload:
        if byte:
            out.append(byte)
        else:
            out[code_at] = len(out) - code_at
            code_at = len(out)
            out.append(0)
    out[code_at] = len(out) - code_at
    return bytes(out)


def as_frame(number: int, stamp_us: int, acc: np.ndarray, gyr: np.ndarray) -> bytes:
    """Return a frame of kind 2: 1/2048 g and 1/16.384 deg/s."""
    numbers = [*(acc / G * 2048.0), *(np.degrees(gyr) * 16.384)]
    limited = [max(-32768, min(32767, round(float(one)))) for one in numbers]
    sent = stuffed(struct.pack("<BHI6h", 2, number & 0xFFFF, stamp_us & 0xFFFFFFFF, *limited))
    crc = check(sent)
    return sent + bytes([0x80 | crc & 0x7F, 0x80 | crc >> 7 & 0x7F, 0x80 | crc >> 14, 0])


def as_text(number: int, stamp_us: int, acc: np.ndarray, gyr: np.ndarray) -> bytes:
    """Return a line of six numbers, m/s² and rad/s."""
    return (",".join(f"{one:.4f}" for one in (*acc, *gyr)) + "\r\n").encode()


def as_json(number: int, stamp_us: int, acc: np.ndarray, gyr: np.ndarray) -> bytes:
    """Return a line with one object."""
    sample = {
        "t_us": stamp_us & 0xFFFFFFFF,
        "sequence": number & 0xFFFF,
        "acc": [round(float(one), 4) for one in acc],
        "gyr": [round(float(one), 5) for one in gyr],
    }
    return (json.dumps(sample) + "\n").encode()


FORMATS = {"frames": as_frame, "text": as_text, "json": as_json}


# --- movement ------------------------------------------------------------------------------------


def scripted_twists(rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return acceleration (m/s²) and angular velocity (rad/s) of several twists."""
    legs = [(REST_S, 0), (3.0, 175), (0.5, 175), (3.0, 0), (1.0, 0), (0.7, 120), (0.6, 120),
            (0.7, 0), (1.0, 0), (2.0, -170), (0.5, -170), (2.0, 0), (1.0, 0)]  # fmt: skip
    roll = [0.0]
    for seconds, degrees in legs:
        part = np.arange(1, round(seconds * rate) + 1) / round(seconds * rate)
        eased = part * part * (3.0 - 2.0 * part)
        roll += list(roll[-1] + (math.radians(degrees) - roll[-1]) * eased)
    angle = np.array(roll)
    dice = np.random.default_rng(1)
    acc = G * np.stack([np.zeros_like(angle), np.sin(angle), np.cos(angle)], axis=1)
    gyr = np.zeros_like(acc)
    gyr[:, 0] = np.gradient(angle) * rate
    return (
        acc + 0.05 * dice.standard_normal(acc.shape),
        gyr + [0.01, -0.006, 0.004] + 0.002 * dice.standard_normal(acc.shape),
    )


def recorded(path: Path) -> tuple[np.ndarray, np.ndarray, float]:
    """Return acceleration (m/s²), angular velocity (rad/s) and rate (Hz) of a file."""
    if path.suffix == ".mat":
        from scipy.io import loadmat

        data = loadmat(path)
        return data["imu_acc"], data["imu_gyr"], float(data["sampling_rate"].squeeze())
    if path.suffix == ".npz":
        data = np.load(path)
        return data["acc"], data["gyr"], float(data["fs"])
    with open(path, newline="") as file:
        rows = csv.reader(file)
        header = [name.strip().lower() for name in next(rows)]
        table = np.array([[float(cell) for cell in row] for row in rows if row])
    acc = table[:, [next(i for i, n in enumerate(header) if n.startswith(f"accelerometer {a}"))
                    for a in "xyz"]]  # fmt: skip
    gyr = table[:, [next(i for i, n in enumerate(header) if n.startswith(f"gyroscope {a}"))
                    for a in "xyz"]]  # fmt: skip
    times = table[:, next(i for i, n in enumerate(header) if n.startswith("time"))]
    return acc * G, np.radians(gyr), 1.0 / float(np.median(np.diff(times)))


def at_rate(values: np.ndarray, before: float, after: float) -> np.ndarray:
    """Return values at another rate, interpolated linearly."""
    old = np.arange(len(values)) / before
    new = np.arange(int(len(values) * after / before)) / after
    return np.stack([np.interp(new, old, axis) for axis in values.T], axis=1)


# --- the wire ------------------------------------------------------------------------------------


class Wire:
    """A pseudo-terminal; `name` is the path of its other end."""

    def __init__(self, link: str) -> None:
        import tty  # not on Windows

        self._ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(self._ours, False)
        self.name = os.ttyname(theirs)
        os.close(theirs)  # so that our end hangs up while the port is closed
        self._poll = select.poll()
        self._poll.register(self._ours, 0)
        self._link = link
        if link:
            with contextlib.suppress(FileNotFoundError):
                if os.path.islink(link):
                    os.unlink(link)
            os.symlink(self.name, link)

    @property
    def is_open(self) -> bool:
        """True while a program has the port open."""
        return not any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def receive(self) -> bytes:
        """Return the received bytes, without waiting."""
        try:
            return os.read(self._ours, 65536)
        except OSError:  # no data, or the port is closed
            return b""

    def send(self, data: bytes) -> None:
        """Send bytes; without buffer space or a reader they are lost, as on a wire."""
        with contextlib.suppress(OSError):
            os.write(self._ours, data)

    def close(self) -> None:
        os.close(self._ours)
        if self._link and os.path.islink(self._link):
            os.unlink(self._link)


def spoil(data: bytes, part: float, dice: random.Random) -> bytes:
    """Return the bytes, each changed with the probability `part`."""
    return bytes(dice.randrange(256) if dice.random() < part else byte for byte in data)


def play_imu(options: argparse.Namespace) -> None:
    """Send samples in real time until stopped."""
    if options.recording is None:
        rate = options.rate or 200.0
        acc, gyr = scripted_twists(rate)
    else:
        acc, gyr, rate = recorded(options.recording)
        if options.rate:
            acc, gyr = at_rate(acc, rate, options.rate), at_rate(gyr, rate, options.rate)
            rate = options.rate
    encode, dice = FORMATS[options.format], random.Random(options.seed)
    wire = Wire(options.link)
    print(f"serial:{options.link or wire.name}  {options.format}, {rate:g} Hz", flush=True)
    began, waiting, number, first, was_open = time.monotonic(), b"", 0, 0, False
    unplugged_at = options.unplug
    try:
        while options.seconds is None or number / rate < options.seconds:
            at = (number - first) % len(acc)
            if number > first and at == 0 and options.once:
                break
            time.sleep(max(0.0, began + number / rate - time.monotonic()))
            if unplugged_at is not None and number / rate >= unplugged_at:
                wire.close()
                print("unplugged", flush=True)
                time.sleep(2.0)
                wire, unplugged_at = Wire(options.link), None
                began += 2.0
                print(f"serial:{options.link or wire.name}  is back", flush=True)
            if dice.random() >= options.lose:
                stamp = options.start_us + round(number / rate * 1e6)
                waiting += encode(number, stamp, acc[at], gyr[at])
            number += 1
            if number % options.burst == 0:
                if wire.is_open and not was_open:  # a board restarts
                    first = number
                was_open = wire.is_open
                wire.send(spoil(waiting, options.noise, dice) if options.noise else waiting)
                waiting = b""
    except KeyboardInterrupt:
        pass
    finally:
        wire.close()


def play_motor(options: argparse.Namespace) -> None:
    """Run a motor in real time until stopped; the last line has the totals as JSON."""
    from simulated_motor import MOVEMENTS, Fingers, Motor, Session

    physics = {"inertia": options.inertia, "friction": options.friction}
    if options.board:
        from simulated_board import BoardMotor

        motor = BoardMotor(**physics)
        path = motor.patient(MOVEMENTS[options.movement]())
    else:
        path = MOVEMENTS[options.movement]()
        motor = Motor(
            counts=options.counts,
            nm_per_unit=options.nm_per_unit,
            watchdog=not options.no_watchdog,
            **physics,
        )
    session = Session(motor, Fingers(path), options.delay_ms * 1e-3)
    dice = random.Random(options.seed)
    wire = Wire(options.link)
    print(f"serial:{options.link or wire.name}  motor, {options.movement}", flush=True)
    began, printed, was_open = time.monotonic(), 0, False
    lowest = highest = motor.angle
    moved = opened = 0.0
    try:
        while options.seconds is None or motor.time < options.seconds:
            time.sleep(0.0005)
            now = time.monotonic() - began
            if (
                now - motor.time > 0.25
            ):  # after a longer interruption the simulated time stands still
                began += now - motor.time
                continue
            sent = session.exchange(now, wire.receive())
            if wire.is_open and not was_open:  # a board restarts
                motor.begin()
                opened = motor.time
            was_open = wire.is_open
            silent = options.mute is not None and motor.time >= opened + options.mute
            if sent and not silent:
                wire.send(spoil(sent, options.noise, dice) if options.noise else sent)
            lowest, highest = min(lowest, motor.angle), max(highest, motor.angle)
            if motor.time >= printed + 1:
                printed += 1
                moved = math.degrees(highest - lowest)
                print(
                    f"{printed:4d} s  {math.degrees(motor.angle):8.2f} deg (moved "
                    f"{moved:6.2f})  {1e3 * motor.torque:+7.3f} mN m  "
                    f"{1e3 * motor.absorbed:8.3f} mJ absorbed  "
                    f"{1e3 * motor.returned:8.3f} mJ returned",
                    flush=True,
                )
                lowest = highest = motor.angle
    except KeyboardInterrupt:
        pass
    finally:
        wire.close()
    totals = {
        "absorbed_mj": 1e3 * motor.absorbed,
        "returned_mj": 1e3 * motor.returned,
        "user_mj": 1e3 * motor.user_work,
        "moved_deg": moved,  # in the last second
        "target": motor.target,
        "enabled": motor.enabled,
        "silences": motor.silences,
    }
    print(json.dumps(totals), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    kinds = parser.add_subparsers(required=True)
    imu = kinds.add_parser("imu", help="an inertial sensor")
    imu.set_defaults(play=play_imu)
    imu.add_argument("recording", nargs="?", type=Path, help=".mat, .npz or .csv")
    imu.add_argument("--format", choices=FORMATS, default="frames")
    imu.add_argument("--rate", type=float, help="rate in Hz (default: the recording's, or 200)")
    imu.add_argument("--seconds", type=float, help="stop after so many seconds")
    imu.add_argument("--once", action="store_true", help="stop where the recording ends")
    imu.add_argument("--noise", type=float, default=0.0, help="share of changed bytes")
    imu.add_argument("--lose", type=float, default=0.0, help="share of omitted samples")
    imu.add_argument("--burst", type=int, default=1, help="samples sent together")
    imu.add_argument("--unplug", type=float, metavar="S", help="remove the port for 2 s")
    imu.add_argument("--start-us", type=int, default=0, help="start of its clock, microseconds")
    imu.add_argument("--seed", type=int, default=1)
    imu.add_argument("--link", default=LINK, help="symbolic link to the port (empty: none)")
    motor = kinds.add_parser("motor", help="a motor knob")
    motor.set_defaults(play=play_motor)
    motor.add_argument("--movement", choices=("sweep", "jiggle", "hold", "flick"), default="sweep")
    motor.add_argument(
        "--board",
        action="store_true",
        help="run the surface on the knob's own board (firmware/knob/surface.h, 14-bit encoder)",
    )
    motor.add_argument("--delay-ms", type=float, default=2.0, help="delay of the wire each way")
    motor.add_argument("--inertia", type=float, default=5e-5, help="inertia in kg m2")
    motor.add_argument("--friction", type=float, default=3e-4, help="friction of the knob in N m")
    motor.add_argument("--counts", type=int, default=4096, help="encoder counts per turn")
    motor.add_argument(
        "--nm-per-unit", type=float, default=0.003, help="torque of 1 unit of its target"
    )
    motor.add_argument("--seconds", type=float, help="stop after so many seconds")
    motor.add_argument(
        "--mute",
        type=float,
        metavar="S",
        help="stop the reports S seconds after the port was opened",
    )
    motor.add_argument("--noise", type=float, default=0.0, help="share of changed bytes")
    motor.add_argument(
        "--no-watchdog", action="store_true", help="keep the torque without commands"
    )
    motor.add_argument("--seed", type=int, default=1)
    motor.add_argument("--link", default=LINK, help="symbolic link to the port (empty: none)")
    options = parser.parse_args()
    if os.name != "posix":
        sys.exit("a pseudo-terminal is needed: Linux or macOS")
    options.play(options)


if __name__ == "__main__":
    main()
