"""Figures 4, 5 and 6 of the paper."""

from __future__ import annotations

from pathlib import Path

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import sweep, tap
from overview_dsp.design.presets.model import Preset
from overview_dsp.files.atomic import make_folder
from overview_dsp.offline.plots.saving import save_figure
from overview_dsp.offline.plots.strokes import plot_strokes
from overview_dsp.offline.plots.timeline import plot_timeline
from overview_dsp.offline.rendering.offline import RenderResult, render

FAST_S, SLOW_S = 1.0, 4.0
TAP_AT, HOLD_S = 1.0, 3.0
GESTURES = {"fast sweep": sweep(FAST_S), "slow sweep": sweep(SLOW_S), "tap": tap(TAP_AT, HOLD_S)}


def renders(timeline: Timeline, preset: Preset) -> dict[str, RenderResult]:
    """Render the three gestures of the paper: a fast sweep, a slow sweep and a tap."""
    return {name: render(timeline, preset, gesture) for name, gesture in GESTURES.items()}


def draw(timeline: Timeline, results: dict[str, RenderResult], folder: str | Path) -> list[Path]:
    """Write figures 4, 5 and 6 to a folder as PNG and SVG; return the files."""
    out = make_folder(folder)
    fast, slow = results["fast sweep"], results["slow sweep"]
    sweeps = plot_strokes(
        [(f"fast sweep, {FAST_S:g} s", fast), (f"slow sweep, {SLOW_S:g} s", slow)],
        timeline,
        f"{timeline.title}: sweeps and recoil",
        [GESTURES["fast sweep"], GESTURES["slow sweep"]],
    )
    taps = plot_strokes(
        [(f"tap at {TAP_AT:g}, held {HOLD_S:g} s", results["tap"])],
        timeline,
        f"{timeline.title}: a tap",
        [GESTURES["tap"]],
    )
    return [
        *save_figure(plot_timeline(timeline, fast.engine.surface.angle_map), out / "figure-4"),
        *save_figure(sweeps, out / "figure-5"),
        *save_figure(taps, out / "figure-6"),
    ]
