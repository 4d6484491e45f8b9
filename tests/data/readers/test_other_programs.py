"""Files of other programs: spreadsheets, watches, health exports, EDF recordings, charts."""

from __future__ import annotations

import datetime as dt
import gzip
import json
import struct
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.readers.registry import list_matches
from overview_dsp.data.readers.tables import workbook_process
from tests.data.readers.make_cardiac import beat_times, ecg
from tests.data.readers.outcome import timeline_or_one_line

SHEET = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
LINKS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PARTS = "http://schemas.openxmlformats.org/package/2006"


def cell(value: Any) -> str:
    if isinstance(value, str):
        return f'<c t="inlineStr"><is><t>{value}</t></is></c>'
    if isinstance(value, np.datetime64):  # days since 1899-12-30, in the style of dates
        days = (value - np.datetime64("1899-12-30")) / np.timedelta64(1, "D")
        return f'<c s="1"><v>{float(days)!r}</v></c>'
    return f"<c><v>{value}</v></c>" if value is not None else "<c/>"


def workbook(path: Path, **sheets: list[tuple[Any, ...]]) -> Path:
    """Write an Excel workbook as its standard (ECMA-376) says, without a library."""
    names = "".join(
        f'<sheet name="{name}" sheetId="{i}" r:id="r{i}"/>' for i, name in enumerate(sheets, 1)
    )
    links = [("styles", "s", "styles.xml")]
    links += [("worksheet", f"r{i}", f"worksheets/sheet{i}.xml") for i in range(1, 1 + len(sheets))]
    relations = "".join(
        f'<Relationship Id="{id_}" Type="{LINKS}/{kind}" Target="{file}"/>'
        for kind, id_, file in links
    )
    with zipfile.ZipFile(path, "w") as book:
        book.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{PARTS}/content-types"><Default Extension="xml" '
            'ContentType="application/xml"/></Types>',
        )
        book.writestr(
            "_rels/.rels",
            f'<Relationships xmlns="{PARTS}/relationships"><Relationship Id="w" '
            f'Type="{LINKS}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        )
        book.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{SHEET}" xmlns:r="{LINKS}"><sheets>{names}</sheets></workbook>',
        )
        book.writestr(
            "xl/_rels/workbook.xml.rels",
            f'<Relationships xmlns="{PARTS}/relationships">{relations}</Relationships>',
        )
        book.writestr(
            "xl/styles.xml",
            f'<styleSheet xmlns="{SHEET}"><cellXfs count="2"><xf numFmtId="0"/>'
            '<xf numFmtId="22"/></cellXfs></styleSheet>',
        )
        for i, rows in enumerate(sheets.values(), 1):
            lines = "".join(f"<row>{''.join(map(cell, row))}</row>" for row in rows)
            book.writestr(
                f"xl/worksheets/sheet{i}.xml",
                f'<worksheet xmlns="{SHEET}"><sheetData>{lines}</sheetData></worksheet>',
            )
    return path


DAYS = [np.datetime64("2026-01-05") + i for i in range(4)]
PRICES = [("date", "load", "note"), *((day, 1.5 * i * i, None) for i, day in enumerate(DAYS))]
MATCH = [("Minute", "What"), (3, "Foul by Hill"), ("45+2", "GOAL! Jones"), (60, "Yellow card")]
HOURS = [("when", "load"), *((DAYS[0] + np.timedelta64(90 * i, "m"), i) for i in range(3))]


def test_a_sheet_is_read_like_its_csv(tmp_path: Path) -> None:
    pytest.importorskip("python_calamine", reason="needs the extra [spreadsheets]")
    path = workbook(tmp_path / "book.xlsx", Empty=[], Prices=PRICES, Match=MATCH, Hours=HOURS)
    timeline = ov.load_timeline(path)
    curve = timeline.intensity
    assert curve is not None
    assert timeline.title == "book: load"
    assert curve.value.tolist() == [0.0, 1.5, 6.0, 13.5]
    assert curve.time_s.tolist() == [86_400.0 * i for i in range(4)]
    assert str(timeline.start) == "2026-01-05 00:00:00"
    assert any("takes one of 'Empty', 'Prices', 'Match'" in note for note in timeline.notes)
    match = ov.load_timeline(path, match="Match")
    assert [(e.kind, e.time_s) for e in match.events if e.kind != "period"] == [
        ("foul", 180.0), ("goal", 2820.0), ("yellow_card", 3720.0),
    ]  # fmt: skip
    hours = ov.load_timeline(path, match="Hours").intensity
    assert hours is not None
    assert hours.time_s.tolist() == [0.0, 5400.0, 10_800.0]
    # another name is one of rows, of the first sheet with cells
    with pytest.raises(ov.InputError, match=r"book.xlsx: .*'Nothing'"):
        ov.load_timeline(path, match="Nothing")


def test_a_duration_in_a_sheet_is_a_clock_not_days() -> None:
    for seconds, text in ((0, "0:00:00"), (5400.5, "1:30:00.5"), (90_061, "25:01:01")):
        assert workbook_process.text_of(dt.timedelta(seconds=seconds)) == text
    assert workbook_process.text_of(dt.datetime(2026, 1, 5)) == "2026-01-05"
    assert workbook_process.text_of(dt.datetime(2026, 1, 5, 7)) == "2026-01-05 07:00:00"
    assert workbook_process.text_of(3.0) == "3"


def test_a_child_with_a_long_report_is_read_to_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("python_calamine", reason="needs the extra [spreadsheets]")
    child = tmp_path / "child.py"
    child.write_text(
        "import sys\nprint('x' * 10**6, file=sys.stderr)\nprint('[\"A\"]')\nsys.exit('so it is')\n"
    )
    monkeypatch.setattr("overview_dsp.data.readers.tables.workbook._CHILD", child)
    with pytest.raises(ov.InputError, match=r"not a readable spreadsheet .so it is."):
        ov.load_timeline(workbook(tmp_path / "book.xlsx", A=PRICES))


@pytest.mark.parametrize("kind", ["text", "spreadsheet"])
def test_only_a_spreadsheet_of_opendocument_is_taken_for_one(kind: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "x", "w") as document:
        document.writestr("mimetype", f"application/vnd.oasis.opendocument.{kind}")
        document.writestr("content.xml", "<x/>")
    reason = "OpenDocument text" if kind == "text" else "spreadsheet .*CSV"
    with pytest.raises(ov.InputError, match=reason):
        ov.load_timeline(tmp_path / "x")


def test_a_damaged_or_empty_spreadsheet_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("python_calamine", reason="needs the extra [spreadsheets]")
    with pytest.raises(ov.InputError, match="no cells"):
        ov.load_timeline(workbook(tmp_path / "empty.xlsx", A=[], B=[]))
    wrong = workbook(tmp_path / "wrong.xlsx", A=[*PRICES, ("later", 3.0, None), (DAYS[0], 1, None)])
    with pytest.raises(ov.InputError, match=r"wrong.xlsx: row 6, column 'date'.*later"):
        ov.load_timeline(wrong)
    # a cell in the last row and column would need 400 GB
    with zipfile.ZipFile(wrong) as book, zipfile.ZipFile(tmp_path / "far.xlsx", "w") as other:
        for name in book.namelist():
            last = b'<row r="1048576"><c r="XFD1048576"><v>1</v></c></row></sheetData>'
            other.writestr(name, book.read(name).replace(b"</sheetData>", last))
    with pytest.raises(ov.InputError, match="needs too much memory"):
        ov.load_timeline(tmp_path / "far.xlsx")
    (tmp_path / "old.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600))
    with pytest.raises(ov.InputError, match="not a readable spreadsheet"):
        ov.load_timeline(tmp_path / "old.xls")


def crc(data: bytes) -> int:
    """CRC-16 as FIT files have it (polynomial 0x8005, reflected)."""
    found = 0
    for byte in data:
        found ^= byte
        for _ in range(8):
            found = (found >> 1) ^ (0xA001 if found & 1 else 0)
    return found


def fit(points: list[tuple[int, float, float, int, int]], outside: bool = True) -> bytes:
    """Write records of (time s, latitude, longitude, heart rate, power) as a Garmin FIT file.

    On a treadmill there are no places, but the speed of a sensor: half the power, mm/s.
    """
    places = ((0, 4, 0x85), (1, 4, 0x85)) if outside else ((6, 2, 0x84),)
    fields = ((253, 4, 0x86), *places, (3, 1, 0x02), (7, 2, 0x84))
    body = struct.pack("<BBBHB", 0x40, 0, 0, 20, len(fields))
    body += b"".join(struct.pack("<BBB", *one) for one in fields)
    for time_s, lat, lon, heart, power in points:
        where = [round(one / 180.0 * 2**31) for one in (lat, lon)] if outside else [power // 2]
        body += struct.pack(f"<BI{'ii' if outside else 'H'}BH", 0, time_s, *where, heart, power)
    head = struct.pack("<BBHI4s", 14, 0x20, 2132, len(body), b".FIT")
    head += struct.pack("<H", crc(head))
    return head + body + struct.pack("<H", crc(head + body))


RUN = [(1_136_505_600 + i, 47.0 + i * 1e-4, 8.0, 120 + i, 200 + 2 * i) for i in range(30)]


def test_a_fit_file_of_a_watch_is_a_track(tmp_path: Path) -> None:
    pytest.importorskip("fitdecode", reason="needs the extra [fit]")
    (tmp_path / "run.fit").write_bytes(fit(RUN))
    timeline = ov.load_timeline(tmp_path / "run.fit")
    curve = timeline.intensity
    assert curve is not None
    assert (timeline.title, curve.unit) == ("run: speed", "km/h")
    # 1e-4 degrees of latitude in a second
    assert curve.value == pytest.approx(6_371_008.8 * np.radians(1e-4) * 3.6, rel=1e-3)
    assert str(timeline.start) == "2026-01-05 00:00:00+00:00"  # seconds since 1989-12-31
    for name, first in (("heart_rate", 120.0), ("power", 200.0)):
        values = ov.load_timeline(tmp_path / "run.fit", value=name).intensity
        assert values is not None
        assert values.value[0] == first
    inside = ov.load_timeline(fit(RUN, outside=False)).intensity
    assert inside is not None
    assert inside.unit == "km/h"
    assert inside.value == pytest.approx([3.6 * (100 + i) / 1000.0 for i in range(30)])


@given(data=st.data())
def test_any_change_of_a_fit_file_is_refused_in_one_line(data: st.DataObject) -> None:
    pytest.importorskip("fitdecode", reason="needs the extra [fit]")
    whole = bytearray(fit(RUN))
    place = data.draw(st.integers(16, len(whole) - 1))
    whole[place] ^= data.draw(st.integers(1, 255))
    end = data.draw(st.sampled_from((len(whole), place)))
    with pytest.raises(ov.InputError, match="a damaged FIT file") as caught:
        ov.load_timeline(bytes(whole[:end]))
    assert "\n" not in str(caught.value)


def record(kind: str, unit: str, hour: int, value: object) -> str:
    at = f"2026-01-05 {hour:02}:00:00 +0100"
    return f'<Record type="{kind}" unit="{unit}" startDate="{at}" endDate="{at}" value="{value}"/>'


HEALTH = "\n".join(
    [
        '<?xml version="1.0"?>\n<!DOCTYPE HealthData [\n<!ELEMENT HealthData (Record*)>\n]>',
        "<HealthData>",
        *(record("HKQuantityTypeIdentifierHeartRate", "count/min", h, 60 + h) for h in range(6)),
        *(record("HKQuantityTypeIdentifierStepCount", "count", h, h * h) for h in range(6)),
        record("HKCategoryTypeIdentifierSleepAnalysis", "", 3, "HKCategoryValueSleepAnalysisAwake"),
        "</HealthData>\n",
    ]
)


@pytest.mark.parametrize("name", ["export.zip", "export.xml", "export.xml.gz", "export"])
def test_the_export_of_apple_health_is_a_table_of_metrics(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if name in ("export.xml.gz", "export"):
        path.write_bytes(gzip.compress(HEALTH.encode()))
    elif name == "export.zip":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("apple_health_export/export_cda.xml", "<ClinicalDocument/>")
            archive.writestr("apple_health_export/workout-routes/route.gpx", "<gpx/>")
            archive.writestr("apple_health_export/export.xml", HEALTH)
    else:
        path.write_text(HEALTH)
    with pytest.raises(ov.InputError, match=r"HeartRate \(count/min\)', 'StepCount") as caught:
        ov.load_timeline(path)
    assert "--select 'metric=HeartRate (count/min)'" in str(caught.value)
    steps = ov.load_timeline(path, match="metric=StepCount (count)")
    assert steps.intensity is not None
    assert steps.intensity.value.tolist() == [0.0, 1.0, 4.0, 9.0, 16.0, 25.0]
    assert str(steps.start) == "2026-01-05 00:00:00+01:00"
    assert list(ov.load_timelines(path, "metric")) == ["HeartRate (count/min)", "StepCount (count)"]


def test_entities_and_broken_xml_in_a_health_export_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "export.xml"
    bomb = '<!ENTITY a "aaaaaaaa">\n<!ENTITY b "&a;&a;">\n]>'
    path.write_text(HEALTH.replace("]>", bomb, 1))
    with pytest.raises(ov.InputError, match="entities"):
        ov.load_timeline(path)
    long = f'<!ATTLIST Record unit CDATA "{"a" * 1000}">\n]>'
    path.write_text(HEALTH.replace("]>", long, 1))
    with pytest.raises(ov.InputError, match="default values"):
        ov.load_timeline(path)
    path.write_text(HEALTH[:-40])
    with pytest.raises(ov.InputError, match="broken XML"):
        ov.load_timeline(path)
    path.write_text("<HealthData></HealthData>")
    with pytest.raises(ov.InputError, match="no records with numbers"):
        ov.load_timeline(path)


def edf(signals: list[tuple[str, str, float, np.ndarray]], notes: list[tuple[float, str]]) -> bytes:
    """Write signals of (name, unit, Hz, samples) in records of 1 s as EDF+ says."""
    seconds = len(signals[0][3]) // int(signals[0][2]) if signals else 60
    tags = [f"+{i}\x14\x14\x00" for i in range(seconds)]
    for at, text in notes:
        tags[int(at)] += f"+{at:g}\x14{text}\x14\x00"
    most = max(map(len, tags))
    columns = [(n, u, -100.0, 100.0, int(rate)) for n, u, rate, _ in signals]
    columns.append(("EDF Annotations", "", -1.0, 1.0, -(-most // 2)))
    head = f"{'0':8}{'X X X X':80}{'Startdate 05-JAN-2026 X X X':80}05.01.2600.00.00"
    head += f"{256 * (1 + len(columns)):<8}{'EDF+C':44}{seconds:<8}{'1':8}{len(columns):<4}"
    for width, texts in (
        (16, [name for name, *_ in columns]), (80, [""] * len(columns)),
        (8, [unit for _, unit, *_ in columns]), (8, [f"{low:g}" for _, _, low, *_ in columns]),
        (8, [f"{high:g}" for *_, high, _ in columns]), (8, ["-32768"] * len(columns)),
        (8, ["32767"] * len(columns)), (80, [""] * len(columns)),
        (8, [str(count) for *_, count in columns]), (32, [""] * len(columns)),
    ):  # fmt: skip
        head += "".join(f"{text:{width}}" for text in texts)
    body = b""
    for i in range(seconds):
        for _, _, rate, samples in signals:
            part = samples[i * int(rate) : (i + 1) * int(rate)]
            body += np.round((part + 100.0) / 200.0 * 65_535 - 32_768).astype("<i2").tobytes()
        body += tags[i].encode().ljust(2 * columns[-1][4], b"\0")
    return head.encode() + body


EEG = 50.0 * np.sin(np.arange(6000) / 300.0)
BEATS = beat_times(60.0)
NIGHT = [("EEG Fpz-Cz", "uV", 100.0, EEG), ("ECG", "mV", 250.0, 50.0 * ecg(BEATS, 60.0, 250.0))]


def test_an_edf_recording_gives_its_heart_or_the_signal_that_is_named(tmp_path: Path) -> None:
    pytest.importorskip("edfio", reason="needs the extra [edf]")
    path = tmp_path / "night.edf"
    path.write_bytes(edf(NIGHT, [(10.5, "Lights off"), (30.0, "Sleep stage W")]))
    heart = ov.load_timeline(path)
    assert heart.kinds()["beat"] == pytest.approx(len(BEATS), abs=2)
    assert heart.intensity is not None
    assert heart.intensity.unit == "bpm"
    sleep = [(e.time_s, e.kind, e.label) for e in heart.events if e.kind != "beat"]
    expected = [(10.5, "lights_off", "Lights off"), (30.0, "sleep_stage_w", "Sleep stage W")]
    assert [one for one in sleep if "_" in one[1]] == expected
    brain = ov.load_timeline(path, value="EEG Fpz-Cz")
    assert brain.intensity is not None
    assert brain.intensity.unit == "uV"
    assert brain.intensity.value == pytest.approx(EEG, abs=0.01)
    assert [e for e in brain.events if e.kind == "lights_off"]


def test_edf_recordings_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("edfio", reason="needs the extra [edf]")
    two = [NIGHT[0], ("Temp", "degC", 1.0, np.full(60, 37.0))]
    whole = edf(two, [])
    with pytest.raises(ov.InputError, match=r"2 signals; name one.*'EEG Fpz-Cz', 'Temp'"):
        ov.load_timeline(whole)
    with pytest.raises(ov.InputError, match=r"2 signals; name one"):
        ov.load_timeline(whole, value="EEG O1")
    with pytest.raises(ov.InputError, match=r"EDF\+D recording with gaps"):
        ov.load_timeline(whole.replace(b"EDF+C", b"EDF+D", 1), value="Temp")
    for end in (300, 700, len(whole) // 2):
        with (
            warnings.catch_warnings(),
            pytest.raises(ov.InputError, match=r"cut off|damaged") as caught,
        ):
            ov.load_timeline(whole[:end], value="Temp")
        assert "\n" not in str(caught.value)


def test_annotations_without_signals_are_events() -> None:
    pytest.importorskip("edfio", reason="needs the extra [edf]")
    stages = [(0.0, "Sleep stage W"), (30.0, "Sleep stage 1"), (45.5, "Sleep stage 2")]
    night = ov.load_timeline(edf([], stages))
    assert [(e.time_s, e.label) for e in night.events] == stages
    assert night.duration_s == 60.0
    assert night.intensity is None


def chart(kind: str, data: object, x: object = "x", **more: object) -> dict[str, object]:
    return {
        "type": kind,
        "title": "Made",
        "axes": {"x": x, "y": {"label": "Tips"}},
        "data": data,
    } | more


DAYS_OF_WEEK = [{"x": "Sat", "y": 87}, {"x": "Sun", "y": 76}, {"x": "Fri", "y": 19}]
YEARS = [{"x": 1967 + i, "y": i * i} for i in range(8)]
BINS = [{"x": 30 + 2 * i, "y": i * (9 - i), "xMin": 29, "xMax": 31} for i in range(10)]
TWO = [[{"x": f"2026-01-0{i}", "y": i * n, "fill": f"line {n}"} for i in (1, 2, 3)] for n in (1, 2)]


def read_chart(document: object, **options: Any) -> ov.Timeline:
    return ov.load_timeline(json.dumps(document).encode(), **options)


def test_charts_of_maidr_are_read_by_their_x_axis() -> None:
    layers = {"id": "a", "subplots": [[{"layers": [chart("bar", DAYS_OF_WEEK)]}]]}
    bars = read_chart(layers)
    assert bars.title == "Made: Tips"
    assert [(e.time_s, e.kind, e.label) for e in bars.events] == [
        (0.0, "bar", "Sat: 87"), (1.0, "bar", "Sun: 76"), (2.0, "bar", "Fri: 19"),
    ]  # fmt: skip
    turned = chart("bar", [{"x": d["y"], "y": d["x"]} for d in DAYS_OF_WEEK], orientation="horz")
    assert [e.label for e in read_chart(turned | {"axes": {"x": "Tips", "y": "Day"}}).events] == [
        "Sat: 87", "Sun: 76", "Fri: 19",
    ]  # fmt: skip
    line = read_chart(chart("line", [YEARS], x="Year"))
    assert str(line.start) == "1967-01-01 00:00:00"
    assert line.intensity is not None
    assert line.intensity.value.tolist() == [i * i for i in range(8)]
    bins = read_chart(chart("hist", BINS)).intensity
    assert bins is not None
    assert bins.time_s.tolist() == [2.0 * i for i in range(10)]
    points = read_chart(chart("point", {"x": [3, 1, 2], "y": [9, 1, 4]})).intensity
    assert points is not None
    assert points.value.tolist() == [1.0, 4.0, 9.0]


def test_the_names_of_bars_are_events_and_times_are_not() -> None:
    bars = read_chart(chart("bar", DAYS_OF_WEEK, x="Day"))
    assert "the names of 'Day' stand one second apart" in bars.notes
    dates = [{"x": f"2026-01-0{1 + i}", "y": i} for i in range(3)]
    with pytest.raises(ov.InputError, match="'x'"):  # one name among dates is a mistake
        read_chart(chart("bar", [*dates, {"x": "total", "y": 3}]))
    same = read_chart(chart("line", [YEARS], x="Tips")).intensity
    assert same is not None
    assert same.value.tolist() == [i * i for i in range(8)]
    twice = chart("line", [[{"x": i, "y": i} for i in range(3)]] * 3)
    with pytest.raises(ov.InputError, match=r"'Made', 'Made \(2\)', 'Made \(3\)'"):
        read_chart(twice)
    for layers in ({"a": 1}, 3, None):
        with pytest.raises(ov.InputError):
            read_chart({"subplots": [[{"layers": layers}]]})


def test_one_line_of_a_chart_is_chosen_by_its_name(tmp_path: Path) -> None:
    document = chart("line", TWO, x="Date")
    (tmp_path / "two.json").write_text(json.dumps(document))
    assert list_matches(tmp_path / "two.json") == ("Made, line 1", "Made, line 2")
    with pytest.raises(ov.InputError, match=r"2 lines; choose one with match.*'Made, line 2'"):
        read_chart(document)
    second = read_chart(document, match="Made, line 2").intensity
    assert second is not None
    assert second.value.tolist() == [2.0, 4.0, 6.0]


@given(
    data=st.recursive(
        st.none() | st.booleans() | st.integers(-3, 3) | st.sampled_from(("x", "", "2026-01-01")),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(("x", "y", "fill", "points", "layers")), inner, max_size=3
            )
        ),
        max_leaves=12,
    ),
    kind=st.sampled_from(("line", "bar", "heat")),
)
def test_any_chart_is_read_or_refused_in_one_line(data: Any, kind: str) -> None:
    for document in (chart(kind, data), {"subplots": [[{"layers": [chart(kind, data)]}]]}):
        timeline_or_one_line(lambda document=document: read_chart(document))
