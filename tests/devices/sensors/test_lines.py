from __future__ import annotations

import json
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from overview_dsp.devices.sensors.app_json import parse_json_line
from overview_dsp.devices.sensors.lines import (
    LONGEST,
    LineDecoder,
    LineSplitter,
    parse_header,
    parse_numbers,
    parse_row,
)
from overview_dsp.devices.sensors.reading import Counters
from tests.devices.sensors.streams import cut, damages, harm, places

AXES = ("ax", "ay", "az")
finite = st.floats(-1e6, 1e6)


def text(data: bytes, where: list[int] = ()) -> tuple[list[dict], Counters]:
    counters = Counters()
    decoder = LineDecoder(counters, lambda line: parse_row(line, AXES))
    return [dict(r) for piece in cut(data, where) for r in decoder.feed(piece)], counters


def as_json(data: bytes, where: list[int] = ()) -> tuple[list[dict], Counters]:
    counters = Counters()
    decoder = LineDecoder(counters, parse_json_line)
    return [dict(r) for piece in cut(data, where) for r in decoder.feed(piece)], counters


@given(st.lists(st.tuples(finite, finite, finite), max_size=10), places,
       st.sampled_from([",", "; ", "\t", "  "]), st.sampled_from(["\n", "\r\n", "\r"]))  # fmt: skip
def test_numbers_come_back_whatever_stands_between_and_however_split(rows, where, apart, end):
    lines = [apart.join(map(repr, row)) + end for row in rows]
    got, counters = text(("\n" + "".join(lines)).encode(), where)
    assert [tuple(reading.values()) for reading in got] == rows
    assert (counters.readings, counters.damaged) == (len(rows), 0)


@given(st.lists(st.tuples(finite, finite, finite), max_size=10), places)
def test_json_comes_back_however_split(rows, where):
    said = [{"t_us": 5, "acc": list(row), "battery": "full"} for row in rows]
    data = "\n" + "".join(json.dumps(one) + "\n" for one in said)
    got, counters = as_json(data.encode(), where)
    assert got == [dict(zip(("t_us", *AXES), (5.0, *row), strict=True)) for row in rows]
    assert counters.damaged == 0


@given(damages, places)
def test_whatever_happens_to_lines_what_comes_out_is_finite_and_counted(harms, where):
    data = harm(b"0.5,-0.25,9.81\r\n" * 30, harms)
    got, counters = text(data, where)
    assert (got, counters) == text(data)
    assert all(set(reading) == set(AXES) for reading in got)
    assert all(math.isfinite(value) for reading in got for value in reading.values())
    assert counters.readings == len(got)


@given(st.binary(max_size=400), places)
@example("5\N{DEGREE SIGN}".encode(), [])  # a sign is a word in a line, and longer
def test_noise_is_counted_and_raises_nothing(data, where):
    for read in (text, as_json):
        got, counters = read(b"\n" + data + b"\n", where)
        assert counters.received_bytes == len(data) + 2
        assert counters.noise_bytes <= len(data)
        assert (got, counters) == read(b"\n" + data + b"\n")


@pytest.mark.parametrize(
    "line", ["1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "1,2,1_0", "1,,2", "0x1,2,3", "1,2,3e999", "a"]
)
def test_a_line_of_another_form_is_damage(line):
    got, counters = text(f"\n{line}\n1,2,3\n".encode())
    assert len(got) == 1
    assert (counters.damaged, counters.noise_bytes) == (1, len(line))


@pytest.mark.parametrize(
    "line",
    ["[1]", "3", "{}", '{"other": 1}', '{"ax": "1"}', '{"ax": NaN}', '{"acc": [1, 2]}', "{" * 400,
     '{"ax": 1e999}', '{"ax": null}', '{"acc": 1}', '{"ax": ' + "9" * 400 + "}"],
)  # fmt: skip
def test_json_of_another_form_is_damage(line):
    assert parse_json_line(line) is None
    assert as_json(f"\n{line}\n".encode())[1].damaged == 1


def test_comments_empty_lines_and_a_header_are_no_damage():
    got, counters = text(b"boot\n# a sensor\n\n  \nax,ay,az\n1,2,3\n")
    assert len(got) == 1
    assert (counters.fragments, counters.damaged) == (1, 0)


def test_the_first_piece_may_be_half_a_line_and_is_not_read():
    assert text(b"1,2,3\n4,5,6\n")[0] == [dict(zip(AXES, (4.0, 5.0, 6.0), strict=True))]


def test_a_line_without_end_is_not_kept():
    counters = Counters()
    splitter = LineSplitter(counters)
    splitter.feed(b"\n")
    for _ in range(100):
        assert splitter.feed(b"1,2,3," * 100) == []
    assert len(splitter._splitter._pending) <= LONGEST + 1
    assert splitter.feed(b"\n1,2,3\n") == ["1,2,3"]
    assert (counters.damaged, counters.noise_bytes) == (1, 60_000)


def test_names_of_columns_are_a_header_and_numbers_are_not():
    assert parse_header("t_us, ax, ay, az") == ("t_us", "ax", "ay", "az")
    assert parse_header("ax,ax") is None
    assert parse_header("1,2") is None
    assert parse_numbers("ax,ay") is None
