"""Timeline of a heart recording, from its beats and its gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from overview_dsp.data.analysis import rhythm
from overview_dsp.data.analysis.heart_signal import Signal, recorded
from overview_dsp.data.analysis.heartbeats import Detection
from overview_dsp.data.analysis.rhythm import NORMAL, OTHER_SHAPE, Beats
from overview_dsp.data.analysis.runs import Spans
from overview_dsp.data.analysis.series_events import rules_of
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted

MAPS = ("rate", "variability")
"""Values of the option `map`: heart rate, or its variability from beat to beat (RMSSD)."""

NO_SIGNAL = "no signal"
TOO_NOISY = "too noisy to find beats"
"""Reasons for a gap."""


@dataclass(frozen=True)
class Description:
    """Title, duration, origin and notes of a recording."""

    title: str
    duration_s: float
    provenance: str
    notes: tuple[str, ...]
    start: datetime | None = None


def check_map(options: LoadOptions) -> None:
    """Raise InputError for an unknown `map`."""
    if options.map is not None and options.map not in MAPS:
        raise InputError(
            f"map is {quoted(options.map)}; must be one of {', '.join(MAPS)} for a heart recording"
        )


def beats_of(detection: Detection, rate: float) -> Beats:
    """Return the detected beats, with times in s."""
    kinds, labels = (
        tuple(name if other else usual for other in detection.other.tolist())
        for usual, name in ((NORMAL, OTHER_SHAPE), ("", "another shape"))
    )
    return Beats(detection.beats / rate, kinds, labels, False, detection.hidden)


def find_gaps(
    silent: Spans, noisy: Spans, rate: float, duration_s: float
) -> tuple[Gaps, tuple[str, ...]]:
    """Return ranges of samples as gaps in order, and the reason for each."""
    gaps = sorted(
        (first / rate, min(end / rate, duration_s), reason)
        for spans, reason in ((silent, NO_SIGNAL), (_subtract(noisy, silent), TOO_NOISY))
        for first, end in spans
    )
    return tuple((start, end) for start, end, _ in gaps), tuple(reason for *_, reason in gaps)


def _subtract(spans: Spans, others: Spans) -> Spans:
    """Return the parts of `spans` that are outside `others`."""
    result: Spans = []
    for start, end in spans:
        for low, high in others:
            if low < end and high > start:
                if low > start:
                    result.append((start, low))
                start = max(start, high)
        if start < end:
            result.append((start, end))
    return result


def heart_timeline(
    description: Description,
    beats: Beats,
    gaps: tuple[Gaps, tuple[str, ...]],
    others: Sequence[Event],
    options: LoadOptions,
    signal: Signal | None = None,
) -> Timeline:
    """Return the Timeline; `gaps` is the result of `find_gaps`, `signal` may be None.

    InputError: there are no beats.
    """
    count = len(beats.time_s)
    spans, reasons = gaps
    noisy_s = sum(
        end - start
        for (start, end), reason in zip(spans, reasons, strict=True)
        if reason == TOO_NOISY
    )
    if count == 0:
        noise = f" ({noisy_s:.0f} s of it are {TOO_NOISY})" if noisy_s else ""
        raise InputError(
            f"no heartbeat was found{noise}; the signal must be an ECG or a pulse wave with the "
            "correct rate: choose another signal with value"
        )
    curve = rhythm.variability if options.map == "variability" else rhythm.heart_rate
    events, omitted = rhythm.beat_events(beats, spans)
    mean = rhythm.mean_rate(beats.time_s, spans)
    omitted += (f"{noisy_s:.0f} s are {TOO_NOISY}, which makes gaps",) if noisy_s else ()
    rate = f", mean heart rate {mean:.2f} bpm" if mean is not None else ""
    timeline = Timeline(
        title=description.title,
        duration_s=description.duration_s,
        events=(*events, *others),
        intensity=curve(beats.time_s, spans),
        gaps=spans,
        gap_reasons=reasons,
        provenance=description.provenance,
        notes=(f"{count} beats{rate}", *omitted, *description.notes),
        start=description.start,
    )
    if timeline.intensity is not None:
        timeline = replace(timeline, rules=rules_of(timeline.intensity, False, timeline))
    return timeline if signal is None else replace(timeline, signal=recorded(signal))


def detected_timeline(
    description: Description,
    detection: Detection,
    signal: Signal,
    others: Sequence[Event],
    options: LoadOptions,
) -> Timeline:
    """Return the Timeline of the beats that were found in a signal; errors as `heart_timeline`."""
    beats, rate = beats_of(detection, signal.rate), signal.rate
    gaps = find_gaps(detection.silent, detection.noisy, rate, description.duration_s)
    return heart_timeline(description, beats, gaps, others, options, signal)
