"""Reports of the content of a timeline, as text and as data for JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from datetime import timedelta
from typing import Any

import numpy as np

from overview_dsp.data.timeline.model import Event, Timeline
from overview_dsp.units import DAYS_FROM_S, clock_text, span_text

_GAPS_SHOWN = 5


def describe(timeline: Timeline, *, events: bool = False) -> str:
    """Return a report of title, span, start, curve, events, gaps, provenance and notes.

    With `events`, one line per event follows.
    """
    return "\n".join(_lines(timeline, events))


def describe_json(timeline: Timeline, *, events: bool = False) -> dict[str, Any]:
    """Return the report as data for JSON: finite numbers, texts and lists."""
    curve = timeline.intensity
    report: dict[str, Any] = {
        "title": timeline.title,
        "duration_s": timeline.duration_s,
        "start": timeline.start.isoformat() if timeline.start is not None else None,
        "unit": curve.unit if curve is not None else None,
        "points": len(curve.value) if curve is not None else 0,
        "lowest": float(np.min(curve.value)) if curve is not None else None,
        "highest": float(np.max(curve.value)) if curve is not None else None,
        "events": len(timeline.events),
        "kinds": timeline.kinds(),
        "details": _counts(timeline.details),
        "gaps": [list(gap) for gap in timeline.gaps],
        "gap_reasons": list(timeline.gap_reasons),
        "gaps_s": sum(end - start for start, end in timeline.gaps),
        "notes": list(timeline.notes),
        "provenance": timeline.provenance,
    }
    if events:
        report["event_list"] = [asdict(event) for event in timeline.events]
    return report


def _lines(timeline: Timeline, events: bool) -> Iterator[str]:
    yield timeline.title or "(no title)"
    yield f"span     {span_text(timeline.duration_s)} ({timeline.duration_s:.10g} s)"
    if timeline.start is not None:
        end = timeline.start + timedelta(seconds=timeline.duration_s)
        yield f"start    {_moment(timeline, 0.0)}, end {end.isoformat(' ', 'seconds')}"
    curve = timeline.intensity
    if curve is None:
        yield "curve    none"
    else:
        low, high = float(np.min(curve.value)), float(np.max(curve.value))
        unit = curve.unit or "no unit given"
        yield f"curve    {len(curve.value)} points, {low:.6g} to {high:.6g}, {unit}"
    kinds = ", ".join(f"{count} {kind}" for kind, count in timeline.kinds().items())
    yield f"events   {len(timeline.events)}{': ' if kinds else ''}{kinds}"
    if timeline.details:
        counts = ", ".join(f"{n} {kind}" for kind, n in _counts(timeline.details).items())
        yield f"details  {len(timeline.details)}: {counts}; shown in windows"
    yield f"gaps     {_gaps(timeline)}"
    if timeline.provenance:
        yield f"from     {timeline.provenance}"
    for note in timeline.notes:
        yield f"note     {note}"
    if events:
        yield ""
        width = max((len(event.kind) for event in timeline.events), default=0)
        numbers: Counter[str] = Counter()
        for event in timeline.events:
            numbers[event.kind] += 1
            name = f"{event.kind}:{numbers[event.kind]}"
            weight = f"  (weight {event.weight:g})" if event.weight != 1.0 else ""
            at = _moment(timeline, event.time_s)
            yield f"{at:>12}  {name:<{width + 4}}  {event.display_label}{weight}".rstrip()


def _counts(events: tuple[Event, ...]) -> dict[str, int]:
    return dict(Counter(event.kind for event in events))


def _moment(timeline: Timeline, time_s: float) -> str:
    if timeline.start is None:
        return clock_text(time_s)
    moment = timeline.start + timedelta(seconds=time_s)
    whole_days = timeline.duration_s >= 30 * DAYS_FROM_S and moment.time() == timeline.start.time()
    return moment.date().isoformat() if whole_days else moment.isoformat(" ", "seconds")


def _gaps(timeline: Timeline) -> str:
    if not timeline.gaps:
        return "none"
    total = span_text(sum(end - start for start, end in timeline.gaps))
    first = "; ".join(
        f"{_moment(timeline, start)} to {_moment(timeline, end)}{_reason(timeline, i)}"
        for i, (start, end) in enumerate(timeline.gaps[:_GAPS_SHOWN])
    )
    more = "; ..." if len(timeline.gaps) > _GAPS_SHOWN else ""
    return f"{len(timeline.gaps)}, {total} in all: {first}{more}"


def _reason(timeline: Timeline, gap: int) -> str:
    reason = timeline.gap_reasons[gap] if timeline.gap_reasons else ""
    return f" ({reason})" if reason else ""
