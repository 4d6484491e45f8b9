"""Android export: a waveform of amplitudes (JSON and the platform's XML) and envelope effects.

- `createWaveform(timings, amplitudes, -1)`: steps of 10 ms, 1..255 inside the clip (0 would switch
  the motor off and cause a click). Equal steps are merged, and the last one ends with the clip.
- Envelope effects (API 36, `WaveformEnvelopeBuilder`): every device supports 16 control points, 20
  ms to 1 s apart, starting at amplitude 0. A clip becomes a sequence of effects. Each ends at a
  moment of low vibration, and its points minimise the perceptible error. An effect ramps from one
  control point to the next.
"""

# ruff: noqa: N815
from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal
from xml.etree import ElementTree

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.files.schema import Allowed
from overview_dsp.offline.export.breakpoints import control_points
from overview_dsp.offline.export.clip import LEVELS_PER_S, MAX_CLIP_S, Clip
from overview_dsp.offline.export.document import READING, Count, Part, Positive, Unit

STEP_MS = 10
MAX_POINTS = 16
POINT_MS = (20, 1000)
PART_MS = 1000  # approximate length of an envelope effect; its 16 points are about 60 ms apart


def _amplitude(value: int, info: ValidationInfo) -> int:
    """Validate an amplitude. 0 would switch the motor off inside the clip; a reader accepts it."""
    low = 0 if info.context == READING else 1
    if not low <= value <= 255:
        raise PydanticCustomError("less_than_equal", f"{low} to 255")
    return value


Milliseconds = Annotated[int, Field(ge=1), Allowed("1 ms or more")]


class Waveform(Part):
    """Amplitudes (0 to 255) and their durations in ms."""

    timings: Annotated[list[Milliseconds], Field(min_length=1)]
    amplitudes: Annotated[list[Annotated[int, AfterValidator(_amplitude)]], Field(min_length=1)]
    repeat: Literal[-1]

    defaults = {"repeat": -1}  # noqa: RUF012
    ignored = ("repeat",)


class ControlPoint(Part):
    """Target amplitude of a ramp."""

    amplitude: Unit
    frequencyHz: Positive
    durationMs: Annotated[int, Field(ge=POINT_MS[0], le=POINT_MS[1]), Allowed("20 to 1000")]


class EnvelopeEffect(Part):
    """Sequence of control points that starts at amplitude 0."""

    startMs: Count
    initialFrequencyHz: Positive
    controlPoints: Annotated[list[ControlPoint], Field(min_length=1, max_length=MAX_POINTS)]


class Android(Part):
    """JSON document with waveform and envelope effects."""

    defaults = {"description": "", "envelopeEffects": []}  # noqa: RUF012
    ignored = ("envelopeEffects",)

    description: str
    waveform: Waveform
    envelopeEffects: list[EnvelopeEffect]

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values."""
        wave = self.waveform
        if len(wave.timings) != len(wave.amplitudes):
            yield f"waveform: {len(wave.timings)} timings and {len(wave.amplitudes)} amplitudes"
        end = 0
        for k, effect in enumerate(self.envelopeEffects):
            if effect.startMs < end:
                yield f"envelopeEffects[{k}].startMs is before the last effect's end ({end})"
            end = effect.startMs + sum(point.durationMs for point in effect.controlPoints)
            if effect.controlPoints[-1].amplitude != 0.0:
                yield f"envelopeEffects[{k}] doesn't end in silence: the next one would click"


def waveform(clip: Clip) -> Waveform:
    """Return a clip's waveform."""
    level = clip.level[:-1]  # the last is the silence after it
    padded = np.pad(level, (0, -len(level) % STEP_MS), mode="edge").reshape(-1, STEP_MS)
    steps = np.clip(np.rint(255.0 * np.sqrt(np.mean(padded**2, axis=1))), 1, 255).astype(int)
    starts = np.flatnonzero(np.diff(steps, prepend=-1))
    bounds = np.append(starts * STEP_MS, len(level))
    return Waveform(timings=np.diff(bounds).tolist(), amplitudes=steps[starts].tolist(), repeat=-1)


def envelopes(clip: Clip) -> list[EnvelopeEffect]:
    """Return the envelope effects in order, within the limits of every device."""
    effects = []
    hz = round(clip.frequency_hz, 3)
    strikes_ms = [round(strike.time_s * LEVELS_PER_S) for strike in clip.transients]
    for first, end in _parts(clip.level):
        level = np.pad(clip.felt[first : end + 1], (0, max(0, POINT_MS[0] - (end - first))))
        places, amplitudes = control_points(
            level, [at - first for at in strikes_ms if first <= at < end], MAX_POINTS, POINT_MS
        )
        points = [
            ControlPoint(amplitude=round(float(high), 4), frequencyHz=hz, durationMs=int(ms))
            for high, ms in zip(amplitudes[1:], np.diff(places), strict=True)
        ]
        effects.append(EnvelopeEffect(startMs=first, initialFrequencyHz=hz, controlPoints=points))
    return effects


def document(clip: Clip) -> Android:
    """Return a document with waveform and envelope effects."""
    return Android(
        description=f"overView DSP: {clip.title}",
        waveform=waveform(clip),
        envelopeEffects=envelopes(clip),
    )


def waveform_xml(wave: Waveform) -> bytes:
    """Return the waveform in the platform's XML (`VibrationXmlParser`)."""
    root = ElementTree.Element("vibration-effect")
    effect = ElementTree.SubElement(root, "waveform-effect")
    for ms, level in zip(wave.timings, wave.amplitudes, strict=True):
        entry = {"durationMs": str(ms), "amplitude": str(level)}
        ElementTree.SubElement(effect, "waveform-entry", entry)
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _parts(level: FloatArray) -> list[tuple[int, int]]:
    """Divide a clip about every `PART_MS` at moments of low vibration."""
    last = len(level) - 1
    cuts = [0]
    while last - cuts[-1] > 1.5 * PART_MS:
        low, high = cuts[-1] + PART_MS // 2, cuts[-1] + 3 * PART_MS // 2
        cuts.append(low + int(np.argmin(level[low:high])))
    if last - cuts[-1] < POINT_MS[0] and len(cuts) > 1:
        cuts.pop()
    return list(zip(cuts, [*cuts[1:], last], strict=True))


def xml_waveform(root: ElementTree.Element) -> dict[str, Any]:
    """Return the JSON of a waveform's XML; InputError for other XML."""
    if root.tag != "vibration-effect" or [child.tag for child in root] != ["waveform-effect"]:
        raise InputError("the root must be a vibration-effect with a waveform-effect")
    wave: dict[str, Any] = {"timings": [], "amplitudes": [], "repeat": -1}
    for k, entry in enumerate(root[0]):
        if entry.tag != "waveform-entry" or set(entry.keys()) != {"durationMs", "amplitude"}:
            raise InputError(
                f"waveform-effect[{k}] must be a waveform-entry with durationMs and amplitude"
            )
        for key, values in (("durationMs", wave["timings"]), ("amplitude", wave["amplitudes"])):
            text = entry.get(key, "")
            values.append(int(text) if re.fullmatch("[0-9]{1,12}", text) else text)
    return wave


def waveform_played(wave: Waveform) -> FloatArray:
    """Return the amplitude of a waveform at each millisecond; InputError if it is too long."""
    if len(wave.timings) != len(wave.amplitudes):
        raise InputError(f"{len(wave.timings)} timings and {len(wave.amplitudes)} amplitudes")
    if sum(wave.timings) > MAX_CLIP_S * LEVELS_PER_S:
        raise InputError(f"it is longer than {MAX_CLIP_S:g} s, which is the maximum")
    return np.append(np.repeat(np.array(wave.amplitudes) / 255.0, wave.timings), 0.0)


def envelopes_played(effects: Sequence[EnvelopeEffect]) -> FloatArray:
    """Return the amplitude of envelope effects at each millisecond."""
    times, values = [0], [0.0]
    for effect in effects:
        points = effect.controlPoints
        at = np.cumsum([effect.startMs, *(point.durationMs for point in points)])
        times += at.tolist()
        values += [0.0, *(point.amplitude for point in points)]
    return np.interp(np.arange(times[-1] + 1), times, values)
