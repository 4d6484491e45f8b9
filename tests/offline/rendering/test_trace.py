from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import overview_dsp as ov
from overview_dsp.kernels.layout import TRACE_COLUMNS
from overview_dsp.offline.rendering.trace import TraceWriter
from tests.profiles import share

TABLES = hnp.arrays(
    np.float64,
    st.tuples(st.integers(0, 20), st.just(len(TRACE_COLUMNS))),
    elements=st.floats(allow_nan=False),
)


def read(path) -> np.ndarray:
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            assert tuple(archive.files) == TRACE_COLUMNS
            return np.stack([archive[name] for name in TRACE_COLUMNS], axis=1)
    lines = path.read_text().splitlines()
    assert lines[0] == ",".join(TRACE_COLUMNS)
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    return np.array(rows).reshape(len(rows), len(TRACE_COLUMNS))


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@settings(max_examples=share(0.6))
@given(st.lists(TABLES, max_size=4))
def test_a_trace_file_is_bit_identical_for_any_block_size(tmp_path_factory, suffix, tables):
    path = tmp_path_factory.getbasetemp() / f"trace{suffix}"
    with TraceWriter(path) as trace:
        for table in tables:
            trace.write(table)
    whole = np.concatenate([np.empty((0, len(TRACE_COLUMNS))), *tables])
    assert read(path).tobytes() == whole.tobytes()


def test_the_columns_are_the_contracts():
    assert ",".join(TRACE_COLUMNS) == (
        "time,theta2,touching,theta1,omega1,cursor,friction,torque,envelope,engaged"
    )


@pytest.mark.parametrize("name", ["a.txt", "a", "a.npy", "a.csv.gz"])
def test_another_suffix_is_an_error_of_one_line(tmp_path, name):
    with pytest.raises(ov.InputError, match=r"a trace must be \.npz or \.csv"):
        TraceWriter(tmp_path / name)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_an_invalid_path_is_an_error_of_one_line(tmp_path, suffix):
    (tmp_path / "file").write_text("")
    (tmp_path / f"folder{suffix}").mkdir()
    for name in (f"no/a{suffix}", f"file/a{suffix}", f"folder{suffix}"):
        with pytest.raises(ov.InputError) as error, TraceWriter(tmp_path / name):
            pass
        assert "\n" not in str(error.value)
        assert str(error.value).startswith(str(tmp_path / name))
    assert sorted(os.listdir(tmp_path)) == ["file", f"folder{suffix}"]


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_unfinished_trace_leaves_the_existing_file(tmp_path, suffix, error):
    path = tmp_path / f"a{suffix}"
    path.write_text("old")

    def fail() -> None:
        with TraceWriter(path) as trace:
            trace.write(np.zeros((5000, len(TRACE_COLUMNS))))
            raise error

    with pytest.raises(error):
        fail()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == [path.name]


def test_no_path_is_no_trace(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with TraceWriter(None) as trace:
        trace.write(np.zeros((5, len(TRACE_COLUMNS))))
    assert os.listdir(tmp_path) == []
