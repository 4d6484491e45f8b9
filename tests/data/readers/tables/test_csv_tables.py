"""Text tables as people and programs write them."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path

import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables import delimited
from tests.data.readers.tables.made import DAILY, load, noted, refusal, times, values

DAY = 86_400.0


def test_a_daily_series_is_read_with_exact_times(tmp_path: Path) -> None:
    timeline = load(tmp_path, DAILY)
    assert timeline.title == "made: temp"
    assert timeline.start == datetime(2020, 1, 1)
    assert times(timeline) == [0.0, DAY, 2 * DAY, 3 * DAY]
    assert values(timeline) == [3.5, 4.0, 2.25, 6.0]
    assert timeline.duration_s == 3 * DAY  # the last sample's time: no step is added
    assert timeline.gaps == ()
    assert "'temp' over 'date' (ISO dates)" in timeline.provenance


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + DAILY,
        DAILY.replace("\n", "\r\n"),
        DAILY.replace("\n", "\r"),
        DAILY.rstrip("\n"),
        DAILY + "\n\n",
        DAILY.replace(",", "\t"),
        DAILY.replace(",", "|"),
        DAILY.replace(",", ";"),
        DAILY.replace(",", ";").replace(".", ","),
        DAILY.replace(",", "\t").replace(".", ","),
        DAILY.replace(",", ", "),
        DAILY.replace("date,temp", '"date","temp"').replace("3.5", '"3.5"'),
        DAILY.replace("\n", ",\n"),
        "# a remark\n#another, with a comma\n" + DAILY,
        DAILY.replace("2020-01-03", "# in between\n2020-01-03"),
        DAILY.replace("\n2020-01-03", "\n\n2020-01-03"),
        "Station: Harbour\nMade: today\n\n" + DAILY,
        DAILY.replace("3.5", "3.50").replace(",4\n", ",4.0\n"),
        DAILY.replace("6", "+6.0e0"),
    ],
)
def test_the_same_table_written_otherwise_is_the_same_series(tmp_path: Path, text: str) -> None:
    timeline, plain = load(tmp_path, text), load(tmp_path, DAILY)
    assert timeline.intensity == plain.intensity
    assert timeline.start == plain.start
    assert timeline.events == plain.events


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32", "cp1252"])
def test_units_in_the_header_in_any_usual_encoding(tmp_path: Path, encoding: str) -> None:
    text = DAILY.replace("temp", "temp_max (°C)").encode(encoding)
    timeline = load(tmp_path, text, value="temp_max")
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "°C"
    assert timeline.title == "made: temp_max"
    assert "highest 6 °C, 2020-01-04" in [event.label for event in timeline.events]
    assert noted(timeline, "Windows-1252") is (encoding == "cp1252")


LOGGED = "".join(f'"2024-06-03 0{hour}:00:00",{hour},{hour * hour}\n' for hour in range(6))
TOA5 = (
    '"TOA5","CR1000","CR1000","1234","CR1000.Std.27","CPU:prog.CR1","55555","Table1"\n'
    '"TIMESTAMP","RECORD","AirTC_Avg"\n"TS","RN","Deg C"\n"","","Avg"\n'
)


@pytest.mark.parametrize(
    ("head", "value", "unit"),
    [
        (TOA5, "AirTC_Avg", "Deg C"),  # a logger of Campbell Scientific
        (",no,Temp\nUTC,-,degC\n", "Temp", "degC"),
        ("A day,,\n,Oslo,\nday,no,Temp\n", "Temp", ""),
        ("A day,,\nexported on,2 March,\n,,\nday,no,Temp (K)\n", "Temp", "K"),
    ],
)
def test_rows_above_and_below_the_names_of_columns(
    tmp_path: Path, head: str, value: str, unit: str
) -> None:
    (tmp_path / "log.csv").write_text(head + LOGGED)
    curve = load_timeline(tmp_path / "log.csv", value=value).intensity
    assert curve is not None
    assert curve.value.tolist() == [0, 1, 4, 9, 16, 25]
    assert curve.unit == unit


def test_a_row_of_units_below_the_header_is_no_data(tmp_path: Path) -> None:
    timeline = load(tmp_path, DAILY.replace("temp\n", "temp\n,deg C\n"))
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "deg C"
    assert values(timeline) == [3.5, 4.0, 2.25, 6.0]


def test_a_file_without_a_header_is_read(tmp_path: Path) -> None:
    timeline = load(tmp_path, DAILY.partition("\n")[2])
    assert values(timeline) == [3.5, 4.0, 2.25, 6.0]
    assert noted(timeline, "no header")


def test_columns_separated_by_blanks_are_read(tmp_path: Path) -> None:
    timeline = load(tmp_path, "  time     level\n   0.0      5\n   0.5     16\n   1.0      7\n")
    assert values(timeline) == [5.0, 16.0, 7.0]
    assert timeline.start is None
    assert timeline.duration_s == 1.0


def test_a_row_name_that_the_header_does_not_count_is_no_value(tmp_path: Path) -> None:
    text = "date,temp\na,2020-01-01,3\nb,2020-01-02,4\nc,2020-01-03,5\n"
    assert values(load(tmp_path, text)) == [3.0, 4.0, 5.0]


@pytest.mark.parametrize("head", [",date,temp", "index,date,temp", "Unnamed: 0,date,temp"])
def test_a_column_that_counts_rows_is_no_value(tmp_path: Path, head: str) -> None:
    text = f"{head}\n0,2020-01-01,3\n1,2020-01-02,4\n2,2020-01-03,5\n"
    assert values(load(tmp_path, text)) == [3.0, 4.0, 5.0]


def test_one_column_is_read_at_a_rate(tmp_path: Path) -> None:
    timeline = load(tmp_path, "level\n3\n5\n\n4\n9\n", rate=2.0)
    assert times(timeline) == [0.0, 0.5, 1.0, 1.5]
    assert values(timeline) == [3.0, 5.0, 4.0, 9.0]
    assert timeline.start is None
    words = refusal(lambda: load(tmp_path, "level\n3\n5\n4\n9\n"))
    assert "no column looks like times; columns are 'level'" in words
    assert "rate" in words


def test_the_value_is_asked_for_where_there_are_several(tmp_path: Path) -> None:
    text = "date,wind (m/s),rain\n2020-01-01,3,1\n2020-01-02,4,2\n2020-01-03,5,0\n"
    words = refusal(lambda: load(tmp_path, text))
    assert "made.csv: which column is the value? 2 hold numbers: 'wind (m/s)', 'rain'" in words
    for name in ("wind (m/s)", "wind", "WIND"):
        assert values(load(tmp_path, text, value=name)) == [3.0, 4.0, 5.0]
    words = refusal(lambda: load(tmp_path, text, value="sun"))
    assert "no column 'sun'" in words
    assert "'date', 'wind (m/s)', 'rain'" in words


def test_two_columns_of_one_name_are_asked_about(tmp_path: Path) -> None:
    text = "date,a,a\n2020-01-01,3,1\n2020-01-02,4,2\n"
    assert "2 columns are called 'a'" in refusal(lambda: load(tmp_path, text, value="a"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (DAILY.replace("2.25", "two"), "line 4, column 'temp': 'two' isn't a number"),
        (DAILY.replace("2.25", "1e999"), "line 4, column 'temp': inf isn't a finite number"),
        (DAILY.replace("2.25", "-inf"), "line 4, column 'temp': '-inf' isn't a number"),
        (DAILY.replace("2.25", "2,25"), "line 4: 3 fields for 2 columns"),
        (DAILY.replace("2.25", '"2,25"'), "line 4, column 'temp': '2,25' isn't a number with a"),
        (DAILY.replace("01-03", "02-30"), "line 4, column 'date': '2020-02-30' isn't a time"),
        (DAILY.replace("2020-01-03", ""), "line 4, column 'date': is missing; give the time"),
        (DAILY.replace("2020-01-03", '"2020-01-03'), "line 4: .*check the quotes from there"),
        (DAILY.replace("2.25", "3 km").replace("3.5", "3 m"), "line 4, .*'3 km' is in 'km'"),
        ("date,temp\n", r"no rows below the header \(line 1\)"),
        ("date,temp\n2020-01-01,3\n", r"only one time \(line 2\)"),
        ("date,temp\n2020-01-01,\n2020-01-02,NA\n2020-01-03,-\n", "no column of numbers"),
        (DAILY.replace(DAILY[10:], "x" * 2_000_000), "line 2 is longer than 1048576 characters"),
    ],
)
def test_a_wrong_cell_is_named_with_file_line_and_column(
    tmp_path: Path, text: str, words: str
) -> None:
    line = refusal(lambda: load(tmp_path, text))
    assert re.search(rf"made\.csv: .*{words}", line), line
    assert line.count("made.csv") == 1


def test_a_quoted_field_over_several_lines_keeps_line_numbers_right(tmp_path: Path) -> None:
    text = 'date,temp,note\n2020-01-01,1,"a\nb"\n2020-01-02,x,c\n2020-01-03,2,d\n'
    assert "line 4, column 'temp': 'x'" in refusal(lambda: load(tmp_path, text, value="temp"))


def test_a_bad_byte_in_an_unused_column_does_not_matter(tmp_path: Path) -> None:
    rows = b"".join(b"2020-01-%02d,%d,ok\n" % (day, day) for day in range(1, 29))
    filler = b"#" + b"." * 70_000 + b"\n"  # so that the encoding is told before the bad byte
    text = b"date,temp,note\n" + rows + filler + b"2020-01-29,29,\xff\n"
    assert len(values(load(tmp_path, text))) == 29
    text = text.replace(b"29,29,\xff", b"29,2\xff,")
    assert "column 'temp'" in refusal(lambda: load(tmp_path, text))


def test_rows_in_any_order_are_sorted_and_that_is_noted(tmp_path: Path) -> None:
    head, *rows = DAILY.splitlines()
    down = load(tmp_path, "\n".join([head, *reversed(rows)]))
    assert values(down) == values(load(tmp_path, DAILY))
    assert noted(down, "descending order; they were reversed")
    mixed = load(tmp_path, "\n".join([head, rows[2], rows[0], rows[3], rows[1]]))
    assert values(mixed) == values(down)
    assert noted(mixed, "2 rows were earlier than the row before them (first line 3)")


def test_of_rows_of_one_time_the_last_with_a_value_counts(tmp_path: Path) -> None:
    text = DAILY + "2020-01-04,7\n2020-01-04,\n"
    timeline = load(tmp_path, text)
    assert values(timeline) == [3.5, 4.0, 2.25, 7.0]
    assert noted(timeline, "2 rows repeat a time")


def test_several_series_below_each_other_are_asked_about_and_distinguished(tmp_path: Path) -> None:
    text = "date,half,symbol,price\n" + "".join(
        f"2020-01-{day:02d},{'ab'[day % 2]},{name},{day * factor}\n"
        for day in range(1, 6)
        for name, factor in (("AAA", 1), ("BBB", 10))
    )
    words = refusal(lambda: load(tmp_path, text))
    assert "column 'symbol' distinguishes 2 series ('AAA', 'BBB'); choose one with match" in words
    for match in ("BBB", "bbb", "symbol=BBB"):
        assert values(load(tmp_path, text, match=match)) == [10.0, 20.0, 30.0, 40.0, 50.0]
    assert "no row contains this text" in refusal(lambda: load(tmp_path, text, match="CCC"))


def test_a_file_larger_than_the_limit_is_refused_and_the_limit_can_be_raised(
    tmp_path: Path,
) -> None:
    text = "date,temp\n" + "".join(f"2020-01-{day:02d},{day}\n" for day in range(1, 29)) * 3000
    assert len(text) > 2**20
    words = refusal(lambda: load(tmp_path, text, max_mb=1.0))
    assert "1 MB, more than the 1 MB that are read" in words
    assert "max_mb" in words
    assert len(values(load(tmp_path, text, max_mb=2.0))) == 28


def test_progress_is_reported_from_0_to_1(tmp_path: Path) -> None:
    parts: list[float] = []
    load(tmp_path, DAILY, progress=parts.append)
    assert parts
    assert parts == sorted(parts)
    assert parts[-1] == 1.0


@pytest.mark.parametrize(
    "text",
    ["time_s,kind\n1,goal\n2,goal\n", "name,colour\nred,blue\n", "just words\nand more\n", "5"],
)
def test_what_is_no_series_is_left_to_others(tmp_path: Path, text: str) -> None:
    path = tmp_path / "other.csv"
    path.write_text(text)
    assert not delimited.sniff(DataFile.open(path))


@pytest.mark.parametrize(
    ("header", "unit"),
    [("rain_mm", "mm"), ("Power_kW", "kW"), ("temp_celsius", "°C"), ("level", ""), ("x_ms", "")],
)
def test_a_header_may_end_with_its_unit(header: str, unit: str, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text(f"date,{header}\n2024-01-01,1\n2024-01-02,3\n2024-01-03,2\n")
    curve = load_timeline(path).intensity
    assert curve is not None
    assert curve.unit == unit


def test_a_mistake_in_one_of_several_series_is_named_by_its_line(tmp_path: Path) -> None:
    rows = [
        f"2020-01-{day:02d},{name},{day * factor}"
        for day in range(1, 8)
        for name, factor in (("AAA", 1), ("BBB", 10))
    ]
    rows[11] = "2020-01-06,BBB,oops"
    text = "\n".join(["date,symbol,price", *rows, ""])
    words = refusal(lambda: load(tmp_path, text, match="BBB"))
    assert "line 13" in words
    assert "'oops' isn't a number" in words
