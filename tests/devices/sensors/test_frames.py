from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.devices.sensors import frames as cobs
from overview_dsp.devices.sensors.frames import (
    FRAME,
    FrameDecoder,
    crc16,
    decode_frame,
)
from overview_dsp.devices.sensors.reading import Counters
from tests.devices.sensors.encoding import encode_frame
from tests.devices.sensors.streams import (
    cut,
    damages,
    flip,
    frame_arguments,
    frame_stream,
    harm,
    places,
)

LONG_BURST = 16


def decoded(*pieces: bytes) -> tuple[list[dict], Counters]:
    counters = Counters()
    decoder = FrameDecoder(counters)
    return [dict(reading) for piece in pieces for reading in decoder.feed(piece)], counters


def test_the_check_is_that_of_hdlc():
    assert crc16(b"123456789") == 0x906E


@pytest.mark.parametrize(
    ("data", "encoded"),
    [
        (b"", b"\x01"),
        (b"\0", b"\x01\x01"),
        (b"\x11\x22\0\x33", b"\x03\x11\x22\x02\x33"),
        (b"\x11\0\0\0", b"\x02\x11\x01\x01\x01"),
    ],
)
def test_zeros_are_stuffed_as_published(data, encoded):
    assert cobs.encode(data) == encoded
    assert cobs.decode(encoded) == data


@given(st.binary(max_size=cobs.LONGEST))
def test_stuffing_leaves_no_zero_and_comes_back(data):
    assert 0 not in cobs.encode(data)
    assert cobs.decode(cobs.encode(data)) == data


@given(st.binary(max_size=60))
def test_any_bytes_unstuff_or_are_refused(data):
    found = cobs.decode(data)
    assert found is None or cobs.encode(found) == data


@given(frame_arguments())
def test_a_frame_comes_back_whole(arguments):
    kind, sequence, stamp, values = arguments
    frame = encode_frame(kind, sequence, stamp, values)
    assert len(frame) == FRAME + 1
    assert frame.index(0) == FRAME
    reading = decode_frame(frame[:-1])
    assert (reading["sequence"], reading["t_us"]) == (sequence, stamp)
    units = {3: (1e-3,), 6: (1e-6, 1e-6, 1e-5, 1e-4)}.get(kind, (1.0,) * 8)
    sent = [value * unit for value, unit in zip(values, units, strict=False)]
    assert list(reading.values())[2:] == pytest.approx(sent, abs=1e-9)


@given(st.integers(0, 12), places)
def test_however_a_stream_is_split_the_readings_are_the_same(count, where):
    data = b"".join(frame_stream(count))
    assert decoded(*cut(data, where)) == decoded(data)
    assert decoded(data)[1] == Counters(received_bytes=len(data), readings=count)


def test_no_burst_of_up_to_16_bits_is_taken_for_a_sample():
    """Every place in three frames, their ends included; every shape for one place of each kind."""
    frames = frame_stream(3, start=300)
    data = b"".join(frames)
    sent = decoded(data)[0]
    shapes = [1, 3, (1 << LONG_BURST) - 1, 0x8001, *random.Random(5).sample(range(1, 65536, 2), 60)]
    for first in range(8 * len(data) - LONG_BURST):
        for shape in shapes:
            got = decoded(flip(data, first, shape))[0]
            assert all(reading in sent for reading in got), (first, shape)
            assert len(got) < len(sent), (first, shape)
    whole = frames[1]
    for first in (0, 5, 83, 158, 8 * FRAME - LONG_BURST):
        for shape in range(1, 1 << LONG_BURST, 2):
            assert decode_frame(flip(whole[:-1], first, shape)) is None


@given(damages, places)
def test_whatever_happens_to_a_stream_only_sent_frames_come_out(harms, where):
    frames = frame_stream(12)
    sent = [decode_frame(frame[:-1]) for frame in frames]
    data = harm(b"".join(frames), harms)
    got, counters = decoded(*cut(data, where))
    assert all(reading in sent for reading in got)
    assert counters.received_bytes == len(data)
    assert counters.readings == len(got)


@given(damages)
def test_after_the_last_damage_at_most_one_frame_is_lost(harms):
    before, after = frame_stream(6), frame_stream(4, start=100)
    got, _ = decoded(harm(b"".join(before), harms) + b"".join(after))
    sent = [decode_frame(frame[:-1]) for frame in after]
    assert got[-3:] == sent[1:]


def test_listening_in_the_middle_of_a_frame_is_no_damage():
    first, second = frame_stream(2)
    got, counters = decoded(first[9:] + second)
    assert len(got) == 1
    assert (counters.fragments, counters.damaged) == (1, 0)


def test_endless_noise_is_counted_and_not_kept():
    counters = Counters()
    decoder = FrameDecoder(counters)
    decoder.feed(b"\0")
    for _ in range(1000):
        assert decoder.feed(b"\xaa" * 1000) == []
    assert len(decoder._splitter._pending) <= FRAME + 1
    decoder.feed(b"\0")
    assert (counters.damaged, counters.noise_bytes) == (1, 1_000_000)
