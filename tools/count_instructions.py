"""Count the kernels' instructions for fixed work, and compare with stored counts.

python tools/count_instructions.py [--why "what was gained for it"]

Callgrind counts the same on every machine and under any load. Each line of `instructions.txt` is
one count, the last of each work holds: more than 3 % above it is an error. `--why` adds a line for
each work that changed. Needs valgrind with its headers and gcc; without them it says so and does
nothing. The kernels are compiled for x86-64-v3, whatever the machine; another numba may count
differently.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
LOG = HERE / "instructions.txt"
HEADER = Path("/usr/include/valgrind/callgrind.h")
FRAMES = 48_000
GROWTH = 1.03
CHANGED = 0.002
TARGET = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": "+avx2"}
LINE = re.compile(r"(?P<work>.+?)\s*\|\s*(?P<count>[\d.]+)\s*\|\s*(?P<why>.+)")


def main(why: str | None) -> int:
    missing = [name for name in ("valgrind", "gcc") if not shutil.which(name)]
    if missing or not HEADER.is_file():
        what = ", ".join(missing) or str(HEADER)
        print(f"instructions not counted: {what} is missing (apt-get install valgrind gcc)")
        return 0
    logged = last_counts()
    counts = counted()
    grown = []
    print(f"{'instructions a sample':<34}{'now':>9}{'logged':>9}")
    for work, count in counts.items():
        before = logged.get(work)
        print(f"{work:<34}{count:>9.1f}{'-' if before is None else f'{before:.1f}':>9}")
        if before is None or count > before * GROWTH:
            grown.append(work)
    if why:
        append(counts, logged, why)
    elif grown:
        print(
            f"more than {100 * (GROWTH - 1):.0f} % above {LOG.name}, or not in it: "
            f"{'; '.join(grown)}. Undo it, or say why with --why ({toolchain()})"
        )
        return 1
    return 0


def toolchain() -> str:
    return ", ".join(f"{part} {importlib.metadata.version(part)}" for part in ("numba", "llvmlite"))


def last_counts() -> dict[str, float]:
    lines = LOG.read_text(encoding="utf-8").splitlines() if LOG.exists() else []
    found = [LINE.fullmatch(line) for line in lines if not line.startswith("#")]
    return {match["work"]: float(match["count"]) for match in found if match}


def append(counts: dict[str, float], logged: dict[str, float], why: str) -> None:
    with LOG.open("a", encoding="utf-8", newline="\n") as file:
        for work, count in counts.items():
            before = logged.get(work)
            if before is None or abs(count / before - 1.0) > CHANGED:
                file.write(f"{work:<34}| {count:8.1f} | {why} ({toolchain()})\n")


def counted() -> dict[str, float]:
    """Return the instructions per sample of each work of instruction_work.py, in its order."""
    with tempfile.TemporaryDirectory() as folder:
        marks = Path(folder) / "marks.so"
        subprocess.run(
            ["gcc", "-O2", "-shared", "-fPIC", str(HERE / "callgrind_marks.c"), "-o", str(marks)],
            check=True,
        )
        environment = {
            **os.environ,
            **TARGET,
            "NUMBA_CACHE_DIR": folder,
            "PYTHONHASHSEED": "0",
            "PYTHONPATH": os.pathsep.join([str(HERE.parent), os.environ.get("PYTHONPATH", "")]),
        }
        work = [sys.executable, str(HERE / "instruction_work.py")]
        subprocess.run(work, env=environment, check=True)
        valgrind = [
            "valgrind", "--tool=callgrind", "--instr-atstart=no", "--combine-dumps=no",
            f"--callgrind-out-file={folder}/out",
        ]  # fmt: skip
        done = subprocess.run([*valgrind, *work, str(marks)], env=environment, capture_output=True)
        if done.returncode:
            sys.exit(f"callgrind failed: {done.stderr.decode()[-2000:]}")
        dumps = sorted(Path(folder).glob("out.*"), key=lambda path: int(path.suffix[1:]))
        found = (count_of(dump.read_text()) for dump in dumps)
        return {work: count / FRAMES for work, count in found if count}


def count_of(dump: str) -> tuple[str, int]:
    name = re.search(r"^desc: Trigger: Client Request: (.*)$", dump, re.MULTILINE)
    total = re.search(r"^(?:summary|totals): (\d+)", dump, re.MULTILINE)
    return (name[1] if name else "", int(total[1]) if name and total else 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--why", help="add lines to the log, with this reason")
    sys.exit(main(parser.parse_args().why))
