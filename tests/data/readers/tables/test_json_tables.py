"""JSON in the shapes in which programs write series."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from overview_dsp.data.readers import load_timeline
from tests.data.readers.tables.made import load, noted, refusal, times, values

DAY = 86_400.0
DATES = ["2020-01-01", "2020-01-02", "2020-01-03", "2020-01-04"]
LEVELS = [3.5, None, 2.25, 6]
RECORDS = [{"date": d, "temp": v} for d, v in zip(DATES, LEVELS, strict=True)]


@pytest.mark.parametrize(
    "document",
    [
        RECORDS,
        {"date": DATES, "temp": LEVELS},
        {"columns": ["date", "temp"], "data": [list(r.values()) for r in RECORDS]},
        {"columns": ["temp"], "index": DATES, "data": [[v] for v in LEVELS]},
        [["date", "temp"], *(list(r.values()) for r in RECORDS)],
        [list(r.values()) for r in RECORDS],
        dict(zip(DATES, LEVELS, strict=True)),
        {d: {"temp": v} for d, v in zip(DATES, LEVELS, strict=True)},
        {"date": dict(enumerate(DATES)), "temp": dict(enumerate(LEVELS))},
        {"temp": dict(zip(DATES, LEVELS, strict=True)), "sun": dict.fromkeys(DATES, "yes")},
        {"meta": {"a": 1}, "series": [{"points": RECORDS}]},
        [[1577836800000 + i * 86_400_000, v] for i, v in enumerate(LEVELS)],
    ],
)
def test_a_series_is_the_same_in_every_shape_of_json(tmp_path: Path, document: Any) -> None:
    timeline = load(tmp_path, json.dumps(document), "made.json")
    assert times(timeline) == [0.0, 2 * DAY, 3 * DAY]
    assert values(timeline) == [3.5, 2.25, 6.0]
    assert timeline.gaps == ((0.0, 2 * DAY),)
    assert timeline.start is not None
    assert timeline.start.replace(tzinfo=None) == datetime(2020, 1, 1)


def test_json_lines_are_read(tmp_path: Path) -> None:
    text = "\n".join(map(json.dumps, RECORDS))
    timeline = load(tmp_path, text, "made.jsonl")
    assert values(timeline) == [3.5, 2.25, 6.0]
    assert "a JSON lines table" in timeline.provenance


def test_units_beside_a_table_are_taken(tmp_path: Path) -> None:
    document = {
        "hourly_units": {"time": "iso8601", "temperature_2m": "°C"},
        "hourly": {"time": ["2020-01-01T00:00", "2020-01-01T01:00"], "temperature_2m": [1, 2]},
    }
    timeline = load(tmp_path, json.dumps(document))
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "°C"
    assert noted(timeline, "the table is at 'hourly'")


def test_the_table_with_the_most_rows_is_read_and_others_named(tmp_path: Path) -> None:
    document = {"day": RECORDS[:2], "week": RECORDS}
    timeline = load(tmp_path, json.dumps(document))
    assert len(values(timeline)) == 3
    assert noted(timeline, "the table is at 'week'")
    assert noted(timeline, "1 other tables in the file were left out")


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ([*RECORDS, {"date": "2020-01-05", "temp": "hot"}], "record 5, column 'temp': 'hot' isn't"),
        ([*RECORDS, {"date": "2020-02-30", "temp": 1}], "record 5, column 'date': '2020-02-30'"),
        ([*RECORDS, {"date": "2020-01-05", "temp": [1]}], r"record 5, column 'temp': \[1\] isn't"),
        ([*RECORDS, {"date": "2020-01-05", "temp": True}], "record 5, column 'temp': True isn't"),
        ([*RECORDS, *([{"date": "2020-01-05", "temp": 1}] * 60), 7], "record 65: 7 isn't an obj"),
        ([[0, 1], [1, 2], *([[2, 3]] * 60), [3]], r"record 63: \[3\] isn't a list of 2"),
        ([{"date": d, "a": 1, "b": 2} for d in DATES], "which column is the value?"),
        ([{"date": d, "temp": 10**400} for d in DATES], "record 1, column 'temp': inf isn't"),
        ([{"id": 1, "name": "x"}], "a JSON list of 1 entries, not a format"),
    ],
)
def test_a_wrong_value_is_named_with_file_record_and_column(
    tmp_path: Path, document: Any, words: str
) -> None:
    import re

    line = refusal(lambda: load(tmp_path, json.dumps(document), "made.json"))
    assert re.search(rf"made\.json: .*{words}", line), line


@pytest.mark.parametrize(
    ("line", "words"),
    [('{"date": "2020', "line 5: broken JSON"), ("[1]", "line 5: "), ("5", "line 5: 5 isn't")],
)
def test_a_broken_line_of_objects_is_named(tmp_path: Path, line: str, words: str) -> None:
    text = "\n".join([*map(json.dumps, RECORDS), line])
    assert words in refusal(lambda: load(tmp_path, text))


def test_deeply_nested_json_is_refused_in_one_line(tmp_path: Path) -> None:
    assert "nested too deep" in refusal(lambda: load(tmp_path, "[" * 200_000))


def test_the_properties_of_geojson_features_are_a_table(tmp_path: Path) -> None:
    features = [
        {
            "type": "Feature",
            "properties": {"mag": 2.0 + i, "time": 1_704_067_200_000 + 60_000 * i, "place": "x"},
            "geometry": {"type": "Point", "coordinates": [1.0, 2.0, 3.0]},
        }
        for i in range(4)
    ]
    path = tmp_path / "quakes.json"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    curve = load_timeline(path, value="mag").intensity
    assert curve is not None
    assert curve.value.tolist() == [2.0, 3.0, 4.0, 5.0]
    assert load_timeline(path, map="count:1min").duration_s == 240.0
