from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.batch.manifest import MEASURES, PARTS, encode_part, read_rows
from overview_dsp.batch.storage import Storage

pytest.importorskip("pyarrow", reason="needs the extra batch")

levels = st.floats(allow_nan=False, allow_infinity=False)
counts = st.integers(0, 2**62)
texts = st.text(st.characters(exclude_categories=["Cs"]))
felt = st.fixed_dictionaries(
    {"event": st.integers(0, 2**31 - 1), "kind": texts, "level_db": levels}
)
rendered = st.fixed_dictionaries(
    {
        "key": texts,
        "file": texts,
        "frames": counts,
        "duration_s": levels,
        "peak_click_dbfs": st.none() | levels,
        "loudness_lufs": st.none() | levels,
        "felt": st.lists(felt, max_size=3),
        "sha256": texts,
    }
)
failed = st.fixed_dictionaries({"key": texts, "error": texts})


@given(rows=st.lists(rendered | failed, min_size=1, max_size=4))
def test_a_part_gives_back_its_rows_to_the_bit(tmp_path_factory, rows):
    place = Storage(str(tmp_path_factory.mktemp("study")))
    place.put(f"{PARTS}/a", encode_part(rows))
    table, parts = read_rows(place)
    assert parts == [f"{PARTS}/a"]
    nothing = dict.fromkeys(("key", *MEASURES))
    assert table.to_pylist() == [{**nothing, **row} for row in rows]


def test_a_row_may_be_long(tmp_path):
    place = Storage(str(tmp_path))
    events = [{"event": i, "kind": "goal", "level_db": -i / 3} for i in range(40_000)]
    rows = [{"key": "a", "felt": events}, {"key": "b"}]
    place.put(f"{PARTS}/a", encode_part(rows))
    table, _ = read_rows(place)
    assert table.column("key").to_pylist() == ["a", "b"]
    assert table.column("felt").to_pylist() == [events, None]
