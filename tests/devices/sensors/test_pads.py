"""Game pads: reports of the shape that pads send, made of a known twist, and damaged ones."""

from __future__ import annotations

import math
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.devices.sensors.pads import (
    DualSenseDecoder,
    JoyConDecoder,
    dualsense_motion,
    dualsense_units,
    framed,
)
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.devices.sensors.reading import Counters
from overview_dsp.devices.sensors.source import SensorSource
from tests.devices.sensors.moving import RULES
from tests.devices.sensors.shapes import RATE, ROLL, STATES, G
from tests.devices.sensors.streams import cut, places

# of each axis: a turn at 540 deg/s either way, 540 and 540; then +1 g and -1 g
UNITS = struct.pack(
    "<B17h6x", 5, 3, -2, 7, *(8840, -8840, 8800, -8850, 8870, -8830), 540, 540,
    *(8300, -8100, 8190, -8210, 8000, -8300),
)  # fmt: skip


def to_pad(vector):
    """The device's x (fingers), y (left), z (out) as a DualSense's: right, up, to the player."""
    x, y, z = vector
    return np.array([-y, z, -x])


def dualsense(state, radio=False, units=True):
    """A report as a pad sends it at a state of the known twist."""
    report = bytearray(78 if radio else 64)
    report[0], at = (0x31, 2) if radio else (0x01, 1)
    report[at + 6] = state.n % 256
    turning, pulled = np.degrees(to_pad(state.g)), to_pad(state.a) / G
    if units:
        turning *= np.array([17680, 17650, 17700]) / 1080
        pulled = pulled * np.array([16400, 16400, 16300]) / 2 + np.array([100, -10, -150])
    else:
        turning, pulled = turning * 16.0, pulled * 8192.0
    numbers = np.rint([*turning, *pulled]).astype(int).tolist()
    struct.pack_into("<6hI", report, at + 15, *numbers, (4_294_000_000 + 30_000 * state.n) % 2**32)
    if radio:
        report[-4:] = zlib.crc32(b"\xa1" + report[:-4]).to_bytes(4, "little")
    return bytes(report)


def joycon(states, right=False):
    """Three states as a Joy-Con sends them."""
    report = bytearray(49)
    report[0] = 0x30
    for n, state in enumerate(states):
        sign = np.array([1.0, -1.0, -1.0]) if right else 1.0
        numbers = [*(sign * state.a / G * 4096.0), *(sign * np.degrees(state.g) * 14.247)]
        struct.pack_into("<6h", report, 13 + 12 * n, *np.rint(numbers).astype(int).tolist())
    return bytes(report)


def followed(kind, reports):
    """What is off by theta2 (deg) at each report (its time in s and its bytes), and the hand."""
    one = SensorSource(load_sensor(kind), RULES)
    off = []
    for at, data in reports:
        one.feed(framed(data), at)
        if at > 3.0:
            off.append(abs(one.angle.theta2 - ROLL[min(len(ROLL) - 1, round(at * RATE))]))
    return math.degrees(max(off)), one


@pytest.mark.parametrize("radio", [False, True], ids=["USB", "Bluetooth"])
def test_a_dualsense_gives_the_twist_of_the_wrist(radio):
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    reports = [(0.0, UNITS), *((s.n / RATE, dualsense(s, radio)) for s in STATES)]
    off, one = followed("dualsense", reports)
    assert off < 2.0
    counters = one.counters
    assert (counters.readings, counters.damaged, counters.lost) == (len(STATES), 0, 0)
    assert counters.clock_restarts == counters.clock_wraps == 0  # its clock did wrap


@pytest.mark.parametrize(("kind", "right"), [("joycon", False), ("joycon-right", True)])
def test_either_joy_con_gives_the_twist_of_the_wrist(kind, right):
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    threes = [STATES[n : n + 3] for n in range(0, len(STATES) - 3, 3)]
    off, one = followed(kind, [(t[-1].n / RATE, joycon(t, right)) for t in threes])
    assert off < 4.0  # of samples without a clock, three at a time
    assert one.counters.readings == 3 * len(threes)


def decoded(reports, where=(), decoder=DualSenseDecoder):
    counters = Counters()
    one = decoder(counters)
    data = b"".join(map(framed, reports))
    return [dict(r) for piece in cut(data, list(where)) for r in one.feed(piece)], counters


def test_a_valid_calibration_of_a_pad_is_used_and_an_invalid_one_is_not():
    units = dualsense_units(UNITS)
    assert units.values[3] == pytest.approx(1080 / 17680)
    assert units.values[2] == pytest.approx(2 / 16300)
    assert units.zeros == (100.0, -10.0, -150.0, 0.0, 0.0, 0.0)
    for wrong in (bytes(41), UNITS[:-1], b"\x06" + UNITS[1:], b"\x05" + b"\xff" * 40):
        assert dualsense_units(wrong) is None
    raw = dualsense(STATES[0], units=False)
    readings, counters = decoded([bytes([5]) + bytes(40), raw])
    assert readings[0]["az"] == pytest.approx(STATES[0].a[0] / -G, abs=2e-3)
    assert counters.damaged == 1


def memory(address, *numbers, mark=b"", accepted=True):
    """A Joy-Con's reply: what its memory holds at an address."""
    data = mark + struct.pack("<12h", *numbers)
    head = bytes([0x21, *bytes(12), 0x90, 0x10 if accepted else 0x03])
    return (head + address.to_bytes(4, "little") + bytes([len(data)]) + data).ljust(49, b"\0")


# offsets and scales of acceleration and gyroscope, as a Joy-Con's maker writes them
FACTORY = (350, 0, 4081, 16300, 16384, 20465, 20, -15, 8, 13391, 13356, 13379)


@pytest.mark.parametrize("user", [False, True])
def test_a_joy_cons_calibration_is_read_from_its_memory(user):
    nothing = memory(0x8026, *[-1] * 12, mark=b"\xff\xff")
    mine = memory(0x8026, *(100, -100, 0, 16384, 16384, 16384), *(300, 0, 0, 13671, 13371, 13371),
                  mark=b"\xb2\xa1")  # fmt: skip
    report = bytearray(49)
    report[0] = 0x30
    struct.pack_into("<6h", report, 13, 4096, -4096, 2048, 1445, -15, 8)
    factory = memory(0x6020, *FACTORY)
    (first, *_), counters = decoded([mine if user else nothing, factory, bytes(report)],
                                    decoder=JoyConDecoder)  # fmt: skip
    assert counters.damaged == 0
    if user:
        assert first["ax"] == pytest.approx(16384 / (16384 - 100))
        assert first["gx"] == pytest.approx((1445 - 300) / 14.247 * 13671 / 13371)
    else:
        assert first["ax"] == pytest.approx(16300 / (16300 - 350))
        assert first["gx"] == pytest.approx((1445 - 20) / 14.247 * 13391 / 13371)
        assert first["gy"] == first["gz"] == 0.0


def test_an_unusable_calibration_of_a_joy_con_is_not_used():
    report = bytearray(49)
    report[0] = 0x30
    struct.pack_into("<6h", report, 13, 4096, 0, 0, 14247, 0, 0)
    for wrong in (memory(0x6020, *[-1] * 12), memory(0x6020, *FACTORY, accepted=False),
                  memory(0x6030, *FACTORY)):  # fmt: skip
        (first, *_), counters = decoded([wrong, bytes(report)], decoder=JoyConDecoder)
        assert (first["ax"], counters.damaged) == (1.0, 0)
        assert first["gx"] == pytest.approx(1000.0)


@given(st.integers(0, 599), st.lists(st.tuples(st.integers(0, 77), st.integers(1, 255)),
                                     min_size=1, max_size=4))  # fmt: skip
def test_a_damaged_bluetooth_report_is_rejected_completely(n, changes):
    good = dualsense(STATES[n], radio=True)
    bad = bytearray(good)
    for at, by in changes:
        bad[at] ^= by
    if bytes(bad) == good or bad[0] == 0x01:
        return
    assert dualsense_motion(bytes(bad)) is None
    readings, counters = decoded([bytes(bad)])
    assert (readings, counters.damaged) == ([], 1)


@given(st.lists(st.binary(min_size=1, max_size=255), max_size=8), places)
def test_any_report_gives_finite_numbers_without_an_exception(reports, where):
    for decoder in (DualSenseDecoder, JoyConDecoder):
        readings, counters = decoded(reports, where, decoder)
        assert all(math.isfinite(value) for one in readings for value in one.values())
        assert counters.readings == len(readings)
        assert counters.readings + 3 * counters.damaged >= len(reports) - 1


@given(places)
def test_the_split_of_the_stream_has_no_effect(where):
    reports = [UNITS, *(dualsense(s, s.n % 2 == 0) for s in STATES[:30])]
    whole, _ = decoded(reports)
    assert decoded(reports, where)[0] == whole
    assert len(whole) == 30


def test_a_report_that_is_lost_is_counted():
    reports = [dualsense(s) for s in STATES[:40] if s.n not in (10, 11, 30)]
    one = SensorSource(load_sensor("dualsense"), RULES)
    for n, data in enumerate(reports):
        one.feed(framed(data), n / RATE)
    assert one.counters.lost == 3
