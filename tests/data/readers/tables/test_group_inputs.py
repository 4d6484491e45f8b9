"""Tables of several series, and JSON that is none: each read right, or refused with the remedy."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import overview_dsp as ov
from tests.data.readers.truths import Events, Input, Refused, Series, check, parametrized

YEAR = 365 * 86_400.0
YEARS = (2001, 2002, 2003)
NORWAY, PERU = (5.0, 7.0, 6.5), (40.0, 38.0, 41.0)
EACH = (0.0, YEAR, 2 * YEAR)


def csv(header: str, rows: Sequence[Sequence[Any]]) -> str:
    return "\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n"


def interleaved(*names: Any, first: bool = False) -> Iterator[tuple[Any, ...]]:
    """Rows by year and then by name."""
    for year, *values in zip(YEARS, NORWAY, PERU, strict=True):
        for name, value in zip(names, values, strict=False):
            yield (name, year, value) if first else (year, name, value)


def stacked(*names: Any) -> list[tuple[Any, ...]]:
    return sorted(interleaved(*names), key=lambda row: names.index(row[1]))


COUNTRIES = csv("year,country,value", list(interleaved("Norway", "Peru")))
RECORDS = [
    {"year": year, "station": name, "level": value}
    for year, name, value in interleaved("Norway", "Peru")
]
TWO_KEYS = csv(
    "year,country,sex,value",
    [
        (year, name, sex, value + (sex == "m"))
        for year, name, value in interleaved("Norway", "Peru")
        for sex in "fm"
    ],
)
SUBJECTS = csv(
    "subject,time (s),load",
    [(s, t / 10, s * 10 + t) for s in (1, 2, 3) for t in range(5)],
)
CHANNELS = csv("channel,t_ms,level", [(c, t, c + t / 8) for t in range(0, 40, 8) for c in (0, 1)])
MINUTES = [f"2024-03-01 00:{minute:02}" for minute in range(0, 60, 5)]
APART = csv("time,station,level", [(m, "AB"[i % 2], i * i) for i, m in enumerate(MINUTES)])
LATER = csv(
    "year,Land,value",
    [
        *((y, "Oslo", y % 7) for y in range(2010, 2015)),
        *((y, "Lima", y % 5) for y in range(2003, 2009)),
    ],
)
DOUBLED = csv("year,station,value", [*interleaved("A", "B"), (2003, "B", 41.0), (2004, "A", 3.0)])
TIDY = csv("time,variable,value", [(t, v, t + len(v)) for t in range(4) for v in ("rain", "wind")])
QUOTED = COUNTRIES.replace("Peru", '"Korea, Rep."')
EVENTS = csv(
    "subject,onset,event",
    [(f"s{s}", t + s / 8, e) for s in (1, 2) for t, e in ((1, "go"), (4, "stop"), (6, "go"))],
)


def frame() -> pd.DataFrame:
    rows = list(interleaved("AAA", "BBB"))
    return pd.DataFrame(rows, columns=["year", "symbol", "close"])


def refused(name: str, data: Any, *words: str, file: str = "made.csv") -> Input:
    return Input(name, data, Refused((*words, "--select", "--group")), file=file)


DETECTED = [
    refused("countries", COUNTRIES, "'country'", "Norway", "Peru", "country=Norway"),
    refused(
        "countries, stacked", csv("year,country,value", stacked("Norway", "Peru")), "'country'"
    ),
    refused("a text under any header", csv("year,x,value", stacked("Norway", "Peru")), "x=Norway"),
    refused("stacked with other years", LATER, "'Land'", "Oslo", "Lima"),
    refused("stations that report in turn", APART, "'station'", "station=A"),
    refused("numbered subjects", SUBJECTS, "'subject'", "subject=1"),
    refused("numbered channels", CHANNELS, "'channel'", "channel=0"),
    refused("two keys", TWO_KEYS, "'country'", "'sex'", "country=Norway, sex=f"),
    refused("a repeated row", DOUBLED, "'station'", "station=A"),
    refused("variables", TIDY, "'variable'", "variable=rain"),
    refused("JSON records", json.dumps(RECORDS), "'station'", "Norway", file="made.json"),
    refused("JSON lines", "\n".join(map(json.dumps, RECORDS)), "'station'", file="made.json"),
    refused("a data frame of shares", frame, "'symbol'", "symbol=AAA"),
    refused("events of subjects", EVENTS, "'subject'", "subject=s1"),
]

NORWAY_READ = Series(NORWAY, EACH, "2001-01-01T00:00:00")
WEATHER = csv(
    "date,weather,temp",
    [(f"2020-01-{d:02}", "sun" if d % 3 else "rain", d % 7) for d in (1, 2, 3, 5, 4, 6, 7, 8)],
)
DAY = 86_400.0

CASES = csv("year,station,value", list(interleaved("a", "A")))
PLACES = csv(
    'year,"place, land",value',
    [(y, f'"{name}"', v) for y, name, v in interleaved("Rome, Italy", "Rome, Georgia")],
)

SELECTED = [
    Input("one of two names in one case", CASES, Series(PERU, EACH), {"match": "station=A"}),
    Input("the other of two names", CASES, NORWAY_READ, {"match": "station=a"}),
    Input("a column and a name with commas", PLACES, Series(PERU, EACH),
          {"match": "place, land=Rome, Georgia"}),
    Input("readings under a name of groups", "time,channel\n0,1.5\n1,2.5\n2,0.5\n",
          Series([1.5, 2.5, 0.5], [0, 1, 2])),
    Input("a country", COUNTRIES, NORWAY_READ, {"match": "country=Norway"}),
    Input("a country by its name alone", COUNTRIES, NORWAY_READ, {"match": "norway"}),
    Input("a name with a comma", QUOTED, Series(PERU, EACH), {"match": "country=Korea, Rep."}),
    Input(
        "a subject by its number", SUBJECTS, Series([20, 21, 22, 23, 24], np.arange(5) / 10),
        {"match": "subject=2"},
    ),
    Input(
        "two columns", TWO_KEYS, Series([6.0, 8.0, 7.5], EACH), {"match": "country=Norway, sex=m"}
    ),
    Input(
        "one of two columns", TWO_KEYS, Refused(("'sex'", "country=Norway, sex=f")),
        {"match": "country=Norway"},
    ),
    Input("an unknown one", COUNTRIES, Refused(("Norway", "Peru")), {"match": "country=Norwegen"}),
    Input("a row twice", DOUBLED, Series([40, 38, 41], EACH), {"match": "station=B"}),
    Input("JSON", json.dumps(RECORDS), NORWAY_READ, {"match": "station=Norway"}, "made.json"),
    Input("a frame", frame, Series(PERU, EACH), {"match": "BBB", "value": "close"}),
    Input("a subject's events", EVENTS, Events([1.25, 4.25, 6.25], ("go", "stop", "go")),
          {"match": "subject=s2"}),
    Input(
        "all as one", APART, Series([float(i * i) for i in range(12)], 300.0 * np.arange(12)),
        {"match": "station=*"},
    ),
    Input("one station", csv("year,station,value", list(interleaved("A"))), NORWAY_READ),
    Input("a state beside a row out of order", WEATHER,
          Series([1, 2, 3, 4, 5, 6, 0, 1], DAY * np.arange(8))),
]  # fmt: skip


def geo(*features: dict[str, Any]) -> str:
    made = [
        {"type": "Feature", "geometry": {"type": "Point", "coordinates": [i, 2 * i]},
         "properties": one} for i, one in enumerate(features)
    ]  # fmt: skip
    return json.dumps({"type": "FeatureCollection", "features": made})


LINE = [[8.1, 47.2], [8.4, 47.1], [8.2, 47.9], [8.3, 47.5]]
TOPOLOGY = {
    "type": "Topology", "transform": {"scale": [0.1, 0.1], "translate": [0, 0]},
    "objects": {"land": {"type": "GeometryCollection", "geometries": [
        {"type": "Polygon", "arcs": [[0]], "id": 4}, {"type": "Polygon", "arcs": [[1]], "id": 8}]}},
    "arcs": [[[1, 2], [3, 4], [5, 1]], [[5, 6], [6, 9], [7, 1]]],
}  # fmt: skip
GRAPH = {
    "nodes": [{"name": "A", "group": 1}, {"name": "B", "group": 2}, {"name": "C", "group": 2}],
    "links": [{"source": 0, "target": 1, "value": 3}, {"source": 1, "target": 2, "value": 8}],
}
TREE = {"name": "root", "children": [{"name": "a", "size": 3}, {"name": "b", "size": 9}]}
STAMPS = [{"mag": m, "time": 1_700_000_000_000 + 60_000 * i} for i, m in enumerate((1.5, 2.5, 2.0))]


def no_series(name: str, document: Any, *words: str) -> Input:
    text = document if isinstance(document, str) else json.dumps(document)
    return Input(name, text, Refused(words), file="made.json")


MAPS = [
    no_series("TopoJSON", TOPOLOGY, "a map (TopoJSON)", "times"),
    no_series("GeoJSON of places", geo({"n": "A", "m": 1}, {"n": "B", "m": 2}), "a map (GeoJSON)"),
    no_series("GeoJSON without properties", geo({}, {}), "a map (GeoJSON)"),
    no_series("one line of a map", {"type": "LineString", "coordinates": LINE}, "a map (GeoJSON)"),
    no_series(
        "geometries", {"type": "GeometryCollection", "geometries": [
            {"type": "MultiPoint", "coordinates": LINE}]}, "a map (GeoJSON)",
    ),
    no_series(
        "one feature", {"type": "Feature", "properties": {"time": "2020"}, "geometry": {
            "type": "Polygon", "coordinates": [LINE]}}, "a map (GeoJSON)",
    ),
    no_series("pairs of places", LINE, "times", "order"),
    no_series("a graph", GRAPH, "a graph (nodes and links)"),
    no_series("a tree", TREE, "a tree (name and children)"),
    no_series("numbers by country", {"NOR": 5.4, "PER": 33.0, "USA": 331.0}, "time"),
    Input("GeoJSON with times", geo(*STAMPS), Series([1.5, 2.5, 2.0], [0, 60, 120]),
          {"value": "mag"}, "made.json"),
]  # fmt: skip


@parametrized(DETECTED, SELECTED, MAPS)
def test_a_table_of_several_series_is_read_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


def test_each_series_of_a_table_becomes_a_timeline(tmp_path: Path) -> None:
    path = tmp_path / "made.csv"
    path.write_text(TWO_KEYS)
    each = ov.load_timelines(path, "country, sex")
    assert list(each) == ["Norway, f", "Norway, m", "Peru, f", "Peru, m"]
    for name, timeline in each.items():
        assert timeline.title == f"made, {name}: value"
        assert timeline.intensity is not None
        added = name.endswith("m")
        expected = [value + added for value in (NORWAY if "Norway" in name else PERU)]
        assert timeline.intensity.value.tolist() == expected
    assert list(ov.load_timelines(frame(), "symbol", value="close")) == ["AAA", "BBB"]
    assert list(ov.load_timelines(EVENTS.encode(), "subject")) == ["s1", "s2"]


def test_series_whose_names_differ_by_case_or_contain_commas_are_read_apart() -> None:
    each = ov.load_timelines(CASES.encode(), "station")
    assert {name: one.intensity.value.tolist() for name, one in each.items() if one.intensity} == {
        "a": list(NORWAY),
        "A": list(PERU),
    }
    assert list(ov.load_timelines(PLACES.encode(), "place, land")) == [
        "Rome, Italy",
        "Rome, Georgia",
    ]


def test_rows_without_a_group_are_counted_in_a_warning() -> None:
    rows = [*interleaved("A", "B"), (2004, "", 9.0), (2005, "", 9.0)]
    with pytest.warns(ov.OverviewWarning, match=r"2 rows have no text in 'station'"):
        each = ov.load_timelines(csv("year,station,value", rows).encode(), "station")
    assert [len(one.intensity.value) for one in each.values() if one.intensity] == [3, 3]


@pytest.mark.parametrize("option", ["match", "colour"])
def test_an_option_that_chooses_no_series_is_refused(option: str) -> None:
    with pytest.raises(ov.InputError, match=f"no option {option}"):
        ov.load_timelines(CASES.encode(), "station", **{option: "a"})


def test_a_series_that_cannot_be_read_is_left_out_with_a_warning() -> None:
    rows = [*interleaved("A", "B"), (2001, "C", 1.0)]
    with pytest.warns(ov.OverviewWarning, match=r"1 of 3 series are left out; C: .*one time"):
        each = ov.load_timelines(csv("year,station,v", rows).encode(), "station")
    assert list(each) == ["A", "B"]
    with pytest.raises(ov.InputError, match=r"no such column; columns are 'year', 'station', 'v'"):
        ov.load_timelines(csv("year,station,v", rows).encode(), "land")
    with pytest.raises(ov.InputError, match="no columns"):
        ov.load_timelines(b"WEBVTT\n\n00:01.000 --> 00:02.000\n[a]\n", "team")
