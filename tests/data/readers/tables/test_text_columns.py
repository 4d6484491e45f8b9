"""Columns of text that are read at once give what is read cell by cell."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers.tables.cells import NumberColumn
from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.readers.tables.text_cells import PAD, TextCells, padded
from overview_dsp.data.readers.tables.time_column import Format, TimeColumn
from overview_dsp.errors import InputError

MANY = settings(max_examples=60, deadline=None)


def cells_of(texts: list[str]) -> TextCells:
    cells = TextCells.of(texts)
    assert cells is not None
    return cells


def locate(i: int) -> CellLocation:
    return CellLocation(i, "cells")


def times(form: str, parts: list[Any], column: bool) -> tuple[Any, ...]:
    """The seconds of consecutive chunks, anchor and offset, or the error."""
    time = TimeColumn(Format(form))
    read = time.seconds if column else lambda cells, where: one_by_one(time, cells)
    found: list[float] = []
    try:
        for part in parts:
            found += read(cells_of(part) if column else part, locate).tolist()
    except InputError as error:
        return (str(error),)
    return found, time.anchor_ns, time.offset_min


def one_by_one(time: TimeColumn, cells: list[str]) -> np.ndarray[Any, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time, "_dates", lambda cells: None)
        patch.setattr(time, "_numbers", lambda cells: None)
        return TimeColumn.seconds(time, cells, locate)


def assert_same(columns: tuple[Any, ...], cells: tuple[Any, ...]) -> None:
    """Equal; a difference of more than 2**53 units of the column may be rounded twice."""
    if len(columns) == 1 or len(cells) == 1:
        assert columns == cells
        return
    assert columns[1:] == cells[1:]
    assert columns[0] == pytest.approx(cells[0], rel=1e-15, abs=0.0, nan_ok=True)


FORMS = {
    "iso": ("%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M", "%Y/%m/%d", "%Y%m%d%H%M", "%Y%m%dT%H%M%S.%f",
            "%Y-%m-%dT%H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.5", "%Y-%m-%d %I:%M %p", "%Y-%m-%d 24:00",
            "%Y-%m-%dT%H:%M:%S.%f123", "%Y-%m-%d %H:60", "%Y-%m-31", "%Y-%m-30 %H:%M", "%Y"),
    "dmy": ("%d.%m.%Y %H:%M", "%d/%m/%Y", "%d-%m-%y", "%d.%m.%Y, %I:%M:%S %p", "31.%m.%Y"),
    "mdy": ("%m/%d/%Y %H:%M", "%m/%d/%Y", "%m-%d-%y", "%m/%d/%Y %I:%M %p", "2/29/%Y"),
    "month names": ("%d %b %Y %H:%M", "%d-%b-%y", "%b %d, %Y", "%a, %d %b %Y %H:%M:%S", "%B %Y",
                    "%Y-%b-%d", "31 %b %Y"),
    "quarters, months or weeks": ("%YQ1", "Q4 %Y", "%Y-M%m", "%Y-W05", "%YQ7"),
    "yyyymm": ("%Y%m",),
}  # fmt: skip
ZONES = st.sampled_from(["", "Z", "+02:00", "+01:00", "-0530", " GMT", " CEST", "+0260", "+25"])
ODD = st.sampled_from(["", "n/a", " 2012-01-01 ", "2012-1-9", "9.1.2012 7:05", "x", "20120919.0"])


@st.composite
def dates(draw: st.DrawFn, form: str) -> list[list[str]]:
    moment = st.datetimes(datetime(1000, 1, 1), datetime(9999, 12, 1)) | st.datetimes(
        datetime(2011, 12, 1), datetime(2012, 3, 3)
    )
    ways = draw(st.lists(st.sampled_from(FORMS[form]), min_size=1, max_size=3))
    zones = draw(st.lists(ZONES, min_size=1, max_size=2))
    one = st.builds(
        lambda when, way, zone: when.strftime(way) + (zone if "%H" in way else ""),
        moment, st.sampled_from(ways), st.sampled_from(zones),
    )  # fmt: skip
    rows = draw(st.lists(one, min_size=1, max_size=12))
    if draw(st.integers(0, 4)) == 0:
        rows.insert(draw(st.integers(0, len(rows))), draw(ODD))
    cut = draw(st.integers(0, len(rows)))
    return [part for part in (rows[:cut], rows[cut:]) if part]


@pytest.mark.parametrize("form", FORMS)
@MANY
@given(data=st.data())
def test_dates_are_the_same_by_columns_and_by_cells(form: str, data: st.DataObject) -> None:
    parts = data.draw(dates(form))
    assert_same(times(form, parts, True), times(form, parts, False))


@st.composite
def consecutive(draw: st.DrawFn, form: str) -> list[list[str]]:
    """Times in even steps, which share a day or begin another, in one way of writing."""
    first = draw(st.datetimes(datetime(1000, 1, 1), datetime(9990, 1, 1)))
    step = draw(st.sampled_from([0, 1, 60, 7200, 43_200, 86_400, -600, 10_000_000]))
    way = draw(st.sampled_from(FORMS[form])) + draw(ZONES)
    count = draw(st.integers(1, 40))
    rows = [(first + i * timedelta(seconds=step)).strftime(way) for i in range(count)]
    for _ in range(draw(st.integers(0, 2))):  # a wrong digit, an empty cell
        at, place = draw(st.integers(0, count - 1)), draw(st.integers(0, 30))
        other = draw(st.sampled_from(["0", "9", "x", ""]))
        rows[at] = rows[at][:place] + other + rows[at][place + 1 :] if other else ""
    return [rows]


@pytest.mark.parametrize("form", FORMS)
@MANY
@given(data=st.data())
def test_dates_of_the_same_days_are_the_same_by_columns_and_by_cells(
    form: str, data: st.DataObject
) -> None:
    parts = data.draw(consecutive(form))
    assert_same(times(form, parts, True), times(form, parts, False))


def test_whole_times_after_a_fraction_are_the_same_by_columns_and_by_cells() -> None:
    for parts in ([["-.01"], ["0"]], [["1600000000000.25"], ["1600000000001", "1600000000002"]]):
        assert times("epoch_ms", parts, True) == times("epoch_ms", parts, False)


NUMBERS = (
    st.text("0123456789.,-+e ", max_size=19)
    | st.floats(allow_nan=False).map(repr)
    | st.integers(-(10**17), 10**17).map(str)
    | st.decimals(-(10**6), 10**6, places=3).map(str)
    | st.sampled_from(["", "n/a", "-", "5 kg", "3 lb", "$4", "1,234.5", "-0", "1e400", "9" * 41])
)


@pytest.mark.parametrize("form", ["s", "ms", "h", "epoch", "epoch_ms", "epoch_ns"])
@MANY
@given(
    parts=st.lists(
        st.lists(st.integers(0, 10**16).map(str) | NUMBERS, min_size=1, max_size=5), max_size=2
    )
)
def test_times_in_numbers_are_the_same_by_columns_and_by_cells(
    form: str, parts: list[list[str]]
) -> None:
    assert_same(times(form, parts, True), times(form, parts, False))


@pytest.mark.parametrize("mark", [".", ","])
@MANY
@given(parts=st.lists(st.lists(NUMBERS, max_size=6), max_size=3))
def test_numbers_are_the_same_by_columns_and_by_cells(mark: str, parts: list[list[str]]) -> None:
    def read(column: bool) -> tuple[Any, ...]:
        numbers = NumberColumn(mark)
        found: list[float] = []
        try:
            for part in parts:
                if column:
                    found += numbers.values(cells_of(part), locate).tolist()
                    continue
                found += [numbers._one(cell, i, locate) for i, cell in enumerate(part)]
                for i, value in enumerate(found[len(found) - len(part) :]):
                    if abs(value) > 1e300:
                        numbers.values(np.array([value]), lambda _, i=i: locate(i))
        except InputError as error:
            return (str(error),)
        return list(map(repr, found)), numbers.unit

    assert read(True) == read(False)


@given(texts=st.lists(st.text("ab0 ,;", max_size=9), max_size=9))
def test_cells_are_a_sequence_of_their_texts(texts: list[str]) -> None:
    cells = cells_of(texts)
    assert list(cells) == texts
    assert [cells[i] for i in range(len(cells))] == texts
    assert cells[1:3].tolist() == texts[1:3]
    assert cells[list(range(0, len(texts), 2))].tolist() == texts[::2]


def test_a_cell_at_the_end_of_the_buffer_is_read() -> None:
    data = padded(b"1234567890123456")
    cells = TextCells(data, np.array([PAD, PAD + 15]), np.array([PAD + 16, PAD + 16]))
    assert cells.wholes()[0].tolist() == [1234567890123456, 6]
    assert TextCells.of(["1", None]) is None
    assert TextCells.of(["é"]) is None
    assert TextCells.of(["a\nb"]) is None


def test_days_of_many_centuries_are_apart_by_their_days() -> None:
    days = np.array(["0001-01-01", "9999-12-31"], "datetime64[D]")
    seconds = TimeColumn(Format("iso")).seconds(days, locate)
    assert seconds.tolist() == [0.0, 3652058 * 86_400.0]


@pytest.mark.parametrize("length", [1, 4, 7, 8, 15, 16, 23])
def test_texts_of_one_length_are_read_as_those_of_any(length: int) -> None:
    texts = [(str(1 + i % 9) + str(i % 10) * length)[:length] for i in range(40)]
    even = cells_of(texts)
    uneven = cells_of([text for i, cell in enumerate(texts) for text in (cell, "y" * (i % 3))])[::2]
    texts[7] = texts[7][:-1] + "x"
    assert even.like_first(np.arange(40)).all()
    assert uneven.like_first(np.arange(40)).all()
    assert np.flatnonzero(~cells_of(texts).like_first(np.arange(40))).tolist() == [7]
    for begin in range(max(length - 18, 0), length):
        numbers = [cells.number(begin, length) for cells in (even, uneven)]
        assert np.array_equal(*numbers)
        assert np.array_equal(numbers[0], [int(text[begin:]) for text in even])


@pytest.mark.parametrize("texts", [["1234", "12", "123456", "5"], ["7", "1", "23", "", "4"]])
def test_texts_whose_first_and_last_steps_agree_are_read_in_their_own_places(
    texts: list[str],
) -> None:
    found, good = cells_of(texts).wholes()
    assert [n for n, is_number in zip(found.tolist(), good.tolist(), strict=True) if is_number] == [
        int(text) for text in texts if text
    ]
    assert cells_of(["12:34", "1:2", "12:3456", "5:67"]).like_first(np.arange(4)).tolist() == [
        True, False, False, False
    ]  # fmt: skip


def test_only_digits_may_differ_from_the_first_text() -> None:
    letters = [chr(code) for code in range(128) if chr(code) != "\n"]
    for first, at in (("12:34:56.789", 8), ("12:34:56.789", 4), ("2012-01-01T10", 10)):
        cells = cells_of([first, *(first[:at] + letter + first[at + 1 :] for letter in letters)])
        alike = [
            letter.isdigit() if first[at].isdigit() else letter == first[at] for letter in letters
        ]
        assert cells.like_first(np.arange(len(cells))).tolist() == [True, *alike]
