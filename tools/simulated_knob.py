"""A device to try without having one: it appears as a serial port and behaves.

    python tools/simulated_knob.py imu
    python tools/simulated_knob.py imu recording.mat --format text --rate 200
    python tools/simulated_knob.py motor --hand jiggle --delay-ms 20
    overview devices --serial /tmp/simulated-knob
    overview play world-cup-final-2018 --input serial:/tmp/simulated-knob

`imu` is an inertial sensor in a hand. Without a recording it lies face up for two seconds, is
turned face down and back, slowly and fast, by one wrist and by the other, and begins again; it also
does when its port is opened, as a board does. A recording is a `.mat` file with imu_acc (m/s²),
imu_gyr (rad/s) and sampling_rate, an `.npz` with acc, gyr and fs, or a CSV with columns such as
"Gyroscope X (deg/s)" and "Accelerometer X (g)".

It speaks the binary frame (`--format frames`), lines of six numbers (`text`, m/s² and rad/s) or
lines of JSON (`json`). What is wrong with real wires can be had too: `--noise` spoils bytes,
`--lose` leaves samples out, `--burst` sends late and together, `--unplug` takes the port away.

`motor` is a motor knob with SimpleFOC's Commander (`simulated_motor.py`), in a hand that sweeps,
jiggles, holds or flicks it, on a wire with a delay each way. A line a second says where it is, what
torque it gives and what work went which way. With `--board` the surface runs on its own board
(`simulated_board.py`, which needs a C compiler), and the host only sends it.

    overview play world-cup-final-2018 --input serial:/tmp/simulated-knob,sensor=simplefoc,force

Imports nothing of the package, so that the two understand each other by what is documented alone.
Needs a pseudo-terminal: Linux or macOS.
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


# --- what it says --------------------------------------------------------------------------------


def check(data: bytes) -> int:
    """CRC-16/X-25, a bit at a time."""
    register = 0xFFFF
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ (0x8408 if register & 1 else 0)
    return register ^ 0xFFFF


def stuffed(payload: bytes) -> bytes:
    """COBS: for each zero, and for the end, how far it is from the one before."""
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
    """Kind 2: 1/2048 g and 1/16.384 deg/s."""
    numbers = [*(acc / G * 2048.0), *(np.degrees(gyr) * 16.384)]
    limited = [max(-32768, min(32767, round(float(one)))) for one in numbers]
    sent = stuffed(struct.pack("<BHI6h", 2, number & 0xFFFF, stamp_us & 0xFFFFFFFF, *limited))
    crc = check(sent)
    return sent + bytes([0x80 | crc & 0x7F, 0x80 | crc >> 7 & 0x7F, 0x80 | crc >> 14, 0])


def as_text(number: int, stamp_us: int, acc: np.ndarray, gyr: np.ndarray) -> bytes:
    """Six numbers, m/s² and rad/s."""
    return (",".join(f"{one:.4f}" for one in (*acc, *gyr)) + "\r\n").encode()


def as_json(number: int, stamp_us: int, acc: np.ndarray, gyr: np.ndarray) -> bytes:
    """An object a line."""
    said = {
        "t_us": stamp_us & 0xFFFFFFFF,
        "sequence": number & 0xFFFF,
        "acc": [round(float(one), 4) for one in acc],
        "gyr": [round(float(one), 5) for one in gyr],
    }
    return (json.dumps(said) + "\n").encode()


FORMATS = {"frames": as_frame, "text": as_text, "json": as_json}


# --- how it moves --------------------------------------------------------------------------------


def made_up(rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration (m/s²) and angular velocity (rad/s) of a hand that twists."""
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
    """Acceleration (m/s²), angular velocity (rad/s) and rate (Hz) of a file."""
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
    """Values at another rate, on straight lines between them."""
    old = np.arange(len(values)) / before
    new = np.arange(int(len(values) * after / before)) / after
    return np.stack([np.interp(new, old, axis) for axis in values.T], axis=1)


# --- the wire ------------------------------------------------------------------------------------


class Wire:
    """A pseudo-terminal; `name` is the other end."""

    def __init__(self, link: str) -> None:
        import tty  # not on Windows

        self._ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(self._ours, False)
        self.name = os.ttyname(theirs)
        os.close(theirs)  # so that our end hangs up while nobody has it open
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
        """Whether somebody has the port open."""
        return not any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def receive(self) -> bytes:
        """What has come, without waiting."""
        try:
            return os.read(self._ours, 65536)
        except OSError:  # nothing, or nobody
            return b""

    def send(self, data: bytes) -> None:
        """What finds no buffer space, or no reader, is lost, as on a wire."""
        with contextlib.suppress(OSError):
            os.write(self._ours, data)

    def close(self) -> None:
        os.close(self._ours)
        if self._link and os.path.islink(self._link):
            os.unlink(self._link)


def spoil(data: bytes, part: float, dice: random.Random) -> bytes:
    """Each byte changed with the chance `part`."""
    return bytes(dice.randrange(256) if dice.random() < part else byte for byte in data)


def play_imu(options: argparse.Namespace) -> None:
    """Send samples at their times until stopped."""
    if options.recording is None:
        rate = options.rate or 200.0
        acc, gyr = made_up(rate)
    else:
        acc, gyr, rate = recorded(options.recording)
        if options.rate:
            acc, gyr = at_rate(acc, rate, options.rate), at_rate(gyr, rate, options.rate)
            rate = options.rate
    encode, dice = FORMATS[options.format], random.Random(options.seed)
    wire = Wire(options.link)
    print(f"serial:{options.link or wire.name}  {options.format}, {rate:g} Hz", flush=True)
    began, waiting, number, first, heard = time.monotonic(), b"", 0, 0, False
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
                if wire.is_open and not heard:  # a board begins again
                    first = number
                heard = wire.is_open
                wire.send(spoil(waiting, options.noise, dice) if options.noise else waiting)
                waiting = b""
    except KeyboardInterrupt:
        pass
    finally:
        wire.close()


def play_motor(options: argparse.Namespace) -> None:
    """Keep a motor in time until stopped; the last line is the whole as JSON."""
    from simulated_motor import HANDS, Hand, Motor, Session

    physics = {"inertia": options.inertia, "friction": options.friction}
    if options.board:
        from simulated_board import BoardMotor

        motor = BoardMotor(**physics)
        path = motor.patient(HANDS[options.hand]())
    else:
        path = HANDS[options.hand]()
        motor = Motor(
            counts=options.counts,
            nm_per_unit=options.nm_per_unit,
            watchdog=not options.no_watchdog,
            **physics,
        )
    session = Session(motor, Hand(path), options.delay_ms * 1e-3)
    dice = random.Random(options.seed)
    wire = Wire(options.link)
    print(f"serial:{options.link or wire.name}  motor, {options.hand}", flush=True)
    began, said, heard = time.monotonic(), 0, False
    lowest = highest = motor.angle
    moved = opened = 0.0
    try:
        while options.seconds is None or motor.time < options.seconds:
            time.sleep(0.0005)
            now = time.monotonic() - began
            if now - motor.time > 0.25:  # held up for longer: the time is lost, as for a person
                began += now - motor.time
                continue
            sent = session.exchange(now, wire.receive())
            if wire.is_open and not heard:  # a board begins again
                motor.begin()
                opened = motor.time
            heard = wire.is_open
            silent = options.mute is not None and motor.time >= opened + options.mute
            if sent and not silent:
                wire.send(spoil(sent, options.noise, dice) if options.noise else sent)
            lowest, highest = min(lowest, motor.angle), max(highest, motor.angle)
            if motor.time >= said + 1:
                said += 1
                moved = math.degrees(highest - lowest)
                print(
                    f"{said:4d} s  {math.degrees(motor.angle):8.2f} deg (moved "
                    f"{moved:6.2f})  {1e3 * motor.torque:+7.3f} mN m  "
                    f"in {1e3 * motor.put_in:8.3f} mJ  back {1e3 * motor.given:8.3f} mJ",
                    flush=True,
                )
                lowest = highest = motor.angle
    except KeyboardInterrupt:
        pass
    finally:
        wire.close()
    totals = {
        "absorbed_mj": 1e3 * motor.put_in,
        "returned_mj": 1e3 * motor.given,
        "hand_mj": 1e3 * motor.hand_work,
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
    imu.add_argument("--rate", type=float, help="Hz, instead of the recording's (or 200)")
    imu.add_argument("--seconds", type=float, help="stop after so long")
    imu.add_argument("--once", action="store_true", help="stop where the recording ends")
    imu.add_argument("--noise", type=float, default=0.0, help="part of the bytes that is spoilt")
    imu.add_argument("--lose", type=float, default=0.0, help="part of the samples left out")
    imu.add_argument("--burst", type=int, default=1, help="samples sent together")
    imu.add_argument("--unplug", type=float, metavar="S", help="take the port away for 2 s")
    imu.add_argument("--start-us", type=int, default=0, help="where its clock begins")
    imu.add_argument("--seed", type=int, default=1)
    imu.add_argument("--link", default=LINK, help="a name for the port (empty: none)")
    motor = kinds.add_parser("motor", help="a motor knob")
    motor.set_defaults(play=play_motor)
    motor.add_argument("--hand", choices=("sweep", "jiggle", "hold", "flick"), default="sweep")
    motor.add_argument(
        "--board",
        action="store_true",
        help="with the surface on its own board: firmware/knob/surface.h, 14-bit encoder",
    )
    motor.add_argument("--delay-ms", type=float, default=2.0, help="of the wire, each way")
    motor.add_argument("--inertia", type=float, default=5e-5, help="kg m2")
    motor.add_argument("--friction", type=float, default=3e-4, help="of the knob itself, N m")
    motor.add_argument("--counts", type=int, default=4096, help="of its encoder, a turn")
    motor.add_argument("--nm-per-unit", type=float, default=0.003, help="torque of 1 of its target")
    motor.add_argument("--seconds", type=float, help="stop after so long")
    motor.add_argument(
        "--mute", type=float, metavar="S", help="say nothing any more S after it was opened"
    )
    motor.add_argument("--noise", type=float, default=0.0, help="part of the bytes that is spoilt")
    motor.add_argument("--no-watchdog", action="store_true", help="keep the torque in silence")
    motor.add_argument("--seed", type=int, default=1)
    motor.add_argument("--link", default=LINK, help="a name for the port (empty: none)")
    options = parser.parse_args()
    if os.name != "posix":
        sys.exit("a pseudo-terminal is needed: Linux or macOS")
    options.play(options)


if __name__ == "__main__":
    main()
