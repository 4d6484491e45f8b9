from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import overview_dsp as ov


def one_line(error: ov.InputError) -> None:
    assert "\n" not in str(error)


def same(one: ov.Gesture, other: ov.Gesture) -> bool:
    return one.duration_s == other.duration_s and all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("time_s", "theta2", "touching")
    )


@pytest.mark.parametrize(
    ("spec", "gesture"),
    [
        ("sweep:4", ov.sweep(4.0)),
        ("sweep:0.5:1:0", ov.sweep(0.5, 1.0, 0.0)),
        ("tap:0.8", ov.tap(0.8)),
        ("tap:0.8:1.5", ov.tap(0.8, 1.5)),
        ("arm:2", ov.arm(2.0)),
        ("arm:2:0.5", ov.arm(2.0, 0.5)),
        ("flick", ov.flick()),
        ("flick:0.15", ov.flick(0.15)),
        ("scrub:0.5:0.02:2", ov.scrub(0.5, 0.02, 2.0)),
        ("scrub:0.5:0.02:2:3", ov.scrub(0.5, 0.02, 2.0, 3.0)),
        ("rest:2", ov.pause(2.0)),
        ("sweep:1+rest:0.5+tap:1:0.2", ov.sweep(1.0) + ov.pause(0.5) + ov.tap(1.0, 0.2)),
        (" sweep:1 + tap:0.1 ", ov.sweep(1.0) + ov.tap(0.1)),
    ],
)
def test_a_spec_is_the_gesture_it_says(spec, gesture):
    assert same(ov.parse_gesture(spec), gesture)


def test_a_take_is_a_part_like_any_other(tmp_path):
    path = tmp_path / "take.csv"
    take = ov.sweep(0.1, 0.2, 0.4)
    ov.save_gesture(take, path)
    assert same(ov.parse_gesture(str(path)), take)
    assert same(ov.parse_gesture(f"tap:0.5:0.1+{path}"), ov.tap(0.5, 0.1) + take)


def test_a_take_may_have_any_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    take = ov.tap(0.5, 0.1)
    for name in ("a+b.csv", "sweep:1.csv", "tap.CSV", "ein Griff.csv"):
        ov.save_gesture(take, tmp_path / name)
        assert same(ov.parse_gesture(name), take)


@pytest.mark.parametrize(
    "spec",
    [
        *("", "+", "sweep:1+", "swoop:4", "sweep", "sweep:", "sweep:1:0.5", "sweep:1:2:3:4"),
        *("tap", "tap:a", "sweep:4s", "rest:1:2", "sweep:nan", "tap:inf", "sweep:0", "tap:2"),
        *("arm", "arm:1:2:3", "flick:1:2", "scrub:0.5", "scrub:0.5:0.02", "scrub:1:1:1:1:1"),
        *("tap:0.5:1:2", "take.txt", "x" * 5000, "tap:0.5;"),
    ],
)
def test_what_is_no_gesture_is_an_error_of_one_line_that_names_the_part(spec):
    with pytest.raises(ov.InputError) as error:
        ov.parse_gesture(spec)
    assert "\n" not in str(error.value)
    part = next((p for p in spec.split("+") if p not in ("", "sweep:1")), "")
    if part not in ("sweep:0", "tap:2"):
        assert repr(part) in str(error.value)
        assert "sweep:SECONDS" in str(error.value)


@pytest.mark.parametrize("spec", ["no.csv", "x" * 5000 + ".csv", "a\0b.csv", "rest:1+no.csv"])
def test_a_take_that_is_not_there_is_an_error_of_one_line(spec):
    with pytest.raises(ov.InputError, match="can't be read") as error:
        ov.parse_gesture(spec)
    assert "\n" not in str(error.value)


PIECES = st.one_of(
    st.sampled_from(["sweep", "tap", "arm", "flick", "scrub", "rest", ":", "+", ".", "-", " "]),
    st.sampled_from(["e", "_", "nan", "inf"]),
    st.sampled_from(["0", "0.5", "1", "2.5", "1e1", "1e999", "-1"]),
    st.text(max_size=3),
)


@given(st.lists(PIECES, max_size=12).map("".join))
def test_any_text_is_a_gesture_or_one_line(spec):
    assume(".csv" not in spec.lower())
    # long sweeps are right and slow
    assume(all(len(part) < 8 for part in spec.replace("+", ":").split(":")))
    try:
        gesture = ov.parse_gesture(spec)
    except ov.InputError as error:
        one_line(error)
    else:
        assert isinstance(gesture, ov.Gesture)


def test_many_parts_are_one_after_the_other_as_two_are():
    parts = [f"tap:0.{i % 7}:0.1" for i in range(5000)]
    whole = ov.parse_gesture("+".join(parts))
    one_by_one = ov.parse_gesture("+".join(parts[:20]))
    for part in parts[20:30]:
        one_by_one = one_by_one + ov.parse_gesture(part)
    count = len(one_by_one.time_s)
    assert np.array_equal(whole.time_s[:count], one_by_one.time_s)
    assert np.array_equal(whole.theta2[:count], one_by_one.theta2)
    assert np.array_equal(whole.touching[:count], one_by_one.touching)
    assert len(whole.time_s) == 10_000
