"""Every shape that boards and apps send is understood, or refused with its reason."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.devices.sensors.app_json import parse_app_batch
from overview_dsp.devices.sensors.decoders import DetectedFormat
from overview_dsp.devices.sensors.labelled_lines import (
    LabelledReader,
    LineCycle,
    cycle_from_shapes,
    find_cycle,
)
from overview_dsp.devices.sensors.lines import LineDecoder
from overview_dsp.devices.sensors.packets import (
    TeapotDecoder,
    WitDecoder,
    teapot_packet,
    wit_packet,
)
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    QUATERNION,
    Counters,
)
from tests.devices.sensors.moving import hand
from tests.devices.sensors.shapes import (
    PAGE,
    SHAPES,
    STATES,
    logger,
    phyphox,
    played,
    sent,
    teapot,
    wit,
    written,
    ypr,
)
from tests.devices.sensors.streams import cut, damages, harm, places

pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")

SIX = ACCELERATION + ANGULAR_VELOCITY
FOLLOWED_DEG = 8.0
"""Gravity alone lags by 6 at the fastest."""

by_name = pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.source)


@by_name
def test_a_shape_is_followed_or_refused_with_its_reason_and_its_line_within_2_s(shape):
    result = played(shape)
    said = [message for at, message in result.messages if at <= 2.0]
    assert all("\n" not in message for message in said)
    if shape.said:
        (refused,) = said
        assert shape.said in refused
        assert np.isnan(result.turns[:, 1]).all()
        return
    at, theta2, true = result.turns.T
    assert np.degrees(np.abs(theta2 - true))[at > 3.0].max() < FOLLOWED_DEG
    assert result.damaged == 0


def test_there_are_sixty_shapes_and_the_documented_table_lists_them():
    assert len({shape.source for shape in SHAPES}) == len(SHAPES) >= 60
    page = PAGE.read_text(encoding="utf-8")
    assert written(page) == page, "run python -m tests.devices.sensors.shapes"


def test_a_refusal_shows_the_received_line_and_two_profiles_that_each_read_it():
    shape = next(one for one in SHAPES if one.source.startswith("a clock and six"))
    (_, refused), *_ = played(shape).messages
    lines = [data.decode().strip() for data, _ in sent(shape)]
    assert any(repr(line) in refused for line in lines[1:60])
    first, second = (json.loads(part.split("]")[0] + "]") for part in
                     refused.split("columns = ")[1:])  # fmt: skip
    one = hand(columns=tuple(first))
    for data, at in sent(shape):
        one.feed(data, at)
    assert one.angle is not None
    assert len(first) == len(second) == 7


@pytest.mark.parametrize("place", [0, 1, 2])
def test_the_angle_that_changes_most_is_the_twist(place):
    one = hand()
    for state in STATES:
        line = "ypr\t" + "\t".join(f"{angle:.2f}" for angle in ypr(state, place)) + "\n"
        one.feed(line.encode(), state.n / 100.0)
    assert math.degrees(one.angle.theta2) == pytest.approx(20.0, abs=0.5)
    assert any(f"angle {place + 1} of three" in said for said in one.take_messages())


def test_a_twist_angle_that_folds_at_90_degrees_is_reported():
    one = hand(angles__twist="2")
    for n in range(200):
        angle = float(n)
        folded = (0.0, angle, 0.0) if angle < 90.0 else (180.0, 180.0 - angle, 180.0)
        one.feed(("ypr " + " ".join(map(str, folded)) + "\n").encode(), n / 100.0)
    assert any("folds back" in said for said in one.take_messages())


def decoded(make, data: bytes, where: list[int]):
    counters = Counters()
    decoder = make(counters)
    readings = [dict(r) for piece in cut(data, where) for r in decoder.feed(piece)]
    assert counters.received_bytes == len(data)
    assert counters.readings == len(readings)
    return readings, counters


def finite(readings) -> bool:
    return all(math.isfinite(value) for reading in readings for value in reading.values())


WIT = b"".join(
    wit(0x51, s.a / 9.81, 16.0) + wit(0x52, s.g * 57.3, 2000.0) + wit(0x53, ypr(s), 180.0)
    for s in STATES[200:240]
)
TEAPOTS = b"".join(map(teapot, STATES[200:300]))


@given(st.binary(min_size=11, max_size=11) | st.integers(0, 10).map(lambda n: WIT[n * 11 :][:11]),
       st.integers(0, 10), st.integers(1, 255))  # fmt: skip
def test_a_witmotion_packet_is_accepted_by_its_sum_alone_and_one_wrong_byte_never(packet, at, by):
    right = packet[0] == 0x55 and packet[1] >> 4 == 5 and sum(packet[:10]) % 256 == packet[10]
    assert (wit_packet(packet) is not None) == right
    if right:
        wrong = packet[:at] + bytes([packet[at] ^ by]) + packet[at + 1 :]
        assert wit_packet(wrong) is None


@given(st.binary(min_size=14, max_size=14), st.integers(0, 99), st.sampled_from([0, 1, 10, 12, 13]),
       st.integers(1, 255))  # fmt: skip
def test_a_teapot_without_its_marks_or_of_another_length_is_never_accepted(noise, n, at, by):
    packet = teapot(STATES[n])
    assert teapot_packet(packet) is not None
    wrong = packet[:at] + bytes([packet[at] ^ by]) + packet[at + 1 :]
    assert teapot_packet(wrong) is None
    assert teapot_packet(packet[:2] + b"\x10\0" * 4 + packet[10:]) is None
    found = teapot_packet(noise)
    assert found is None or abs(math.hypot(*(found[name] for name in QUATERNION)) - 1.0) <= 0.02


@given(damages, places)
def test_damaged_witmotion_packets_give_only_readings_that_were_sent(harms, where):
    whole = [tuple(one.items()) for one in decoded(lambda c: WitDecoder(c, SIX), WIT, [])[0]]
    assert len(whole) == 40
    bytes_sent = [harm for harm in harms if harm[0] in ("drop", "repeat")]
    data = harm(WIT, bytes_sent)
    got, _ = decoded(lambda c: WitDecoder(c, SIX), data, where)
    assert got == decoded(lambda c: WitDecoder(c, SIX), data, [])[0]
    assert finite(decoded(lambda c: WitDecoder(c, SIX), harm(WIT, harms), where)[0])


@given(damages, places)
def test_damaged_teapot_packets_give_finite_readings_independent_of_the_split(harms, where):
    data = harm(TEAPOTS, harms)
    got, counters = decoded(TeapotDecoder, data, where)
    assert got == decoded(TeapotDecoder, data, [])[0]
    assert finite(got)
    assert harms or len(got) == 100 - counters.damaged == 100


LABELLED = "Acceleration X: 0.10, Y: -0.20, Z: 9.81 m/s^2\nRotation X: 1, Y: 2, Z: 3 rad/s\nT: 4\n"
ROUND = cycle_from_shapes(find_cycle(LABELLED.splitlines() * 3)[0])


@given(damages, places)
def test_damaged_labelled_lines_give_complete_finite_readings_independent_of_the_split(
    harms, where
):
    assert isinstance(ROUND, LineCycle)
    data = harm(("\n" + LABELLED * 30).encode(), harms)

    def make(counters):
        return LineDecoder(counters, LabelledReader(ROUND).parse)

    got, _ = decoded(make, data, where)
    assert got == decoded(make, data, [])[0]
    assert all(set(reading) == set(SIX) for reading in got)
    assert finite(got)
    assert harms or len(got) == 30


@given(st.text(alphabet="aAgGxXyYzZwq:=,. \t-#/0189e", max_size=60))
def test_every_line_has_a_shape_without_an_exception(line):
    shapes, _ = find_cycle([line] * 3)
    if shapes:
        found = cycle_from_shapes(shapes, "angles")
        if isinstance(found, LineCycle):
            reader = LabelledReader(found)
            readings = [reader.parse(line) for _ in range(3)]
            assert finite(one for one in readings if one)


anything = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4)
    | st.dictionaries(
        st.sampled_from(["buffer", "payload", "name", "time", "values", "accX", "accY", "accZ",
                         "x", "y", "z", "gyroscope", "totalacceleration"]), inner, max_size=5),
    max_leaves=20,
)  # fmt: skip


@given(anything, st.sampled_from(["buffer", "payload", ""]))
def test_any_json_gives_finite_readings_or_none(said, key):
    found = parse_app_batch(json.dumps({key: said} if key else said))
    assert isinstance(found, list | str | None)
    if isinstance(found, list):
        assert finite(found)


@given(damages, places, st.booleans())
def test_damaged_batches_give_finite_readings_independent_of_the_split(harms, where, phone):
    make = (lambda s: logger(s, ("gyroscope", "totalacceleration"))) if phone else phyphox
    data = harm(b"\n" + b"".join(map(make, STATES[1:8])), harms)
    got, _ = decoded(DetectedFormat("app").decoder, data, where)
    assert got == decoded(DetectedFormat("app").decoder, data, [])[0]
    assert finite(got)
    assert harms or len(got) == (14 if phone else 7)
