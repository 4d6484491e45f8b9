"""Nothing is felt that isn't in the data: prices, times, matches and ids are told, not guessed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.library import fitting_preset
from overview_dsp.errors import InputError
from tests.data.timeline.test_every_zoom import SERIES


def write(tmp_path: Path, text: str, name: str = "made.csv") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def series(header: str, values: np.ndarray, beside: str = "") -> str:
    days = np.datetime64("2020-01-01") + np.arange(len(values))
    rows = (f"{day},{value:.2f}{beside}" for day, value in zip(days, values, strict=True))
    return f"date,{header}\n" + "\n".join(rows) + "\n"


def halved(count: int = 300) -> np.ndarray:
    """A price that calmly falls to half within a day: as a split of 2:1 would."""
    worth = 80.0 * np.exp(np.cumsum(np.random.default_rng(5).normal(0.0, 0.005, count)))
    worth[200:] *= worth[199] / worth[200] / 2.0
    return worth


def per_cent(timeline: Timeline) -> bool:
    return any("steps are per cent" in note for note in timeline.notes) or any(
        "%" in event.label for event in timeline.events if event.kind.startswith("largest")
    )


def falls(timeline: Timeline) -> list[str]:
    return [event.label for event in timeline.events if event.kind == "largest_fall"]


@pytest.mark.parametrize(("file", "column"), SERIES)
def test_of_the_shared_series_prices_alone_are_per_cent_and_shares_alone_have_splits(
    data_folder: Path, file: str, column: str
) -> None:
    timeline = load_timeline(data_folder / file, value=column)
    is_price = "stocks" in file and column.lower() != "volume"
    assert per_cent(timeline) is is_price
    unadjusted = file.endswith("AAPL.csv") and column in ("Open", "Close")
    assert timeline.kinds().get("split", 0) == (2 if unadjusted else 0)


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("Price", "made"),
        ("price", "commodity"),
        ("Close", "coffee"),
        ("Close", "CL=F"),
        ("Close", "BTC-USD"),
        ("Close", "natural gas 2020"),
        ("crude oil price ($/barrel)", "made"),
        ("Settle", "made"),
    ],
)
def test_a_crash_of_a_commodity_is_a_fall_and_no_split(
    tmp_path: Path, header: str, name: str
) -> None:
    timeline = load_timeline(write(tmp_path, series(header, halved()), f"{name}.csv"))
    assert "split" not in timeline.kinds()
    assert any(float(label.split()[0]) < -49.9 for label in falls(timeline))
    assert per_cent(timeline)
    assert any(":share" in note for note in timeline.notes)


def test_an_option_says_what_a_column_is(tmp_path: Path) -> None:
    path = write(tmp_path, series("Close", halved()), "aapl.csv")
    assert load_timeline(path).kinds()["split"] == 1
    assert "split" not in load_timeline(path, value="Close:price").kinds()
    plain = load_timeline(path, value="Close:plain")
    assert not per_cent(plain)
    assert "split" not in plain.kinds()
    assert load_timeline(path, value=":plain") == plain
    level = write(tmp_path, series("level", halved()), "made.csv")
    assert load_timeline(level, value="level:share").kinds()["split"] == 1
    with pytest.raises(InputError, match="'bond' is not a type of value; allowed: share, price"):
        load_timeline(path, value="Close:bond")


@pytest.mark.parametrize(
    "header", ["temperature (°C)", "high", "low", "open", "level", "last", "pressure"]
)
def test_what_is_not_called_a_price_is_never_per_cent_however_it_grows(
    tmp_path: Path, header: str
) -> None:
    values = np.linspace(2.0, 30.0, 200) + np.sin(np.arange(200.0)) * 0.05
    timeline = load_timeline(write(tmp_path, series(header, values)))
    assert not per_cent(timeline)


@pytest.mark.parametrize("header", ["cost ($)", "gold [EUR]", "price"])
def test_money_is_per_cent_unless_it_falls_to_0_or_below(tmp_path: Path, header: str) -> None:
    values = 50.0 + np.sin(np.arange(60.0))
    assert per_cent(load_timeline(write(tmp_path, series(header, values))))
    values[30] = -3.0
    timeline = load_timeline(write(tmp_path, series(header, values)))
    assert falls(timeline)
    assert not any("%" in label for label in falls(timeline))
    assert any("some values are 0 or below" in note for note in timeline.notes)


@pytest.mark.parametrize(
    "header", ["index", "id", "ID", "patient", "row", "n", "sample", "month", "week", ""]
)
def test_numbers_of_rows_and_names_are_never_seconds(tmp_path: Path, header: str) -> None:
    rows = "".join(f"{i},{20 + i % 7}.5\n" for i in range(1, 40))
    path = write(tmp_path, f"{header},level\n{rows}")
    with pytest.raises(InputError, match=r"no column looks like times|isn't a time"):
        load_timeline(path, value="level")
    if header:
        assert load_timeline(path, value="level", time=f"{header}:s").duration_s == 38.0
    assert load_timeline(path, value="level", rate=2.0).duration_s == 19.0


@pytest.mark.parametrize("header", ["year", "season", "time", "t", "vintage"])
def test_years_are_years_whatever_they_are_called(tmp_path: Path, header: str) -> None:
    rows = "".join(f"{1960 + i},{i % 7}.5\n" for i in range(50))
    timeline = load_timeline(write(tmp_path, f"{header},level\n{rows}"))
    assert timeline.start is not None
    assert timeline.start.year == 1960
    if header != "year":
        assert any(f"time='{header}:s'" in note for note in timeline.notes)


@pytest.mark.parametrize("header", ["time of day", "hour", "Uhrzeit", "local time", "time (hh:mm)"])
def test_clocks_under_a_time_of_day_are_hours(tmp_path: Path, header: str) -> None:
    rows = "".join(f"{8 + i // 2:02d}:{30 * (i % 2):02d},{i % 5}.5\n" for i in range(22))
    timeline = load_timeline(write(tmp_path, f"{header},load\n{rows}"))
    assert timeline.duration_s == 10.5 * 3600.0
    assert any(":clock' (--time-column)" in note for note in timeline.notes)


def test_a_lone_clock_says_how_it_was_read_and_what_reads_it_otherwise(tmp_path: Path) -> None:
    rows = "".join(f"{8 + i // 2:02d}:{30 * (i % 2):02d},{i % 5}.5\n" for i in range(22))
    path = write(tmp_path, f"time,load\n{rows}")
    timeline = load_timeline(path)
    assert timeline.duration_s == 10.5 * 60.0
    assert any("read as minutes:seconds; time='time:hhmm'" in note for note in timeline.notes)
    assert load_timeline(path, time="time:hhmm").duration_s == 10.5 * 3600.0
    halves = write(tmp_path, "time,load\n11:30 AM,1\n12:30 PM,2\n1:30 PM,3\n")
    assert load_timeline(halves).duration_s == 7200.0


@pytest.mark.parametrize(
    "rows",
    [
        ("time,load", "2024-10-27T02:{}:00{},", ("+02:00", "+01:00")),
        ("time,load", "2024-10-27 02:{} {},", ("CEST", "CET")),
        ("time,utc_offset,load", "2024-10-27 02:{},{},", ("+02:00", "+01:00")),
        ("date,time,tz,load", "2024-10-27,02:{},{},", ("+0200", "+0100")),
    ],
)
def test_hours_that_a_clock_change_repeats_are_kept_apart_where_the_offset_tells(
    tmp_path: Path, rows: tuple[str, str, tuple[str, str]]
) -> None:
    header, row, offsets = rows
    text = "\n".join(
        row.format(minute, offset) + str(i)
        for i, (offset, minute) in enumerate((o, m) for o in offsets for m in ("00", "30"))
    )
    timeline = load_timeline(write(tmp_path, f"{header}\n{text}\n"), value="load")
    assert timeline.duration_s == 5400.0
    assert timeline.intensity is not None
    assert np.asarray(timeline.intensity.value).tolist() == [0.0, 1.0, 2.0, 3.0]


MEETING = """minute,type,player,team
3,welcome,Ann,red
12,goals of the year,Bob,red
40,break,Ann,blue
55,award,Bob,blue
"""


def test_a_list_without_footballs_words_is_no_match(tmp_path: Path) -> None:
    timeline = load_timeline(write(tmp_path, MEETING))
    assert timeline.duration_s == 55.0 * 60.0
    assert timeline.intensity is None
    assert fitting_preset(timeline.kinds()).preset == "plain"
    assert timeline.kinds() == {"welcome": 1, "goals_of_the_year": 1, "break": 1, "award": 1}
    football = MEETING.replace("award", "yellow card").replace("welcome", "goal")
    match = load_timeline(write(tmp_path, football))
    assert match.duration_s >= 90.0 * 60.0
    assert fitting_preset(match.kinds()).preset == "football"


def test_an_event_id_that_is_there_twice_is_noted(tmp_path: Path) -> None:
    rows = "id,time,event\na1,0:10,start\na1,0:20,stop\na2,0:30,start\n"
    timeline = load_timeline(write(tmp_path, rows))
    assert len(timeline.events) == 3
    assert any("event ids occur more than once: 'a1'" in note for note in timeline.notes)


def test_a_statsbomb_id_that_is_there_twice_is_noted(
    statsbomb_folder: Path, tmp_path: Path
) -> None:
    records = json.loads((statsbomb_folder / "69321.json").read_bytes())
    shot = next(r for r in records if r["type"]["name"] == "Shot")
    path = write(tmp_path, json.dumps([*records, shot]), "m.json")
    timeline = load_timeline(path)
    assert any(f"more than once: '{shot['id']}'" in note for note in timeline.notes)
    assert not any(
        "more than once" in n for n in load_timeline(statsbomb_folder / "69321.json").notes
    )
