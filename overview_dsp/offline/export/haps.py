"""`.haps`, the clip of Interhaptics (JSON): notes with an amplitude curve, and transient notes.

Only the vibration is read: stiffness and texture need a device that measures position. Gains
multiply, and sounding notes add in energy. A transient is a note without a curve; its amplitude is
its gain. The format has no frequency for it, so its sharpness is medium.
"""

# ruff: noqa: N815
from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.offline.export.clip import LEVELS_PER_S, MAX_CLIP_S, Transient
from overview_dsp.offline.export.document import MAX_ENTRIES, Part, Seconds, Unit

SHARPNESS = 0.5
Gain = Annotated[float, Field(ge=0.0, le=10.0)]


class Keyframe(Part):
    """Value at a time of a note."""

    m_time: Seconds
    m_value: float


class Modulation(Part):
    """Curve over a note, linear between keyframes."""

    m_keyframes: Annotated[list[Keyframe], Field(max_length=MAX_ENTRIES)]
    m_extrapolationStrategy: int | None = None


class Effect(Part):
    """Effect of a note. Without amplitudes it is a transient."""

    m_type: int | None = None
    m_amplitudeModulation: Modulation | None = None
    m_frequencyModulation: Modulation | None = None


class Note(Part):
    """Effect from a time on."""

    defaults = {"m_startingPoint": 0.0, "m_gain": 1.0}  # noqa: RUF012

    m_startingPoint: Seconds
    m_length: Seconds | None = None
    m_priority: int | None = None
    m_gain: Gain
    m_hapticEffect: Effect


class Melody(Part):
    """Notes that are played together."""

    defaults = {"m_gain": 1.0, "m_mute": 0}  # noqa: RUF012

    m_mute: int
    m_gain: Gain
    m_notes: Annotated[list[Note], Field(max_length=MAX_ENTRIES)]


class Modality(Part):
    """Melodies of one modality, such as vibration."""

    defaults = {"m_gain": 1.0, "m_maximum": 1.0}  # noqa: RUF012

    m_loop: int | None = None
    m_maximum: Unit
    m_gain: Gain
    m_signalEvaluationMethod: int | None = None
    m_melodies: list[Melody]


class Haps(Part):
    """`.haps` document."""

    defaults = {"m_version": "5", "m_gain": 1.0}  # noqa: RUF012
    ignored = ("m_stiffness", "m_texture")

    m_version: str
    m_description: str | None = None
    m_HDFlag: int | None = None
    m_time_unit: int | None = None
    m_length_unit: int | None = None
    m_gain: Gain
    m_stiffness: Any = None
    m_texture: Any = None
    m_vibration: Modality


def decoded(clip: Haps) -> tuple[FloatArray, list[Transient]]:
    """Return the amplitude of the vibration at each millisecond, and its strikes."""
    vibration = clip.m_vibration
    notes = [
        (note, clip.m_gain * vibration.m_gain * melody.m_gain * note.m_gain)
        for melody in vibration.m_melodies
        if not melody.m_mute
        for note in melody.m_notes
    ]
    strikes, curves = [], []
    for note, gain in notes:
        curve = note.m_hapticEffect.m_amplitudeModulation
        if curve is None or not curve.m_keyframes:
            strikes.append(Transient(note.m_startingPoint, min(gain, 1.0), SHARPNESS, ""))
            continue
        points = sorted((one.m_time, one.m_value) for one in curve.m_keyframes)
        at_s, values = np.array(points).T
        curves.append((note.m_startingPoint + at_s, gain * np.clip(values, 0.0, None)))
    ends = [*(at_s[-1] for at_s, _ in curves), *(one.time_s for one in strikes)]
    if not ends:
        raise InputError("m_vibration: has no notes")
    if max(ends) > MAX_CLIP_S:
        raise InputError(f"it is longer than {MAX_CLIP_S:g} s, which is the maximum")
    times = np.arange(round(max(ends) * LEVELS_PER_S) + 1) / LEVELS_PER_S
    energy = np.zeros(len(times))
    for at_s, values in curves:
        energy += np.interp(times, at_s, values, left=0.0, right=0.0) ** 2
    return np.minimum(np.sqrt(energy), 1.0), sorted(strikes, key=lambda one: one.time_s)
