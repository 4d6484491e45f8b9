from __future__ import annotations

import math
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov

HEADER = "time_s,theta2_rad,touching\n"


def one_line(error: ov.InputError) -> None:
    assert "\n" not in str(error)


@st.composite
def gestures(draw: st.DrawFn) -> ov.Gesture:
    """Any hand's movement that ends with a release, with a rest after it or not."""
    count = draw(st.integers(1, 30))
    times = sorted(draw(st.lists(st.floats(0.0, 1e5), min_size=count, max_size=count)))
    theta2 = draw(st.lists(st.floats(0.0, math.pi), min_size=count, max_size=count))
    touching = [*draw(st.lists(st.booleans(), min_size=count - 1, max_size=count - 1)), False]
    rest = draw(st.one_of(st.just(0.0), st.floats(0.0, 10.0)))
    return ov.Gesture(np.array(times), np.array(theta2), np.array(touching), times[-1] + rest)


@given(gestures())
def test_a_take_comes_back_from_its_file_to_the_bit(tmp_path_factory, gesture):
    path = tmp_path_factory.getbasetemp() / "take.csv"
    ov.save_gesture(gesture, path)
    back = ov.load_gesture(path)
    count = len(gesture.time_s)
    for name in ("time_s", "theta2", "touching"):
        assert np.array_equal(getattr(back, name)[:count], getattr(gesture, name))
    assert back.duration_s == gesture.duration_s
    # a rest at the end is one more line, which changes nothing
    assert len(back.time_s) == count + (gesture.duration_s > gesture.time_s[-1])
    assert not back.touching[-1]


@pytest.mark.parametrize(
    "gesture", [ov.pause(2.0), ov.pause(0.0), ov.tap(0.5, 0.2) + ov.pause(1.0)]
)
def test_a_rest_keeps_its_length(gesture, tmp_path):
    ov.save_gesture(gesture, tmp_path / "take.csv")
    back = ov.load_gesture(tmp_path / "take.csv")
    assert back.duration_s == gesture.duration_s
    assert np.array_equal(back.touching[: len(gesture.touching)], gesture.touching)


def test_the_file_has_the_columns_of_the_contract(tmp_path):
    ov.save_gesture(ov.tap(0.0, 0.5), tmp_path / "take.csv")
    text = (tmp_path / "take.csv").read_bytes()
    assert text == b"time_s,theta2_rad,touching\n0.0,0.0,1\n0.5,0.0,0\n"


def load(tmp_path, text) -> ov.Gesture:
    path = tmp_path / "take.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return ov.load_gesture(path)


@pytest.mark.parametrize(
    "text",
    [
        HEADER + "0,0.5,1\n1,1.5,0\n",
        "\ufeff" + HEADER + "0,0.5,1\n1,1.5,0\n",
        (HEADER + "0,0.5,1\n1,1.5,0\n").replace("\n", "\r\n"),
        HEADER + "\n0,0.5,true\n  ,,\n1,1.5,FALSE",
        " touching , time_s,sample,theta2_rad\n1,0,0,0.5\n0,1,48000,1.5\n",
        '"time_s","theta2_rad","touching"\n"0","0.5","1"\n1e0,15e-1,0\n',
    ],
    ids=["plain", "bom", "windows", "blank lines", "more columns", "quoted"],
)
def test_a_take_is_read_however_it_was_written(text, tmp_path):
    gesture = load(tmp_path, text)
    assert gesture.time_s.tolist() == [0.0, 1.0]
    assert gesture.theta2.tolist() == [0.5, 1.5]
    assert gesture.touching.tolist() == [True, False]


def test_a_take_that_holds_on_ends_with_a_release(tmp_path):
    gesture = load(tmp_path, HEADER + "0,0.5,1\n1,1.5,1\n")
    assert gesture.touching.tolist() == [True, True, False]
    assert gesture.time_s.tolist() == [0.0, 1.0, 1.0]
    assert gesture.theta2.tolist() == [0.5, 1.5, 1.5]


def test_events_at_the_same_time_keep_their_order(tmp_path):
    gesture = load(tmp_path, HEADER + "0,0.5,1\n0,1.5,1\n0,0.25,0\n")
    assert gesture.theta2.tolist() == [0.5, 1.5, 0.25]


def test_pi_as_others_print_it_is_pi(tmp_path):
    gesture = load(tmp_path, HEADER + "0,-1e-10,1\n0,3.1415926536,0\n")
    assert gesture.theta2.tolist() == [0.0, math.pi]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", None, "empty"),
        ("\n\n", 1, "no column"),
        ("time,theta2_rad,touching\n", 1, "no column time_s"),
        (HEADER, None, "no events"),
        (HEADER + "0,soon,1\n", 2, "theta2_rad = 'soon' is not a number"),
        (HEADER + "0,0.5,1\nnan,0.5,1\n", 3, "time_s = nan is not finite"),
        (HEADER + "0,inf,1\n", 2, "theta2_rad = inf is not finite"),
        (HEADER + "0,0.5,maybe\n", 2, "touching = 'maybe'; must be 0 or 1"),
        (HEADER + "0,0.5,2\n", 2, "must be 0 or 1"),
        (HEADER + "-1,0.5,1\n", 2, "negative"),
        (HEADER + "2,0.5,1\n\n1,0.5,1\n", 4, "time_s goes back, 1 after 2"),
        (HEADER + "0,3.2,1\n", 2, "theta2_rad = 3.2 is out of range; allowed: 0 to pi"),
        (HEADER + "0,-0.1,1\n", 2, "out of range"),
        (HEADER + "1e300,0.5,1\n", 2, "0 to 604800"),
        (HEADER + "0,0.5\n", 2, "2 cells; the header needs 3"),
        (HEADER + '0,0.5,"' + "x" * 200_000, 2, "not CSV"),
        ('"' + "x" * 200_000, 1, "not CSV"),
        (HEADER + "0," + "9" * 100_000 + "x,1\n", 2, "not a number"),
        (b"\xff\xfe\x00", None, "UTF-8"),
        (HEADER.encode() + b"0,0.5,1\n\xe9", None, "UTF-8"),
    ],
)
def test_a_bad_take_is_an_error_of_one_line_that_names_file_and_line(text, line, words, tmp_path):
    with pytest.raises(ov.InputError) as error:
        load(tmp_path, text)
    message = str(error.value)
    assert "\n" not in message
    assert len(message) < 500 + len(str(tmp_path))
    place = f"{tmp_path / 'take.csv'}:" + (f"{line}:" if line else "")
    assert message.startswith(place)
    assert words in message


@given(
    st.one_of(
        st.binary(max_size=300),
        st.text(max_size=100).map(lambda text: (HEADER + text).encode(errors="replace")),
        st.lists(st.tuples(st.floats(), st.floats(), st.integers(0, 1))).map(
            lambda rows: (HEADER + "".join(f"{a},{b},{c}\n" for a, b, c in rows)).encode()
        ),
    )
)
def test_any_bytes_are_a_gesture_that_lets_go_or_one_line(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(data)
    try:
        gesture = ov.load_gesture(path)
    except ov.InputError as error:
        one_line(error)
    else:
        assert not gesture.touching[-1]


def test_a_missing_take_and_a_folder_are_one_line(tmp_path):
    for path in (tmp_path, tmp_path / "no.csv", "a\0b", "x" * 5000):
        with pytest.raises(ov.InputError) as error:
            ov.load_gesture(path)
        assert "\n" not in str(error.value)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_instead_of_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(ov.InputError, match=r"pipe\.csv: is not a file"):
        ov.load_gesture(tmp_path / "pipe.csv")


def test_a_take_goes_into_no_folder_that_is_not_there(tmp_path):
    with pytest.raises(ov.InputError, match=r"take\.csv: can't be written"):
        ov.save_gesture(ov.tap(0.5), tmp_path / "no" / "take.csv")
    assert list(tmp_path.iterdir()) == []


def test_an_angle_that_was_rounded_to_six_decimals_is_the_end_it_was(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("time_s,theta2_rad,touching\n0,3.141593,1\n1,-0.000001,0\n")
    assert ov.load_gesture(path).theta2.tolist() == [math.pi, 0.0]
    path.write_text("time_s,theta2_rad,touching\n0,3.1417,1\n")
    with pytest.raises(ov.InputError, match="out of range"):
        ov.load_gesture(path)
