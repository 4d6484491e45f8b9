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

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.errors import InputError, quoted
from overview_dsp.installation import require_package

_CHILD = Path(__file__).with_name("workbook_process.py")
_PART = 1 << 20


def with_sheet(source: DataFile) -> DataFile:
    """Return the file with its sheets, and that which the option `match` begins with.

    InputError: the file can't be read, or is protected by a password.
    """
    sheets, match = tuple(json.loads(b"".join(_printed(source)))), source.options.match or ""
    named = [one for one in sheets if match == one or match.startswith(f"{one}, ")]
    if named:
        sheet = max(named, key=len)
        options = replace(source.options, match=match[len(sheet) + 2 :] or None)
        return replace(source, options=options, sheets=sheets, sheet=sheet)
    names = ", ".join(map(quoted, sheets[:6]))
    note = f"the first sheet with cells is read; match (--select) takes one of {names}"
    return replace(source, sheets=sheets, notes=(*source.notes, *([note] * (len(sheets) > 1))))


def csv_parts(source: DataFile) -> Iterator[bytes]:
    """Yield the rows of a sheet as CSV: that of the file, or the first with cells.

    InputError: the sheet needs too much memory, or there are no cells.
    """
    empty = True
    for part in _printed(source, source.sheet):
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
