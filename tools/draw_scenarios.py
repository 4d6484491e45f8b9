"""Draw the paper's two scenarios (its section 4) into docs/pictures: overview, then detail.

python tools/draw_scenarios.py [FOLDER]

The first is a match in one twist, and then around a goal. The second is a (made-up) share over a
year, and then over its last weeks. The left column is the whole, the right column is the part. The
rows are the data, the surface, and the vibration that a finger feels.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import overview_dsp as ov
from overview_dsp.data.timeline.time_expressions import window_of, zoom_window
from overview_dsp.measure.perceived_level import strokes, window_db
from overview_dsp.offline.plots.style import BLUE, GREY, VERMILION, save_figure
from overview_dsp.offline.plots.timeline import draw_timeline
from overview_dsp.units import FELT_WINDOW_S

FOLDER = Path(__file__).parent.parent / "docs" / "pictures"


@dataclass(frozen=True)
class Look:
    """Visible part of a timeline, and the duration of the sweep over it."""

    title: str
    timeline: ov.Timeline
    seconds: float


def draw(looks: list[Look], preset: ov.Preset) -> Figure:
    figure = Figure(figsize=(6.4 * len(looks), 6.6), layout="constrained")
    grid = figure.subplots(3, len(looks), squeeze=False)
    for row in grid[1:]:  # data have the scale of the part shown
        for axes in row[1:]:
            axes.sharey(row[0])
    for column, look in enumerate(looks):
        data, surface, felt = grid[:, column]
        result = ov.render(look.timeline, preset, ov.sweep(look.seconds))
        (out, *_) = strokes(result.trace.engaged, result.trace.cursor)
        starts, level = window_db(
            result.samples[out.start : out.stop, 1], result.sample_rate, FELT_WINDOW_S / 2.0
        )
        half = FELT_WINDOW_S / 2.0 * result.sample_rate
        middle = np.minimum((starts + half).astype(int) + out.start, out.stop - 1)
        degrees = np.linspace(0.0, 180.0, len(result.engine.surface.friction))
        draw_timeline(data, look.timeline, result.engine.surface.angle_map)
        data.set_title(look.title, loc="left", fontsize=10)
        surface.plot(degrees, result.engine.surface.friction * 1e3, color=VERMILION, linewidth=0.7)
        surface.set_yscale("log")
        surface.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        felt.plot(result.trace.cursor[middle] * 180.0, level, color=BLUE, linewidth=0.8)
        felt.set_ylim(-60.0, 0.0)
        felt.set_xlabel(f"turn of the hand, degrees, in {look.seconds:g} s")
        for axes in (surface, felt):
            axes.set_xlim(0.0, 180.0)
            axes.set_xticks(range(0, 181, 30))
            axes.spines[["top", "right"]].set_visible(False)
            axes.grid(color="#dddddd", linewidth=0.6)
        if column == 0:
            surface.set_ylabel("friction B, mN·m·s/rad")
            felt.set_ylabel("vibration, dB of full scale")
    handles: dict[str, object] = {}
    for axes in grid[0]:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label.rpartition(" (")[0], handle)
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=9, frameon=False,
        fontsize=8, labelcolor=GREY,
    )  # fmt: skip
    figure.suptitle(looks[0].timeline.title, x=0.01, ha="left", fontsize=11)
    return figure


def main(folder: Path) -> None:
    match = ov.load_timeline("world-cup-final-2018")
    goal = match.window(*zoom_window(match, "goal:2"))
    before = match.window(*window_of(match, "goal:2-45", "goal:2+5"))
    share = ov.load_timeline("made-up-share")
    weeks = share.window(*window_of(share, "end-6w", "end"))
    football, series = ov.load_preset("football"), ov.load_preset("series")
    glance = [
        Look("a twist: the whole match", match, 2.0),
        Look("--zoom-to goal:2", goal, 8.0),
        Look("--window goal:2-45 goal:2+5", before, 8.0),
    ]
    year = [Look("a twist: the year", share, 2.0), Look("--window end-6w end", weeks, 4.0)]
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in (
        ("match-zoom", draw(glance, football)),
        ("share-zoom", draw(year, series)),
    ):
        for path in save_figure(figure, folder / name):
            if path.suffix != ".png":
                path.unlink()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
