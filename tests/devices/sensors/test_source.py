"""A sensor as a whole: whatever comes, events stay sane and nothing is raised."""

from __future__ import annotations

import math
import sys
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.devices.sensors.stream import WRAP
from overview_dsp.devices.sensors.touch_detection import DiskState, TouchRules
from overview_dsp.installation import install_command
from tests.devices.sensors.encoding import encode_frame
from tests.devices.sensors.moving import course, fed, frames, hand, lines, turning
from tests.devices.sensors.streams import cut, damages, harm, places

RATE = 100.0
ROLL = course(RATE, (0, 0), (1.5, 0), (2.2, 150), (2.6, 150), (3.2, 0), (3.8, 0))


def sane(events):
    for event in events:
        assert math.isfinite(event.time_s)
        assert -1e-9 <= event.theta2 <= math.pi + 1e-9
    assert all(b.time_s >= a.time_s for a, b in pairwise(events))


def streams():
    acceleration, speed = turning(ROLL, RATE, noise=1.0)
    return {
        "frames": b"".join(frames(acceleration, speed, RATE)),
        "text": b"".join(lines(np.hstack([acceleration, speed]))),
        "gravity": b"".join(lines(acceleration)),
        "roll": b"".join(lines([[float(f"{math.degrees(roll) + 0.01:.2f}")] for roll in ROLL])),
    }


STREAMS = streams()


@given(st.sampled_from(sorted(STREAMS)), damages, places, st.sampled_from([0.0, 1e-4, 0.01, 1.0]))
def test_whatever_happens_to_a_stream_events_stay_sane(name, harms, where, apart_s):
    if name in ("frames", "text"):
        pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    data = harm(STREAMS[name], [(what, 37 * place, how) for what, place, how in harms])
    one = hand()
    events = []
    for n, piece in enumerate(cut(data, [37 * place for place in where])):
        events += one.feed(piece, n * apart_s)
    sane(events)
    assert one.counters.received_bytes == len(data)


@given(st.lists(st.binary(max_size=300), max_size=20))
def test_noise_raises_nothing_and_holds_nothing(pieces):
    one = hand()
    assert [event for n, piece in enumerate(pieces) for event in one.feed(piece, n * 0.1)] == []


NUMBERS = st.floats(-1e30, 1e30) | st.sampled_from([0.0, 1.0, 9.81, -9.81, 1e300, -1e300])


@given(
    st.sampled_from([("ax", "ay", "az"), ("t_s", "ax", "ay", "az"), ("t_us", "roll_deg"),
                     ("count",), ("pot",), ("t_ms", "touch", "pot"), ("touch",)]),
    st.lists(st.lists(NUMBERS, min_size=4, max_size=4), min_size=30, max_size=60),
    st.sampled_from([0.0, 1e-3, 0.04, 3.0]),
)  # fmt: skip
def test_any_numbers_make_sane_events(columns, rows, apart_s):
    one = hand(columns=columns)
    pieces = [b"\n", *lines([row[: len(columns)] for row in rows])]
    events = [event for n, piece in enumerate(pieces) for event in one.feed(piece, n * apart_s)]
    sane(events)
    assert all("\n" not in said for said in one.take_messages())


def test_where_a_clock_begins_changes_nothing_but_the_count_of_its_wraps():
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    moving = turning(ROLL, RATE, noise=1.0)
    early, late = hand(), hand()
    first, _ = fed(early, frames(*moving, RATE), RATE)
    second, _ = fed(late, frames(*moving, RATE, WRAP - 2_000_000), RATE)
    assert (early.counters.clock_wraps, late.counters.clock_wraps) == (0, 1)
    assert [event.touching for event in first] == [event.touching for event in second]
    apart = [abs(a.theta2 - b.theta2) for a, b in zip(first, second, strict=True)]
    assert max(apart) < 1e-6


def test_a_gyroscope_without_its_filter_plays_by_gravity_and_names_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "vqf", None)
    one = hand()
    events, turns = fed(one, frames(*turning(ROLL, RATE), RATE), RATE)
    (said,) = [word for word in one.take_messages() if "VQF" in word]
    assert install_command("sensors") in said
    assert "gravity alone" in said
    assert "\n" not in said
    other = hand(angular_velocity__use=False)
    same, others = fed(other, frames(*turning(ROLL, RATE), RATE), RATE)
    assert events == same
    assert turns[-1] == others[-1]
    assert any(event.touching for event in events)


def knob_frames(level, motions):
    """What a motor knob's own board sends: its state; hand, disk and stretch each 2 ms."""
    state = encode_frame(7, 0, 0, (8193, 4000, 257, 1, 1, 1, level, 0))
    return state + b"".join(
        encode_frame(6, n, 2000 * n, (round(1e6 * hand), round(1e6 * disk), 0, round(1e4 * bent)))
        for n, (hand, disk, bent) in enumerate(motions, 1)
    )


@pytest.mark.parametrize(("level", "theta2"), [(255, 0.7 + 0.1 + 2.0 * (0.7 - 0.65)), (0, 1.2)])
def test_the_disk_is_pulled_as_a_knobs_board_pulls_its_own(level, theta2):
    """Where it runs one; else by the hand's angle."""
    source = SensorSource(load_sensor("simplefoc"), TouchRules.of(ov.load_preset("football")))
    at_rest = [(0.0, 0.0, 0.0)] * 3
    events = []
    for n, frame in enumerate(
        knob_frames(level, at_rest + [(1.2, 0.7, 0.1)] * 400).split(b"\0")[:-1]
    ):
        events += source.feed(frame + b"\0", 0.002 * n, DiskState(None, 0.65))
    assert source.holding
    assert events[-1].theta2 == pytest.approx(theta2, abs=1e-4)


def test_a_motors_board_is_detected_as_frames_or_as_lines():
    rules = TouchRules.of(ov.load_preset("football"))
    for said, detected in (
        (b"# overview knob 1\r\n\0" + knob_frames(0, [(0.0, 0.0, 0.0)] * 2), "binary frames"),
        (b"12\t1.0\r\n0.0000\t1.0000\r\n0.0000\t1.0000\r\n", "lines of motor_target"),
    ):
        source = SensorSource(load_sensor("simplefoc"), rules)
        for n, byte in enumerate(said):
            source.feed(bytes((byte,)), 1e-4 * n)
        assert source.report()["format"].startswith(detected)
    source = SensorSource(load_sensor("simplefoc"), rules)
    for n in range(400):
        source.feed(b"\x80\x91noise", 0.01 * n)
    assert source.report()["format"] is None
    assert len(source.take_messages()) == 1


def test_events_are_at_most_a_thousand_a_second():
    one = hand(columns=("t_us", "pot"))
    pieces = [b"\n", *lines([[500 * n, min(1023, n)] for n in range(4000)])]
    events, _ = fed(one, pieces, 2000.0)
    steps = np.diff([event.time_s for event in events])
    assert len(events) > 1500
    assert steps.min() > 0.9e-3


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        ([180 / math.pi] * 3, "deg/s, not rad/s"),
        ([math.pi / 180] * 3, "rad/s, not deg/s"),
        ([-1.0, 1.0, 1.0], "axis or a sign"),
        ([1.0, 1.0, 1.0], None),
    ],
)
def test_a_gyroscope_that_disagrees_with_gravity_is_said_once(factor, said):
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    roll = course(RATE, (0, 0), (1.5, 0), (3, 170), (4.5, -100), (6, 80), (7.5, 0))
    acceleration, speed = turning(roll, RATE, noise=0.3)
    one = hand()
    fed(one, lines(np.hstack([acceleration, speed * factor])), RATE)
    complaints = [word for word in one.take_messages() if "gyroscope" in word]
    assert len(complaints) == (said is not None)
    assert all(said in word for word in complaints)
