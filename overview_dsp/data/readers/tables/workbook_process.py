"""Child process of `workbook`, with limited memory: prints the sheets as JSON, or one as CSV.

A small file can need a lot: calamine makes room for all cells up to the last one. Windows and macOS
have no such limit. Arguments: the path, and the name of a sheet, which another name leaves to the
first with cells; none to list them.
"""

import contextlib
import csv
import datetime as dt
import io
import itertools
import json
import re
import sys
import zipfile
from collections.abc import Sequence

MEMORY_BYTES = 3 << 30
ROWS = 1000
DAYS_TO_1904 = 1462  # from 1899-12-30, where the plain numbers of dates begin in other books

_DATED = re.compile("date|datum", re.IGNORECASE)


def text_of(cell: object) -> str:
    """Return a cell as text: dates without a time of day, whole numbers without a point."""
    if isinstance(cell, dt.datetime):
        return cell.isoformat(" ") if cell.time() != dt.time() else cell.date().isoformat()
    if isinstance(cell, dt.timedelta):  # days would be another unit
        minutes, seconds = divmod(cell // dt.timedelta(seconds=1), 60)
        fraction = f".{cell.microseconds:06}".rstrip("0").rstrip(".")
        return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}{fraction}"
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 2**53 else repr(cell)
    return str(cell)


def moved_days(path: str) -> int:
    """Return the days to add to dates that are plain numbers: 0, unless they count from 1904."""
    with contextlib.suppress(zipfile.BadZipFile, KeyError), zipfile.ZipFile(path) as archive:
        if re.search(rb'date1904="(1|true)"', archive.read("xl/workbook.xml")):
            return DAYS_TO_1904
    return 0


def moved(row: Sequence[object], dated: set[int], days: int) -> list[object]:
    """Return a row with its plain numbers in columns of dates moved; adds columns to `dated`."""
    dated |= {i for i, cell in enumerate(row) if isinstance(cell, str) and _DATED.search(cell)}
    numbers = {i for i in dated if i < len(row) and type(row[i]) in (int, float)}
    return [float(str(c)) + days if i in numbers else c for i, c in enumerate(row)]


def main(path: str, *sheets: str) -> None:
    """Print names, or rows."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        most = MEMORY_BYTES if hard == resource.RLIM_INFINITY else min(MEMORY_BYTES, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))
    import python_calamine

    book = python_calamine.CalamineWorkbook.from_path(path)
    if not sheets:
        print(json.dumps(book.sheet_names))
        return
    days = moved_days(path)
    for name in sheets if sheets[0] in book.sheet_names else book.sheet_names:
        rows = iter(book.get_sheet_by_name(name).iter_rows())
        count, dated = 0, set[int]()
        while some := list(itertools.islice(rows, ROWS)):
            text = io.StringIO()
            cells = [moved(row, dated, days) for row in some] if days else some
            csv.writer(text, lineterminator="\n").writerows(map(text_of, row) for row in cells)
            sys.stdout.buffer.write(text.getvalue().encode())
            count += len(some)
        if count:
            return


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    # calamine's errors, and those of its files
    except Exception as error:
        sys.exit(str(error) or type(error).__name__)
