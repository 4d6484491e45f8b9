"""Display of a timeline in a notebook: summary and curve with events and gaps, as HTML."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.public import counted
from overview_dsp.units import span_text

if TYPE_CHECKING:
    from overview_dsp.data.timeline.model import Timeline

WIDTH, HEIGHT = 480, 84
_KINDS = 8


def timeline_page(timeline: Timeline, begin: str) -> str:
    """Return title, summary and curve as HTML, with all texts escaped.

    `begin` is the date and time of the start, "" without a calendar.
    """
    title = html.escape(timeline.title or "Timeline", quote=True)
    kinds = [f"{html.escape(kind)} {count}" for kind, count in timeline.kinds().items()]
    more = [f"{len(kinds) - _KINDS} more kinds"] if len(kinds) > _KINDS else []
    parts = [f"{span_text(timeline.duration_s)}{f' from {begin}' if begin else ''}"]
    if timeline.gaps:
        parts.append(counted(len(timeline.gaps), "gap"))
    words = "; ".join([*parts, ", ".join([*kinds[:_KINDS], *more]) or "no events"])
    return (
        f"<div><b>{title}</b><br/>{words}<br/>"
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
        f'font-family="sans-serif" font-size="10" role="img" aria-label="Curve of {title}">'
        f"{_gaps(timeline)}{_events(timeline)}{_curve(timeline)}</svg></div>"
    )


def _x(timeline: Timeline, time_s: float) -> float:
    return time_s / timeline.duration_s * WIDTH


def _gaps(timeline: Timeline) -> str:
    """Return gaps as grey areas, at most one per pixel."""
    spans = {
        (round(_x(timeline, start)), round(_x(timeline, end)) or 1) for start, end in timeline.gaps
    }
    return "".join(
        f'<rect x="{begin}" y="0" width="{max(1, end - begin)}" height="{HEIGHT - 12}" '
        'fill="#e2e2e2"/>'
        for begin, end in sorted(spans)
    )


def _events(timeline: Timeline) -> str:
    """Return events as ticks along the bottom, at most one per pixel."""
    at = sorted({round(_x(timeline, event.time_s)) for event in timeline.events})
    marks = "".join(f"M{x},{HEIGHT - 12}v8" for x in at)
    return f'<path d="{marks}" stroke="#0072B2"/>' if marks else ""


def _curve(timeline: Timeline) -> str:
    """Return the curve, interrupted at gaps, with its minimum and maximum."""
    curve = timeline.intensity
    if curve is None:
        return ""
    times = np.arange(WIDTH + 1, dtype=np.float64) * (timeline.duration_s / WIDTH)
    level = timeline.normalised_levels(WIDTH)
    there = ~in_gap(timeline.gaps, times)
    path, down = [], False
    for x, (value, known) in enumerate(zip(level.tolist(), there.tolist(), strict=True)):
        if known:
            path.append(f"{'L' if down else 'M'}{x},{(1.0 - value) * (HEIGHT - 18) + 3:.1f}")
        down = known
    unit = html.escape(curve.unit)
    low, high = (f"{v:.4g} {unit}".strip() for v in curve.extremes_outside(timeline.gaps))
    return (
        f'<path d="{"".join(path)}" fill="none" stroke="#333333"/>'
        f'<text x="2" y="10" fill="#555555">{low} to {high}</text>'
    )
