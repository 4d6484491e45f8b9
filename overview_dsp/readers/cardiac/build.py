"""The Timeline of a heart recording, from its beats and its silent stretches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from overview_dsp.errors import InputError
from overview_dsp.readers.cardiac import rhythm
from overview_dsp.readers.cardiac.beat_kinds import NORMAL
from overview_dsp.readers.cardiac.detection import Detection
from overview_dsp.readers.cardiac.rhythm import Beats
from overview_dsp.readers.cardiac.signal import Spans
from overview_dsp.readers.source import LoadOptions
from overview_dsp.timeline import checks
from overview_dsp.timeline.event import Event
from overview_dsp.timeline.gaps import Gaps
from overview_dsp.timeline.model import Timeline

MAPS = ("rate", "variability")
"""What the option `map` may be: the heart rate, or how much it varies from beat to beat (RMSSD)."""


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
        raise InputError(
            f"map is {checks.shown(options.map)}; for a heart it is one of {', '.join(MAPS)}"
        )


def detected(detection: Detection, rate: float) -> Beats:
    """Return the beats a search found."""
    count = len(detection.beats)
    return Beats(detection.beats / rate, (NORMAL,) * count, ("",) * count, annotated=False)


def in_seconds(silent: Spans, rate: float, duration_s: float) -> Gaps:
    """Return stretches of samples as gaps."""
    return tuple((first / rate, min(end / rate, duration_s)) for first, end in silent)


def heart_timeline(
    about: About,
    beats: Beats,
    gaps: Gaps,
    others: Sequence[Event],
    options: LoadOptions,
) -> Timeline:
    """Make the Timeline.

    Raises
    ------
    InputError
        No beat at all.
    """
    count = len(beats.time_s)
    if count == 0:
        raise InputError(
            "no heartbeat was found; is it an ECG or a pulse wave, and is the rate right? choose "
            "another signal with value"
        )
    curve = rhythm.variability if options.map == "variability" else rhythm.heart_rate
    events, left_out = rhythm.beat_events(beats, gaps)
    mean = rhythm.mean_rate(beats.time_s, gaps)
    rate = f", mean heart rate {mean:.2f} bpm" if mean is not None else ""
    return Timeline(
        title=about.title,
        duration_s=about.duration_s,
        events=(*events, *others),
        intensity=curve(beats.time_s, gaps),
        gaps=gaps,
        provenance=about.provenance,
        notes=(f"{count} beats{rate}", *left_out, *about.notes),
        start=about.start,
    )
