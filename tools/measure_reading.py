"""Processor time of reading tables, beside polars': `python tools/measure_reading.py [ROUNDS]`.

A table of 2,000 rows x 5,007 columns and one of 2 million rows, read in turns, each in a process of
its own; imports aren't counted. polars detects times (`try_parse_dates`), is given their format
(`str.to_datetime`), or leaves them as text, which is less work than ours.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

READ = {
    "overview": "import overview_dsp.data.readers.registry as r; "
    "f = lambda: r.load_timeline(path, value=value)",
    "polars, times": "import polars as p; f = lambda: p.read_csv(path, try_parse_dates=True)",
    "polars, told times": "import polars as p; f = lambda: p.read_csv(path).with_columns("
    "p.col('time').str.to_datetime('%Y-%m-%dT%H:%M:%S'))",
    "polars, text": "import polars as p; f = lambda: p.read_csv(path)",
}
TIMED = "import sys, time; path, value = sys.argv[1:]; {}; "
TIMED += "begin = time.process_time(); f(); print(time.process_time() - begin)"


def write(path: Path, rows: int, columns: int, step_s: int) -> None:
    """A table of times and random walks."""
    values = np.random.default_rng(1).standard_normal((rows, columns)).cumsum(axis=0).round(3)
    times = np.datetime64("2020-01-01T00:00:00") + np.arange(rows) * np.timedelta64(step_s, "s")
    with open(path, "w") as file:
        print("time", *(f"c{i}" for i in range(columns)), sep=",", file=file)
        for time, row in zip(times.astype(str).tolist(), values, strict=True):
            print(time, *row.tolist(), sep=",", file=file)


def main(rounds: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name, shape in {"wide": (2000, 5006, 3600), "long": (2_000_000, 1, 1)}.items():
            path = Path(folder) / f"{name}.csv"
            write(path, *shape)
            spent: dict[str, list[float]] = {way: [] for way in READ}
            for _ in range(rounds):
                for way, code in READ.items():
                    command = [sys.executable, "-c", TIMED.format(code), str(path), "c0"]
                    spent[way].append(float(subprocess.check_output(command)))
            medians = {way: float(np.median(seconds)) for way, seconds in spent.items()}
            line = ", ".join(f"{way} {seconds:.2f} s" for way, seconds in medians.items())
            ratio = medians["overview"] / medians["polars, times"]
            print(f"{name} ({path.stat().st_size / 1e6:.0f} MB): {line}; {ratio:.2f} x polars")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
