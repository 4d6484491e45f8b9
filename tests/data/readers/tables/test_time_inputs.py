"""Compact dates, months in several languages, minutes or seconds: right, or refused."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import overview_dsp as ov
from tests.data.readers.truths import Events, Input, Refused, Series, check, parametrized

MIN, HOUR, DAY = 60.0, 3600.0, 86_400.0


def series(cells: Sequence[Any], header: str = "date") -> str:
    rows = [f'"{cell}",{i * i}' for i, cell in enumerate(cells)]
    return "\n".join([f"{header},level", *rows]) + "\n"


def dated(
    name: str, cells: Sequence[Any], start: str, seconds: Sequence[float], header: str = "date",
    **options: Any,
) -> Input:  # fmt: skip
    squares = [float(i * i) for i in range(len(cells))]
    return Input(name, series(cells, header), Series(squares, seconds, start), options)


def refused(name: str, data: str, *words: str, **options: Any) -> Input:
    return Input(name, data, Refused(words), options)


def hours_frame() -> pd.DataFrame:
    return pd.DataFrame({"when": [2026011500, 2026011501, 2026011503], "level": [0.0, 1.0, 4.0]})


APART = "date,time,level\n20260115,0,0\n20260115,30,1\n20260115,100,4\n20260115,1245,9\n"
HOURS = "date,hour,level\n2026-01-15,0,0\n2026-01-15,1,1\n2026-01-15,23,4\n2026-01-16,0,9\n"
MARKED_HOURS = HOURS.replace(",0,0", ",00:00,0").replace(",1,1", ",01:00,1")
MARKED_HOURS = MARKED_HOURS.replace(",23,4", ",23:00,4").replace(",0,9", ",00:00,9")
MARKED = "date,hour,event\n2026-01-15,08:00,start\n2026-01-15,12:30,lunch\n2026-01-16,09:15,go\n"
BESIDE = "date,{},level\n2026-01-15,{},0\n2026-01-16,{},1\n2026-01-17,{},4\n"
SHIFTS = "date,time,event\n20260115,930,go\n20260115,1245,stop\n20260116,5,go\n"

COMPACT = [
    dated("days", ["20260115", "20260116", "20260118"], "2026-01-15T00:00:00", [0, DAY, 3 * DAY]),
    dated("hours", ["2026011512", "2026011513", "2026011600"], "2026-01-15T12:00:00",
          [0, HOUR, 12 * HOUR]),
    dated("hours of a weather service", ["2026011523", "2026011600"], "2026-01-15T23:00:00",
          [0, HOUR], "MESS_DATUM"),
    dated("minutes", ["202601151230", "202601151245", "202601160000"], "2026-01-15T12:30:00",
          [0, 15 * MIN, 11.5 * HOUR]),
    dated("minutes under timestamp", ["202601151230", "202601151231"], "2026-01-15T12:30:00",
          [0, MIN], "timestamp"),
    dated("seconds", ["20260115123005", "20260115123010"], "2026-01-15T12:30:05", [0, 5], "time"),
    Input("whole numbers of a frame", hours_frame, Series([0, 1, 4], [0, HOUR, 3 * HOUR],
          "2026-01-15T00:00:00"), {"value": "level"}),
    Input("numbers of JSON", json.dumps([{"time": 202601151230 + i, "v": i} for i in range(4)]),
          Series([0, 1, 2, 3], [0, MIN, 2 * MIN, 3 * MIN], "2026-01-15T12:30:00"), {}, "m.json"),
    dated("floats", ["2026011512.0", "2026011514.0"], "2026-01-15T12:00:00", [0, 2 * HOUR]),
    dated("seconds since 1970", ["1768478400", "1768482000"], "2026-01-15T12:00:00+00:00",
          [0, HOUR]),
    dated("milliseconds since 1970", ["1768478400000", "1768478400250"],
          "2026-01-15T12:00:00+00:00", [0, 0.25]),
    refused("a wrong hour", series([f"20260115{h:02}" for h in (1, 2, 3, 4, 77, 6)]),
            "line 6", "'date'", "2026011577"),
    Input("a day and a clock without marks", APART,
          Series([0, 1, 4, 9], [0, 30 * MIN, HOUR, 12.75 * HOUR], "2026-01-15T00:00:00")),
    Input("a day and its hour", HOURS,
          Series([0, 1, 4, 9], [0, HOUR, 23 * HOUR, DAY], "2026-01-15T00:00:00")),
    Input("a day and a clock, noted", APART, Series([0, 1, 4, 9], [0, 30 * MIN, HOUR, 12.75 * HOUR],
          noted="times are made of columns 'date' and 'time'")),
    Input("events of a day and a clock", SHIFTS, Events([0, 3.25 * HOUR, 14 * HOUR + 35 * MIN],
          ("go", "stop", "go"), "2026-01-15T09:30:00",
          noted="times are made of columns 'date' and 'time'")),
    Input("events of a day and an hour with marks", MARKED, Events([0, 4.5 * HOUR, 25.25 * HOUR],
          ("start", "lunch", "go"), "2026-01-15T08:00:00")),
    *(Input(f"days and {name}", HOURS.replace("hour", name),
            Series([0, 1, 4, 9], [0, HOUR, 23 * HOUR, DAY], "2026-01-15T00:00:00"))
      for name in ("hours", "hhmm", "Stunde")),
    Input("a day and an hour with marks", MARKED_HOURS,
          Series([0, 1, 4, 9], [0, HOUR, 23 * HOUR, DAY], "2026-01-15T00:00:00")),
    Input("hours of work, one number a day", BESIDE.format("hour", 8, 7, 6),
          Series([0, 1, 4], [0, DAY, 2 * DAY], "2026-01-15T00:00:00"), {"value": "level"}),
    Input("minutes of a run under time", BESIDE.format("time", 32, 30, 41),
          Series([0, 1, 4], [0, DAY, 2 * DAY], "2026-01-15T00:00:00"), {"value": "level"}),
    Input("values under time", BESIDE.format("time", 1130, 1145, 1210),
          Series([1130, 1145, 1210], [0, DAY, 2 * DAY], "2026-01-15T00:00:00"), {"value": "time"}),
    Input("a setting that is called like a clock", BESIDE.format("timeout", 1130, 1145, 1210),
          Series([0, 1, 4], [0, DAY, 2 * DAY], "2026-01-15T00:00:00"), {"value": "level"}),
]  # fmt: skip

TENTHS = [
    dated("tenths of a second", ["2026-01-15 12:30:00.5", "2026-01-15 12:30:00.9",
          "2026-01-15 12:30:01.2"], "2026-01-15T12:30:00.500000", [0, 0.4, 0.7]),
    dated("German tenths", ["15.01.2026 12:30:00,5", "15.01.2026 12:30:00,9",
          "15.01.2026 12:30:01,2"], "2026-01-15T12:30:00.500000", [0, 0.4, 0.7]),
    dated("hundredths", ["2026-01-15T12:30:00.05Z", "2026-01-15T12:30:00.50Z",
          "2026-01-15T12:30:00.75Z"], "2026-01-15T12:30:00.050000+00:00", [0, 0.45, 0.7]),
]  # fmt: skip

THREE = [0, 31 * DAY, 59 * DAY]
JAN = "2026-01-15T00:00:00"
MONTHS = [
    dated("German", ["15. Januar 2026", "15. Februar 2026", "15. März 2026"], JAN, THREE, "Datum"),
    dated("German, short", ["15. Jän. 2026", "15. Feb. 2026", "15. Mrz. 2026"], JAN, THREE),
    dated("French", ["15 janvier 2026", "15 février 2026", "15 mars 2026"], JAN, THREE),
    dated("French, short", ["1er juin 2026", "1er juil. 2026", "1er août 2026"],
          "2026-06-01T00:00:00", [0, 30 * DAY, 61 * DAY]),
    dated("French, with days", ["jeudi 15 janvier 2026", "dimanche 15 février 2026"], JAN,
          THREE[:2]),
    dated("Spanish", ["15 de enero de 2026", "15 de febrero de 2026", "15 de marzo de 2026"], JAN,
          THREE),
    dated("Spanish, short", ["15-ene-26", "15-feb-26", "15-dic-26"], JAN, [0, 31 * DAY, 334 * DAY]),
    dated("Portuguese", ["15 de janeiro de 2026", "15 de fevereiro de 2026", "15 de março de 2026"],
          JAN, THREE),
    dated("Italian", ["15 gennaio 2026", "15 febbraio 2026", "15 ottobre 2026"], JAN,
          [0, 31 * DAY, 273 * DAY]),
    dated("Polish", ["15 stycznia 2026", "15 lutego 2026", "15 października 2026"], JAN,
          [0, 31 * DAY, 273 * DAY]),
    dated("Dutch months", ["jan 2026", "feb 2026", "mrt 2026", "mei 2026"], "2026-01-01T00:00:00",
          [0, 31 * DAY, 59 * DAY, 120 * DAY]),
    dated("Turkish", ["15 Oca 2026", "15 Şub 2026", "15 Ağu 2026"], JAN, [0, 31 * DAY, 212 * DAY]),
    dated("accents apart", ["15 fe\u0301vr. 2026", "15 aou\u0302t 2026"], "2026-02-15T00:00:00",
          [0, 181 * DAY]),
    dated("a clock behind", ["15. März 2026 12:30", "15. März 2026 12:45"], "2026-03-15T12:30:00",
          [0, 15 * MIN]),
    refused("a word that is no month", series(["15 jan 2026", "16 jan 2026", "17 jon 2026"]),
            "line 4", "17 jon 2026"),
    dated("Austrian", ["15. Jänner 2026", "15. Feber 2026"], JAN, [0, 31 * DAY]),
    dated("German Excel", ["Okt-20", "Nov-20", "Dez-20", "Jan-21"], "2020-10-01T00:00:00",
          [0, 31 * DAY, 61 * DAY, 92 * DAY]),
    dated("September, by its beginning", ["15 sept. 2026", "16 septemb. 2026", "17 sep 2026"],
          "2026-09-15T00:00:00", [0, DAY, 2 * DAY]),
    refused("words that begin like months", series(["15 marble 2026", "16 marble 2026"]), "'date'"),
    refused("words without days", series(["ma 26", "ju 26", "se 26"]), "'date'"),
    refused("no months", series(["15 foo 2026", "16 foo 2026", "17 bar 2026"]), "'date'"),
]  # fmt: skip

EVENTS = "time,event\n1,call\n2,call\n12,rest\n30,rest\n"
MATCH = "time,type,team\n18,goal,A\n38,yellow card,B\n59,goal,A\n"
CLOCKS = "time,level\n01:30,0\n02:00,1\n02:30,4\n"
AT = (1.0, 2.0, 12.0, 30.0)
HEART = np.sin(np.arange(4000) / 250 * 2 * np.pi * 1.2) ** 31


def heart(header: str, factor: float) -> str:
    rows = [f"{i / 250 * factor:.6g},{value:.4f}" for i, value in enumerate(HEART)]
    return "\n".join([f"{header},ecg", *rows]) + "\n"


def minutes_of(*at: float) -> list[float]:
    return [60.0 * one for one in at]


UNITS = [
    Input("numbers under time are seconds", EVENTS, Events(AT, noted="plain time in s")),
    Input("numbers under time, told", EVENTS, Events(minutes_of(*AT), noted="plain time in min"),
          {"time": "time:min"}),
    Input("minutes by their header", EVENTS.replace("time", "minute"),
          Events(minutes_of(*AT), noted="plain time in min")),
    Input("minutes of a header, told", EVENTS.replace("time", "minute"),
          Events(AT, noted="plain time in s"), {"time": "minute:s"}),
    Input("a match's minutes", MATCH, Events([0, 1080, 2280, 2700, 3540, 5400],
          noted="column 'time' (minutes of the match; time='time:s'")),
    Input("a match's seconds, told", MATCH, Events([18, 38, 59], ("goal", "yellow_card", "goal"),
          noted="plain time in s"), {"time": "time:s"}),
    Input("m:ss", CLOCKS, Series([0, 1, 4], [0, 30, 60], noted="(m:ss or h:mm:ss)")),
    Input("h:mm, told", CLOCKS, Series([0, 1, 4], [0, 30 * MIN, HOUR], noted="(h:mm"),
          {"time": "time:hhmm"}),
    Input("h:mm by a header", CLOCKS.replace("time", "time of day"),
          Series([0, 1, 4], [0, 30 * MIN, HOUR], noted="(h:mm")),
    Input("a series in minutes", "time (min),level\n0,0\n1.5,1\n3,4\n",
          Series([0, 1, 4], [0, 90, 180], noted="plain time in min")),
    Input("a series, told", "t,level\n0,0\n1.5,1\n3,4\n",
          Series([0, 1, 4], [0, 90, 180], noted="plain time in min"), {"time": "t:min"}),
]  # fmt: skip


def lasting(name: str, header: str, factor: float, words: str, **options: Any) -> Input:
    truth = Events((), noted=words, duration_s=16.0)
    return Input(f"a heart in {name}", heart(header, factor), truth, options)


HEARTS = [
    lasting("seconds", "time", 1.0, "column 'time' (plain time in s)"),
    lasting("milliseconds", "time (ms)", 1e3, "(plain time in ms)"),
    lasting("milliseconds, by a blank", "time ms", 1e3, "(plain time in ms)"),
    lasting("milliseconds by the rate", "time", 1e3, "(plain time in ms"),
    lasting("minutes", "time [min]", 1 / 60, "(plain time in min)"),
    lasting("minutes, told", "t", 1 / 60, "(plain time in min)", time="t:min"),
    refused(
        "a heart in an unknown unit",
        heart("time", 1.0),
        "'xyz' is not a format of times",
        time="time:xyz",
    ),
]


@parametrized(COMPACT, TENTHS, MONTHS, UNITS)
def test_times_are_read_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


@parametrized(HEARTS)
def test_the_times_of_a_heart_are_those_of_other_tables(made: Input, tmp_path: Path) -> None:
    if isinstance(made.truth, Refused):
        check(made, tmp_path)
        return
    assert isinstance(made.truth, Events)
    path = tmp_path / "made.csv"
    path.write_text(str(made.data))
    timeline = ov.load_timeline(path, **made.options)
    assert timeline.duration_s == pytest.approx(16.0, abs=0.02)
    assert "beats" in timeline.provenance
    assert made.truth.noted in timeline.provenance
