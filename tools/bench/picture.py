"""Picture of a report's rows: the speed of each contender, on a logarithmic scale."""

from __future__ import annotations

import os

from overview_dsp.offline.plots.style import save_picture
from tools.bench.many_voices import BARE_CORES, CORES
from tools.bench.report import Report

OURS, THEIRS = "#0072B2", "#999999"


def draw(report: Report, path: str | os.PathLike[str]) -> None:
    """Write the picture; the suffix selects the format (PNG, SVG, PDF)."""
    from matplotlib.figure import Figure

    # only the work of one core; the work of all cores is another measure
    rows = [row for row in report.rows if row.group not in (CORES, BARE_CORES)]
    groups = [*dict.fromkeys(row.group for row in rows)]
    heights = [sum(row.group == group for row in rows) for group in groups]
    figure = Figure(figsize=(10.0, 1.5 + 0.32 * sum(heights)), layout="constrained")
    axes = figure.subplots(len(groups), 1, squeeze=False, height_ratios=heights)[:, 0]
    for axis, group in zip(axes, groups, strict=True):
        shown = [row for row in rows if row.group == group][::-1]
        for height, row in enumerate(shown):
            colour = OURS if row.name.startswith("overView") else THEIRS
            axis.barh(height, row.speed, color=colour)
            axis.plot([row.low, row.high], [height, height], color="#000000", linewidth=1.5)
        axis.set_yticks(range(len(shown)), [row.name for row in shown], fontsize=8)
        axis.set_xscale("log")
        axis.set_title(group, loc="left", fontsize=10)
    axes[-1].set_xlabel("seconds of sound in a second of CPU time; line: lowest to highest")
    save_picture(figure, path)
