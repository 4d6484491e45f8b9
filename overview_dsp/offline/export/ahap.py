"""AHAP, Apple's haptic pattern (Core Haptics): JSON in two files that are played together.

One file has the vibration (continuous events of up to 30 s with an intensity curve), one the
strikes (transient events). They are separate, since a pattern's curves also modulate its
transients. The vibration is silent during a transient (`TRANSIENTS_MS`).

Conversions: intensity = sqrt(amplitude), as in Meta's exporter (perceived strength); sharpness =
(frequency - 65 Hz)/235 Hz, as in the MPEG encoder. A control point's time is relative to its
curve. `HapticIntensityControl` multiplies.

Apple does not publish the waveform of a transient. It is modelled as a burst of constant amplitude
of 6 to 22 ms (12 ms: Meta's sharpest emphasis; 22 ms: the MPEG reference's transient), whose energy
adds to that of the continuous vibration. Amplitude is intensity squared, the inverse of the
exporters' conversion.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
import pydantic
from pydantic import AfterValidator, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.files.schema import Allowed
from overview_dsp.files.toml import load_toml
from overview_dsp.offline.export.breakpoints import breakpoints
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip, Transient
from overview_dsp.offline.export.document import CHECKING, MAX_ENTRIES, Part, Seconds, descending

TRANSIENTS_MS = (12, 6, 22)  # assumed lengths of a transient; exports are optimised for the first
LONGEST_EVENT_S = 30.0
DULLEST_HZ, SHARPEST_HZ = 65.0, 300.0
_TOLERANCE_S = 0.0015

INTENSITY, SHARPNESS, CONTROL = "HapticIntensity", "HapticSharpness", "HapticIntensityControl"
TRANSIENT, CONTINUOUS, WAVEFORM = "HapticTransient", "HapticContinuous", "AudioCustom"
_NAMES: dict[str, list[str]] = load_toml(__file__, "documents.toml")["ahap"]
_WAVEFORM_KEYS = ("EventWaveformPath", "EventWaveformLoopEnabled", "EventWaveformUseVolumeEnvelope")
_FROM_ZERO = (INTENSITY, SHARPNESS, CONTROL, "Sustained", "AudioVolume")


def _known(*names: str) -> AfterValidator:
    """Return a validator of a name; a reader ignores objects with other names."""

    def check(name: str, info: ValidationInfo) -> str:
        if info.context == CHECKING and name not in names:
            raise PydanticCustomError("literal_error", ", ".join(names))
        return name

    return AfterValidator(check)


def _range_by_id(info: ValidationInfo) -> tuple[float, float]:
    """Return the range of a `ParameterID`; a reader limits only parameters that it uses."""
    id = info.data.get("ParameterID")
    if info.context != CHECKING and id not in (INTENSITY, SHARPNESS, CONTROL):
        return -math.inf, math.inf
    return 0.0 if id in _FROM_ZERO else -1.0, 1.0


def _in_range(value: float, info: ValidationInfo) -> float:
    low, high = _range_by_id(info)
    if not low <= value <= high:
        raise PydanticCustomError("less_than_equal", f"{low:g} to {high:g}")
    return value


ControlId = Annotated[str, _known(*_NAMES["curve_parameters"])]
Value = Annotated[float, AfterValidator(_in_range)]


class EventParameter(Part):
    """Parameter of an event."""

    ParameterID: Annotated[str, _known(*_NAMES["event_parameters"])]
    ParameterValue: Value


class PatternEvent(Part):
    """Event: a vibration, a strike or a sound."""

    defaults = {"EventType": "", "EventParameters": []}  # noqa: RUF012
    ignored = _WAVEFORM_KEYS

    EventType: Annotated[str, _known(TRANSIENT, CONTINUOUS, WAVEFORM, "AudioContinuous")]
    Time: Seconds
    EventDuration: Seconds | None = None
    EventParameters: Annotated[list[EventParameter], Field(max_length=MAX_ENTRIES)]
    EventWaveformPath: str | None = None
    EventWaveformLoopEnabled: bool | None = None
    EventWaveformUseVolumeEnvelope: bool | None = None

    @pydantic.model_validator(mode="after")
    def _keys_of_type(self, info: ValidationInfo) -> PatternEvent:
        needed = {CONTINUOUS: "EventDuration"}
        if info.context == CHECKING:
            needed |= {"AudioContinuous": "EventDuration", WAVEFORM: "EventWaveformPath"}
            waveform = [key for key in _WAVEFORM_KEYS if getattr(self, key) is not None]
            if waveform and self.EventType != WAVEFORM:
                raise ValueError(f"{waveform[0]} is a key of {WAVEFORM} only")
        key = needed.get(self.EventType)
        if key is not None and getattr(self, key) is None:
            raise ValueError(f"{key} is missing")
        return self

    def value(self, id: str, default: float) -> float:
        """Return the value of a parameter, or its default."""
        values = {one.ParameterID: one.ParameterValue for one in self.EventParameters}
        return values.get(id, default)

    @property
    def end_s(self) -> float:
        """End time, s."""
        return self.Time + (self.EventDuration or 0.0)


class ControlStep(Part):
    """Parameter of the whole pattern from a time on."""

    ParameterID: ControlId
    Time: Seconds
    ParameterValue: Value


class ControlPoint(Part):
    """Point of a curve, with a time relative to the curve."""

    Time: Seconds
    ParameterValue: float


class ControlCurve(Part):
    """Curve of a parameter of the whole pattern, linear between points."""

    ParameterID: ControlId
    Time: Seconds
    ParameterCurveControlPoints: Annotated[list[ControlPoint], Field(max_length=MAX_ENTRIES)]

    @pydantic.field_validator("ParameterCurveControlPoints")
    @classmethod
    def _points(cls, points: list[ControlPoint], info: ValidationInfo) -> list[ControlPoint]:
        if info.context == CHECKING and not points:
            raise ValueError("is empty; must have at least one point")
        low, high = _range_by_id(info)
        for k, point in enumerate(points):
            if not low <= (value := point.ParameterValue) <= high:
                raise ValueError(f"[{k}] has a value of {value:g}; must be {low:g} to {high:g}")
        return points


class Entry(Part):
    """Entry of a pattern: an event, a curve or a parameter."""

    Event: PatternEvent | None = None
    ParameterCurve: ControlCurve | None = None
    Parameter: ControlStep | None = None

    @pydantic.model_validator(mode="after")
    def _one(self, info: ValidationInfo) -> Entry:
        if info.context == CHECKING and len(self.model_fields_set) != 1:
            raise ValueError(f"must be an object with one of {', '.join(Entry.model_fields)}")
        return self


class About(Part):
    """Metadata of a pattern."""

    Project: str | None = None
    Created: str | None = None
    Description: str | None = None


class Ahap(Part):
    """AHAP document."""

    defaults = {"Version": 1.0}  # noqa: RUF012
    ignored = ("Version", "Metadata")

    Version: Annotated[float, Field(ge=1.0, le=1.0), Allowed("1.0")]
    Metadata: About | None = None
    Pattern: Annotated[list[Entry], Field(max_length=MAX_ENTRIES)]

    @property
    def events(self) -> list[PatternEvent]:
        """Return all events in the order of the document."""
        return [entry.Event for entry in self.Pattern if entry.Event is not None]

    @property
    def curves(self) -> list[ControlCurve]:
        """Return all curves in the order of the document."""
        return [entry.ParameterCurve for entry in self.Pattern if entry.ParameterCurve is not None]

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values."""
        if not self.events:
            yield "Pattern has no event: it plays nothing"
            return
        end = max(event.end_s for event in self.events)
        for k, entry in enumerate(self.Pattern):
            if entry.ParameterCurve is None:
                continue
            name = f"Pattern[{k}].ParameterCurve.ParameterCurveControlPoints"
            times = [point.Time for point in entry.ParameterCurve.ParameterCurveControlPoints]
            yield from descending(times, name)
            start = entry.ParameterCurve.Time
            absolute = start > 0.0 and times[0] >= start and start + times[-1] > end + _TOLERANCE_S
            if absolute or start > end + _TOLERANCE_S:
                yield (
                    f"{name} end at {start + times[-1]:g} s, after all events ({end:g} s); a "
                    "point's time counts from its curve's"
                )
        for event in self.events:
            lasts_s = event.end_s - event.Time
            if event.EventType == CONTINUOUS and not 0.0 < lasts_s <= LONGEST_EVENT_S:
                yield (
                    f"EventDuration at {event.Time:g} s is {event.EventDuration:g}; "
                    f"must be more than 0 and at most {LONGEST_EVENT_S:g} s"
                )


def decoded(pattern: Ahap) -> tuple[FloatArray, list[Transient]]:
    """Return the amplitude of a pattern's vibration at each millisecond, and its strikes."""
    spans = [one for one in pattern.events if one.EventType == CONTINUOUS]
    strikes = [
        Transient(one.Time, one.value(INTENSITY, 1.0) ** 2, one.value(SHARPNESS, 0.5), "")
        for one in pattern.events
        if one.EventType == TRANSIENT
    ]
    if not spans and not strikes:
        raise InputError("Pattern: has no vibration")
    end = max([*(span.end_s for span in spans), *(strike.time_s for strike in strikes)])
    times = np.arange(round(end * LEVELS_PER_S) + 1) / LEVELS_PER_S
    intensity = np.zeros(len(times))
    for span in spans:
        inside = (times >= span.Time) & (times <= span.end_s)
        intensity[inside] = np.maximum(intensity[inside], span.value(INTENSITY, 1.0))
    points = [
        (curve.Time + point.Time, point.ParameterValue)
        for curve in pattern.curves
        if curve.ParameterID == CONTROL
        for point in curve.ParameterCurveControlPoints
    ]
    steps = [one.Parameter for one in pattern.Pattern if one.Parameter is not None]
    points += [(one.Time, one.ParameterValue) for one in steps if one.ParameterID == CONTROL]
    if points:
        points.sort(key=lambda point: point[0])  # stable: equal times keep their order
        at, value = np.array(points).T
        # before the first point, the events define the intensity
        control = np.where(times < at[0], 1.0, np.interp(times, at, value))
        intensity *= control
        # a pattern's curves also modulate its transients
        strikes = [
            replace(one, amplitude=one.amplitude * float(control[round(one.time_s * 1000)]) ** 2)
            for one in strikes
        ]
    return intensity**2, sorted(strikes, key=lambda strike: strike.time_s)


def with_transients(level: FloatArray, strikes: Sequence[Transient], length_ms: int) -> FloatArray:
    """Return a continuous level with added transients."""
    starts = [round(strike.time_s * LEVELS_PER_S) for strike in strikes]
    count = max([len(level), *(start + length_ms + 1 for start in starts)])
    energy = np.pad(level, (0, count - len(level))) ** 2
    for start, strike in zip(starts, strikes, strict=True):
        for first in (start, start + 1):  # a millisecond of a level is centred on its moment
            energy[first : first + length_ms] += 0.5 * strike.amplitude**2
    return np.asarray(np.sqrt(energy))


def sharpness_of(frequency_hz: float) -> float:
    """Return the sharpness of a vibration, clamped to 0..1."""
    part = (frequency_hz - DULLEST_HZ) / (SHARPEST_HZ - DULLEST_HZ)
    return round(min(max(part, 0.0), 1.0), 4)


def vibration_pattern(clip: Clip, budget: int) -> Ahap:
    """Return the continuous part, with one event and one curve per 30 s."""
    joints = list(range(0, len(clip.level) - 1, round(LONGEST_EVENT_S * LEVELS_PER_S)))
    level, corners = clip.under_strikes(lambda strike: TRANSIENTS_MS[0])
    places = breakpoints(level, budget + len(corners), [*joints, *corners])
    pattern: list[Entry] = []
    for first, end in itertools.pairwise([*joints, len(clip.level) - 1]):
        start = first / LEVELS_PER_S
        points = [
            ControlPoint(
                # MPEG's reader rounds down to a millisecond, also binary sums just below one
                Time=time if int((start + time) * LEVELS_PER_S) == place else round(time + 1e-6, 6),
                ParameterValue=_intensity(float(level[place])),
            )
            for place in places.tolist()
            if first <= place <= end
            for time in [(place - first) / LEVELS_PER_S]
        ]
        length = (end - first) / LEVELS_PER_S
        event = _event(CONTINUOUS, start, 1.0, sharpness_of(clip.frequency_hz), length)
        curve = ControlCurve(ParameterID=CONTROL, Time=start, ParameterCurveControlPoints=points)
        pattern += [Entry(Event=event), Entry(ParameterCurve=curve)]
    return _document(clip, "vibration", pattern)


def strikes_pattern(clip: Clip) -> Ahap:
    """Return the pattern of the transients."""
    events = [
        _event(TRANSIENT, round(strike.time_s, 4), _intensity(strike.amplitude), strike.sharpness)
        for strike in clip.transients
    ]
    return _document(clip, "strikes", [Entry(Event=event) for event in events])


def _event(
    kind: str, time_s: float, intensity: float, sharpness: float, duration_s: float | None = None
) -> PatternEvent:
    return PatternEvent(
        EventType=kind,
        Time=time_s,
        EventDuration=duration_s,
        EventParameters=[
            EventParameter(ParameterID=INTENSITY, ParameterValue=intensity),
            EventParameter(ParameterID=SHARPNESS, ParameterValue=round(sharpness, 4)),
        ],
    )


def _intensity(amplitude: float) -> float:
    return round(math.sqrt(min(max(amplitude, 0.0), 1.0)), 4)


def _document(clip: Clip, part: str, pattern: list[Entry]) -> Ahap:
    about = About(Project="overView DSP", Description=f"{clip.title}: {part}")
    return Ahap(Version=1.0, Metadata=about, Pattern=pattern)
