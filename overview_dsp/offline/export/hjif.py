"""HJIF, the interchange format of MPEG haptics (ISO/IEC 23090-31): JSON with two perceptions.

- *Vibrotactile*: one channel with the vibration (a wave with keyframes of amplitude) and one with
  the strikes (short waves), for a C2-like voice coil.
- *Friction*: B(phi) for devices that can brake: a linear curve over the half turn, with one
  tick per 0.01 degrees, where 1 is the surface's highest friction (in the description).

The timescale is 1000 and every count a whole number, since the reference reader drops others and
assumes one millisecond per tick for any timescale. It always plays a Transient band as 22 ms at 91
Hz. Strikes are therefore waves, during which the vibration is silent.

A document is validated by the rules of the reference parser and its limits of playback. It is
decoded like in the reference decoder: channels and effects are summed as signals. Waves of the same
frequency add by phase, relative to the effect's position, and waves of different frequencies add in
energy. A wave's amplitude is linear between keyframes. A transient is 22 ms of 90.9 Hz (two
cycles). Gains multiply.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.files.schema import Allowed
from overview_dsp.files.toml import load_toml
from overview_dsp.kernels.layout import CELLS
from overview_dsp.offline.export.ahap import sharpness_of
from overview_dsp.offline.export.breakpoints import breakpoints
from overview_dsp.offline.export.clip import LEVELS_PER_S, MAX_CLIP_S, Clip, Transient, level_by_ms
from overview_dsp.offline.export.document import Count, Part, Signed, descending

STRIKE_MS = 12  # duration of a strike's wave: three cycles of a C-2

TICKS_PER_TURN = 18_000
"""Number of ticks of the friction curve: half a turn in units of 0.01 degrees."""

FINE = 4  # moments per millisecond at which waves are added
TRANSIENT_MS, TRANSIENT_HZ = 22, 1000.0 / 11.0
MAX_STRIKE_MS = 30  # longest wave that is read as a strike, ms
FRICTION_POINTS = 2000
_PARTS: dict[str, dict[str, Any]] = load_toml(__file__, "documents.toml")["hjif"]

_VERSIONS = r"(202[3-9]|20[3-9][0-9]|2[1-9][0-9]{2}|[3-9][0-9]{3})(-[0-9])?"


def _iso_date(text: str) -> str:
    datetime.date.fromisoformat(text)
    return text


Date = Annotated[str, AfterValidator(_iso_date), Allowed("a date like 2026-07-01")]
Frequency = Annotated[float, Field(ge=0.0), Allowed("a number of Hz, 0 or more")]


class Keyframe(Part):
    """Amplitude at a tick of an effect."""

    relative_position: Count
    amplitude_modulation: Signed
    frequency_modulation: Count | None = None


class Effect(Part):
    """Effect: a wave or a curve from a tick on."""

    defaults = {"phase": 0.0, "base_signal": "Sine"}  # noqa: RUF012

    id: Count | None = None
    effect_type: Literal["Basis", "Reference", "Composite"]
    position: Count
    phase: float
    base_signal: Literal["Sine", "Square", "Triangle", "SawToothUp", "SawToothDown"]
    keyframes: Annotated[list[Keyframe], Field(min_length=1)]


class Band(Part):
    """Band of effects of one kind."""

    band_type: Literal["Transient", "Curve", "VectorialWave", "WaveletWave"]
    curve_type: Literal["Linear", "Cubic", "Akima", "Bezier", "Bspline", "Unknown"] | None = None
    lower_frequency_limit: Count
    upper_frequency_limit: Count
    effects: Annotated[list[Effect], Field(min_length=1)]

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values, with locations relative to the band."""
        if self.upper_frequency_limit < self.lower_frequency_limit:
            yield ": its upper frequency limit is below the lower one"
        curve = self.band_type == "Curve"
        if curve and self.curve_type is None:
            yield ".curve_type is missing"
        for e, effect in enumerate(self.effects):
            frames = effect.keyframes
            here = f".effects[{e}]"
            yield from descending([one.relative_position for one in frames], f"{here}.keyframes")
            if curve and (len(frames) < 3 or effect.position):
                yield f"{here}: a curve must have 3 or more keyframes and start at 0, or is silent"
            if self.band_type == "VectorialWave":
                for k, frame in enumerate(frames):
                    if frame.frequency_modulation is None:
                        yield f"{here}.keyframes[{k}].frequency_modulation is missing"
        yield from descending([effect.position for effect in self.effects], ".effects")


class Channel(Part):
    """Channel: sum of bands."""

    ignored = ("reference_device_id",)

    id: Count
    description: str
    gain: float
    mixing_coefficient: float
    body_part_mask: Count
    reference_device_id: Count | None = None
    bands: Annotated[list[Band], Field(min_length=1, max_length=7)]


class Device(Part):
    """Actuator for which a perception is intended."""

    id: Count
    name: str
    type: Literal["Unknown", "LRA", "VCA", "ERM", "Piezo"] | None = None
    minimum_frequency: Frequency | None = None
    resonance_frequency: Frequency | None = None
    maximum_frequency: Frequency | None = None


class Perception(Part):
    """Perception: channels of one modality."""

    id: Count
    avatar_id: Count
    description: str
    perception_modality: Literal[
        "Other", "Pressure", "Acceleration", "Velocity", "Position", "Temperature", "Vibrotactile",
        "Water", "Wind", "Force", "Vibrotactile Texture", "Stiffness", "Friction", "Electrotactile",
    ]  # fmt: skip
    reference_devices: list[Device] | None = None
    channels: Annotated[list[Channel], Field(min_length=1, max_length=127)]
    effect_library: list[Part]

    ignored = ("reference_devices",)

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values, with locations relative to the perception."""
        devices = self.reference_devices or []
        for k, device in enumerate(devices):
            names = ("minimum_frequency", "resonance_frequency", "maximum_frequency")
            known = [limit for one in names if (limit := getattr(device, one)) is not None]
            if known != sorted(known):
                yield (
                    f".reference_devices[{k}]: minimum, resonance and maximum frequency aren't in "
                    "this order"
                )
        for c, channel in enumerate(self.channels):
            wanted = channel.reference_device_id
            if wanted is not None and wanted not in [device.id for device in devices]:
                yield f".channels[{c}].reference_device_id is {wanted}; must be the id of a device"
            for b, band in enumerate(channel.bands):
                for fault in band.faults():
                    yield f".channels[{c}].bands[{b}]{fault}"


class Hjif(Part):
    """HJIF document."""

    version: Annotated[str, Field(pattern=f"^{_VERSIONS}$"), Allowed("2023 or later")]
    profile: Literal["Main", "Simple Parametric"]
    level: Literal[1, 2]
    date: Date
    description: str
    timescale: Literal[1000]  # others play with the wrong phase
    perceptions: Annotated[list[Perception], Field(min_length=1)]
    avatars: list[Part]
    syncs: list[Part]

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values."""
        channels = [channel.id for one in self.perceptions for channel in one.channels]
        perceptions = [one.id for one in self.perceptions]
        for name, ids in (("perceptions", perceptions), ("channels", channels)):
            if len(set(ids)) < len(ids):
                yield f"{name}: ids must be unique"
        for p, perception in enumerate(self.perceptions):
            for fault in perception.faults():
                yield f"perceptions[{p}]{fault}"


def document(clip: Clip, budget: int) -> Hjif:
    """Return the clip as an HJIF document."""
    hz = round(clip.frequency_hz)
    level, corners = clip.under_strikes(lambda strike: STRIKE_MS)
    places = breakpoints(level, max(budget, 3) + len(corners), corners).tolist()
    vibration = _wave(0, [(place, round(float(level[place]), 4)) for place in places], hz)
    strikes = [
        _wave(
            round(strike.time_s * LEVELS_PER_S),
            [(at, round(strike.amplitude, 4)) for at in (0, STRIKE_MS // 2, STRIKE_MS - 1)],
            hz,
        )
        for strike in clip.transients
    ]
    device = Device(resonance_frequency=hz, **_PARTS["device"])
    channels = [
        _channel(number, name, Band(effects=effects, **_PARTS["wave"]), device.id)
        for number, (name, effects) in enumerate((("vibration", [vibration]), ("strikes", strikes)))
        if effects
    ]
    highest = float(clip.surface.resistance.max())
    felt = Perception(reference_devices=[device], channels=channels, **_PARTS["vibration"])
    friction = Perception(
        description=f"friction over the half turn; 1 is {highest:.6g} N m s/rad, a tick "
        "0.01 degree",
        channels=[_channel(2, "B over phi", _friction(clip, highest))],
        **_PARTS["friction"],
    )
    return Hjif(
        date=datetime.date.today().isoformat(),
        description=f"overView DSP: {clip.title}",
        perceptions=[felt, friction],
        **_PARTS["document"],
    )


def _channel(number: int, name: str, band: Band, device: int | None = None) -> Channel:
    return Channel(
        id=number, description=name, reference_device_id=device, bands=[band], **_PARTS["channel"]
    )


def _wave(position: int, points: list[tuple[int, float]], hz: int | None = None) -> Effect:
    frames = [
        Keyframe(relative_position=at, amplitude_modulation=level, frequency_modulation=hz)
        for at, level in points
    ]
    return Effect(position=position, keyframes=frames, **_PARTS["effect"])


def _friction(clip: Clip, highest: float) -> Band:
    ticks = np.arange(TICKS_PER_TURN + 1)
    # the highest cell around each tick, so that no event is lost
    edges = np.clip(np.rint((ticks - 0.5) / TICKS_PER_TURN * CELLS), 0, CELLS).astype(np.int64)
    curve = np.maximum.reduceat(clip.surface.resistance / highest, edges)
    # levels may be very low, since a goal is several hundred times higher than the base surface
    places = breakpoints(curve / curve.min(), FRICTION_POINTS).tolist()
    if len(places) == 2:  # the reference reader plays curves of two points as silence
        places.insert(1, TICKS_PER_TURN // 2)
    wave = _wave(0, [(place, round(float(curve[place]), 6)) for place in places])
    return Band(effects=[wave], **_PARTS["curve"])


Wave = tuple[int, FloatArray, float, float]
"""Start (ms), amplitude at each fine moment, frequency (Hz) and phase of a wave."""


def decoded(hjif: Hjif) -> tuple[FloatArray, list[Transient], FloatArray]:
    """Return the amplitude of long waves at each millisecond, short ones as strikes, and all."""
    waves = _waves(hjif)
    strikes = [
        Transient(start / LEVELS_PER_S, min(float(level.max()), 1.0), sharpness_of(hz), "")
        for start, level, hz, _ in waves
        if 0 < len(level) < MAX_STRIKE_MS * FINE
    ]
    long = [wave for wave in waves if len(wave[1]) >= MAX_STRIKE_MS * FINE]
    return _summed(long), sorted(strikes, key=lambda one: one.time_s), _summed(waves)


def _waves(hjif: Hjif) -> list[Wave]:
    effects = [
        (band.band_type, effect, channel.gain)
        for perception in hjif.perceptions
        if perception.perception_modality == "Vibrotactile"
        for channel in perception.channels
        for band in channel.bands
        for effect in band.effects
    ]
    if not effects:
        raise InputError("perceptions: none is Vibrotactile, with effects")
    end = max(one.position + one.keyframes[-1].relative_position for _, one, _ in effects)
    if end > MAX_CLIP_S * LEVELS_PER_S:
        raise InputError(f"it lasts {end / LEVELS_PER_S:g} s; at most {MAX_CLIP_S:g} s are allowed")
    return [wave for one in effects for wave in _parts(*one)]


def _summed(parts: list[Wave]) -> FloatArray:
    count = max((start * FINE + len(amplitude) for start, amplitude, _, _ in parts), default=0)
    phasors: dict[float, NDArray[np.complex128]] = {}
    for start, amplitude, hz, phase in parts:
        summed = phasors.setdefault(hz, np.zeros(count, np.complex128))
        turn = phase - 2.0 * np.pi * hz * start / LEVELS_PER_S
        summed[start * FINE :][: len(amplitude)] += amplitude * np.exp(1j * turn)
    energy = sum((np.abs(one) ** 2 for one in phasors.values()), np.zeros(count))
    return level_by_ms(np.sqrt(energy), FINE * LEVELS_PER_S)


def _parts(band: str, effect: Effect, gain: float) -> list[Wave]:
    """Return the waves of an effect."""
    at = [frame.relative_position for frame in effect.keyframes]
    levels = [gain * frame.amplitude_modulation for frame in effect.keyframes]
    if band == "Transient":
        return [
            (effect.position + start, np.full(TRANSIENT_MS * FINE, level), TRANSIENT_HZ, 0.0)
            for start, level in zip(at, levels, strict=True)
        ]
    amplitude = np.interp((np.arange(at[-1] * FINE) + 0.5) / FINE, at, levels)
    hz = effect.keyframes[0].frequency_modulation or 0
    return [(effect.position, amplitude, hz, effect.phase)]
