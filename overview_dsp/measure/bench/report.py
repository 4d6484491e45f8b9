"""Everything `overview bench` measures, and how it is shown: a table, and what was left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from overview_dsp.measure.bench import (
    c_rows,
    many_voices,
    overview_rows,
    programs,
    scaling,
    solvers,
)
from overview_dsp.measure.bench.building import MissingError
from overview_dsp.measure.bench.scaling import Cost, Memory
from overview_dsp.measure.bench.timing import VOICE, Contender, Row, interleaved
from overview_dsp.measure.bench.work import RATE

NEIGHBOURS = (c_rows.contenders, solvers.contenders, programs.faust, programs.csound)
SPEEDS_PART = 0.4
"""Of the whole time, for the progress bar."""


@dataclass(frozen=True)
class Report:
    """What was measured. `left_out`: what wasn't, and why. `ghz`: the processor's clock."""

    rounds: int
    rows: list[Row]
    costs: list[Cost]
    memory: Memory
    left_out: list[str]
    ghz: float


def measure(
    rounds: int = 7,
    longest_s: float = 600.0,
    progress: Callable[[float], None] | None = None,
) -> Report:
    """Measure speeds, then costs; streams of up to `longest_s` of sound."""
    report_part = progress or (lambda part: None)
    contenders: list[Contender] = overview_rows.contenders() + many_voices.contenders()
    left_out = []
    for add in NEIGHBOURS:
        try:
            contenders += add()
        except MissingError as missing:
            left_out.append(str(missing))
    rows = interleaved(contenders, rounds, lambda part: report_part(SPEEDS_PART * part))
    ghz = overview_rows.clock_ghz()
    memory = scaling.memory(longest_s)
    costs = scaling.measure(
        rounds, longest_s, lambda part: report_part(SPEEDS_PART + (1.0 - SPEEDS_PART) * part)
    )
    return Report(rounds, rows, costs, memory, left_out, ghz)


def lines(report: Report) -> list[str]:
    """The report as lines of text."""
    found = [
        f"medians of {report.rounds} interleaved rounds (lowest to highest), CPU time of one core"
    ]
    for group in dict.fromkeys(row.group for row in report.rows):
        rows = [row for row in report.rows if row.group == group]
        found += ["", *speed_table(group, rows)]
        if group == VOICE:
            found += ["", cycles(rows, report.ghz)]
    found += ["", f"{'cost':<34}{'of the first':>13}"]
    for cost in report.costs:
        spread = f"({cost.low:.2f} to {cost.high:.2f})"
        entry = f"{cost.series}: {cost.entry}"
        merged = merging(cost)
        found.append(f"{entry:<34}{cost.ratio:>13.2f}  {spread}{merged}")
    memory = report.memory
    found += [
        "",
        f"highest memory: {memory.ready_mb:.0f} MB with an engine ready, "
        f"{memory.streamed_mb:.0f} MB after a stream of {memory.seconds:g} s",
    ]
    return found + [f"left out: {reason}" for reason in report.left_out]


def speed_table(group: str, rows: Sequence[Row]) -> list[str]:
    """One group's rows as lines of text."""
    width = max(len(row.name) for row in rows)
    head = f"{group:<{width}}  {'x realtime':>10}  {'':<18}  of the first"
    return [
        head,
        *(
            f"{row.name:<{width}}  {row.speed:>10.4g}  {f'({row.low:.4g} to {row.high:.4g})':<18}  "
            f"{row.ratio:.3g} ({row.ratio_low:.3g} to {row.ratio_high:.3g})"
            for row in rows
        ),
    ]


def cycles(rows: Sequence[Row], ghz: float) -> str:
    """Our rows of the full voice in a unit that no other row and no clock changes."""
    each = (
        f"{row.name.removeprefix('overView, ')} {1e9 * ghz / (row.speed * RATE):.0f}"
        for row in rows
        if row.name.startswith("overView")
    )
    return f"cycles a voice and sample, at {ghz:.2f} GHz: {', '.join(each)}"


def merging(cost: Cost) -> str:
    """Says so where a series' events were merged."""
    if cost.series != "events" or int(cost.entry.split()[0]) == cost.strikes:
        return ""
    return f", merged to {cost.strikes} strikes"
