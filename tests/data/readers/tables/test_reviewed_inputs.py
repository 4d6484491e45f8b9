"""Tables that a reviewer brought: exports of watches, loggers, chats, calendars and meters."""

from __future__ import annotations

from pathlib import Path

from tests.data.readers.truths import Events, Input, Refused, Series, check, parametrized

HOUR, DAY = 3600.0, 86_400.0
RUNS = "Datum;Dauer;km\n01.01.2024;58:30;5\n02.01.2024;1:02:30;6\n03.01.2024;59:10;7\n"
CODES = "date,temp\n" + "".join(
    f"2024-01-{i:02},{value}\n" for i, value in enumerate((10, -999, 12, -9999, 11, 10, 13), 1)
)
LOG = "".join(
    f"2024-01-01 10:00:0{at} {text}\n"
    for at, text in (("0,100", "INFO start"), ("0,900", "ERROR no"), ("1,050", "INFO end"))
)
CHAT = "1/2/24, 10:15 AM - Ann: hi\n1/2/24, 10:15 PM - Ben: hello\n1/13/24, 9:00 AM - Ann: bye\n"
METER = "Record Type,Device Timestamp,Glucose mmol/L\n" + "".join(
    f"{kind},2024-03-10 00:{minute:02},{value}\n"
    for kind, minute, value in ((0, 0, 5.5), (0, 15, 5.6), (1, 20, ""), (0, 30, 5.8), (0, 45, 6))
)
PARTS = "YEAR,MONTH,DAY,HOUR,MIN,TEMP\n" + "".join(
    f"2024,1,{5 + n // 3},{9 + n % 3},30,{n}\n" for n in range(6)
)
ENTRY = "BEGIN:VEVENT\nDTSTART:2024010{}T100000Z\nSUMMARY:A\n{}END:VEVENT\n"
CALENDAR = "BEGIN:VCALENDAR\n{}END:VCALENDAR\n".format(
    ENTRY.format(1, "STATUS:CANCELLED\n") + ENTRY.format(2, "") + ENTRY.format(3, "")
)
YEARS = "month,2021,2022,2023\n2020-01,1,2,3\n2020-02,3,4,5\n2020-03,4,7,6\n"

INPUTS = [
    Input("lengths of under and over an hour", RUNS,
          Series([58.5, 62.5, 59 + 1 / 6], [0, DAY, 2 * DAY], "2024-01-01T00:00:00"),
          {"value": "Dauer"}),
    Input("lengths of hours alone", "date,km,length\n2024-01-01,5,1:30:00\n2024-01-02,6,2:15:00\n",
          Series([1.5, 2.25], [0, DAY]), {"value": "length"}),
    Input("two codes for no value", CODES,
          Series([10, 12, 11, 10, 13], [0, 2 * DAY, 4 * DAY, 5 * DAY, 6 * DAY],
                 noted="-9999 in column")),
    Input("a log with milliseconds after a comma", LOG, Refused(("a log", "--map count"))),
    Input("a chat", CHAT, Refused(("a log", "--map count"))),
    Input("times of day over midnight", "time of day;what\n22:00;sleep\n01:30;awake\n06:45;up\n",
          Refused(("line 3", "clock goes back", "give dates"))),
    Input("a mark of a footnote", "date,flow\n2024-01-01,1.5\n2024-01-02,2.5*\n2024-01-03,3.5\n",
          Series([1.5, 2.5, 3.5], [0, DAY, 2 * DAY], unit="")),
    Input("begin_s", "begin_s\tend_s\tlabel\n1.5\t2\ta\n3\t4\tb\n", Events([1.5, 3.0])),
    Input("a cancelled entry", CALENDAR,
          Events([0.0, DAY], start="2024-01-02T10:00:00+00:00", noted="1 cancelled entry"),
          file="made.ics"),
    Input("seconds with a decimal comma", "Zeit (s);Wert\n0,5;1,5\n1,0;2,5\n1,5;3,5\n",
          Series([1.5, 2.5, 3.5], [0.0, 0.5, 1.0])),
    Input("events with a decimal comma", "time;event\n0,5;a\n1,25;b\n3,5;c\n",
          Events([0.5, 1.25, 3.5], ("a", "b", "c"))),
    Input("seconds that have fractions after a hundred rows",
          "time_s,v\n" + "".join(f"{n + 0.5 * (n > 99):g},{n}\n" for n in range(120)),
          Series(range(120), [n + 0.5 * (n > 99) for n in range(120)])),
    Input("seconds that may have groups of thousands", "t (s);v\n1,000;5\n2,000;6\n3,000;7\n",
          Refused(("no column looks like times",))),
    Input("dates in five columns", PARTS,
          Series(range(6), [0, HOUR, 2 * HOUR, DAY, DAY + HOUR, DAY + 2 * HOUR],
                 "2024-01-05T09:30:00"), {"value": "TEMP"}),
    Input("a column for each year", YEARS,
          Series([2, 4, 7], [0, 31 * DAY, 60 * DAY], "2020-01-01T00:00:00"), {"value": "2022"}),
    Input("a first row of numbers that might be years",
          "0.5,2001,2002\n1.0,2010,2005\n1.5,2020,2009\n2.0,2012,2010\n",
          Series([2001, 2010, 2020, 2012], [0.0, 0.5, 1.0, 1.5]),
          {"value": "column 2", "time": "column 1"}),
    Input("rows for something else", METER, Series([5.5, 5.6, 5.8, 6], [0, 900, 1800, 2700]),
          {"value": "Glucose mmol/L"}),
]  # fmt: skip


@parametrized(INPUTS)
def test_a_table_is_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


def test_a_row_for_something_else_makes_no_gap(tmp_path: Path) -> None:
    from overview_dsp.data.readers import load_timeline

    (tmp_path / "meter.csv").write_text(METER)
    assert load_timeline(tmp_path / "meter.csv", value="Glucose mmol/L").gaps == ()
    (tmp_path / "codes.csv").write_text(CODES)
    gaps = load_timeline(tmp_path / "codes.csv").gaps
    assert gaps == ((0.0, 2 * DAY), (2 * DAY, 4 * DAY))
