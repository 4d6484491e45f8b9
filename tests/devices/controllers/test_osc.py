"""OSC, byte by byte; the bytes are made here, by the specification (OSC 1.0)."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.timeline.event import Event
from overview_dsp.devices.controllers.control_messages import (
    AngleChanged,
    SetParameter,
    TouchEnded,
    TouchStarted,
)
from overview_dsp.devices.controllers.osc_messages import (
    OscReader,
    OscReport,
    encode_message,
    require_osc,
)
from tests.devices.controllers.osc_bytes import bundle, message


def read(reader, *datagrams):
    return [move for one in datagrams for move in reader.read(one, 0.0)]


def test_a_message_is_the_specifications_bytes():
    assert message("/oscillator/4/frequency", 440.0) == bytes.fromhex(
        "2f6f7363696c6c61746f722f342f6672657175656e6379002c66000043dc0000"
    )
    assert encode_message("/oscillator/4/frequency", [440.0]) == message(
        "/oscillator/4/frequency", 440.0
    )


def test_an_angle_alone_is_turned():
    reader = OscReader()
    moves = read(reader, message("/overview/theta2", 1.5), message("/overview/theta2", 2))
    assert moves == [AngleChanged("theta2", 1.5), AngleChanged("theta2", 2.0)]
    assert reader.counters.messages == 2


class Sent(bytes):
    sender = ""


def sent(sender, *words):
    one = Sent(message(*words))
    one.sender = sender
    return one


def test_a_silent_sender_no_longer_touches_while_another_still_does():
    """A client that has crashed must not get the disk back when another one releases it."""
    reader = OscReader()
    for time_s in (0.0, 0.1):
        reader.read(sent("10.0.0.1:1", "/overview/theta2", 1.0, 1), time_s)
    for time_s in (1.0, 2.0, 3.0, 4.0, 5.0):
        reader.read(sent("10.0.0.2:1", "/overview/theta2", 2.0, 1), time_s)
        assert reader.tick(time_s) == []
    assert reader.tick(5.2) == [TouchEnded("theta2 10.0.0.1:1")]
    assert reader.take_messages() == ("10.0.0.1:1: no messages for 5 s; its touch has ended",)
    assert reader.tick(5.3) == []
    reader.read(sent("10.0.0.1:1", "/overview/theta2", 1.1), 6.0)
    (began,) = reader.read(sent("10.0.0.1:1", "/overview/theta2", 1.1, 1), 6.0)
    assert began == TouchStarted("theta2 10.0.0.1:1", pytest.approx(1.1))


def test_any_number_of_senders_is_survived_and_each_touch_ends():
    reader = OscReader()
    held = set()
    for number in range(400):
        address = f"10.0.{number // 200}.{number % 200}:9"
        for words in (
            ("/overview/theta2", 1.0, 1),
            ("/overview/theta2", 1.1),
            ("/overview/touch", 0),
        ):
            for move in reader.read(sent(address, *words), 0.01 * number):
                if isinstance(move, TouchStarted):
                    held.add(move.touch_id)
                else:
                    held.discard(move.touch_id)
        assert not held


def test_once_a_touch_was_said_it_decides_alone():
    reader = OscReader()
    moves = read(
        reader,
        message("/overview/touch", 0),
        message("/overview/theta2", 1.5),
        message("/overview/touch", True),
        message("/overview/theta2", 2.0),
        message("/overview/touch", 1.0),
        message("/overview/touch", False),
        message("/overview/touch", 0),
        message("/overview/theta2", 2.5),
    )
    assert moves == [
        TouchEnded("theta2"),
        TouchStarted("theta2", 1.5),
        TouchStarted("theta2", 2.0),
        TouchEnded("theta2"),
    ]


def test_an_angle_and_a_touch_in_one_are_a_step_there():
    reader = OscReader()
    moves = read(
        reader,
        message("/overview/theta2", 0.5),
        message("/overview/theta2", 2.0, 1),
        message("/overview/theta2", 2.5, 1),
        message("/overview/theta2", 2.6, 0),
        message("/overview/theta2", 1.0, 1),
    )
    assert moves[1:] == [
        TouchStarted("theta2", 2.0),
        TouchStarted("theta2", 2.5),
        TouchEnded("theta2"),
        TouchStarted("theta2", 1.0),
    ]


def test_a_bundle_is_its_messages_whenever_they_are_due():
    reader = OscReader()
    inner = bundle(message("/overview/theta2", 1.0), seconds=2_085_900_000)
    moves = read(reader, bundle(inner, message("/overview/tactor/gain_db", -6.0)))
    assert set(moves) == {SetParameter("tactor.gain_db", -6.0), AngleChanged("theta2", 1.0)}
    assert reader.counters.messages == 2


def test_a_parameter_is_asked_for_by_its_id_with_dots_or_strokes():
    reader = OscReader()
    assert read(
        reader,
        message("/overview/tactor.gain_db", -6),
        message("/overview/kinds/goal/height", 20.0),
        message("/overview/disk/release", "return"),
    ) == [
        SetParameter("tactor.gain_db", -6),
        SetParameter("kinds.goal.height", 20.0),
        SetParameter("disk.release", "return"),
    ]


@pytest.mark.parametrize(
    ("datagram", "word"),
    [
        (message("/overview/theta2", math.nan), "nan"),
        (message("/overview/theta2", math.inf), "inf"),
        (message("/overview/theta2", "up"), "number"),
        (message("/overview/theta2", True), "number"),
        (message("/overview/theta2"), "angle"),
        (message("/overview/theta2", 1.0, 2), "0 or 1"),
        (message("/overview/touch", 0.5), "0 or 1"),
        (message("/overview/touch"), "one value"),
        (message("/overview/tactor/gain_db", 1.0, 2.0), "one value"),
        (b"", "not OSC"),
        (b"GET / HTTP/1.1", "not OSC"),
        (b"/overview/theta2\0\0\0\0,f\0\0\x3f", "not OSC"),
    ],
)
def test_what_can_not_be_is_counted_and_the_first_one_said(datagram, word):
    reader = OscReader()
    assert read(reader, datagram, datagram) == []
    assert reader.counters.rejected == 2
    (line,) = reader.take_messages()
    assert word in line
    assert "\n" not in line
    assert reader.take_messages() == ()


def test_beyond_an_end_is_the_end_and_that_is_said_once():
    reader = OscReader()
    assert read(reader, message("/overview/theta2", math.pi)) == [AngleChanged("theta2", math.pi)]
    assert (reader.counters.clamped, reader.take_messages()) == (0, ())
    assert read(reader, message("/overview/theta2", 4.0), message("/overview/theta2", -1.0)) == [
        AngleChanged("theta2", math.pi), AngleChanged("theta2", 0.0)
    ]  # fmt: skip
    assert reader.counters.clamped == 2
    assert len(reader.take_messages()) == 1


def test_other_programs_addresses_are_left_alone():
    reader = OscReader()
    assert read(reader, message("/1/fader1", 0.5)) == []
    assert reader.counters.unknown == 1
    assert reader.take_messages() == ()


@given(st.binary(max_size=200))
def test_no_bytes_break_the_reader(data):
    read(OscReader(), data)


@given(
    st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), min_size=1, max_size=5),
    st.integers(0, 80),
)
def test_no_damage_breaks_the_reader(changes, cut):
    whole = bundle(bundle(message("/overview/theta2", 1.0, 1)), message("/overview/a/b", "text", 3))
    data = bytearray(whole[: max(1, len(whole) - cut)])
    for at, byte in changes:
        data[at % len(data)] = byte
    for move in read(OscReader(), bytes(data)):
        if isinstance(move, AngleChanged | TouchStarted):
            assert 0.0 <= move.theta2 <= math.pi


def test_bundles_in_bundles_without_end_break_nothing():
    data = message("/overview/theta2", 1.0)
    for _ in range(2000):
        data = b"#bundle\0" + bytes(8) + struct.pack(">i", len(data)) + data
    reader = OscReader()
    read(reader, data)
    assert reader.counters.rejected == 1


def test_a_type_nobody_knows_writes_nothing_to_the_terminal(capfd):
    require_osc()
    read(OscReader(), b"/overview/theta2\0\0\0\0,?f\0" + struct.pack(">f", 1.0))
    assert capfd.readouterr().err == ""


def test_the_report_says_what_is_new_and_now_and_then_that_it_is_there():
    report = OscReport()
    first = report.messages(0.0, 0.25, 0.001, True, [])
    assert first == [
        message("/overview/cursor", 0.25),
        message("/overview/torque", 0.001),
        message("/overview/touching", 1),
    ]
    assert report.messages(0.1, 0.25, 0.001, True, []) == []
    assert report.messages(0.2, 0.5, 0.001, True, [])[0] == message("/overview/cursor", 0.5)
    assert len(report.messages(0.8, 0.5, 0.001, True, [])) == 3
    lost = ("output lost", "system disconnected", "output lost: system disconnected")
    changed = report.messages(0.805, 0.5, 0.001, True, [], lost)
    assert changed[-1] == message("/overview/state", *lost)
    assert report.messages(0.806, 0.5, 0.001, True, [], lost) == []
    report.messages(0.807, 0.5, 0.001, True, [])
    goal = Event(5340.0, "goal", "1-0 Müller")
    assert report.messages(0.81, 0.5, 0.001, True, [(goal, 0.5)]) == [
        message("/overview/event", "goal", "1-0 Müller", 5340.0, 0.5)
    ]
