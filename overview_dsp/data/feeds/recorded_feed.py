"""A timeline that is finished, told as a feed: what happened, at its time."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.feeds.feed_lines import HEADER, VERSION, event_object
from overview_dsp.data.timeline.intensity import EXTREMES
from overview_dsp.data.timeline.model import Timeline

CLOCK_EVERY_S = 30.0
"""The clock is told so often, s, well within what counts as silence; but in ..."""

MOST_CLOCKS = 1_000
"""... no more than so many lines, of a timeline of years."""

_SCORE = re.compile(r"(?<=\S )\d+[-–]\d+(?= \S)")


def feed_of(timeline: Timeline) -> Iterator[tuple[float, dict[str, Any]]]:
    """Tell a timeline as a feed.

    The score in the title comes with the end. A curve that was derived from the events isn't told,
    as whoever follows derives it.

    Parameters
    ----------
    timeline
        What is told.

    Yields
    ------
    time_s, line
        When it is told, ascending, and an object of `feed_lines`.
    """
    periods_first = sorted(timeline.events, key=lambda event: event.kind != "period")
    derived, provenance, notes = derive_intensity(periods_first, timeline.duration_s)
    is_derived = derived is not None and derived == timeline.intensity
    words = {"title": timeline.title, "provenance": timeline.provenance}
    words["notes"] = list(timeline.notes)  # type: ignore[assignment]
    if is_derived:
        words["provenance"] = timeline.provenance.removesuffix(provenance).removesuffix("; ")
        words["notes"] = [one for one in timeline.notes if one not in notes]  # type: ignore[assignment]
    header: dict[str, Any] = {HEADER: VERSION, "title": _SCORE.sub("-", timeline.title)}
    clock_every_s = max(CLOCK_EVERY_S, timeline.duration_s / MOST_CLOCKS)
    header["expect_s"] = timeline.duration_s
    header["silence_s"] = 4.0 * clock_every_s
    if timeline.start is not None:
        header["start"] = timeline.start.isoformat()
    curve = None if is_derived else timeline.intensity
    if curve is not None:
        header["unit"] = curve.unit
        if curve.percentiles != EXTREMES:
            header["percentiles"] = list(curve.percentiles)
    yield 0.0, header
    told: list[tuple[float, dict[str, Any]]] = []
    told += [(event.time_s, {"event": event_object(event)}) for event in timeline.events]
    told += [(event.time_s, {"detail": event_object(event)}) for event in timeline.details]
    if curve is not None:
        points = zip(curve.time_s[:].tolist(), curve.value.tolist(), strict=True)
        told += [(time_s, {"sample": [time_s, value]}) for time_s, value in points]
    reasons = timeline.gap_reasons or ("",) * len(timeline.gaps)
    for (start, end), reason in zip(timeline.gaps, reasons, strict=True):
        told.append((end, {"gap": [start, end], **({"reason": reason} if reason else {})}))
    clocks = int(timeline.duration_s // clock_every_s)
    told += [(n * clock_every_s, {"clock": n * clock_every_s}) for n in range(1, clocks + 1)]
    told.sort(key=lambda one: one[0])
    yield from told
    yield timeline.duration_s, {"end": timeline.duration_s, **words}
