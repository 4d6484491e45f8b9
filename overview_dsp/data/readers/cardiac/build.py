"""The Timeline of a heart recording, from its beats and the stretches without any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from overview_dsp.data.analysis import rhythm
from overview_dsp.data.analysis.heart_signal import Signal, Spans, recorded
from overview_dsp.data.analysis.heartbeats import Detection
from overview_dsp.data.analysis.rhythm import NORMAL, Beats
from overview_dsp.data.analysis.series_events import rules_of
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

MAPS = ("rate", "variability")
"""What the option `map` may be: the heart rate, or how much it varies from beat to beat (RMSSD)."""


NO_SIGNAL = "no signal"
TOO_NOISY = "too noisy to find beats"
"""Why a stretch is a gap."""


@dataclass(frozen=True)
class About:
    """What a recording's timeline says of itself."""

    title: str
    duration_s: float
    provenance: str
    notes: tuple[str, ...]
    start: datetime | None = None


def check_map(options: LoadOptions) -> None:
    """Refuse an unknown `map`."""
    if options.map is not None and options.map not in MAPS:
        raise InputError(f"map is {shown(options.map)}; for a heart it is one of {', '.join(MAPS)}")


def detected(detection: Detection, rate: float) -> Beats:
    """Return the beats a search found."""
    count = len(detection.beats)
    return Beats(detection.beats / rate, (NORMAL,) * count, ("",) * count, annotated=False)


def find_gaps(
    silent: Spans, noisy: Spans, rate: float, duration_s: float
) -> tuple[Gaps, tuple[str, ...]]:
    """Return stretches of samples as gaps, in order, and why each is one."""
    known = sorted(
        (first / rate, min(end / rate, duration_s), why)
        for spans, why in ((silent, NO_SIGNAL), (_outside(noisy, silent), TOO_NOISY))
        for first, end in spans
    )
    return tuple((start, end) for start, end, _ in known), tuple(why for *_, why in known)


def _outside(spans: Spans, others: Spans) -> Spans:
    """Return what of some stretches lies in none of the others."""
    left: Spans = []
    for first, end in spans:
        at = first
        for low, high in others:
            if low < end and high > at:
                if low > at:
                    left.append((at, low))
                at = max(at, high)
        if at < end:
            left.append((at, end))
    return left


def heart_timeline(
    about: About,
    beats: Beats,
    gaps: tuple[Gaps, tuple[str, ...]],
    others: Sequence[Event],
    options: LoadOptions,
    signal: Signal | None = None,
) -> Timeline:
    """Make the Timeline; `gaps` as `find_gaps` gives them, `signal` where there is one.

    Raises
    ------
    InputError
        No beat at all.
    """
    count = len(beats.time_s)
    spans, reasons = gaps
    noisy_s = sum(
        end - start for (start, end), why in zip(spans, reasons, strict=True) if why == TOO_NOISY
    )
    if count == 0:
        noise = f" ({noisy_s:.0f} s of it are {TOO_NOISY})" if noisy_s else ""
        raise InputError(
            f"no heartbeat was found{noise}; is it an ECG or a pulse wave, and is the rate right? "
            "choose another signal with value"
        )
    curve = rhythm.variability if options.map == "variability" else rhythm.heart_rate
    events, left_out = rhythm.beat_events(beats, spans)
    mean = rhythm.mean_rate(beats.time_s, spans)
    left_out += (f"{noisy_s:.0f} s are {TOO_NOISY}: gaps",) if noisy_s else ()
    rate = f", mean heart rate {mean:.2f} bpm" if mean is not None else ""
    timeline = Timeline(
        title=about.title,
        duration_s=about.duration_s,
        events=(*events, *others),
        intensity=curve(beats.time_s, spans),
        gaps=spans,
        gap_reasons=reasons,
        provenance=about.provenance,
        notes=(f"{count} beats{rate}", *left_out, *about.notes),
        start=about.start,
    )
    if timeline.intensity is not None:
        timeline = replace(timeline, rules=rules_of(timeline.intensity, False, timeline))
    return timeline if signal is None else replace(timeline, signal=recorded(signal))
