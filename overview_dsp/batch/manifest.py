"""Results of a batch: parts while it runs, and one Parquet manifest at the end.

A part is a file of JSON lines, which a worker writes without a library. It has one row per case:
the key, and the measurements or an error. The manifest has one row per case in the order of the
grid: names, every parameter, measurements. Its metadata (`overview_study`, JSON) hold the complete
presets. The same grid gives the same bytes.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from overview_dsp import __version__
from overview_dsp.arrays import IntArray
from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.storage import Storage
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.design.presets.serialization import preset_to_dict
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.files.toml import load_toml
from overview_dsp.installation import require_package

SOUNDS = "sounds"
PARTS = "parts"
MANIFEST = "manifest.parquet"

_MEASURES = load_toml(__file__, "measures.toml")
MEASURES: Mapping[str, str] = {name: one["meaning"] for name, one in _MEASURES.items()}
"""Columns of a part beside the key, with their meanings."""


def _pyarrow(module: str = "") -> Any:
    return require_package(f"pyarrow{module}", "overview batch", "batch")


def _schema() -> Any:
    arrow = _pyarrow()
    felt = arrow.struct(
        [("event", arrow.int32()), ("kind", arrow.string()), ("level_db", arrow.float64())]
    )
    kinds = {name: getattr(arrow, name)() for name in ("string", "int64", "float64")}
    kinds["events"] = arrow.list_(felt)
    measures = [(name, kinds[one["type"]]) for name, one in _MEASURES.items()]
    return arrow.schema([("key", arrow.string()), *measures])


def encode_part(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return rows (a key and measurements) as JSON lines; a missing measurement becomes null."""
    return "".join(json.dumps(row) + "\n" for row in rows).encode()


def _decoded(name: str, data: bytes) -> Any:
    """Return the table of a part or of a manifest, with the columns of `_schema`."""
    schema, file = _schema(), io.BytesIO(data)
    if name == MANIFEST:
        found = _pyarrow(".parquet").read_table(file, columns=schema.names)
    else:
        read = _pyarrow(".json")
        found = read.read_json(
            file,
            # pyarrow rejects a row that spans two blocks
            read.ReadOptions(use_threads=False, block_size=len(data) + 1),
            read.ParseOptions(explicit_schema=schema, unexpected_field_behavior="error"),
        )
    return found.select(schema.names).cast(schema).replace_schema_metadata(None)


def read_rows(storage: Storage) -> tuple[Any, list[str]]:
    """Read all finished rows of an output folder, and the names of its parts; InputError."""
    arrow = _pyarrow()
    parts = sorted(storage.sizes(PARTS))
    tables = [_schema().empty_table()]
    for name in (MANIFEST, *parts):
        try:
            data = storage.get(name)
        except FileNotFoundError:
            continue
        try:
            tables.append(_decoded(name, data))
        except (arrow.ArrowException, KeyError, ValueError) as error:
            raise InputError(
                f"{storage.where}/{name}: not a file of a batch ({error}); remove it, "
                "or choose another output folder"
            ) from None
    return arrow.concat_tables(tables), parts


def finished_rows(table: Any, sizes: Mapping[str, int]) -> dict[str, int]:
    """Return the table row of each finished key: its file exists in full size."""
    columns = (table.column(name).to_pylist() for name in ("key", "file", "bytes", "error"))
    return {
        key: row
        for row, (key, file, size, error) in enumerate(zip(*columns, strict=True))
        if error is None and sizes.get(file) == size
    }


def rows_of(
    storage: Storage, table: Any, finished: Mapping[str, int], keys: Sequence[str]
) -> IntArray:
    """Return the table row of each key: the finished one, else the last failed one.

    OverviewError for a key with neither, as its file was deleted during the run.
    """
    columns = (table.column(name).to_pylist() for name in ("key", "error"))
    rows_and_errors = enumerate(zip(*columns, strict=True))
    failed = {key: row for row, (key, error) in rows_and_errors if error is not None}
    rows = [finished.get(key, failed.get(key, -1)) for key in keys]
    if -1 in rows:
        raise OverviewError(
            f"{storage.where}: {rows.count(-1)} sounds were deleted during the run; "
            "run the command again"
        )
    return np.array(rows, np.int64)


def encode_manifest(grid: RenderGrid, table: Any, rows: IntArray) -> bytes:
    """Return the manifest; case `i` has the measurements in row `rows[i]` of the table."""
    arrow = _pyarrow()
    count = len(grid)
    indices = np.unravel_index(np.arange(count), grid.sizes)

    def chosen(values: Sequence[Any], at: IntArray) -> Any:
        # each value once: with duplicates, Parquet writes uninitialised bytes
        unique = list(dict.fromkeys(values))
        code = np.array([unique.index(value) for value in values], np.int32)
        return arrow.DictionaryArray.from_arrays(arrow.array(code[at]), arrow.array(unique))

    columns: dict[str, Any] = {
        "index": arrow.array(np.arange(count)),
        "timeline": chosen(list(grid.timelines), indices[0]),
        "preset": chosen(list(grid.presets), indices[1]),
        "gesture": chosen(list(grid.gestures), indices[2]),
        "seed": arrow.array(np.array(grid.seeds, np.int64)[indices[-1]]),
    }
    varied = dict(zip(grid.parameters, indices[3:-1], strict=True))
    for id in (*PARAMETERS, *(id for id in varied if id not in PARAMETERS)):
        if id in varied:
            columns[id] = chosen(grid.parameters[id], varied[id])
        else:
            values = [preset.values[id] for preset in grid.presets.values()]
            columns[id] = chosen(values, indices[1])
    measured = table.take(arrow.array(rows))
    columns |= {name: measured.column(name) for name in measured.schema.names}
    about = {
        "overview_dsp": __version__,
        "sample_rate": grid.settings.sample_rate,
        "tail": grid.settings.tail,
        "presets": {name: preset_to_dict(preset) for name, preset in grid.presets.items()},
        "columns": MEASURES,
    }
    metadata = {"overview_study": json.dumps(about, ensure_ascii=False)}
    whole = arrow.table(columns).combine_chunks()
    file = io.BytesIO()
    _pyarrow(".parquet").write_table(whole.replace_schema_metadata(metadata), file)
    return file.getvalue()
