"""Hostile files are refused early, with the limit and the option that raises it."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import lzma
import os
import time
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import data_file, load_timeline, opening, save_timeline
from overview_dsp.data.readers.data_file import DEEPEST, extent
from overview_dsp.data.readers.opening import packing
from overview_dsp.errors import InputError
from tests.data.readers.football_files import METRICA, MINUTES, OPENFOOTBALL_TEXT, WYSCOUT_TEXT
from tests.data.readers.statsbomb_match import full_match

NATIVE = '{"overview_timeline": 1, "duration_s": 9, "events": [{"time_s": 1, "kind": "goal"}]}'
TEXTS = {
    "native": NATIVE,
    "statsbomb": json.dumps(full_match()),
    "metrica": METRICA,
    "wyscout": WYSCOUT_TEXT,
    "openfootball": OPENFOOTBALL_TEXT,
    "minutes": MINUTES,
    "event list": "time_s,kind\n1,goal\n9,goal\n",
}


def refused(path: Path, words: str, **options: Any) -> str:
    """The one line; the work before it takes neither long nor much memory."""
    started = time.process_time()
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=words) as caught:
            load_timeline(path, **options)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert time.process_time() - started < 20.0
    assert most < 500 * 2**20
    assert str(caught.value).count("\n") <= 1  # the second line: what it comes nearest to
    return str(caught.value)


def zipped(data: bytes, name: str = "match.json") -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, data)
    return stream.getvalue()


PACKERS = {
    ".gz": lambda data: gzip.compress(data, mtime=0),
    ".bz2": bz2.compress,
    ".xz": lambda data: lzma.compress(data),
    ".zip": zipped,
}


# --- size ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_sparse_file_of_10_gb_is_refused_before_it_is_read(text: str, tmp_path: Path) -> None:
    path = tmp_path / "big"
    # spaces: after them a file of holes is text as far as its head can tell
    path.write_bytes(text.encode().ljust(data_file.HEAD_BYTES))
    os.truncate(path, 10 * 2**30)
    refused(
        path, r"big: 10240 MB, more than the 64 MB that are read; .*max_mb \(--read max-mb=MB\)"
    )
    refused(path, r"more than the 5 MB that are read", max_mb=5.0)


def test_a_sparse_file_without_text_is_binary_data(tmp_path: Path) -> None:
    (tmp_path / "big").write_bytes(b"")
    os.truncate(tmp_path / "big", 10 * 2**30)
    refused(tmp_path / "big", "binary data")


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_the_limit_of_size_is_lowered_and_raised_by_an_option(text: str, tmp_path: Path) -> None:
    (tmp_path / "x").write_text(text)
    size_mb = len(text.encode()) / 2**20
    whole = load_timeline(tmp_path / "x")
    assert load_timeline(tmp_path / "x", max_mb=size_mb) == whole
    refused(tmp_path / "x", "MB that are read; .*--read max-mb", max_mb=size_mb * 0.99)


def test_a_large_file_is_read_with_the_option(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data_file, "MAX_WHOLE_BYTES", 20)
    (tmp_path / "x").write_text(NATIVE)
    refused(tmp_path / "x", "--read max-mb")
    assert load_timeline(tmp_path / "x", max_mb=1.0).duration_s == 9.0


# --- depth and number of values -----------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        "[" * 100_000 + "]" * 100_000,
        '{"overview_timeline":' * 100_000,
        '[{"period":1,"timestamp":"00","type":' + "[" * 3000,
        '{"matches":[{"team1":"A","team2":' + "{" * 3000,
        '[{"matchPeriod":"1H","eventSec":1,"tags":' + "[" * 3000,
        '{"a": "' + "\\\\" * 9 + '", "b": ' + "[" * 100,
    ],
)
def test_deep_json_is_refused_before_it_is_parsed(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def parse(*_: object) -> object:
        raise AssertionError("parsed")

    monkeypatch.setattr(data_file, "parse_json", parse)
    (tmp_path / "deep").write_text(text)
    refused(
        tmp_path / "deep",
        r"deep: .*more than 64 levels.*max_depth \(--read max-depth=LEVELS\), to 500",
    )


def test_deep_json_is_read_with_the_option(tmp_path: Path) -> None:
    text = '{"overview_timeline": 1, "duration_s": 9, "x": ' + "[" * 200 + "]" * 200 + "}"
    (tmp_path / "x").write_text(text)
    refused(tmp_path / "x", "nested too deep")
    refused(tmp_path / "x", "unknown key 'x'", max_depth=201)
    for bad in (0, DEEPEST + 1, 2.5, "9", True):
        refused(tmp_path / "x", "max_depth is .*1 to 500", max_depth=bad)


def test_the_deepest_allowed_json_does_not_end_the_stack(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("[" * DEEPEST + "]" * DEEPEST)
    refused(tmp_path / "x", "a JSON list of 1 entries", max_depth=DEEPEST)


def test_brackets_in_text_are_no_depth(tmp_path: Path) -> None:
    label = json.dumps("[{" * 200 + '\\"\\' + "[" * 200)
    (tmp_path / "x").write_text(NATIVE.replace('"goal"', f'"goal", "label": {label}'))
    assert len(load_timeline(tmp_path / "x").events[0].label) > 600


@given(
    st.recursive(
        st.none() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
        max_leaves=12,
    ),
    st.sampled_from((3, 7, 1 << 20)),
    st.booleans(),
)
def test_the_depth_is_that_of_the_parsed_document(
    document: Any, chunk: int, ascii_only: bool
) -> None:
    def depth(value: Any) -> int:
        if isinstance(value, dict):
            return 1 + max(map(depth, value.values()), default=0)
        return 1 + max(map(depth, value), default=0) if isinstance(value, list) else 0

    text = json.dumps(document, ensure_ascii=ascii_only)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(data_file, "_JSON_CHUNK", chunk)
        assert extent(text).depth == depth(document)


@pytest.mark.parametrize("unit", ['{"":0},', "[],", "{},", '"ab",', "300,", "0.5,", '[{"a":{}}],'])
def test_values_by_the_million_are_refused_before_they_are_made(unit: str, tmp_path: Path) -> None:
    size = 40 * 2**20
    (tmp_path / "x").write_text("[" + unit * (size // len(unit)) + "0]")
    refused(tmp_path / "x", r"would take about \d+ MB of memory, more than 576 MB; .*--read max-mb")


@pytest.mark.parametrize("unit", ['{"":0},', "[],", "{},", '"ab",', "300,", "0.5,", '[{"a":{}}],'])
def test_the_estimate_of_memory_is_no_less_than_it_takes(unit: str) -> None:
    text = "[" + unit * 20_000 + "0]"
    tracemalloc.start()
    document = json.loads(text)
    taken, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert document
    assert taken <= extent(text).parsed_bytes <= 15 * taken


# --- compressed files ---------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", PACKERS)
@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_compressed_file_is_read_as_what_it_holds(text: str, suffix: str, tmp_path: Path) -> None:
    (tmp_path / "match").write_text(text)
    (tmp_path / f"match{suffix}").write_bytes(PACKERS[suffix](text.encode()))
    assert load_timeline(tmp_path / f"match{suffix}") == load_timeline(tmp_path / "match")


def test_a_compressed_file_is_detected_by_its_content_and_titled_by_its_name(
    tmp_path: Path,
) -> None:
    (tmp_path / "final.json.gz").write_bytes(gzip.compress(NATIVE.encode(), mtime=0))
    assert load_timeline(tmp_path / "final.json.gz").title == "final"
    (tmp_path / "final").write_bytes(gzip.compress(NATIVE.encode(), mtime=0))
    assert load_timeline(tmp_path / "final").duration_s == 9.0


def test_companions_lie_beside_the_compressed_file(tmp_path: Path) -> None:
    from tests.data.readers.football_files import companion

    (tmp_path / "events.json.gz").write_bytes(gzip.compress(WYSCOUT_TEXT.encode(), mtime=0))
    (tmp_path / "matches.json").write_text(json.dumps([companion()]))
    title = load_timeline(tmp_path / "events.json.gz").title
    assert title.startswith("Northport City 1-3 Sudbury")


def test_errors_name_the_file_that_was_given(tmp_path: Path) -> None:
    path = tmp_path / "m.csv.gz"
    path.write_bytes(gzip.compress(b"time_s,kind\nsoon,goal\n", mtime=0))
    assert refused(path, "line 2").startswith(f"{path}: line 2")


@pytest.mark.parametrize("suffix", PACKERS)
def test_a_bomb_is_refused_at_the_limit_with_the_option(suffix: str, tmp_path: Path) -> None:
    bomb = PACKERS[suffix](b"[" + b" " * (40 * 2**20))
    assert len(bomb) < 100_000
    (tmp_path / "bomb").write_bytes(bomb)
    refused(
        tmp_path / "bomb",
        r"bomb: unpacks to more than the 8 MB that are read; .*max_mb \(--read max-mb=MB\)",
        max_mb=8.0,
    )
    assert not list(Path(opening.tempfile.gettempdir()).glob("overview-*/bomb"))


def test_the_usual_limit_of_what_is_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opening, "MAX_MB", 1.0)
    (tmp_path / "b.gz").write_bytes(gzip.compress(NATIVE.encode() + b" " * 2**20, mtime=0))
    refused(tmp_path / "b.gz", "more than the 1 MB")
    assert load_timeline(tmp_path / "b.gz", max_mb=2.0).duration_s == 9.0


def test_a_zip_that_lies_about_its_size_is_stopped_too(tmp_path: Path) -> None:
    data = zipped(b"[" + b" " * (40 * 2**20))
    true = (40 * 2**20 + 1).to_bytes(4, "little")
    assert data.count(true) == 2
    (tmp_path / "z").write_bytes(data.replace(true, (100).to_bytes(4, "little")))
    refused(tmp_path / "z", "unpack", max_mb=8.0)


def test_a_zip_of_too_many_files_is_refused_by_its_table_of_contents(tmp_path: Path) -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for i in range(20_000):
            archive.writestr(f"{i}.json", b"")
    (tmp_path / "z").write_bytes(stream.getvalue())
    refused(tmp_path / "z", "ZIP archive of too many files")


def test_an_archive_of_several_files_gives_a_one_line_error(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "z.zip", "w") as archive:
        archive.writestr("a.json", NATIVE)
        archive.writestr("b.json", NATIVE)
    refused(tmp_path / "z.zip", "of 2 files; unpack it and name one")
    with zipfile.ZipFile(tmp_path / "y.zip", "w") as archive:
        archive.writestr("folder/", "")
        archive.writestr("__MACOSX/a.json", "x")
        archive.writestr("folder/.DS_Store", "x")
        archive.writestr("folder/a.json", NATIVE)
    assert load_timeline(tmp_path / "y.zip").duration_s == 9.0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (gzip.compress(NATIVE.encode(), mtime=0)[:-12], "cut off"),
        (
            gzip.compress(gzip.compress(NATIVE.encode(), mtime=0), mtime=0),
            "contains another compressed file",
        ),
        (gzip.compress(b"", mtime=0), "contains an empty file"),
        (b"\x1f\x8b\x08\x00" + b"\x00" * 6 + b"\xff" * 30, "can't be unpacked"),
        (bz2.compress(NATIVE.encode())[:-12], "cut off"),
        (lzma.compress(NATIVE.encode())[:-12], "cut off|can't be unpacked"),
        (zipped(NATIVE.encode())[:-12], "can't be unpacked"),
        (b"PK\x03\x04" + b"noise" * 30, "can't be unpacked"),
        (b"\x28\xb5\x2f\xfd" + b"x" * 20, "a Zstandard archive can't be read; unpack it first"),
        (b"7z\xbc\xaf\x27\x1c" + b"x" * 20, "a 7z archive can't be read"),
    ],
)
def test_a_damaged_archive_gives_a_one_line_error(
    content: bytes, words: str, tmp_path: Path
) -> None:
    (tmp_path / "a").write_bytes(content)
    refused(tmp_path / "a", f"a: .*{words}")


def test_xz_takes_no_memory_of_its_choice(tmp_path: Path) -> None:
    greedy = lzma.compress(
        NATIVE.encode(), filters=[{"id": lzma.FILTER_LZMA2, "dict_size": 1 << 29}]
    )
    (tmp_path / "x").write_bytes(greedy)
    refused(tmp_path / "x", "can't be unpacked .*[Mm]emory")


@given(
    suffix=st.sampled_from(sorted(PACKERS)),
    at=st.integers(0, 400),
    length=st.integers(0, 30),
    put=st.binary(max_size=8),
)
def test_any_change_of_an_archive_gives_a_timeline_or_a_one_line_error(
    suffix: str, at: int, length: int, put: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    from tests.data.readers.outcome import timeline_or_one_line

    data = PACKERS[suffix](NATIVE.encode())
    path = tmp_path_factory.mktemp("a") / "x"
    path.write_bytes((data[:at] + put + data[at + length :]) or b"x")
    timeline_or_one_line(lambda: load_timeline(path))


def test_packing_is_detected_by_the_first_bytes() -> None:
    assert packing(b"BZh nothing of it") is None
    assert packing(b"PKzip") is None
    assert packing(b'{"a": 1}') is None
    assert packing(bz2.compress(b"")) == "bzip2"


def test_a_timeline_that_was_saved_and_packed_is_the_same(tmp_path: Path) -> None:
    bundled = load_timeline("world-cup-final-2018")
    save_timeline(bundled, tmp_path / "m.json")
    (tmp_path / "m.json.xz").write_bytes(lzma.compress((tmp_path / "m.json").read_bytes()))
    assert load_timeline(tmp_path / "m.json.xz") == bundled
