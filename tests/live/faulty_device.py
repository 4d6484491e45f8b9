"""A sensor at 1000 Hz that goes wrong in every way, on a pseudo-terminal; a program of its own.

    python faulty_device.py LINK SECONDS

Lies still, swings to and fro, and has one fault after another; in the end it prints, as JSON, the
faults with their times (`time.monotonic`), and of each connection when its first sample was taken
and how many were. A sample's number counts whether or not it reaches the wire. The faults leave no
doubt about how many samples are missing: the first and the last of a connection are whole.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import select
import struct
import sys
import time
import tty

RATE = 1000
STILL_S, PERIOD_S = 1.6, 4.0
BETWEEN_S = 1.5
"""Without a fault, for the disk to be taken hold of again."""

TABLE = []
for _byte in range(256):
    for _ in range(8):
        _byte = _byte >> 1 ^ (0x8408 if _byte & 1 else 0)
    TABLE.append(_byte)


def frame(number, stamp_us, roll, speed, trembling):
    """`docs/guide/sensors.md`, kind 2."""
    gravity = (trembling, round(2048 * math.sin(roll)), round(2048 * math.cos(roll)))
    turning = (round(math.degrees(speed) * 16.384), 0, 0)
    payload = struct.pack("<BHI6h", 2, number & 0xFFFF, stamp_us & 0xFFFFFFFF, *gravity, *turning)
    out, code = bytearray(b"\0"), 0
    for byte in payload:
        if byte:
            out.append(byte)
        else:
            out[code] = len(out) - code
            code = len(out)
            out.append(0)
    out[code] = len(out) - code
    crc = 0xFFFF
    for byte in out:
        crc = crc >> 8 ^ TABLE[(crc ^ byte) & 0xFF]
    crc ^= 0xFFFF
    return bytes(out) + bytes((0x80 | crc & 0x7F, 0x80 | crc >> 7 & 0x7F, 0x80 | crc >> 14, 0))


def roll_at(since_s):
    """Angle (rad) and its speed (rad/s) so long after the port was opened."""
    moving = since_s - STILL_S
    if moving < 0.0:
        return 0.0, 0.0
    # up to 90 degrees once, then to and fro between 30 and 150: never at rest
    if moving < 1.0:
        return math.pi / 2 * moving * moving * (3 - 2 * moving), math.pi * 3 * moving * (1 - moving)
    phase = 2 * math.pi * (moving - 1.0) / PERIOD_S
    return (
        math.pi / 2 + math.pi / 3 * math.sin(phase),
        math.pi / 3 * math.cos(phase) * 2 * math.pi / PERIOD_S,
    )


class Device:
    def __init__(self, link, wrap_after_s):
        self.link = link
        self.dice = random.Random(1)
        self.number = 0
        self.connections, self.faults = [], []
        self.wrap_after_s = wrap_after_s
        self.shift_us = 0
        self.plug()

    def plug(self):
        self.ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(self.ours, False)
        self.name = os.ttyname(theirs)
        os.close(theirs)
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.link)
        os.symlink(self.name, self.link)

    def wait_until_open(self):
        poll = select.poll()
        poll.register(self.ours, 0)
        while any(event & select.POLLHUP for _, event in poll.poll(0)):
            time.sleep(0.01)
        time.sleep(0.1)
        self.write(b"\0")
        self.opened = self.due = time.monotonic()
        if not self.connections:
            # its clock passes its highest count so long after it is first listened to
            self.shift_us = (1 << 32) - round((self.opened + self.wrap_after_s) * 1e6)
        self.connections.append({"began": None, "samples": 0})

    def write(self, data):
        with contextlib.suppress(OSError):
            os.write(self.ours, data)

    def sample(self):
        """The next sample's frame; whether it is sent is the caller's business."""
        now = time.monotonic()
        roll, speed = roll_at(now - self.opened)
        here = self.connections[-1]
        here["began"] = now if here["began"] is None else here["began"]
        here["samples"] += 1
        self.number += 1
        trembling = self.dice.randrange(-9, 10)
        self.last = frame(self.number, round(now * 1e6) + self.shift_us, roll, speed, trembling)
        return self.last

    def run(self, seconds, send=None, rate=RATE):
        """Samples in time for so long, each given to `send`."""
        send = send or self.write
        self.due = time.monotonic()
        until = self.due + seconds
        while self.due < until:
            time.sleep(max(0.0, self.due - time.monotonic()))
            self.due += 1.0 / rate
            send(self.sample())
        self.write(self.sample())  # whole

    def fault(self, name, seconds, send=None, rate=RATE):
        began = time.monotonic()
        self.run(seconds, send, rate)
        self.faults.append({"name": name, "from": began, "to": time.monotonic()})
        self.run(BETWEEN_S)

    # --- the faults -------------------------------------------------------------------------------

    def noise(self, data):
        """One byte of some frames, so that the check always catches it."""
        data = bytearray(data)
        if self.dice.random() < 0.2:
            data[self.dice.randrange(23)] ^= self.dice.randrange(1, 256)
        self.write(bytes(data))

    def halves(self, data):
        self.write(data[: self.dice.randrange(24)] if self.dice.random() < 0.2 else data)

    def garbage(self, data):
        """As another speed reads."""
        self.write(bytes(self.dice.randrange(256) for _ in data))

    def stuck(self, data):
        """The frame from before, again and again."""
        self.write(self.before)

    def frozen(self, data):
        """Numbers and clock go on, and it says the very same."""
        stamp_us = round(time.monotonic() * 1e6) + self.shift_us
        self.write(frame(self.number, stamp_us, 1.0, 0.1, 3))

    def stolen(self, seconds):
        """Another program reads the port too."""
        began = time.monotonic()
        try:
            other = os.open(self.name, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
        except OSError:  # who isn't root is kept out by the lock
            other = None

        def send(data):
            self.write(data)
            if other is not None:
                with contextlib.suppress(OSError):
                    os.read(other, 10)

        self.run(seconds, send)
        if other is not None:
            os.close(other)
        self.faults.append({"name": "stolen", "from": began, "to": time.monotonic()})
        self.run(BETWEEN_S)

    def unplugged(self, seconds):
        time.sleep(0.1)  # all of it is read
        began = time.monotonic()
        os.close(self.ours)
        os.unlink(self.link)
        time.sleep(seconds)
        self.faults.append({"name": "disconnected", "from": began, "to": time.monotonic()})
        self.plug()
        self.wait_until_open()
        self.run(STILL_S + 1.0 + BETWEEN_S)

    def round(self):
        self.fault("noise", 1.5, self.noise)
        self.fault("halves", 1.5, self.halves)
        self.fault("garbage", 1.0, self.garbage)
        self.before = self.last
        self.fault("stuck", 1.0, self.stuck)
        self.fault("silence", 1.0, lambda data: None)
        self.fault("frozen", 3.0, self.frozen)
        self.fault("overload", 1.5, rate=10 * RATE)
        self.stolen(1.0)
        self.unplugged(1.5)


def main():
    link, seconds = sys.argv[1], float(sys.argv[2])
    device = Device(link, wrap_after_s=8.0)
    print("ready", flush=True)
    device.wait_until_open()
    device.run(STILL_S + 1.0 + BETWEEN_S)
    until = time.monotonic() + seconds
    while True:
        device.round()
        if time.monotonic() >= until:
            break
    time.sleep(0.2)
    print(json.dumps({"faults": device.faults, "connections": device.connections}), flush=True)
    sys.stdin.read()  # the port stays until the other side is done
    os.unlink(link)


if __name__ == "__main__":
    main()
