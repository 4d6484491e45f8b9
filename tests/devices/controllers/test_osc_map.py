"""OSC as apps send it: lists of their messages, read, learned and played."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.controllers.control_map import (
    APPS,
    PHONE,
    OscControl,
    load_osc_map,
    parse_osc_map,
    write_map,
)
from overview_dsp.devices.controllers.control_messages import (
    AngleChanged,
    ScaleParameter,
    TouchEnded,
    TouchStarted,
)
from overview_dsp.devices.controllers.learning import DEVICE, OscLearner
from overview_dsp.devices.controllers.osc_messages import OscReader
from tests.devices.controllers.osc_bytes import message
from tests.devices.sensors.shapes import RATE, STATES, G


def read(reader, *datagrams, at=0.0):
    return [move for one in datagrams for move in reader.read(one, at)]


def phone(state):
    """Up in a phone's axes: x right, y up the screen, z out of it; 1 is gravity."""
    x, y, z = state.a / G
    return -y, x, z


def twisted(controls, make):
    """Theta2 (deg) at the end of a known twist of which `make` says each state; what is wrong."""
    reader = OscReader(controls=controls)
    moves = [m for s in STATES for m in reader.read(make(s), s.n / RATE)]
    return math.degrees(moves[-1].theta2), reader


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["Android", "iOS"])
@pytest.mark.parametrize(
    ("app", "address"),
    [("gyrosc", "/gyrosc/grav"), ("zigsim", "/ZIGSIM/anna/gravity"), ("zigsim", "/bo/gravity"),
     ("touchosc", "/accxyz")],
)  # fmt: skip
def test_a_phone_that_is_twisted_turns_the_disk(app, address, sign):
    def said(state):
        return message(address, *(float(sign * one) for one in phone(state)))

    theta2, reader = twisted(load_osc_map(app), said)
    assert theta2 == pytest.approx(20.0, abs=2.0)
    assert reader.counters.rejected == 0
    assert reader.counters.messages == len(STATES)
    assert any("face up" in said for said in reader.take_messages())


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_a_quaternion_turns_it_in_either_order(order):
    controls = (OscControl("*/quaternion", "quaternion", order=order),)

    def said(state):
        w, x, y, z = state.q
        return message("/a/quaternion", *((w, x, y, z) if order == "wxyz" else (x, y, z, w)))

    assert twisted(controls, said)[0] == pytest.approx(20.0, abs=1.0)


def test_of_three_angles_in_radians_the_one_that_is_turned_counts():
    controls = (OscControl("/gyrosc/gyro", "angles", scale=180.0 / math.pi),)

    def said(state):
        return message("/gyrosc/gyro", 0.01, math.radians(state.roll), 0.02)

    theta2, reader = twisted(controls, said)
    assert theta2 == pytest.approx(20.0, abs=1.0)
    assert any("angle 2 of three" in line for line in reader.take_messages())


def test_a_fader_is_the_timeline_and_a_button_holds_on():
    reader = OscReader(controls=load_osc_map("touchosc"))
    moves = read(
        reader,
        message("/1/push1", 0.0),
        message("/1/fader1", 0.25),
        message("/1/push1", 1.0),
        message("/3/fader1", 0.5),
        message("/1/push1", 0.0),
    )
    assert [type(move) for move in moves] == [TouchEnded, TouchStarted, TouchStarted, TouchEnded]
    assert moves[2].theta2 == pytest.approx(math.pi / 2)


def test_ends_values_and_parameters_are_as_the_list_says():
    controls = parse_osc_map(
        'schema = 1\n[[control]]\naddress = "/xy"\nto = "theta2"\nvalue = 2\nsends = [127, 0]\n'
        'low = 0.2\nhigh = 0.6\n[[control]]\naddress = "/vol"\nto = "tactor.gain_db"\n',
        "x.toml",
    )
    reader = OscReader(controls=controls)
    moves = read(reader, message("/xy", 5, 127), message("/xy", 5, 0), message("/vol", 0.75))
    assert moves[0].theta2 == pytest.approx(0.2 * math.pi)
    assert moves[1].theta2 == pytest.approx(0.6 * math.pi)
    assert moves[2] == ScaleParameter("tactor.gain_db", 0.75)
    assert read(reader, message("/xy", 5), message("/xy", "a", "b"), message("/vol", 2.0)) == [
        ScaleParameter("tactor.gain_db", 1.0)
    ]
    assert (reader.counters.rejected, reader.counters.clamped) == (2, 1)


def test_what_nobody_listens_to_is_counted_and_not_said():
    reader = OscReader(controls=load_osc_map("gyrosc"))
    others = [message(f"/gyrosc/{name}", 0.1, 0.2, 0.3) for name in ("accel", "rrate", "gyro")]
    assert read(reader, *(100 * others)) == []
    assert reader.counters.unknown == 300
    assert reader.take_messages() == ()


@given(
    st.sampled_from(["/accxyz", "/1/fader1", "/1/push1", "/q", "/a", "/r"]),
    st.lists(st.one_of(st.floats(width=32), st.integers(-(2**31), 2**31 - 1), st.booleans(),
                       st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=4)),
             max_size=6),
    st.integers(0, 5),
)  # fmt: skip
def test_no_values_break_it_and_every_angle_is_on_the_timeline(address, values, repeats):
    controls = (*APPS["touchosc"], OscControl("/q", "quaternion"), OscControl("/a", "angles"),
                OscControl("/r", "angular_velocity"))  # fmt: skip
    reader = OscReader(controls=controls)
    for n in range(repeats):
        for move in reader.read(message(address, *values), 0.6 * n):
            if isinstance(move, AngleChanged | TouchStarted):
                assert 0.0 <= move.theta2 <= math.pi
    assert reader.counters.messages + reader.counters.rejected == repeats


# --- the file -------------------------------------------------------------------------------------

WHOLE = """
schema = 1

[[control]]
address = "*/fader1"
to = "theta2"
sends = [0.0, 100.0]
low = 0.1

[[control]]
address = "/q"
to = "quaternion"
axes = ["y", "-x", "z"]
order = "wxyz"
"""


def test_a_list_is_written_as_it_is_read(tmp_path):
    controls = parse_osc_map(WHOLE, "my.toml")
    assert controls == (
        OscControl("*/fader1", sends=(0.0, 100.0), low=0.1),
        OscControl("/q", "quaternion", axes=PHONE, order="wxyz"),
    )
    path = tmp_path / "my.toml"
    path.write_text(write_map(controls))
    assert load_osc_map(path) == controls
    for app in APPS.values():
        assert parse_osc_map(write_map(app), "x") == app
    with pytest.raises(ov.InputError, match="gyrosc, zigsim, touchosc"):
        load_osc_map(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("schema = 1", "schema = 3", ("schema",)),
        ('"*/fader1"', '"fader1"', ("control 1", "begin with /")),
        ("[0.0, 100.0]", "[1.0, 1.0]", ("control 1", "different")),
        ("[0.0, 100.0]", "[1.0]", ("control 1", "two different numbers")),
        ("[0.0, 100.0]", "[nan, 1.0]", ("control 1", "different")),
        ("low = 0.1", "low = 2.0", ("0 to 1",)),
        ("low = 0.1", "value = 0", ("value", "1 to 64")),
        ("low = 0.1", "scale = 2.0", ("scale", "does not apply")),
        ('["y", "-x", "z"]', '["y", "y", "z"]', ("control 2", "not a rotation")),
        ('["y", "-x", "z"]', '["y"]', ("control 2", "three")),
        ('"wxyz"', '"zyx"', ("order", "xyzw or wxyz")),
        ('address = "/q"', 'adress = "/q"', ("adress", "address")),
        ('"/q"', '"*/fader1"', ("twice",)),
    ],
)
def test_a_list_that_is_wrong_is_an_error_of_one_line_that_says_where(before, after, words):
    assert before in WHOLE
    with pytest.raises(ov.InputError) as caught:
        parse_osc_map(WHOLE.replace(before, after, 1), "my.toml")
    assert str(caught.value).startswith("my.toml: ")
    for word in words:
        assert word in str(caught.value)


@given(st.text(max_size=80))
def test_any_text_is_read_or_gives_an_input_error(text):
    with contextlib.suppress(ov.InputError):
        parse_osc_map(text, "x")


# --- learning -------------------------------------------------------------------------------------


def learned(to, sent):
    """What is learned of (time, datagram)s, and when (s)."""
    learner = OscLearner(to)
    for at, data in sent:
        learner.read(data, at)
        found = learner.found(at)
        if found is not None:
            return found
    return None


def moved(address, values, others=()):
    """A value that goes so, ten a second, and then others' messages for two seconds."""
    sent = [(n / 10.0, message(address, *([0.5] if two else []), float(value)))
            for two in [bool(others)] for n, value in enumerate(values)]  # fmt: skip
    end = len(values) / 10.0
    return sent + [(end + n / 10.0, message("/accxyz", 0.01 * n, 0.0, 1.0)) for n in range(20)]


UP_AND_DOWN = [*(n / 20.0 for n in range(21)), *(n / 20.0 for n in range(20, -1, -1))]


def test_the_fader_that_is_moved_is_learned_with_its_ends():
    assert learned("theta2", moved("/1/fader3", UP_AND_DOWN)) == OscControl("/1/fader3")
    wide = [127.0 * one for one in UP_AND_DOWN]
    found = learned("tactor.gain_db", moved("/vol", wide))
    assert found == OscControl("/vol", "tactor.gain_db", 1, (0.0, 127.0))
    assert learned("theta2", moved("/xy", UP_AND_DOWN, others=(1,))) == OscControl("/xy", value=2)


def test_a_fader_is_learned_only_when_it_has_come_back():
    assert learned("theta2", moved("/1/fader3", UP_AND_DOWN[:21])) is None


def test_a_button_is_learned_when_it_is_pressed():
    sent = [(0.0, message("/f", 0.3)), (0.1, message("/b", 0.0)), (0.2, message("/b", 1.0))]
    assert learned("touch", sent) == OscControl("/b", "touch")


@pytest.mark.parametrize(
    ("address", "values", "what"),
    [("/gyrosc/grav", (0.1, 0.1, -1.0), "acceleration"), ("/x/gravity", (0.0, 0.0, 9.8),
      "acceleration"), ("/x/gravity", (0.0, 0.1, 0.1), None), ("/x/gravity", (0.0, 1.0), None),
     ("/x/gyro", (0.1, 0.1, 0.1), None), ("/x/quaternion", (1.0, 0.0, 0.0, 0.0), None)],
)  # fmt: skip
def test_a_phone_at_rest_is_learned_by_its_gravity_and_others_only_by_a_turn(address, values, what):
    sent = [(n / 10.0, message(address, *values)) for n in range(30)]
    found = learned(DEVICE, sent)
    assert (None if found is None else (found.address, found.to)) == (
        None if what is None else (address, what)
    )


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["/a", "/b/gravity", "/c"]),
            st.lists(st.one_of(st.floats(width=32), st.integers(-5, 5), st.booleans()), max_size=5),
        ),
        max_size=60,
    ),
    st.sampled_from(["theta2", "touch", DEVICE]),
    st.binary(max_size=30),
)
def test_what_is_learned_can_be_written(sent, to, noise):
    datagrams = [(n / 5.0, message(address, *values)) for n, (address, values) in enumerate(sent)]
    found = learned(to, [(0.0, noise), *datagrams, *((20.0 + n, noise) for n in range(3))])
    if found is not None:
        assert parse_osc_map(write_map((found,)), "x") == (found,)
