"""Write the tables of docs/benchmarks.md from reports of the benchmarks.

python tools/write_benchmarks.py                 measures speeds here: about five minutes
python tools/write_benchmarks.py --live          how the output holds: 22 minutes, and it sounds
python tools/write_benchmarks.py --first-starts  what first starts cost: a minute
python tools/write_benchmarks.py --report FILE   one of them, from `python -m tools.bench --json`,
                                                 `python -m tools.bench --live --json` or
                                                 `python tools/measure_first_starts.py --json`

Speeds draw docs/pictures/speeds.png too. The tables stand between `<!-- bench: speeds -->` (or
`live`, `first starts`) and `<!-- end of bench -->`, behind the machine and the day: measure on a
quiet one.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "benchmarks.md"
PICTURE = ROOT / "docs" / "pictures" / "speeds.png"
ROUNDS = 5


def measured(what: str) -> dict[str, Any]:
    """Measure now, and return the report."""
    rounds = ("--rounds", str(ROUNDS), "--json")
    command: tuple[str, ...] = {
        "speeds": ("-m", "tools.bench", *rounds, "--plot", str(PICTURE)),
        "live": ("-m", "tools.bench", "--live", *rounds),
        "first starts": (str(ROOT / "tools" / "measure_first_starts.py"), "--json"),
    }[what]
    done = subprocess.run([sys.executable, *command], stdout=subprocess.PIPE, check=True, cwd=ROOT)
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def table(*rows: tuple[str, ...]) -> str:
    """Return a Markdown table; the first row is its head."""
    head, *others = (f"| {' | '.join(row)} |" for row in rows)
    return "\n".join([head, "|---" * len(rows[0]) + "|", *others])


def speeds(report: dict[str, Any]) -> str:
    """Return a table for each group of rows, a table of costs, and the memory."""
    from overview_dsp.measure.bench import VOICE, Row, cycles
    from tools.bench.report import merging
    from tools.bench.scaling import Cost

    parts = [f"{report['date']}, {report['machine']}; medians of {report['rounds']} rounds:"]
    for group in dict.fromkeys(row["group"] for row in report["rows"]):
        rows = [
            (row["name"], f"{row['speed']:.4g}", f"{row['ratio']:.3g}", ranged(row, "ratio_"))
            for row in report["rows"]
            if row["group"] == group
        ]
        parts.append(table((group, "x realtime", "of the first", "lowest to highest"), *rows))
        if group == VOICE:
            of_group = [Row(**row) for row in report["rows"] if row["group"] == group]
            said = cycles(of_group, report["ghz"])
            parts.append(f"{said[0].upper()}{said[1:]}.")
    costs = [
        (f"{cost.series}: {cost.entry}{merging(cost)}", f"{cost.ratio:.2f}", ranged(asdict(cost)))
        for cost in (Cost(**cost) for cost in report["costs"])
    ]
    parts.append(table(("what a second costs", "of the first", "lowest to highest"), *costs))
    memory = report["memory"]
    parts.append(
        f"Highest memory: {memory['ready_mb']:.0f} MB with an engine ready, "
        f"{memory['streamed_mb']:.0f} MB after a stream of {memory['seconds']:g} s."
    )
    parts += [f"Left out: {reason}." for reason in report["left_out"]]
    return "\n\n".join(parts)


def ranged(figure: dict[str, Any], prefix: str = "") -> str:
    return f"{figure[prefix + 'low']:.3g} to {figure[prefix + 'high']:.3g}"


def live(report: dict[str, Any]) -> str:
    """Return the output of `python -m tools.bench --live`."""
    from tools.bench.live.latency import LatencyResult
    from tools.bench.live.session import SessionRow
    from tools.bench.live.table import LoadRow, Report, lines

    shown = {key: value for key, value in report.items() if key not in ("machine", "date")}
    shown["load"] = [LoadRow(**row) for row in report["load"]]
    shown["latency"] = [LatencyResult(**row) for row in report["latency"]]
    shown["sessions"] = [SessionRow(**row) for row in report["sessions"]]
    text = "\n".join(lines(Report(**shown)))
    return f"{report['date']}, {report['machine']}:\n\n```text\n{text}\n```"


def first_starts(report: dict[str, Any]) -> str:
    """Return a table with one row for each command."""
    rows = [
        (
            f"`overview {one['command']}`",
            *(
                "" if one[figure] is None else f"{one[figure]:.2f}"
                for figure in ("imports_s", "first_sound_s", "whole_s")
            ),
        )
        for one in report["first_starts"]
    ]
    head = ("first start, s of processor time", "imports", "to the first sound", "to the end")
    return f"{report['date']}, {report['machine']}:\n\n{table(head, *rows)}"


WRITERS = {"speeds": speeds, "live": live, "first starts": first_starts}


def what_of(report: dict[str, Any]) -> str:
    """Return the key of `WRITERS` for a report."""
    if "first_starts" in report:
        return "first starts"
    return "live" if "load" in report else "speeds"


def filled(page: str, what: str, text: str) -> str:
    """Return the page with a text between the markers of `what`."""
    marked = re.compile(rf"(<!-- bench: {what} -->\n).*?(\n<!-- end of bench -->)", re.DOTALL)
    page, times = marked.subn(lambda found: f"{found[1]}\n{text}\n{found[2]}", page)
    if times != 1:
        sys.exit(f"{PAGE.name}: one place is marked '<!-- bench: {what} -->', not {times}")
    return page


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    chosen = parser.add_mutually_exclusive_group()
    for what in ("live", "first starts"):
        option = f"--{what.replace(' ', '-')}"
        chosen.add_argument(option, dest="what", action="store_const", const=what, default="speeds")
    parser.add_argument("--report", type=Path, metavar="FILE", help="measured before")
    asked = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    report = json.loads(asked.report.read_text()) if asked.report else measured(asked.what)
    what = what_of(report)
    text = WRITERS[what](report)
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), what, text), encoding="utf-8")


if __name__ == "__main__":
    main()
