"""Share charts as web interfaces give them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overview_dsp.data.readers import load_timeline

TIMES = [1_704_205_800 + 86_400 * i for i in range(60)]
CLOSE = [float(v) for v in np.round(100.0 + np.cumsum(np.random.default_rng(1).normal(size=60)), 2)]
HIGH = [v + 1.0 for v in CLOSE]
LOW = [v - 1.0 for v in CLOSE]
YAHOO = {
    "chart": {
        "result": [
            {
                "meta": {"currency": "USD", "symbol": "XYZ", "gmtoffset": -18_000},
                "timestamp": TIMES,
                "indicators": {
                    "quote": [{"close": HIGH, "open": LOW, "volume": [7] * 60, "high": None}],
                    "adjclose": [{"adjclose": CLOSE}],
                },
            }
        ],
        "error": None,
    }
}
BARS = zip(TIMES, HIGH, LOW, CLOSE, strict=True)
RECORDS = [{"t": t * 1000, "o": c, "h": h, "l": low, "c": c, "v": 5} for t, h, low, c in BARS]
CANDLES = [[r["t"], r["o"], r["h"], r["l"], str(r["c"]), 5] for r in RECORDS]
LISTS = {"s": "ok", **{k: [r[k] for r in RECORDS] for k in "tohlcv"}}


@pytest.mark.parametrize(
    ("document", "name", "unit"),
    [
        (YAHOO, "adj close", "USD"),
        ({"ticker": "XYZ", "results": RECORDS}, "close", ""),
        (LISTS, "close", ""),
        (CANDLES, "close", ""),
    ],
)
def test_a_price_chart_is_read_as_its_closing_prices(
    document: Any, name: str, unit: str, tmp_path: Path
) -> None:
    (tmp_path / "chart.json").write_text(json.dumps(document))
    timeline = load_timeline(tmp_path / "chart.json")
    assert timeline.title == f"chart: {name}"
    assert timeline.start is not None
    assert timeline.start.isoformat() == "2024-01-02T14:30:00+00:00"
    assert timeline.intensity is not None
    assert list(timeline.intensity.value) == CLOSE
    assert timeline.intensity.unit == unit


def test_rows_that_are_no_candles_keep_their_numbers(tmp_path: Path) -> None:
    rows = [[t, c, low, h, c] for t, h, low, c in zip(TIMES, HIGH, LOW, CLOSE, strict=True)]
    (tmp_path / "chart.json").write_text(json.dumps(rows))
    assert load_timeline(tmp_path / "chart.json", value="column 3").title == "chart: column 3"
