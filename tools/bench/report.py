"""Tables of everything that `python -m tools.bench` measures, and of missing programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from overview_dsp.measure import bench as speeds
from tools.bench import c_rows, many_voices, programs, scaling, solvers
from tools.bench.building import MissingError
from tools.bench.scaling import Cost, Memory

NEIGHBOURS = (c_rows.contenders, solvers.contenders, programs.faust, programs.csound)
SPEEDS_PART = 0.4
"""Part of the whole time, for the progress bar."""


@dataclass(frozen=True)
class Report(speeds.Report):
    """Results of all measurements. `left_out`: reasons for those that could not run."""

    costs: list[Cost]
    memory: Memory
    left_out: list[str]


def measure(
    rounds: int = 7,
    longest_s: float = 600.0,
    progress: Callable[[float], None] | None = None,
) -> Report:
    """Measure speeds, then costs; streams of up to `longest_s` of sound."""
    report_part = progress or (lambda part: None)
    contenders = speeds.contenders() + many_voices.contenders()
    left_out = []
    for add in NEIGHBOURS:
        try:
            contenders += add()
        except MissingError as missing:
            left_out.append(str(missing))
    rows = speeds.run_in_turn(contenders, rounds, lambda part: report_part(SPEEDS_PART * part))
    ghz = speeds.clock_ghz()
    memory = scaling.memory(longest_s)
    costs = scaling.measure(
        rounds, longest_s, lambda part: report_part(SPEEDS_PART + (1.0 - SPEEDS_PART) * part)
    )
    return Report(rounds, rows, ghz, costs, memory, left_out)


def lines(report: Report) -> list[str]:
    """Write the report as lines of text."""
    found = [*speeds.lines(report), "", f"{'cost':<34}{'of the first':>13}"]
    for cost in report.costs:
        spread = f"({cost.low:.2f} to {cost.high:.2f})"
        entry = f"{cost.series}: {cost.entry}"
        found.append(f"{entry:<34}{cost.ratio:>13.2f}  {spread}{merging(cost)}")
    memory = report.memory
    found += [
        "",
        f"highest memory: {memory.ready_mb:.0f} MB with an engine ready, "
        f"{memory.streamed_mb:.0f} MB after a stream of {memory.seconds:g} s",
    ]
    return found + [f"left out: {reason}" for reason in report.left_out]


def merging(cost: Cost) -> str:
    """Write how many strikes a series' events were merged to, if they were."""
    if cost.series != "events" or int(cost.entry.split()[0]) == cost.strikes:
        return ""
    return f", merged to {cost.strikes} strikes"
