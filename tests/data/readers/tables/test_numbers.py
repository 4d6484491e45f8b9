"""Numbers as tables write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.tables.cells import detect_decimal_mark, looks_numeric, parse
from overview_dsp.errors import InputError
from tests.data.readers.tables.made import load, values


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("12", 12.0, ""),
        ("300 K", 300.0, "K"),
        ("512 B", 512.0, "B"),
        ("300K", 300_000.0, ""),
        ("$3 B", 3e9, "$"),
        ("(5)", -5.0, ""),
        ("-0.5", -0.5, ""),
        ("+.5", 0.5, ""),
        ("5.", 5.0, ""),
        ("1e-3", 0.001, ""),
        ("1,234.5", 1234.5, ""),
        ("1,234,567", 1_234_567.0, ""),
        ("12,34,567", 1_234_567.0, ""),
        ("1 234", 1234.0, ""),
        ("1\u202f234.5", 1234.5, ""),
        ("1'234", 1234.0, ""),
        ("$1,234.50", 1234.5, "$"),
        ("-$5", -5.0, "$"),
        ("€ 5", 5.0, "€"),
        ("(5.5)", -5.5, ""),
        ("5%", 5.0, "%"),
        ("21.5 °C", 21.5, "°C"),
        ("3 km", 3.0, "km"),
        ("1.5K", 1500.0, ""),
        ("2.5M", 2_500_000.0, ""),
        ("1.2B", 1.2e9, ""),
        ("−5", -5.0, ""),
    ],
)  # fmt: skip
def test_a_number_with_a_decimal_point(text: str, value: float, unit: str) -> None:
    assert parse(text, ".") == (value, unit)


@pytest.mark.parametrize(
    ("text", "value"), [("12,5", 12.5), ("1.234,5", 1234.5), ("1 234,5", 1234.5), ("0,25", 0.25)]
)
def test_a_number_with_a_decimal_comma(text: str, value: float) -> None:
    assert parse(text, ",") == (value, "")


@pytest.mark.parametrize(
    "text",
    ["", "-", "a", "1-2", "1:30", "1/2", "12,34", "1,23,4", "1.2.3", "--5", "0x10", "1e", "١",
     "1,2345", "5 \ud800", "2020-01-01", "(-5)"],
)  # fmt: skip
def test_a_text_that_is_not_a_number_is_parsed_as_none(text: str) -> None:
    assert parse(text, ".") is None


@pytest.mark.parametrize(
    ("cells", "mark"),
    [
        (["1", "12,5"], ","),
        (["1.234,5"], ","),
        (["1,234.5"], "."),
        (["0.250"], "."),
        (["1,234,567"], "."),
        (["1.234.567"], ","),
        (["1,234"], None),
        (["12"], None),
    ],
)
def test_the_decimal_mark_is_detected_by_cells_in_which_it_can_be_only_one(
    cells: list[str], mark: str | None
) -> None:
    assert detect_decimal_mark(cells) == mark


def test_one_number_of_thousands_does_not_turn_a_column_of_commas(tmp_path: Path) -> None:
    text = "date;level\n2020-01-01;1,5\n2020-01-02;2,250\n2020-01-03;1.002,125\n"
    assert values(load(tmp_path, text)) == [1.5, 2.25, 1002.125]


def test_a_comma_that_nothing_decides_is_decimal_where_semicolons_separate(tmp_path: Path) -> None:
    text = "date;level\n2020-01-01;1,500\n2020-01-02;2,250\n"
    assert values(load(tmp_path, text)) == [1.5, 2.25]
    text = 'date,level\n2020-01-01,"1,500"\n2020-01-02,"2,250"\n'
    assert values(load(tmp_path, text)) == [1500.0, 2250.0]


def test_a_column_that_is_mostly_numbers_looks_numeric() -> None:
    assert looks_numeric(["1", "", "NA", "2.5", None])
    assert looks_numeric(["1", "2", "x"])
    assert not looks_numeric(["1", "x"])
    assert not looks_numeric(["", None])
    assert not looks_numeric([True, False])


def test_a_currency_in_the_cells_is_the_unit(tmp_path: Path) -> None:
    text = 'date,paid\n2020-01-01,"$1,200.50"\n2020-01-02,$900\n2020-01-03,"$1,000"\n'
    timeline = load(tmp_path, text)
    assert values(timeline) == [1200.5, 900.0, 1000.0]
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "$"


def test_a_pace_is_a_number_of_its_first_unit() -> None:
    rows = "Time;Pulse;Pace (min/km)\n0:00:00;105;6:10\n0:00:30;120;5:12\n0:01:00;130;5:30\n"
    curve = load_timeline(rows.encode(), value="Pace (min/km)").intensity
    assert curve is not None
    assert curve.unit == "min/km"
    assert curve.value == pytest.approx([6.0 + 1 / 6, 5.2, 5.5])
    with pytest.raises(InputError, match="5:72"):
        load_timeline(rows.replace("5:12", "5:72").encode(), value="Pace (min/km)")
