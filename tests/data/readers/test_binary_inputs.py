"""Excel workbooks, FIT files and EDF recordings: each read right, or refused with the remedy."""

from __future__ import annotations

import io
import re
import struct
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import overview_dsp as ov
from tests.data.readers.test_other_programs import crc, workbook
from tests.data.readers.truths import Events, Input, Refused, Series, check, parametrized

for extra in ("python_calamine", "fitdecode", "edfio"):
    pytest.importorskip(extra)

DAY = 86_400.0
SERIAL = 46_027  # 2026-01-05, days since 1899-12-30
START = "2026-01-05T00:00:00"

# ---- Excel (ECMA-376) ----

STYLES = {"date": 14, "percent": 10, "elapsed": 46, "clock": 20}  # built-in number formats


RAW = r'<c t="inlineStr"><is><t>RAW:(.*?)</t></is></c>'


def raw(xml: str) -> str:
    return f"RAW:{xml}"


def number(value: float, style: str) -> str:
    return raw(f'<c s="{2 + list(STYLES).index(style)}"><v>{value!r}</v></c>')


def book(*changes: tuple[str, str], **sheets: list[tuple[Any, ...]]) -> bytes:
    """Write sheets with cells as XML, more styles, and other changes of the XML."""
    more = "".join(f'<xf numFmtId="{one}" applyNumberFormat="1"/>' for one in STYLES.values())
    changes += (('<xf numFmtId="22"/>', f'<xf numFmtId="22"/>{more}'), ('count="2"', 'count="6"'))
    made = io.BytesIO()
    with tempfile.TemporaryDirectory() as folder:
        plain = workbook(Path(folder) / "plain.xlsx", **sheets)
        with zipfile.ZipFile(plain) as old, zipfile.ZipFile(made, "w") as new:
            for part in old.namelist():
                text = re.sub(RAW, r"\1", old.read(part).decode())
                for before, after in changes:
                    text = text.replace(before, after)
                new.writestr(part, text)
    return made.getvalue()


def merged(*cells: str) -> tuple[str, str]:
    each = "".join(f'<mergeCell ref="{one}"/>' for one in cells)
    return "</sheetData>", f'</sheetData><mergeCells count="{len(cells)}">{each}</mergeCells>'


def dated(values: Sequence[Any], first: int = SERIAL) -> list[tuple[Any, ...]]:
    return [(number(first + i, "date"), value) for i, value in enumerate(values)]


def excel(name: str, data: bytes, truth: Any, **options: Any) -> Input:
    return Input(name, data, truth, options, "book.xlsx")


MAC = ("<sheets>", '<workbookPr date1904="1"/><sheets>')
LOADS = (3.5, 4.25, 1.5, 6.0)
TITLED = [("Load of the pump station",), ("date", "load"), *dated(LOADS)]
NOTED = [("Load of the pump station",), ("exported on", "2 March"), ("", ""), *TITLED[1:]]
SINCE_1904 = [("date", "load"), *((SERIAL - 1462 + i, load) for i, load in enumerate(LOADS))]
TEXTS = [("Datum", "Verbrauch (kWh)")]
TEXTS += [(f"{5 + i:02}.01.2026", t) for i, t in enumerate(("1.234,5", "987,25", "1.001,0"))]
FORMULAS = [("date", "load"), *dated(LOADS[:1])]
FORMULAS += [(raw("<c/>"), raw("<c/>")), ()]  # two empty rows
FORMULAS += [
    (raw(f'<c s="2"><f>A{2 + i}+1</f><v>{SERIAL + i}</v></c>'), value)
    for i, value in (
        (1, raw("<c><f>1.5*B2-1</f><v>4.25</v></c>")),
        (2, raw('<c t="e"><f>NA()</f><v>#N/A</v></c>')),
        (3, raw("<c><f>SUM(B2:B3)</f><v>6</v></c>")),
        (4, raw("<c><f>AVERAGE(B2:B3)</f><v>2.5</v></c>")),
    )
]
LEVELS = [("", "Station A", raw("<c/>")), ("date", "temp", "rain")]
LEVELS += [(number(SERIAL + i, "date"), 20.5 + i, load) for i, load in enumerate(LOADS)]
ELAPSED = [("time", "load")]
ELAPSED += [(number((23 + i) / 24, "elapsed"), load) for i, load in enumerate(LOADS)]
LANDS = [("year", "country", "value")]
LANDS += [(y, c, v + y - 2001) for y in (2001, 2002, 2003) for c, v in (("Norway", 5), ("Peru", 9))]
README = [("This workbook", "Owner"), ("sheet Data has the values", "Ann")]
PARTS = (0.125, 0.5, 0.25, 0.375)
SHARES = [("date", "humidity")]
SHARES += dated([number(part, "percent") for part in PARTS], SERIAL - 1462)
TWO = {"Prices": [("date", "price"), *dated(LOADS)], "Loads": [("date", "load"), *dated(LOADS)]}

XLSX = [
    excel("a title above the header, merged", book(merged("A1:B1"), A=TITLED),
          Series(LOADS, DAY * np.arange(4), START, "", "column 'load'")),
    excel("a title, a line of the export and an empty row", book(A=NOTED),
          Series(LOADS, DAY * np.arange(4), START, "", "3 lines before the table")),
    excel("German dates and decimal commas as text", book(A=TEXTS),
          Series((1234.5, 987.25, 1001.0), DAY * np.arange(3), START, "kWh")),
    excel("dates since 1904 and per cents, both by style", book(MAC, A=SHARES),
          Series(PARTS, DAY * np.arange(4), START)),
    excel("dates since 1904, without a style", book(MAC, A=SINCE_1904),
          Series(LOADS, DAY * np.arange(4), START)),
    excel("a total at the end", book(A=[("date", "load"), *dated(LOADS), ("Total", sum(LOADS))]),
          Refused(("row 6", "Total"))),
    excel("formulas, an error and empty rows", book(A=FORMULAS),
          Series((3.5, 4.25, 6.0, 2.5), DAY * np.array((0, 1, 3, 4)), START, noted="gap")),
    excel("a header of two rows, merged", book(merged("B1:C1"), A=LEVELS),
          Series(LOADS, DAY * np.arange(4), START, ""), value="rain"),
    excel("elapsed times over 24 h", book(A=ELAPSED), Series(LOADS, 3600.0 * np.arange(4))),
    excel("a first sheet without a table", book(Readme=README, Data=LANDS),
          Refused(("first sheet", "--select", "'Data'"))),
    excel("groups in the second sheet", book(Readme=README, Data=LANDS),
          Refused(("--select", "Norway", "Peru")), match="Data"),
    excel("no sheet of this name", book(**TWO), Refused(("'Prices'", "'Loads'")), match="Load"),
]  # fmt: skip

# ---- Garmin FIT (its SDK's protocol document) ----

AT = 1_136_505_600  # 2026-01-05, seconds since 1989-12-31
BEGIN = f"{START}+00:00"
TIME, HEART = (253, 0x86, "I"), (3, 0x02, "B")
PLACE = ((0, 0x85, "i"), (1, 0x85, "i"))
NOWHERE = 0x7FFFFFFF
STEP = 2048  # semicircles a second
EXACT = STEP * np.pi / 2**31 * 6_371_008.8 * 3.6  # km/h, on the mean radius of the earth
PACE = round(EXACT, 3)
Field = tuple[int, int, str]


def messages(
    kind: int,
    fields: Sequence[Field],
    *rows: Sequence[Any],
    local: int = 0,
    order: str = "<",
    developer: Sequence[tuple[int, str]] = (),
) -> list[bytes]:
    """Give a definition and its messages; fields are (number, base type, struct's format)."""
    more = b"".join(struct.pack("<BBB", n, struct.calcsize(f), 0) for n, f in developer)
    head = struct.pack("<BBB", 0x40 | local | 0x20 * bool(developer), 0, order == ">")
    head += struct.pack(f"{order}HB", kind, len(fields))
    head += b"".join(struct.pack("<BBB", n, struct.calcsize(f), base) for n, base, f in fields)
    form = f"{order}B" + "".join([f for *_, f in fields] + [f for _, f in developer])
    head += bytes([len(developer)]) + more if developer else b""
    return [head, *(struct.pack(form, local, *row) for row in rows)]  # fmt: skip


def fit(*parts: bytes) -> bytes:
    """Add the file's first message, its header and its check sums."""
    id_ = ((0, 0x00, "B"), (1, 0x84, "H"), (2, 0x84, "H"), (3, 0x8C, "I"), (4, 0x86, "I"))
    body = b"".join([*messages(0, id_, (4, 1, 1, 7, AT)), *parts])
    head = struct.pack("<BBHI4s", 14, 0x20, 2132, len(body), b".FIT")
    head += struct.pack("<H", crc(head))
    return head + body + struct.pack("<H", crc(head + body))


def records(fields: Sequence[Field], *rows: Sequence[Any], **more: Any) -> list[bytes]:
    return messages(20, (TIME, *fields), *((AT + t, *row) for t, *row in rows), **more)


def wrapped(semicircles: int) -> int:
    return (semicircles + 2**31) % 2**32 - 2**31


NORTH, EAST, FIJI = 560_000_000, 95_000_000, -200_000_000
HEARTS = [100 + i for i in range(12)]
STRAP = records([HEART], *((i, 0xFF if i in (5, 6) else h) for i, h in enumerate(HEARTS)))
TUNNEL = records([*PLACE, HEART], *(
    (i, *((NOWHERE, NOWHERE) if 10 <= i < 13 else (NORTH + STEP * i, EAST)), 120)
    for i in range(30)
))  # fmt: skip
EVENT = (TIME, (0, 0x00, "B"), (1, 0x00, "B"))  # the timer: 0 starts, 4 stops
MOVED = [(i if i < 10 else 599 + i, NORTH + STEP * min(i, 9) + STEP * max(i - 10, 0), EAST)
         for i in range(20)]  # fmt: skip
PAUSE = [*messages(21, EVENT, (AT, 0, 0)), *records(PLACE, *MOVED[:10], local=1),
         *messages(21, EVENT, (AT + 9, 0, 4), (AT + 609, 0, 0)),
         *records(PLACE, *MOVED[10:], local=1)]  # fmt: skip
FIJIAN = records(PLACE, *((i, FIJI, wrapped(2**31 + STEP * (i - 10))) for i in range(20)))
SESSION = messages(18, (TIME, (2, 0x86, "I"), (7, 0x86, "I"), (5, 0x00, "B")),
                   (AT + 1800, AT, 1_800_000, 1))  # fmt: skip
BELT = records([(73, 0x86, "I"), HEART], *((i, 2500 + 10 * i, 120) for i in range(20)), order=">")
LATER = records([HEART], *((60 + i, 150 + i) for i in range(10)))
MPH = [  # developer_data_id, field_description (with its units), records
    *messages(207, ((1, 0x0D, "16s"), (3, 0x02, "B")), (bytes(range(16)), 0)),
    *messages(206, (*((n, 0x02, "B") for n in (0, 1, 2)), (3, 0x07, "6s"), (8, 0x07, "4s")),
              (0, 0, 0x88, b"speed", b"mph")),
    *records([HEART], *((i, h, 6.0 + i / 4) for i, h in enumerate(HEARTS)), developer=[(0, "f")]),
]  # fmt: skip
SHORT = messages(20, [HEART], local=1)
SHORT += [bytes([0xA0 | (AT + i) & 31, 100 + i]) for i in range(1, 80)]
SPLIT = [part for i in range(20) for part in (
    *records(PLACE, (i, NORTH + STEP * i, EAST)), *records([HEART], (i, 100 + i), local=1))
]  # fmt: skip
EACH = np.arange(20.0)


def watch(name: str, data: bytes, truth: Any, **options: Any) -> Input:
    return Input(name, data, truth, options, "run.fit")


FIT = [
    watch("a chest strap alone, two values invalid", fit(*STRAP),
          Series([h for h in HEARTS if h not in (105, 106)], [0, 1, 2, 3, 4, 7, 8, 9, 10, 11],
                 BEGIN, "bpm", "gap")),
    watch("places unknown in a tunnel", fit(*TUNNEL),
          Series([PACE] * 26, [*range(10), *range(14, 30)], BEGIN, "km/h", "gap")),
    watch("a pause of ten minutes", fit(*PAUSE),
          Series([PACE] * 10 + [0.0] + [PACE] * 9, [t for t, *_ in MOVED], BEGIN, "km/h", "gap")),
    watch("south, over the date line", fit(*FIJIAN),
          Series([round(EXACT * np.cos(FIJI / 2**31 * np.pi), 3)] * 20, EACH, BEGIN, "km/h")),
    watch("a session without records", fit(*SESSION), Refused(("record",))),
    watch("big-endian, enhanced speed on a treadmill", fit(*BELT),
          Series(3.6 * (2.5 + 0.01 * EACH), EACH, BEGIN, "km/h")),
    watch("two files chained", fit(*records([HEART], *enumerate(HEARTS[:10]))) + fit(*LATER),
          Series([*HEARTS[:10], *range(150, 160)], [*range(10), *range(60, 70)], BEGIN, "bpm"),
          value="heart_rate"),
    # or 6 mph, or 9.656 km/h
    watch("a developer's speed in miles an hour", fit(*MPH), Refused(("speed",)), value="speed"),
    watch("compressed timestamps", fit(*records([HEART], (0, 100)), *SHORT),
          Series(100.0 + np.arange(80), range(80), BEGIN, "bpm"), value="heart_rate"),
    watch("places and heart in messages of their own", fit(*SPLIT),
          Series([PACE] * 20, EACH, BEGIN, "km/h"), value="speed"),
]  # fmt: skip

# ---- EDF, EDF+ (Kemp et al. 1992, 2003) ----

Signal = tuple[str, str, tuple[int, int, int, int], int, Sequence[int]]
TENTHS = (-100, 100, -1000, 1000)  # physical and digital minimum and maximum


def edf(
    *signals: Signal,
    day: str = "05.01.26",
    kind: str = "",
    count: int | None = None,
    seconds: str = "1",
    tags: Sequence[str] = (),
    version: bytes = b"0       ",
) -> bytes:
    """Write signals (label, unit, range, samples a record, samples) and a record's tags."""
    each = [(*s[:4], np.asarray(s[4], "<i2").tobytes()) for s in signals]
    if tags:
        each.append(("EDF Annotations", "", (-1, 1, -32768, 32767), 60,
                     b"".join(tag.encode().ljust(120, b"\0") for tag in tags)))  # fmt: skip
    whole = len(each[0][4]) // (2 * each[0][3])
    head = f"{'X X X X':80}{'Startdate 05-JAN-2026 X X X' if kind else '':80}{day}00.00.00"
    head += f"{256 * (1 + len(each)):<8}{kind:44}{whole if count is None else count:<8}"
    head += f"{seconds:8}{len(each):<4}" + "".join(f"{one[0]:16}" for one in each)
    head += " " * 80 * len(each) + "".join(f"{one[1]:8}" for one in each)
    head += "".join(f"{one[2][i]:<8}" for i in range(4) for one in each) + " " * 80 * len(each)
    head += "".join(f"{one[3]:<8}" for one in each) + " " * 32 * len(each)
    parts = (d[i * 2 * n : (i + 1) * 2 * n] for i in range(whole) for *_, n, d in each)
    return version + head.encode("latin-1") + b"".join(parts)


RISE = np.arange(1, 61)
TEMPS = ("Temp", "degC", TENTHS, 1, RISE)
BRAIN = ("EEG Fpz-Cz", "uV", TENTHS, 200, np.arange(1, 1201))
WARM = 0.1 * RISE
KEPT = [f"+{i}\x14\x14\0" for i in range(60)]
HYPNOGRAM = [KEPT[0] + "+0\x1530\x14Sleep stage W\x14\0+12.5\x1530\x14Sleep stage 2\x14\0",
             *KEPT[1:20], KEPT[20] + "+20\x14Tür öffnet\x14Lights on\x14\0",
             *KEPT[21:]]  # fmt: skip
OFFSET = [f"+{i}.5\x14\x14\0" + "+10.5\x14Marker\x14\0" * (i == 10) for i in range(60)]


def night(name: str, data: bytes, truth: Any, **options: Any) -> Input:
    return Input(name, data, truth, options, "night.edf")


EDF = [
    night("plain, of 1985, 1 Hz", edf(TEMPS, day="05.01.85"),
          Series(WARM, range(60), "1985-01-05T00:00:00", "degC")),
    night("BDF of 24 bits", edf(TEMPS, kind="24BIT", version=b"\xffBIOSEMI"), Refused(("BDF",))),
    night("digital minimum = maximum", edf(("Temp", "degC", (0, 40, 0, 0), 1, RISE[:6]), BRAIN),
          Refused(("digital", "Temp")), value="Temp"),
    night("physical minimum = maximum", edf(("Temp", "degC", (40, 40, 0, 9), 1, RISE[:6])),
          Refused(("physical", "Temp"))),
    night("two rates in records of 10 s", edf(BRAIN, (*TEMPS[:4], RISE[:6]), seconds="10"),
          Series(WARM[:6], 10.0 * np.arange(6), unit="degC"), value="Temp"),
    night("inverted polarity", edf((*TEMPS[:2], (100, -100, -1000, 1000), 1, RISE)),
          Series(-WARM, range(60), unit="degC")),
    night("µV as one byte", edf(("EEG", "µV", TENTHS, 1, RISE)),
          Series(WARM, range(60), unit="µV")),
    night("sleep stages with durations", edf(tags=HYPNOGRAM, kind="EDF+C"),
          Events((0, 12.5, 20, 20), ("sleep_stage_w", "sleep_stage_2", "lights_on", "tur_offnet"),
                 duration_s=60.0)),
    night("a start between two seconds", edf(TEMPS, tags=OFFSET, kind="EDF+C"),
          Series(WARM, range(60), "2026-01-05T00:00:00.500000", "degC")),
    night("a number of records of -1", edf(TEMPS, count=-1), Series(WARM, range(60))),
    night("two signals of one name",
          edf(("EEG", "uV", TENTHS, 1, RISE), ("EEG", "uV", TENTHS, 1, -RISE)),
          Refused(("EEG",)), value="EEG"),
]  # fmt: skip


@parametrized(XLSX, FIT, EDF)
def test_it_is_read_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


def load(name: str, folder: Path, **options: Any) -> ov.Timeline:
    made = next(one for one in (*XLSX, *FIT, *EDF) if one.name == name)
    assert isinstance(made.data, bytes)
    (folder / made.file).write_bytes(made.data)
    return ov.load_timeline(folder / made.file, **(made.options | options))


GAPS = {
    "formulas, an error and empty rows": (DAY, 3 * DAY),
    "a chest strap alone, two values invalid": (4.0, 7.0),
    "places unknown in a tunnel": (9.0, 14.0),
    "a pause of ten minutes": (9.0, 609.0),
    "two files chained": (9.0, 60.0),
}


@pytest.mark.parametrize("name", GAPS)
def test_it_has_one_gap(name: str, tmp_path: Path) -> None:
    assert load(name, tmp_path).gaps == (GAPS[name],)


def test_annotations_keep_their_words_and_count_from_the_first_sample(tmp_path: Path) -> None:
    events = load("sleep stages with durations", tmp_path).events
    assert [event.label for event in events[1:]] == ["Sleep stage 2", "Lights on", "Tür öffnet"]
    events = load("a start between two seconds", tmp_path).events
    assert [event.time_s for event in events if event.kind == "marker"] == [10.0]


def test_the_remedy_for_groups_in_the_second_sheet_works(tmp_path: Path) -> None:
    with pytest.raises(ov.InputError) as caught:
        load("groups in the second sheet", tmp_path)
    (remedy,) = re.findall(r"--select '([^']+)'", str(caught.value))
    curve = load("groups in the second sheet", tmp_path, match=remedy).intensity
    assert curve is not None
    assert curve.value.tolist() == [5.0, 6.0, 7.0]
