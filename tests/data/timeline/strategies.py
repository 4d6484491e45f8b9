"""Hypothesis strategies for timelines."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
from hypothesis import strategies as st

from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS

TEXT = st.text(st.characters(exclude_categories=("Cs",)), max_size=12)


def without_ticks(part: Timeline) -> list[Event]:
    """The events of a window that don't just say where one is."""
    return [event for event in part.events if event.kind not in TICKS]


NAMES = TEXT.filter(bool)
KINDS = st.from_regex(r"[a-z0-9_]{1,12}", fullmatch=True)


@st.composite
def timelines(draw: st.DrawFn) -> Timeline:
    """Any valid timeline, of up to a dozen events, points and gaps."""
    duration_s = draw(st.floats(1e-3, 1e6))
    times = st.floats(0.0, duration_s)
    events = draw(
        st.lists(
            st.builds(Event, times, KINDS, TEXT, st.floats(1e-6, 1e6), st.integers(0, 2)),
            max_size=12,
            unique_by=lambda event: (event.time_s, event.kind, event.label),
        )
    )
    details = draw(
        st.lists(
            st.builds(Event, times, KINDS, TEXT),
            max_size=6,
            unique_by=lambda event: (event.time_s, event.kind, event.label),
        )
    )
    points = draw(st.lists(times, min_size=0 if events else 1, max_size=12, unique=True))
    intensity = None
    if points:
        value = st.floats(-1e6, 1e6) if draw(st.booleans()) else st.floats(0.0, 1.0)
        intensity = Intensity(
            np.array(sorted(points)),
            np.array([draw(value) for _ in points]),
            draw(TEXT),
            draw(st.sampled_from([(0.0, 100.0), (1.0, 99.0), (12.5, 50.0)])),
        )
    edges = sorted(draw(st.lists(times, max_size=8, unique=True)))
    return Timeline(
        title=draw(TEXT),
        sides=draw(st.just(()) | st.tuples(NAMES, NAMES)),
        duration_s=duration_s,
        events=tuple(events),
        intensity=intensity,
        gaps=tuple(zip(edges[::2], edges[1::2], strict=False)),
        gap_reasons=draw(st.just(()) | st.tuples(*[TEXT] * (len(edges) // 2))),
        known_until_s=draw(st.none() | times),
        provenance=draw(TEXT),
        notes=tuple(draw(st.lists(TEXT, max_size=3))),
        details=tuple(details),
        start=draw(
            st.none()
            | st.datetimes(
                datetime(1, 1, 2), datetime(9900, 1, 1), timezones=st.sampled_from([None, UTC])
            )
        ),
    )
