"""Meta's `.haptic` 1.0: JSON with an amplitude and a frequency envelope and emphasis points.

Amplitude is that of the signal, and frequency 0..1 is 65..300 Hz, as in AHAP. Both envelopes
start at 0 (otherwise Meta's renderer rejects a clip). The amplitude envelope is silent while
Meta's renderer plays an emphasis. An emphasis is at least as strong as the envelope.

A document is validated by the rules of Meta's strict validator and renderer, and decoded like the
renderer (MIT, `core/renderer_c`) with the profile of the Quest. Amplitudes ramp linearly
between points. An emphasis has a constant amplitude for 36.4 ms (frequency 0) to 12.1 ms
(frequency 1). It is added and halves the continuous part during that time. The next one replaces
it. This is the renderer's amplitude curve. Its waveform, which changes from sine to square with an
emphasis' frequency, has up to 3 dB more energy.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.files.toml import load_toml
from overview_dsp.offline.export.ahap import sharpness_of
from overview_dsp.offline.export.breakpoints import breakpoints
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip, Transient, level_by_ms
from overview_dsp.offline.export.document import MAX_ENTRIES, Count, Part, Seconds, Unit, descending

STEP_MS, QUEST_HZ = 10, 2000  # step of Meta's player on Android; rate of its example
DUCKING = 0.5
DULL_MS, SHARP_MS = 36.4, 12.1


class Emphasis(Part):
    """Strike at a point."""

    amplitude: Unit
    frequency: Unit


class AmplitudePoint(Part):
    """Point of the amplitude envelope."""

    time: Seconds
    amplitude: Unit
    emphasis: Emphasis | None = None


class FrequencyPoint(Part):
    """Point of the frequency envelope."""

    time: Seconds
    frequency: Unit


class Envelopes(Part):
    """Envelopes of amplitude and frequency."""

    defaults = {"frequency": []}  # noqa: RUF012

    amplitude: Annotated[list[AmplitudePoint], Field(min_length=2, max_length=MAX_ENTRIES)]
    frequency: Annotated[list[FrequencyPoint], Field(max_length=MAX_ENTRIES)]


class Continuous(Part):
    """Signal of a clip."""

    envelopes: Envelopes


class Signals(Part):
    """Signals of a clip."""

    continuous: Continuous


class Version(Part):
    """Version of the format."""

    major: Literal[1]
    minor: Count
    patch: Count


class Metadata(Part):
    """Metadata of a clip."""

    editor: str | None = None
    source: str | None = None
    project: str | None = None
    tags: list[str] | None = None
    author: str | None = None
    description: str | None = None


class Haptic(Part):
    """`.haptic` document."""

    defaults = {"version": {"major": 1, "minor": 0, "patch": 0}, "metadata": {}}  # noqa: RUF012
    ignored = ("version", "metadata")

    version: Version
    metadata: Metadata
    signals: Signals

    @property
    def points(self) -> list[AmplitudePoint]:
        """Amplitude envelope."""
        return self.signals.continuous.envelopes.amplitude

    def unplayable(self) -> Iterator[str]:
        """Yield faults that prevent playback: descending times, or no duration."""
        yield from descending([point.time for point in self.points], "amplitude times")
        if self.points[-1].time <= 0.0:
            yield "the clip has no length: its last amplitude is at 0"

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values."""
        yield from self.unplayable()
        pitches = self.signals.continuous.envelopes.frequency
        yield from descending([point.time for point in pitches], "frequency times")
        if self.points[0].time != 0.0:
            yield f"amplitude[0].time = {self.points[0].time:g}; Meta's renderer wants 0"
        end = self.points[-1].time
        for k, pitch in enumerate(pitches):
            if pitch.time > end:
                yield (
                    f"frequency[{k}].time = {pitch.time:g} is after the last amplitude ({end:g} s)"
                )
        for k, point in enumerate(self.points):
            if point.emphasis is not None and point.emphasis.amplitude < point.amplitude:
                yield (
                    f"amplitude[{k}].emphasis.amplitude = {point.emphasis.amplitude:g} is below "
                    f"the envelope there ({point.amplitude:g})"
                )


def emphasis_ms(frequency: float) -> float:
    """Return the duration of an emphasis of this frequency (0 to 1)."""
    return DULL_MS + (SHARP_MS - DULL_MS) * frequency


def curve(document: Haptic, rate: float, catch_up: bool) -> FloatArray:
    """Return the amplitude curve of Meta's renderer at a sample rate, Hz.

    A point counts from the first sample at or after its time, a float32. A ramp reaches its target
    one sample early. `catch_up`: a ramp that starts late is shorter.
    """
    points, number = document.points, np.dtype("f8" if catch_up else "f4")
    times = np.array([point.time for point in points], np.float32).astype(number)
    clock = np.arange(math.ceil(times[-1] * rate)).astype(number) * np.array(1.0 / rate, number)
    places = np.searchsorted(clock, times)
    level, emphasis = np.zeros((2, len(clock)))
    now = points[0].amplitude
    for k, (start, end) in enumerate(itertools.pairwise(places)):
        length = (times[k + 1] - (start / rate if catch_up else times[k])) * rate - 1.0
        part = np.arange(end - start + 1) / length if length > 0.0 else np.ones(end - start + 1)
        ramp = now + (points[k + 1].amplitude - now) * np.minimum(part, 1.0)
        level[start:end], now = ramp[:-1], ramp[-1]
        if (struck := points[k].emphasis) is not None:
            emphasis[start:] = 0.0
            samples = int(emphasis_ms(struck.frequency) * rate / LEVELS_PER_S)
            emphasis[start : start + samples] = struck.amplitude
    return np.minimum(np.where(emphasis > 0.0, DUCKING, 1.0) * level + emphasis, 1.0)


def on_quest(document: Haptic) -> FloatArray:
    """Return the amplitude at each millisecond on the Quest."""
    return level_by_ms(curve(document, QUEST_HZ, catch_up=True), QUEST_HZ)


def on_android(document: Haptic) -> FloatArray:
    """Return the amplitude in the steps of Meta's player on Android: 10 ms, 1 to 255."""
    level = curve(document, LEVELS_PER_S / STEP_MS, catch_up=False)
    steps = np.maximum(np.floor(255.0 * level), 1.0) / 255.0
    return np.repeat(steps, STEP_MS)[: round(document.points[-1].time * LEVELS_PER_S)]


def decoded(document: Haptic) -> tuple[FloatArray, list[Transient]]:
    """Return the envelope's amplitude at each millisecond, and the emphases."""
    for fault in document.unplayable():
        raise InputError(fault)
    points = document.points
    grid = np.arange(round(points[-1].time * LEVELS_PER_S) + 1) / LEVELS_PER_S
    level = np.interp(grid, [one.time for one in points], [one.amplitude for one in points])
    return level, [
        Transient(one.time, one.emphasis.amplitude, one.emphasis.frequency, "")
        for one in points
        if one.emphasis is not None
    ]


def document(clip: Clip, budget: int) -> Haptic:
    """Return the clip as a `.haptic` document."""
    strikes = {
        round(one.time_s * LEVELS_PER_S): Emphasis(
            amplitude=round(one.amplitude, 4), frequency=round(one.sharpness, 4)
        )
        for one in clip.transients
    }
    continuous, corners = clip.under_strikes(lambda strike: int(emphasis_ms(strike.sharpness)))
    places = breakpoints(continuous, budget + len(corners), corners)
    levels = np.round(continuous[places], 4).tolist()
    envelope = [
        AmplitudePoint(time=place / LEVELS_PER_S, amplitude=level, emphasis=strikes.get(place))
        for place, level in zip(places.tolist(), levels, strict=True)
    ]
    pitch = sharpness_of(clip.frequency_hz)
    pitches = [{"time": time, "frequency": pitch} for time in (0.0, clip.duration_s)]
    parts = load_toml(__file__, "documents.toml")["haptic"]
    signals = {"continuous": {"envelopes": {"amplitude": envelope, "frequency": pitches}}}
    metadata = {"project": clip.title, **parts["metadata"]}
    return Haptic.model_validate({**parts, "metadata": metadata, "signals": signals})
