"""The same bytes give the same timeline through every reader that accepts them."""

from __future__ import annotations

import csv
import io
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events import event_table
from overview_dsp.data.readers.football import minute_list
from overview_dsp.data.readers.formats import FORMATS
from overview_dsp.data.readers.tables.delimited import DelimitedTable, records
from overview_dsp.data.readers.tables.dialect import detect, header_dialect
from overview_dsp.errors import InputError

KINDS = st.sampled_from(("goal", "foul", "yellow_card", "lunch", "walk"))
WORDS = st.text(st.sampled_from("abc é,;#\"'"), max_size=12).map(
    lambda text: " ".join(text.split())
)
EVENTS = st.lists(
    st.tuples(st.integers(0, 5000), KINDS, WORDS, st.sampled_from(("", "1", "2.5", "NA"))),
    min_size=3,
    max_size=12,
    unique_by=lambda row: row[0],
)


def written(rows, header, separator, end, quoted, comments, mark):
    """A delimited text of these rows, in one of many ways."""
    stream = io.StringIO()
    quoting = csv.QUOTE_ALL if quoted else csv.QUOTE_MINIMAL
    writer = csv.writer(stream, delimiter=separator, lineterminator=end, quoting=quoting)
    writer.writerow(header)
    for i, row in enumerate(rows):
        if comments and i % 3 == 1:
            stream.write(f'# not "a row{end}{end}')
        writer.writerow(row)
    return (mark + f"# title: A day{end}" * comments + stream.getvalue()).encode()


WAYS = st.tuples(
    st.sampled_from((",", ";", "\t")),
    st.sampled_from(("\n", "\r\n")),
    st.booleans(),
    st.booleans(),
    st.sampled_from(("", "\ufeff")),
)


def through(content, *readers):
    """What each of these readers makes of the bytes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "list.csv"
        path.write_bytes(content)
        source = DataFile.open(path)
        return [read(source, LoadOptions()) for read in readers]


def accepting(content):
    """The readers whose `sniff` claims these bytes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "list.csv"
        path.write_bytes(content)
        return [known.read for known in FORMATS if known.sniff(DataFile.open(path))]


@settings(max_examples=60)
@given(EVENTS, WAYS)
def test_a_list_of_events_is_the_same_read_strictly_or_not(rows, way):
    assume(any(row[0] for row in rows))
    content = written(rows, ("time_s", "kind", "label", "weight"), *way)
    readers = accepting(content)
    assert event_table.read_list in readers
    strict, free = through(content, event_table.read_list, event_table.read)
    assert free.events == strict.events
    assert free.duration_s == strict.duration_s
    assert free.title == strict.title == ("A day" if way[3] else "list")
    assert [e.weight for e in strict.events] == [
        {"": 1.0, "NA": 1.0}.get(w) or float(w) for _, _, _, w in sorted(rows)
    ]
    assert (free.intensity is None) == (strict.intensity is None)


@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(st.integers(0, 44), st.sampled_from(("goal", "foul", "yellow card")), WORDS),
        min_size=3,
        max_size=9,
        unique_by=lambda row: row[0],
    ),
    WAYS,
)
def test_minutes_lie_where_they_do_in_any_list(rows, way):
    content = written(rows, ("minute", "event", "player"), *way)
    assert minute_list.read in accepting(content)
    match, plain = through(content, minute_list.read, event_table.read)
    kinds = {"goal", "foul", "yellow_card"}

    def found(timeline):
        return [(e.time_s, e.kind) for e in timeline.events if e.kind in kinds]

    assert found(match) == found(plain)


@settings(max_examples=60)
@given(EVENTS, WAYS)
def test_a_dialect_found_or_known_by_its_header_holds_the_same_cells(rows, way):
    content = written(rows, ("time_s", "kind", "label", "weight"), *way)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "list.csv"
        path.write_bytes(content)
        source = DataFile.open(path)
        dialect = detect(source, lambda header, below: True)
        assert dialect is not None
        table = DelimitedTable(source, dialect)
        streamed = [
            cells for chunk in table.chunks(range(4)) for cells in zip(*chunk.cells, strict=True)
        ]
        numbers = [chunk.number(i) for chunk in table.chunks([0]) for i in range(len(chunk))]
    whole = list(records(content.decode("utf-8-sig")))
    assert [line for line, _ in whole] == numbers
    assert [tuple(fields.values()) for _, fields in whole] == [
        tuple(cell.strip() for cell in cells) for cells in streamed
    ]
    known = header_dialect(content.decode("utf-8-sig"))
    assert known is not None
    assert (known.separator, known.first) == (dialect.separator, dialect.first)


@pytest.mark.parametrize(
    ("header", "times"),
    [
        ("time,event", [10.0, 20.0, 40.0]),
        ("minute,event", [600.0, 1200.0, 2400.0]),
        ("time,event,player", [600.0, 1200.0, 2400.0]),
        ("time,event,team", [600.0, 1200.0, 2400.0]),
    ],
)
def test_bare_numbers_under_time_are_minutes_only_beside_a_team_or_player(header, times):
    more = "," * (header.count(",") - 1)
    content = "".join(
        f"{line}\n" for line in (header, f"10,goal{more}", f"20,foul{more}", f"40,goal{more}")
    ).encode()
    timeline = through(content, accepting(content)[0])[0]
    assert [e.time_s for e in timeline.events if e.kind != "period"] == times


@given(EVENTS, WAYS, st.integers(0, 11), st.sampled_from((0, 3)))
@settings(max_examples=40)
def test_an_error_says_line_column_value_and_note(rows, way, at, column):
    at %= len(rows)
    broken = [list(row) for row in rows]
    broken[at][column] = "wrong!"
    header = ("time_s", "kind", "label", "weight")
    content = written(broken, header, *way)
    with pytest.raises(InputError) as caught:
        through(content, event_table.read_list)
    lines = content.decode("utf-8-sig").splitlines()
    expected = next(i for i, line in enumerate(lines, 1) if "wrong!" in line)
    error = caught.value
    assert (error.line, error.column, error.value) == (expected, header[column], "wrong!")
    assert str(error).endswith(f"line {expected}, column '{header[column]}': 'wrong!' {error.note}")


def test_a_series_with_a_wrong_cell_carries_its_location():
    content = b"date,close\n2020-01-01,1\n2020-01-02,2\n2020-01-03,x\n2020-01-04,4\n"
    with pytest.raises(InputError) as caught:
        through(content, accepting(content)[0])
    assert (caught.value.line, caught.value.column, caught.value.value) == (4, "close", "x")
    assert np.array_equal(through(content.replace(b"x", b"3"), accepting(content)[0])[0].intensity
                          .value, [1.0, 2.0, 3.0, 4.0])  # fmt: skip


@pytest.mark.parametrize("header", ["", "time,event\n"])
def test_comments_give_title_and_length_with_a_header_or_without(header):
    rows = "2024-06-03 08:30,walk\n2024-06-03 12:00,lunch\n2024-06-03 14:00,walk\n"
    content = f"# title: A day\n# duration_s: 90000\n{header}{rows}".encode()
    timeline = through(content, accepting(content)[0])[0]
    assert (timeline.title, timeline.duration_s) == ("A day", 90_000.0)
    assert timeline.kinds() == {"walk": 2, "lunch": 1}


LONG = b"time,close\n" + b"".join(b"%d,%d\n" % (i, i) for i in range(500))


@pytest.mark.parametrize(
    ("content", "line", "note"),
    [
        (b"date,close\n2020-01-01,1\n2020-01-02,2,3\n2020-01-03,4\n", 3, "3 fields for 2 columns"),
        (LONG + b'500,"2\n501,4\n', 502, "check the quotes"),
        (b"t,close\n0:01,1\n0:09,2\n0:05,3\n", 4, "the clock goes back"),
        (b'{"t": 1, "close": 2}\n{"t": 2, "close": 3}\n{"t": 3, \n', 3, "broken JSON"),
    ],
)
def test_an_error_of_a_row_carries_its_line_and_note(content, line, note):
    with pytest.raises(InputError) as caught:
        through(content, accepting(content)[0])
    assert caught.value.line == line
    assert note in caught.value.note
    assert str(caught.value).endswith(f"line {line}: {caught.value.note}")
