"""Spreadsheets (Excel, OpenDocument) as CSV, through python-calamine (extra `spreadsheets`)."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import IO, cast

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.errors import InputError, quoted
from overview_dsp.installation import require_package

_CHILD = Path(__file__).with_name("workbook_process.py")
_PART = 1 << 20


def choice(source: DataFile) -> tuple[LoadOptions, tuple[str, ...]]:
    """Return the options for the sheet that is read, without its name, and notes about it.

    InputError: the file can't be read, or is protected by a password.
    """
    sheets = json.loads(b"".join(_printed(source)))
    if source.options.match in sheets:
        return replace(source.options, match=None), source.notes
    names = ", ".join(map(quoted, sheets[:6]))
    note = f"the first sheet with cells is read; match (--select) takes one of {names}"
    return source.options, (*source.notes, *([note] if len(sheets) > 1 else []))


def csv_parts(source: DataFile) -> Iterator[bytes]:
    """Yield the rows of a sheet as CSV: that named by the option `match`, or the first with cells.

    InputError: the sheet needs too much memory, or there are no cells.
    """
    empty = True
    for part in _printed(source, source.options.match or ""):
        empty = False
        yield part
    if empty:
        raise InputError(f"{source.where}: no cells; write a table of times and values")


def _printed(source: DataFile, *sheet: str) -> Iterator[bytes]:
    """Yield what the child prints; InputError if it fails."""
    require_package("python_calamine", "reading a spreadsheet (a CSV file needs none)",
                    "spreadsheets")  # fmt: skip
    command = [sys.executable, "-P", str(_CHILD), str(source.path), *sheet]
    # a file, as a child that waits for its error to be read would never end its output
    with tempfile.TemporaryFile() as errors:
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors) as child:
            output = cast("IO[bytes]", child.stdout)
            yield from iter(lambda: output.read(_PART), b"")
        errors.seek(0)
        reason = errors.read().decode(errors="replace").strip().splitlines()
    if child.returncode:
        why = "it needs too much memory" if child.returncode < 0 else "".join(reason[-1:])
        raise InputError(f"{source.where}: not a readable spreadsheet ({why}); save it as CSV")
