"""The pictures: the timeline (the paper's figure 4), sweeps (figure 5) and a tap (figure 6).

Colours are Okabe and Ito's, which colour-blind eyes tell apart; event kinds differ in shape too.
"""

from __future__ import annotations

import os
from datetime import timedelta
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.files import require_writable, whole_file
from overview_dsp.presets.model import Preset
from overview_dsp.rendering.offline import Result
from overview_dsp.timeline import FOOTBALL_KINDS, Timeline
from overview_dsp.timeline.gaps import in_gap
from overview_dsp.units import HALF_TURN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from overview_dsp.measure.feel_report import FeelReport

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#767676"

# kind: (marker, face colour, words); the paper's goals are blue, its cards yellow and red
KIND_STYLE: dict[str, tuple[str, str, str]] = {
    "goal": ("o", BLUE, "goal"),
    "own_goal": ("h", SKY, "own goal"),
    "near_miss": ("^", GREEN, "near miss"),
    "yellow_card": ("s", YELLOW, "yellow card"),
    "red_card": ("D", VERMILION, "red card"),
    "foul": ("x", GREY, "foul"),
    "period": ("|", BLACK, "start or end of a half"),
    "shot": ("<", GREEN, "shot"),
    "touch": ("+", GREY, "touch"),
}
# of kinds that have no style of their own, one after the other
_OTHER_MARKERS = "Pv*X>pd8"
_OTHER_COLOURS = (VERMILION, BLUE, YELLOW, SKY, GREEN, ORANGE, PURPLE)
_LINES = "x|+"  # markers without a face
GAP_HATCH = "////"
_POINTS = 1500  # a curve keeps its extremes in this many steps, so that an SVG stays small


def styles_of(timeline: Timeline) -> dict[str, tuple[str, str, str]]:
    """The style of each kind of a timeline: the known ones first, the others by name."""
    kinds = timeline.kinds()
    known = {kind: style for kind, style in KIND_STYLE.items() if kind in kinds}
    others = sorted(set(kinds) - set(known))
    return known | {
        kind: (
            _OTHER_MARKERS[index % len(_OTHER_MARKERS)],
            _OTHER_COLOURS[index % len(_OTHER_COLOURS)],
            kind.replace("_", " "),
        )
        for index, kind in enumerate(others)
    }


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def _tidy(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def extremes(
    x: NDArray[np.float64], y: NDArray[np.float64], points: int = _POINTS
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A curve with fewer points and the same extremes: the lowest and highest of each step."""
    if len(x) <= 2 * points:
        return x, y
    edges = np.linspace(0, len(x), points + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)
    return np.repeat(x[edges], 2), np.column_stack([low, high]).ravel()


def plot_timeline(timeline: Timeline) -> Figure:
    """The intensity curve with its events, as in the paper's figure 4; gaps are hatched."""
    figure = _figure(9.0, 3.6)
    axes = figure.subplots()
    draw_timeline(axes, timeline)
    figure.subplots_adjust(left=0.07, right=0.785, top=0.92, bottom=0.14)
    axes.set_title(timeline.title, loc="left", fontsize=10)
    if timeline.events or timeline.gaps:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=8)
    return figure


def draw_timeline(axes: Axes, timeline: Timeline, like: Timeline | None = None) -> None:
    """The intensity curve with its events and gaps into axes of any figure.

    Kinds have the markers they have in a picture of `like`, which must have them all.
    """
    scale, unit = _time_unit(timeline.duration_s)
    times = np.linspace(0.0, timeline.duration_s, 4001)
    curve = timeline.normalised_levels(4000)
    curve[in_gap(timeline.gaps, times)] = np.nan  # no line over a gap
    for i, (start, end) in enumerate(timeline.gaps):
        axes.axvspan(
            start / scale,
            end / scale,
            facecolor="none",
            edgecolor="#b0b0b0",
            hatch=GAP_HATCH,
            linewidth=0.0,
            label=f"no data ({len(timeline.gaps)})" if i == 0 else None,
            zorder=1,
        )
    axes.fill_between(times / scale, curve, color="#e8eef4", zorder=1)
    axes.plot(times / scale, curve, color=GREY, linewidth=1.2, zorder=2)
    for kind, (marker, colour, words) in styles_of(like or timeline).items():
        at = np.array([event.time_s for event in timeline.events if event.kind == kind])
        if not len(at):
            continue
        height = timeline.normalised_intensity_at(at)
        goal = kind in ("goal", "own_goal")
        axes.scatter(
            at / scale,
            height,
            s=90 if goal else 46,
            marker=marker,
            color=colour,
            edgecolors=None if marker in _LINES else BLACK,
            linewidths=1.6 if marker in _LINES else 0.7,
            label=f"{words} ({len(at)})",
            zorder=4 if goal else 3,
        )
    for event in timeline.events:
        if event.kind in ("goal", "own_goal") and event.label:
            axes.annotate(
                event.label.split(" ")[0],
                (
                    event.time_s / scale,
                    float(timeline.normalised_intensity_at(np.array([event.time_s]))[0]),
                ),
                xytext=(0, 8),
                textcoords="offset points",
                ha="center",
                fontsize=8,
            )
    axes.set_xlim(0.0, timeline.duration_s / scale)
    axes.set_ylim(0.0, 1.18)
    _label_time(axes, timeline, scale, unit)
    axes.set_ylabel("intensity")
    _tidy(axes)


def _time_unit(duration_s: float) -> tuple[float, str]:
    """The seconds and the name of the unit that suits a duration."""
    for longest_s, scale, name in ((600.0, 1.0, "s"), (18_000.0, 60.0, "min"), (3e5, 3600.0, "h")):
        if duration_s <= longest_s:
            return scale, name
    return 86_400.0, "days"


def _label_time(axes: Axes, timeline: Timeline, scale: float, unit: str) -> None:
    """Label the time axis: dates where the timeline has a calendar, else its unit."""
    start = timeline.start
    if start is None:
        football = not FOOTBALL_KINDS.isdisjoint(timeline.kinds())
        axes.set_xlabel(f"time of play, {unit}" if football else f"time, {unit}")
        return
    dates: Any = import_module("matplotlib.dates")  # it has no types
    # the clock on the wall: a zone would be turned into UTC
    first = start.replace(tzinfo=None)
    locator = dates.AutoDateLocator(minticks=4, maxticks=9)
    days = np.asarray(locator.tick_values(first, first + timedelta(seconds=timeline.duration_s)))
    at_s = (days - dates.date2num(first)) * 86_400.0
    shown = (at_s >= 0.0) & (at_s <= timeline.duration_s)
    words = dates.ConciseDateFormatter(locator).format_ticks(days[shown])
    axes.set_xticks(at_s[shown] / scale, words)
    axes.set_xlabel(f"from {start.isoformat(' ', 'seconds')}")


def plot_strokes(results: list[tuple[str, Result]], timeline: Timeline, title: str) -> Figure:
    """Torque, friction, disk 1 and disk 2 over time, a column a gesture (figures 5 and 6).

    Where data is missing, the surface under disk 1 is hatched.
    """
    figure = _figure(5.2 * len(results) + 0.6, 7.6)
    grid: Any = figure.subplots(4, len(results), sharex="col", sharey="row", squeeze=False)
    for column, (name, result) in enumerate(results):
        trace = result.trace
        assert trace is not None
        # the last part of the recoil is all alike
        shown = trace.time <= _end_of_interest(trace.time, trace.cursor)
        time, held = trace.time[shown], trace.touching[shown] > 0.5
        axes: list[Axes] = list(grid[:, column])
        rows = (
            (trace.torque[shown] * 1e3, "(a) torque\nmN·m", BLUE),
            (trace.friction[shown] * 1e3, "(b) friction B\nmN·m·s/rad", VERMILION),
            (trace.cursor[shown] * HALF_TURN, "(c) disk 1\nrad on the surface", BLACK),
            (np.where(held, trace.theta2[shown], 0.0), "(d) disk 2, the hand\nrad", GREEN),
        )
        for ax, (values, label, colour) in zip(axes, rows, strict=True):
            ax.plot(*extremes(time, values), color=colour, linewidth=1.0)
            if column == 0:
                ax.set_ylabel(label)
            _tidy(ax)
            if held.any() and not held.all():
                release = float(time[np.flatnonzero(held)[-1]])
                ax.axvline(release, color=GREY, linestyle="--", linewidth=0.9)
        _mark_strikes(axes[0], result, timeline, float(time[-1]))
        for start, end in timeline.gaps:
            axes[2].axhspan(
                start / timeline.duration_s * HALF_TURN,
                end / timeline.duration_s * HALF_TURN,
                facecolor="none",
                edgecolor="#b0b0b0",
                hatch=GAP_HATCH,
                linewidth=0.0,
            )
        axes[0].set_title(name, fontsize=10, pad=14)
        # linear within 1 mN·m, logarithmic beyond: the surface and its goals in one view
        axes[0].set_yscale("symlog", linthresh=1.0)
        # plain numbers: powers of ten would go through the slow setting of formulas
        axes[0].yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes[-1].set_xlabel("time, s (dashed: the finger lets go)")
    # margins by hand: finding them takes longer than drawing
    inch = 1.0 / (5.2 * len(results) + 0.6)
    figure.subplots_adjust(
        left=0.95 * inch, right=1.0 - 0.15 * inch, top=0.89, bottom=0.1, wspace=0.06, hspace=0.12
    )
    figure.align_ylabels(grid[:, 0])
    figure.suptitle(title, x=0.1 * inch, ha="left", fontsize=11)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="lower center", ncols=6, frameon=False, fontsize=8)
    return figure


def _end_of_interest(time: NDArray[np.float64], cursor: NDArray[np.float64]) -> float:
    away = np.flatnonzero(cursor > 0.01)
    return float(time[away[-1]]) + 0.3 if len(away) else float(time[-1])


def _mark_strikes(axes: Axes, result: Result, timeline: Timeline, end: float) -> None:
    # a row of marks just above the axes
    above = axes.get_xaxis_transform()
    strikes = result.strikes.of_events()
    for kind, (marker, colour, words) in styles_of(timeline).items():
        at = [
            time
            for time, event in zip(strikes.time_s, strikes.event, strict=True)
            if timeline.events[event].kind == kind and time <= end
        ]
        if not at or kind in ("foul", "period", "touch", "shot"):
            continue
        axes.scatter(
            at,
            np.full(len(at), 1.03),
            transform=above,
            s=26,
            marker=marker,
            color=colour,
            edgecolors=BLACK,
            linewidths=0.5,
            label=words,
            clip_on=False,
            zorder=4,
        )


def plot_gallery(result: Result, preset: Preset) -> Figure:
    """What is heard and felt of each kind of event, in the order it is passed."""
    figure = _figure(11.0, 4.6)
    heard, felt = figure.subplots(2, 1, sharex=True)
    rate = result.sample_rate
    trace = result.trace
    assert trace is not None
    # out only: the recoil is the same backwards, and slower
    count = int(np.argmax(trace.touching < 0.5)) or len(trace.time)
    time = trace.time[:count]
    heard.plot(*extremes(time, result.samples[:count, 0].astype(float)), color=BLUE, linewidth=0.7)
    heard.set_ylabel("click")
    level = 20.0 * np.log10(np.maximum(trace.envelope[:count], 1e-4))
    felt.plot(*extremes(time, level), color=VERMILION, linewidth=1.0)
    felt.set_ylabel("vibration, dB")
    felt.set_ylim(-60.0, 3.0)
    felt.set_xlabel("time, s")
    seen: set[str] = set()
    strikes = result.strikes.of_events()
    for at, event in zip(strikes.time_s, strikes.event, strict=True):
        if at * rate >= count:
            continue
        for axes in (heard, felt):
            axes.axvline(at, color=GREY, linewidth=0.5, zorder=0)
        kind = result.engine.timeline.events[event].kind
        if kind not in seen:
            seen.add(kind)
            heard.annotate(
                kind,
                (at, 1.0),
                xycoords=heard.get_xaxis_transform(),
                xytext=(0, 3),
                textcoords="offset points",
                rotation=35.0,
                fontsize=7,
                va="bottom",
            )
    for axes in (heard, felt):
        _tidy(axes)
    figure.suptitle(f"{preset.title}: {preset.description}", x=0.01, ha="left", fontsize=10)
    figure.subplots_adjust(left=0.065, right=0.985, top=0.74, bottom=0.11, hspace=0.1)
    return figure


def plot_feel(report: FeelReport) -> Figure:
    """How far each kind stands out of the rest, stroke by stroke, with the steps of touch."""
    kinds = list(dict.fromkeys(kind.kind for stroke in report.strokes for kind in stroke.kinds))
    figure = _figure(9.0, 1.4 + 0.36 * len(kinds))
    axes = figure.subplots()
    table = np.full((len(kinds), len(report.strokes)), np.nan)
    for column, stroke in enumerate(report.strokes):
        for kind in stroke.kinds:
            table[kinds.index(kind.kind), column] = kind.contrast_db
    shown = axes.imshow(table, aspect="auto", cmap="cividis", vmin=0.0, vmax=30.0)
    for (row, column), value in np.ndenumerate(table):
        if np.isfinite(value):
            axes.text(
                column,
                row,
                f"{value:.0f}",
                ha="center",
                va="center",
                fontsize=8,
                # a step of 2.3 dB is the least that is felt
                color=VERMILION if value < 2.3 else "white" if value < 18.0 else "black",
                fontweight="bold" if value < 2.3 else "normal",
            )
    axes.set_xticks(range(len(report.strokes)), [stroke.name for stroke in report.strokes])
    axes.tick_params(axis="x", rotation=25, labelsize=8)
    axes.set_yticks(range(len(kinds)), kinds)
    axes.grid(visible=False)
    figure.colorbar(shown, ax=axes, label="dB above the rest (red: masked)", pad=0.02)
    axes.set_title(f"{report.preset} on {report.timeline or 'a timeline'}", loc="left", fontsize=10)
    figure.tight_layout()
    return figure


PICTURES = (".png", ".svg", ".pdf")
"""How a picture may be written, by the suffix of its file."""


def require_picture(path: str | os.PathLike[str]) -> None:
    """Refuse early, with InputError, a picture that could not be written at the end."""
    _picture_suffix(path)
    require_writable(path)


def _picture_suffix(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in PICTURES:
        raise InputError(f"{path}: a picture is {', '.join(PICTURES)}; choose one of them")
    return suffix


def save_picture(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure as one file (`PICTURES`), whole or not at all; errors as `whole_file`."""
    import matplotlib

    # no date and fixed ids: the same figure gives the same bytes
    metadata = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    suffix = _picture_suffix(path)
    with (
        matplotlib.rc_context({"svg.hashsalt": "overview", "svg.fonttype": "none"}),
        whole_file(path) as temporary,
    ):
        figure.savefig(temporary, dpi=150, metadata=metadata[suffix])


def save_figure(figure: Figure, stem: str | os.PathLike[str]) -> list[Path]:
    """Write a figure as PNG and as SVG; the files, whole or absent."""
    written = []
    for suffix in (".png", ".svg"):
        path = Path(f"{os.fspath(stem)}{suffix}")
        save_picture(figure, path)
        written.append(path)
    return written
