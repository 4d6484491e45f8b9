"""Processor time of reading tables, beside polars': `python tools/measure_reading.py`.

Arguments: rounds (3) and rows (3,000,000).

Each form of times is a file of two columns and ROWS rows (3 million): CSV, JSON lines or Parquet.
Ours and polars' own reading (`read_csv(try_parse_dates=True)`, `read_ndjson`, `read_parquet`) run
in turns, each in a process of its own; a first reading of a short file isn't counted, nor are its
imports. "reading" is the table alone, without the search for groups; "timeline" adds this search,
events and the curve. "analysis" is the difference, per million rows; it is also measured with a
sixth of the rows, and both are about equal if it grows linearly. A form that isn't read is a
failure; so is a ratio above 2.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl

LIMIT = 2.0
STEP_S = 60
EPOCH_S = 1_600_000_000

READ = {
    "reading": "from pathlib import Path; from overview_dsp.data.readers.data_file import *; "
    "from overview_dsp.data.readers import registry; "
    "from overview_dsp.data.readers.series import read_plan, rows\n"
    "def f():\n"
    " s = DataFile.open(path); t = registry._format_of(s).open_table(s)\n"
    " p = read_plan.make_read_plan(t, LoadOptions(value='level'))\n"
    " for _ in rows.RowReader(t, p.time, p.columns, p.decimal_mark): pass\n",
    "timeline": "import overview_dsp.data.readers.registry as r\n"
    "f = lambda: r.load_timeline(path, value='level')\n",
    "polars": "import polars as p\n"
    "f = lambda: {{'csv': lambda q: p.read_csv(q, try_parse_dates=True, separator={mark!r}), "
    "'jsonl': p.read_ndjson, 'parquet': p.read_parquet}}[path.rpartition('.')[2]](path)\n",
}
TIMED = "import sys, time; path = sys.argv[2]\n{}f(); path = sys.argv[1]; "
TIMED += "begin = time.process_time(); f(); print(time.process_time() - begin)"

Written = Callable[[pl.Expr], pl.Expr]


def _as(form: str) -> Written:
    return lambda time: time.dt.strftime(form)


FORMS: dict[str, tuple[Written, str]] = {
    "ISO": (_as("%Y-%m-%dT%H:%M:%S"), ","),
    "ISO with Z": (_as("%Y-%m-%dT%H:%M:%SZ"), ","),
    "ISO with an offset": (_as("%Y-%m-%dT%H:%M:%S+02:00"), ","),
    "day.month.year": (_as("%d.%m.%Y %H:%M"), ";"),
    "month/day/year": (_as("%m/%d/%Y %H:%M"), ","),
    "month names": (_as("%d %b %Y %H:%M"), ","),
    "YYYYMMDDHHMM": (_as("%Y%m%d%H%M"), ","),
    "epoch": (lambda time: time.dt.epoch("s"), ","),
    "epoch, ms": (lambda time: time.dt.epoch("ms"), ","),
    "seconds": (lambda time: (time.dt.epoch("s") - EPOCH_S) / 8, ","),
}  # fmt: skip


def write(folder: Path, rows: int) -> dict[str, tuple[Path, str]]:
    """Return the files by name of their form, with their separators."""
    level = np.random.default_rng(1).standard_normal(rows).cumsum().round(3)
    seconds = EPOCH_S + STEP_S * np.arange(rows)
    times = pl.Series("time", seconds * 1_000_000).cast(pl.Datetime("us"))
    base = pl.DataFrame({"time": times, "level": level})
    files = {}
    for name, (written, mark) in FORMS.items():
        frame = base.with_columns(written(pl.col("time")).alias("time"))
        path = folder / f"{name.replace('/', '-').replace(' ', '-')}.csv"
        if mark == ";":
            frame = frame.with_columns(
                pl.col("level").cast(str).str.replace(".", ",", literal=True)
            )
        frame.write_csv(path, separator=mark)
        files[f"CSV, {name}"] = path, mark
    station = pl.lit("north").alias("station")
    base.with_columns(FORMS["ISO"][0](pl.col("time")), station).write_csv(folder / "text.csv")
    files["CSV, ISO and a text column"] = folder / "text.csv", ","
    for name in ("ISO", "epoch"):
        frame = base.with_columns(FORMS[name][0](pl.col("time")).alias("time"))
        frame.write_ndjson(folder / f"{name}.jsonl")
        frame.write_parquet(folder / f"{name}.parquet")
        files[f"JSON lines, {name}"] = folder / f"{name}.jsonl", ","
        files[f"Parquet, {name}"] = folder / f"{name}.parquet", ","
    count = min(rows, 2000)
    values = np.random.default_rng(2).standard_normal((count, 5005)).cumsum(axis=0).round(3)
    wide = base[:count].hstack(pl.DataFrame(values, schema=[f"c{i}" for i in range(5005)]))
    wide.with_columns(FORMS["ISO"][0](pl.col("time"))).write_csv(folder / "wide.csv")
    files["CSV, 2,000 rows x 5,007 columns"] = folder / "wide.csv", ","
    base.write_parquet(folder / "moments.parquet")
    files["Parquet, moments"] = folder / "moments.parquet", ","
    return files


def spent(code: str, path: Path) -> float | None:
    """Processor time of one reading, None if it failed."""
    paths = [str(path), str(path.parent / "short" / path.name)]
    command = [sys.executable, "-W", "ignore", "-c", TIMED.format(code), *paths]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"{path.name}: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    return float(done.stdout)


def main(rounds: int, rows: int) -> int:
    failed = []
    head = ("polars, s", "reading, s", "ratio", "timeline, s", "analysis, s per million rows")
    print(f"| {rows} rows |", *(f"{title} |" for title in (*head, "of a sixth")))
    print("|---" * 7 + "|")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "short").mkdir()
        write(Path(folder) / "short", 1000)
        (Path(folder) / "sixth" / "short").mkdir(parents=True)
        sixth = write(Path(folder) / "sixth", rows // 6)
        write(Path(folder) / "sixth" / "short", 1000)
        for name, (path, mark) in write(Path(folder), rows).items():
            found: dict[str, list[float | None]] = {way: [] for way in READ}
            for _ in range(rounds):
                for way, code in READ.items():
                    found[way].append(
                        spent(code.format(mark=mark) if "{mark" in code else code, path)
                    )
            medians = {
                way: float(np.median([s for s in all_ if s is not None]))
                if None not in all_
                else None
                for way, all_ in found.items()
            }
            ours, theirs, whole = (medians[way] for way in ("reading", "polars", "timeline"))
            ratio = ours / theirs if ours and theirs else None
            if ratio is None or ratio > LIMIT or whole is None:
                failed.append(name)
            part = [spent(READ[way], sixth[name][0]) for way in ("timeline", "reading")]
            added = [(a - b) / count * 1e6 if a is not None and b is not None else None
                     for a, b, count in ((whole, ours, rows), (*part, rows // 6))]  # fmt: skip
            cells = (theirs, ours, ratio, whole, *added)
            print(f"| {name} |", *("- |" if c is None else f"{c:.2f} |" for c in cells), flush=True)
    print(f"\n{len(failed)} of {len(FORMS) + 7} above {LIMIT:g} or not read: {', '.join(failed)}")
    return bool(failed)


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[1:]]
    sys.exit(main(*(given + [3, 3_000_000][len(given) :])))
