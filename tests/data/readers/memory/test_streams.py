"""Open files, bytes and addresses, and what is refused in one line."""

from __future__ import annotations

import gzip
import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import overview_dsp as ov
from overview_dsp.installation import install_command

DAILY = "date,temp\n2020-01-01,3.5\n2020-01-02,4\n2020-01-03,2.25\n2020-01-04,6\n"


def refusal(data: Any, **options: Any) -> str:
    with pytest.raises(ov.InputError) as caught:
        ov.load_timeline(data, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_an_open_file_is_read_and_gives_its_name(tmp_path: Path) -> None:
    path = tmp_path / "daily.csv"
    path.write_text(DAILY)
    expected = ov.load_timeline(path)
    with open(path, "rb") as binary, open(path, encoding="utf-8") as text:
        assert ov.load_timeline(binary) == expected
        assert ov.load_timeline(text) == expected
        assert not binary.closed
    assert "closed file" in refusal(text)
    packed = tmp_path / "daily.csv.gz"
    packed.write_bytes(gzip.compress(DAILY.encode()))
    with open(packed, "rb") as binary:
        assert ov.load_timeline(binary) == expected
    assert ov.load_timeline(packed.read_bytes()).title == "temp"


def test_an_address_is_opened_and_its_secrets_stay_unsaid(tmp_path: Path) -> None:
    fsspec = pytest.importorskip("fsspec", reason="needs fsspec: pip install '.[urls]'")
    with fsspec.open("memory://folder/daily.csv", "wb") as file:
        file.write(DAILY.encode())
    timeline = ov.load_timeline("memory://folder/daily.csv")
    assert timeline.title == "daily: temp"
    assert refusal("memory://folder/none.csv").startswith("memory://folder/none.csv: can't be open")
    words = refusal("nosuch://someone:secret@place/a.csv?token=secret")
    assert "secret" not in words
    assert "nosuch" in words


def test_an_open_file_is_read_up_to_the_limit() -> None:
    class Endless(io.RawIOBase):
        given = 0

        def read(self, size: int = -1) -> bytes:
            self.given += size
            return b"1\n" * (size // 2)

    endless = Endless()
    assert "more than the 2 MB that are read; if that is intended, raise" in refusal(
        endless, max_mb=2.0
    )
    assert endless.given <= 4 * 2**20


def test_a_stream_that_fails_while_it_is_read_gives_a_one_line_error() -> None:
    class Broken(io.RawIOBase):
        def read(self, size: int = -1) -> bytes:
            raise ConnectionResetError("the line is dead")

    assert "the line is dead" in refusal(Broken())
    assert "is empty" in refusal(b"")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ([], "no rows"),
        (pd.DataFrame(), "no rows"),
        (pl.DataFrame({"a": []}), "no rows"),
        (np.zeros((2, 2, 2)), "3 dimensions"),
        ({"time": [1, 2], "x": [1]}, "different lengths"),
        ([(1.0, "goal"), 3], "row 2: 3 has another type"),
        ([(0.0, 1.0), (1.0, 2.0, 3.0)], "row 1.*2 values, not 3"),
        (iter([1.0, 2.0]), "list"),
        (pl.LazyFrame({"a": [1]}), "collect"),
        (pd.DataFrame([[1, 2]], columns=["a", "a"]), "unique|twice|'a'"),
        ([1.0, "three", 2.0], "row 2, column 'value': 'three' isn't a number"),
        ({"overview_timeline": 1, "events": [{"time_s": np.nan, "kind": "a"}]}, "duration_s"),
    ],
)
def test_data_that_are_not_a_series_give_a_one_line_error(data: Any, words: str) -> None:
    with pytest.raises(ov.InputError, match=words):
        ov.load_timeline(data, rate=2.0 if words.startswith("row 2, col") else None)


def test_an_option_that_the_data_hold_is_refused_as_in_a_file() -> None:
    assert "duration_s does not apply" in refusal([1.0, 2.0, 3.0], rate=1.0, duration_s=9.0)
    assert "value does not apply" in refusal(ov.load_timeline("made-up-share"), value="x")
    assert "names a column of a file" in refusal(DAILY.encode(), time=[1, 2, 3, 4])
    assert "not a column of times" in refusal([1.0, 2.0], time=3)


def test_a_frame_without_narwhals_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "narwhals"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "narwhals", None)
    words = refusal(pd.DataFrame({"time": [0, 1], "x": [1.0, 2.0]}))
    assert install_command("dataframes") in words
    assert ov.load_timeline({"time": [0, 1], "x": [1.0, 2.0]}).duration_s == 1.0
