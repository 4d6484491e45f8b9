"""The bytes the page is given hold the memory, and its layout is the kernel's."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.offline.export import browser_memory as encoding
from overview_dsp.offline.export.browser_memory import (
    DATA,
    FILL,
    INTEGRAL,
    TABLE,
    encode_change,
    encode_engine,
)
from overview_dsp.signal.engine.surface_slots import write_surface
from tests.web.schedule import RATE, engine
from tests.web.surfaces import preset_of

ROOT = Path(__file__).resolve().parents[3]


def decoded_runs(runs: bytes) -> np.ndarray:
    """The columns of a run of runs, as the page decodes them."""
    parts, at = [], 0
    while at < len(runs):
        how, columns = np.frombuffer(runs, "<i4", 2, at)
        count = {FILL: 1, DATA: columns, TABLE: columns // 2, INTEGRAL: 0}[how]
        values = np.frombuffer(runs, "<u8", count, at + 8)
        at += 8 + 8 * count
        if how == FILL:
            parts.append(np.repeat(values, columns))
        elif how == DATA:
            parts.append(values)
        elif how == INTEGRAL:
            friction = parts[-1].view("<f8")[0::2]
            means = 0.5 * (friction[1:] + friction[:-1])
            parts.append(np.append(0.0, np.cumsum(means)).view(np.uint64))
        else:
            table = np.zeros(columns)
            table[0::2] = values.view("<f8")
            table[1:-1:2] = np.diff(table[0::2])
            parts.append(table.view(np.uint64))
    return np.concatenate(parts)


@given(st.lists(st.tuples(st.integers(1, 9), st.integers(0, 2**64 - 1)), min_size=1, max_size=50))
def test_any_columns_come_back(stretches):
    bits = np.concatenate([np.full(count, value, np.uint64) for count, value in stretches])
    assert np.array_equal(decoded_runs(encoding._runs(bits)), bits)


def test_an_engine_comes_back_column_by_column(match, football):
    made = engine(match, football)
    data = encode_engine(made)
    assert data[:8] == encoding.layout_digest()
    assert np.frombuffer(data, "<i4", 2, 8).tolist() == [encoding.WHOLE, 0]
    assert np.frombuffer(data, "<f8", 3, 16).tolist() == [-1.0, RATE, 2.0]
    assert np.array_equal(decoded_runs(data[40:]), made.memory.view(np.uint64))
    assert len(data) < 600_000  # of 17 MB: what a phone must load


def test_a_change_has_the_values_that_an_engine_would_receive(match, football):
    made = engine(match, football, hands=False)
    before = made.preset
    made.set_preset(preset_of("stadium"), sample_time=4_711)
    data = encode_change(before, made.preset, RATE, made.surface, 4_711)
    count = int(np.frombuffer(data, "<i4", 2, 8)[1])
    pairs = np.frombuffer(data, "<f8", 2 * count, 40).reshape(-1, 2)
    told = made.memory.view(np.int64)[layout.HOST_WHAT :][: count + 1].tolist()
    assert count > 0
    assert [*pairs[:, 0], layout.COMMAND_SURFACE] == told
    assert pairs[:, 1].tolist() == made.memory[layout.HOST_VALUE :][:count].tolist()
    assert np.frombuffer(data, "<f8", 3, 16).tolist() == [4_711, RATE, 0]
    slot = np.zeros(layout.SURFACES + layout.SLOT_SIZE)
    slot[layout.S_SAMPLE_RATE] = RATE
    write_surface(slot, 0, made.surface)
    columns = decoded_runs(data[40 + 16 * count :])
    assert np.array_equal(columns, slot[layout.SURFACES :].view(np.uint64))


def test_a_change_of_parameters_alone_is_small(football):
    quieter = football.with_changes({"tactor.gain_db": -9.0, "disk.release": "return"})
    assert len(encode_change(football, quieter, RATE)) == 40 + 2 * 16
    assert len(encode_change(football, football, RATE)) == 40


def test_a_carrier_that_does_not_fit_the_rate_is_refused(football):
    with pytest.raises(ov.InputError, match="too high"):
        encode_change(football, football, 500)
    with pytest.raises(ov.InputError, match="sample_time"):
        encode_change(football, football, RATE, sample_time=-3)


def test_the_pages_layout_is_the_kernels(tmp_path):
    tool = ROOT / "tools" / "write_layout.py"
    again = tmp_path / "layout.js"
    subprocess.run([sys.executable, str(tool), str(again)], check=True)
    shipped = ROOT / "overview_dsp" / "web" / "layout.js"
    assert again.read_bytes() == shipped.read_bytes(), "run python tools/write_layout.py"
