"""What is known of a study's renders: parts while it runs, one Parquet manifest in the end.

A part holds a row for each case, by its key: the measures, or why it failed; JSON lines, which cost
a worker no library. The manifest has a row for each case of the study in the order of the grid:
what was combined, every parameter, the measures. Its metadata hold the presets whole
(`overview_study`, JSON). The same study gives the same bytes.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import __version__
from overview_dsp.batch.extra import library
from overview_dsp.batch.grid import Study
from overview_dsp.batch.storage import Place
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.design.presets.serialization import preset_to_dict
from overview_dsp.errors import InputError, OverviewError

SOUNDS = "sounds"
PARTS = "parts"
MANIFEST = "manifest.parquet"

MEASURES: Mapping[str, str] = {
    "file": "in the study's place",
    "frames": "length",
    "duration_s": "length, s",
    "peak_click_dbfs": "none for silence",
    "peak_tactor_dbfs": "none for silence",
    "loudness_lufs": "of the clicks, BS.1770 integrated; -70 is silence, none below 4000 Hz",
    "strikes": "events passed and slips",
    "felt": "each event passed: its number, kind, and highest level over 10 ms of the tactor, dB",
    "bytes": "size of the file",
    "sha256": "of the file",
    "samples_sha256": "of the samples before they were stored, as little-endian float32",
    "error": "why there is no render, else none",
}
"""The columns of a part, beside the key."""


def _schema() -> Any:
    arrow = library("pyarrow")
    felt = arrow.struct(
        [("event", arrow.int32()), ("kind", arrow.string()), ("level_db", arrow.float64())]
    )
    numbers = {"frames": arrow.int64(), "strikes": arrow.int64(), "bytes": arrow.int64()}
    texts = ("file", "sha256", "samples_sha256", "error")
    kinds = {**numbers, **dict.fromkeys(texts, arrow.string()), "felt": arrow.list_(felt)}
    measures = [(name, kinds.get(name, arrow.float64())) for name in MEASURES]
    return arrow.schema([("key", arrow.string()), *measures])


def _encoded(table: Any) -> bytes:
    file = io.BytesIO()
    library("pyarrow.parquet").write_table(table, file)
    return file.getvalue()


def encode_part(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Rows (a key and measures; what is left out is none) as JSON lines."""
    return "".join(json.dumps(row) + "\n" for row in rows).encode()


def _decoded(name: str, data: bytes) -> Any:
    """The table of a part or of a manifest: the columns of `_schema`."""
    schema, file = _schema(), io.BytesIO(data)
    if name == MANIFEST:
        found = library("pyarrow.parquet").read_table(file, columns=schema.names)
    else:
        read = library("pyarrow.json")
        found = read.read_json(
            file,
            # a row that spans two blocks is refused
            read.ReadOptions(use_threads=False, block_size=len(data) + 1),
            read.ParseOptions(explicit_schema=schema, unexpected_field_behavior="error"),
        )
    return found.select(schema.names).cast(schema).replace_schema_metadata(None)


def read_rows(place: Place) -> tuple[Any, list[str]]:
    """What is known of a place: a table of parts' columns, and the names of the parts.

    Raises
    ------
    InputError
        A file there isn't what it should be.
    """
    arrow = library("pyarrow")
    parts = sorted(place.sizes(PARTS))
    tables = [_schema().empty_table()]
    for name in (MANIFEST, *parts):
        try:
            data = place.get(name)
        except FileNotFoundError:
            continue
        try:
            tables.append(_decoded(name, data))
        except (arrow.ArrowException, KeyError, ValueError) as error:
            raise InputError(
                f"{place.where}/{name}: not what a study left here ({error}); remove it, "
                "or choose another place"
            ) from None
    return arrow.concat_tables(tables), parts


def finished_rows(table: Any, sizes: Mapping[str, int]) -> dict[str, int]:
    """Where in the table each finished key is: rendered, and its file there in full size."""
    columns = (table.column(name).to_pylist() for name in ("key", "file", "bytes", "error"))
    return {
        key: row
        for row, (key, file, size, error) in enumerate(zip(*columns, strict=True))
        if error is None and sizes.get(file) == size
    }


def rows_of(
    place: Place, table: Any, finished: Mapping[str, int], keys: Sequence[str]
) -> NDArray[np.int64]:
    """The table's row of each key: the finished one, else the last that failed.

    OverviewError if a key has neither: its file was taken away meanwhile.
    """
    failed = {
        key: row
        for row, (key, error) in enumerate(
            zip(table.column("key").to_pylist(), table.column("error").to_pylist(), strict=True)
        )
        if error is not None
    }
    rows = [finished.get(key, failed.get(key, -1)) for key in keys]
    if -1 in rows:
        raise OverviewError(
            f"{place.where}: {rows.count(-1)} sounds have vanished while others were made; "
            "run it again"
        )
    return np.array(rows, np.int64)


def encode_manifest(study: Study, table: Any, rows: NDArray[np.int64]) -> bytes:
    """The study's manifest; case `i` has the measures of row `rows[i]` of the table."""
    arrow = library("pyarrow")
    count = len(study)
    lists = [study.timelines, study.presets, study.gestures, *study.parameters.values()]
    sizes = (*map(len, lists), len(study.seeds))
    places = np.unravel_index(np.arange(count), sizes)

    def chosen(values: Sequence[Any], at: NDArray[np.int64]) -> Any:
        # each value once: of a dictionary with twins Parquet writes bytes left over in memory
        unique = list(dict.fromkeys(values))
        code = np.array([unique.index(value) for value in values], np.int32)
        return arrow.DictionaryArray.from_arrays(arrow.array(code[at]), arrow.array(unique))

    columns: dict[str, Any] = {
        "index": arrow.array(np.arange(count)),
        "timeline": chosen(list(study.timelines), places[0]),
        "preset": chosen(list(study.presets), places[1]),
        "gesture": chosen(list(study.gestures), places[2]),
        "seed": arrow.array(np.array(study.seeds, np.int64)[places[-1]]),
    }
    varied = dict(zip(study.parameters, places[3:-1], strict=True))
    for id in (*PARAMETERS, *(id for id in varied if id not in PARAMETERS)):
        if id in varied:
            columns[id] = chosen(study.parameters[id], varied[id])
        else:
            values = [preset.values[id] for preset in study.presets.values()]
            columns[id] = chosen(values, places[1])
    measured = table.take(arrow.array(rows))
    columns |= {name: measured.column(name) for name in measured.schema.names}
    about = {
        "overview_dsp": __version__,
        "sample_rate": study.settings.sample_rate,
        "tail": study.settings.tail,
        "presets": {name: preset_to_dict(preset) for name, preset in study.presets.items()},
        "columns": MEASURES,
    }
    metadata = {"overview_study": json.dumps(about, ensure_ascii=False)}
    whole = arrow.table(columns).combine_chunks()
    return _encoded(whole.replace_schema_metadata(metadata))
