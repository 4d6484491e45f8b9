"""Tables as well-known services and programs write them, made up here in their forms."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.data.readers.tables.made import load, values

DAYS = [datetime(2020, 1, 1) + timedelta(days=i) for i in range(40)]
EPOCHS = [1577836800 + 86_400 * i for i in range(40)]
PLAIN = [i + 0.5 for i in range(40)]
TEN = range(10)


@dataclass(frozen=True)
class Case:
    text: str
    value: list[float]
    start: datetime = DAYS[0]
    gaps: int = 0
    encoding: str = "utf-8"
    options: dict[str, str] = field(default_factory=dict)


def rows(head: str, form: str, count: int = 40) -> str:
    """A header and a row a day, of `d` (the day), `i` (its number) and `e` (its epoch)."""
    made = (form.format(d=DAYS[i], i=i, e=EPOCHS[i], j=i % 7) for i in range(count))
    return head + "".join(f"{row}\n" for row in made)


def turned(text: str) -> str:
    head, *lines = text.splitlines(keepends=True)
    return head + "".join(reversed(lines))


CASES = {
    "FRED": Case(
        rows("observation_date,DGS10\n", "{d:%Y-%m-%d},{i}.5").replace(",5.5", ",."),
        [value for value in PLAIN if value != 5.5],
        gaps=1,
    ),
    "Investing.com": Case(
        turned(
            rows(
                '"Date","Price","Open","High","Low","Vol.","Change %"\n',
                '"{d:%m/%d/%Y}","1,0{i:02}.50","1,000.00","1,300.00","900.00","1.5M","-1.25%"',
            )
        ),
        [1000.0 + value for value in PLAIN],
    ),
    "Investing.com, German": Case(
        turned(
            rows(
                '"Datum","Zuletzt","Eröffn.","Hoch","Tief","Vol.","+/- %"\n',
                '"{d:%d.%m.%Y}","1.0{i:02},50","1.{j}00,00","1.300,00","900,00","1,5M","-1,25%"',
            )
        ),
        [1000.0 + value for value in PLAIN],
    ),
    "Yahoo": Case(
        rows(
            "Date,Open,High,Low,Close,Adj Close,Volume\n",
            "{d:%Y-%m-%d},1,2,0.5,1.5,{i}.5,1000",
        ).replace("1,2,0.5,1.5,7.5,1000", "null,null,null,null,null,null"),
        [value for value in PLAIN if value != 7.5],
        gaps=1,
    ),
    "Binance": Case(
        rows("", "{e}000,7{j}.1,80.2,60.3,{i}.5,10.5,{e}999,70.1,100,5.1,300.2,0"),
        PLAIN,
        DAYS[0].replace(tzinfo=UTC),
        options={"value": "column 5"},
    ),
    "Open-Meteo": Case(
        "latitude,longitude,elevation,timezone\n52.52,13.41,38.0,GMT\n\n"
        + rows("time,temperature_2m (°C)\n", "{d:%Y-%m-%d}T00:00,{i}.5"),
        PLAIN,
    ),
    "Mauna Loa": Case(
        "# Use of these data implies\n# decimal average\n"
        + "".join(f"1960  {i + 1:2}   {1960 + i / 8:.4f}  {i}.50  -1  -9.99\n" for i in TEN),
        PLAIN[:10],
        datetime(1960, 1, 1),
        options={"time": "column 3:year", "value": "column 4"},
    ),
    "SILSO": Case(
        "".join(f"1749;{i + 1:02};{1750 + i / 8:.3f};  {i}.5;  -1.0;   -1;1\n" for i in TEN),
        PLAIN[:10],
        datetime(1750, 1, 1),
        options={"time": "column 3:year", "value": "column 4"},
    ),
    "DWD": Case(
        rows(
            "STATIONS_ID;MESS_DATUM;QN_3;  FM; RSK;eor\n",
            "        433;{d:%Y%m%d};   10;   4.{j};    {i}.5;eor",
        ).replace("    5.5;", "   -999;"),
        [value for value in PLAIN if value != 5.5],
        gaps=1,
        options={"value": "RSK"},
    ),
    "USGS": Case(
        "# ---- WARNING ----\n# Some text\n#\n"
        + rows(
            "agency_cd\tsite_no\tdatetime\ttz_cd\t69928_00060\t69928_00060_cd\n"
            "5s\t15s\t20d\t6s\t14n\t10s\n",
            "USGS\t01646500\t{d:%Y-%m-%d %H:%M}\tEST\t{i}.5\tA",
        ),
        PLAIN,
    ),
    "Excel, German": Case(
        "sep=;\n" + rows("Datum;Umsatz (€)\n", "{d:%d.%m.%y};{i},5"), PLAIN, encoding="cp1252"
    ),
    "Home Assistant": Case(
        rows("entity_id,state,last_changed\n", "sensor.x,{i}.5,{d:%Y-%m-%d}T00:00:00.000Z").replace(
            ",9.5,", ",unavailable,"
        ),
        [value for value in PLAIN if value != 9.5],
        DAYS[0].replace(tzinfo=UTC),
        gaps=1,
    ),
    "Stooq": Case(
        rows(
            "<TICKER>,<PER>,<DATE>,<TIME>,<OPEN>,<HIGH>,<LOW>,<CLOSE>,<VOL>,<OPENINT>\n",
            "AAPL.US,D,{d:%Y%m%d},000000,1,2,0.5,{i}.5,1000,0",
        ),
        PLAIN,
    ),
    "FRED, JSON": Case(
        json.dumps(
            {
                "observations": [
                    {
                        "realtime_start": "2020-01-01",
                        "date": f"{day:%Y-%m-%d}",
                        "value": "." if value == 5.5 else str(value),
                    }
                    for day, value in zip(DAYS, PLAIN, strict=True)
                ]
            }
        ),
        [value for value in PLAIN if value != 5.5],
        gaps=1,
    ),
    "Alpha Vantage": Case(
        json.dumps(
            {
                "Meta Data": {"1. Information": "Daily"},
                "Time Series (Daily)": {
                    f"{day:%Y-%m-%d}": {
                        "1. open": "1.0",
                        "2. high": "3.0",
                        "3. low": "0.5",
                        "4. close": str(value),
                        "5. volume": "1000",
                    }
                    for day, value in reversed(list(zip(DAYS, PLAIN, strict=True)))
                },
            }
        ),
        PLAIN,
    ),
    "CoinGecko": Case(
        json.dumps({"prices": [[e * 1000, v] for e, v in zip(EPOCHS, PLAIN, strict=True)]}),
        PLAIN,
        DAYS[0].replace(tzinfo=UTC),
    ),
    "Prometheus": Case(
        json.dumps(
            {
                "status": "success",
                "data": {
                    "result": [
                        {
                            "metric": {"job": "x"},
                            "values": [[e, str(v)] for e, v in zip(EPOCHS, PLAIN, strict=True)],
                        }
                    ]
                },
            }
        ),
        PLAIN,
        DAYS[0].replace(tzinfo=UTC),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_every_known_table_gives_the_values_written_in_it(tmp_path: Path, name: str) -> None:
    case = CASES[name]
    timeline = load(tmp_path, case.text.encode(case.encoding), **case.options)
    assert values(timeline) == case.value
    assert timeline.start == case.start
    assert len(timeline.gaps) == case.gaps
