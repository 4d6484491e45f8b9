"""Reader of haptic clips: decode, validate, and convert to events of presets.

Decoded clips have an amplitude for each millisecond and strikes, by the conversions of the exports
(`ahap`, `haptic`). An exported clip is thus decoded without changes. An AHAP clip with
two files, vibration and strikes, is read from either of them.

In a preset, a clip's vibration becomes an event's friction, and its strikes become modes.
The amplitude over the clip's duration becomes the profile of friction over the event: time
becomes position, so the disk plays the clip at any speed and in both directions.
The sharpness of a strike becomes the pitch of a mode, its strength the level.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.design.presets.parameters import MODE_PARAMETERS
from overview_dsp.errors import InputError
from overview_dsp.kernels.layout import MAX_MODES
from overview_dsp.offline.export import ahap, haps, haptic, hjif
from overview_dsp.offline.export.android import Android, Waveform, waveform_played, xml_waveform
from overview_dsp.offline.export.clip import DULL_HZ, SHARP_HZ, Transient
from overview_dsp.offline.export.document import Part, read, validate
from overview_dsp.offline.export.haps import Haps
from overview_dsp.offline.export.hjif import Hjif
from overview_dsp.public import counted

MAX_BYTES = 8_000_000
MAX_DIGITS = 18  # of a whole number

SUFFIXES = (".ahap", ".haptic", ".hjif", ".haps", ".xml")
PLAIN = SUFFIXES[0]
PAIRS = ((PLAIN, ".strikes.ahap"), ("_continuous.ahap", "_transients.ahap"))
"""Suffixes of the two files of an AHAP clip: ours, and Meta's."""

_MODELS: dict[str, type[Part]] = {
    "Pattern": ahap.Ahap,
    "signals": haptic.Haptic,
    "perceptions": Hjif,
    "waveform": Android,
    "m_vibration": Haps,
}
"""Formats by a unique key."""

FORMATS = "AHAP, .haptic, HJIF, Android (JSON, XML) or .haps"

MAX_FAULTS = 20  # highest number of faults to list; later ones are often consequences


@dataclass(frozen=True, eq=False)
class DecodedClip:
    """Decoded haptic clip.

    Attributes
    ----------
    level : float64 (n,)
        Amplitude at each millisecond, 0 to 1.
    transients : tuple of Transient
        Strikes in order of time.
    played : float64 (m,)
        Level including strikes on the format's player; for AHAP and `.haps`, Core Haptics with
        transients of 12 ms.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> _ = ov.export.export(result, "ahap", "match.ahap")
    >>> clip = ov.export.read_clip("match.ahap")
    >>> float(clip.level.max()) <= 1.0
    True
    """

    level: FloatArray
    transients: tuple[Transient, ...]
    played: FloatArray

    def __repr__(self) -> str:
        return f"<DecodedClip: {len(self.level)} ms, {counted(len(self.transients), 'strike')}>"


def read_clip(path: str | os.PathLike[str]) -> DecodedClip:
    """Read a haptic clip, whose format is detected from its content.

    Parameters
    ----------
    path : str or path
        AHAP, `.haptic`, HJIF, `.haps` or Android file (JSON, or the XML of a waveform), or either
        file of an AHAP clip with two (`x.ahap` and `x.strikes.ahap`,
        `x_continuous.ahap` and `x_transients.ahap`).

    Returns
    -------
    DecodedClip
        Amplitudes and strikes.

    Raises
    ------
    InputError
        The file is not readable, too large, not JSON, of another format, or has an invalid entry.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> _ = ov.export.export(result, "ahap", "match.ahap")
    >>> clip = ov.export.read_clip("match.ahap")
    >>> len(clip.level) > 500
    True
    """
    found = [_read(one) for one in paired(validation.path(path, "a clip"))]
    level = np.zeros(max(len(clip.level) for clip in found))
    for clip in found:
        part = level[: len(clip.level)]
        np.maximum(part, clip.level, out=part)
    strikes = sorted((one for clip in found for one in clip.transients), key=lambda one: one.time_s)
    return found[0] if len(found) == 1 else _core_haptics(level, strikes)


def _read(path: Path) -> DecodedClip:
    document = load_document(path)
    with validation.prefix_errors(f"{path}: "):
        model = _model_of(document)
        if model is None:
            raise InputError(f"must be {FORMATS}")
        clip: Any = read(model, document)
        if isinstance(clip, Android):
            level = waveform_played(clip.waveform)
            return DecodedClip(level, (), level)
        if isinstance(clip, Hjif):
            level, strikes, played = hjif.decoded(clip)
            return DecodedClip(level, tuple(strikes), played)
        if isinstance(clip, haptic.Haptic):
            level, strikes = haptic.decoded(clip)
            return DecodedClip(level, tuple(strikes), haptic.on_quest(clip))
        return _core_haptics(*(ahap if isinstance(clip, ahap.Ahap) else haps).decoded(clip))


def _model_of(document: object) -> type[Part] | None:
    keys = document if isinstance(document, dict) else {}
    return next((model for key, model in _MODELS.items() if key in keys), None)


def _core_haptics(level: FloatArray, strikes: list[Transient]) -> DecodedClip:
    played = ahap.with_transients(level, strikes, ahap.TRANSIENTS_MS[0])
    return DecodedClip(level, tuple(strikes), played)


def paired(path: Path) -> tuple[Path, ...]:
    """Return the existing files of the clip to which a file belongs: vibration and strikes."""
    for vibration, strikes in PAIRS:
        for own, other in ((vibration, strikes), (strikes, vibration)):
            # one suffix is a part of the other: match.strikes.ahap is not a vibration
            if not path.name.endswith(own) or (own == PLAIN and path.name.endswith(strikes)):
                continue
            beside = path.with_name(path.name.removesuffix(own) + other)
            if beside.is_file():
                return (path, beside) if own == vibration else (beside, path)
    return (path,)


def clips_in(path: str | os.PathLike[str], kind: str | None) -> dict[str, Path]:
    """Return the clips of a file or a folder by event kind.

    `kind` is that of a single clip. None: the file names of a folder are kinds. InputError if the
    kind of a file is missing, a folder has no clip, or a kind has several.
    """
    place = Path(path)
    if not place.is_dir():
        if kind is None:
            raise InputError(f"{place}: the event kind is missing; add --as KIND")
        return {kind: place}
    found: dict[str, Path] = {}
    for one in sorted(place.iterdir()):
        if one.suffix.lower() in SUFFIXES and paired(one)[0] == one:
            ends = [end for end, _ in reversed(PAIRS) if one.name.endswith(end)]
            name = one.name.removesuffix(ends[0]) if ends else one.stem
            if name in found:
                raise InputError(f"{place}: two clips have the name {name}; keep one of them")
            found[name] = one
    if not found:
        raise InputError(f"{place}: the folder has no clip ({', '.join(SUFFIXES)})")
    if kind is None:
        return found
    if len(found) > 1:
        raise InputError(
            f"{place}: {len(found)} clips for one kind; remove --as or select one clip"
        )
    return {kind: next(iter(found.values()))}


def load_document(path: str | os.PathLike[str]) -> Any:
    """Load a clip's JSON, that of an Android waveform from XML; InputError names the file."""
    data = _file_bytes(path)
    with validation.prefix_errors(f"{os.fspath(path)}: "):
        return _document(data, Path(path).suffix)


def _file_bytes(path: str | os.PathLike[str]) -> bytes:
    where = os.fspath(path)
    try:
        if Path(path).stat().st_size <= MAX_BYTES:
            return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(f"{where}: can't be read ({error})") from None
    raise InputError(f"{where}: larger than {MAX_BYTES:,} bytes; a clip is a short JSON file")


def _document(data: bytes, suffix: str) -> Any:
    if suffix.lower() == ".xml":
        return {"waveform": xml_waveform(_xml(data))}
    try:
        return json.loads(
            data.decode("utf-8-sig"), parse_constant=_no_constant, parse_int=_whole_number
        )
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON: {error}") from None


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is not valid JSON")


def _whole_number(digits: str) -> int:
    if len(digits) > MAX_DIGITS:
        raise ValueError(f"a number of {len(digits)} digits; at most {MAX_DIGITS} are allowed")
    return int(digits)


def check_clip(path: str | os.PathLike[str]) -> list[str]:
    """Return the faults of a haptic clip by the rules of its format and players.

    This is stricter than `read_clip`, which accepts all playable clips.

    Parameters
    ----------
    path : str or path
        An AHAP, `.haptic`, HJIF, `.haps` or Android file (JSON, or the XML of a waveform).

    Returns
    -------
    list of str
        One line per fault, at most 20; empty without faults.

    Raises
    ------
    InputError
        The file can't be read.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> written = ov.export.export(result, "hjif", "match.hjif")
    >>> ov.export.check_clip("match.hjif")
    []
    """
    data = _file_bytes(validation.path(path, "a clip"))
    try:
        document = _document(data, Path(path).suffix)
    except InputError as error:
        return [str(error)]
    model = _model_of(document)
    if model is None:
        return [f"has none of {', '.join(_MODELS)}; must be {FORMATS}"]
    if model is Android and "description" not in document:
        return validate(Waveform, document["waveform"])[:MAX_FAULTS]
    return validate(model, document)[:MAX_FAULTS]


def _xml(data: bytes) -> ElementTree.Element:
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise InputError("not XML of a clip: its document type may expand to gigabytes")
    try:
        return ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"not XML: {error}") from None


POINTS = 64
Layer = Literal["tactor", "click", "both"]

_DULL_MS, _SHARP_MS = 60.0, 12.0


def amplitude_profile(clip: DecodedClip, count: int = POINTS) -> tuple[float, ...]:
    """Return the clip's amplitude, with its strikes, at `count` positions; its highest is 1."""
    level = clip.played
    edges = np.linspace(0, len(level), count + 1).astype(np.int64)[:-1]
    highest = np.maximum.reduceat(level, np.minimum(edges, len(level) - 1))
    if highest.max() <= 0.0:
        raise InputError("the clip is silent")
    return tuple(round(float(value), 4) for value in highest / highest.max())


def modes(clip: DecodedClip) -> tuple[ClickMode, ...]:
    """Return the clip's strikes as modes, the strongest first, each pitch once."""
    found: list[Transient] = []
    for strike in sorted(clip.transients, key=lambda strike: -strike.amplitude):
        if strike.amplitude > 0.0 and all(
            abs(strike.sharpness - other.sharpness) > 0.02 for other in found
        ):
            found.append(strike)
    if not found:
        raise InputError("the clip has no strikes (transients, emphasis) to make a click of")
    return tuple(_mode(strike, found[0].amplitude) for strike in found[:MAX_MODES])


def _mode(strike: Transient, loudest: float) -> ClickMode:
    hz = DULL_HZ * (SHARP_HZ / DULL_HZ) ** strike.sharpness
    decay = _DULL_MS * (_SHARP_MS / _DULL_MS) ** strike.sharpness
    gain = max(MODE_PARAMETERS["gain_db"].low, 20.0 * math.log10(strike.amplitude / loudest))
    return ClickMode(round(hz, 1), round(decay, 1), round(gain, 1))


def with_layer(preset: Preset, kind: str, clip: DecodedClip, layer: Layer) -> Preset:
    """Return a preset with a clip in one of its kinds; a new kind extends `default`."""
    base: EventKind = preset.kinds[preset.kind_for(kind) or DEFAULT_KIND]
    if kind not in preset.kinds:
        base = replace(base, aliases=())
    if layer in ("tactor", "both"):
        base = replace(base, points=amplitude_profile(clip))
    # of both, a clip without strikes leaves the click as it is
    if layer == "click" or (layer == "both" and clip.transients):
        base = replace(base, modes=modes(clip))
    return replace(preset, kinds={**preset.kinds, kind: base})
