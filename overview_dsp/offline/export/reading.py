"""Haptic clips of others: AHAP and `.haptic` files, read to what they make a device do.

What comes back is an amplitude for each millisecond and the strikes, by the same laws as exports
are written (`ahap`, `haptic`): so a clip that was exported comes back as it was. Of an AHAP clip in
two files, vibration and strikes, either one names both.

A haptic clip as a layer of a preset: its vibration as an event's friction, its strikes as modes.

The friction's course over the event is the clip's amplitude over its length; what was time becomes
the way over the event, so the hand plays the clip, as fast as it moves and backwards too. Strikes
become modes of the click: sharpness is pitch, strength is level.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.design.presets.parameters import MODE_PARAMETERS
from overview_dsp.errors import InputError
from overview_dsp.kernels.layout import MAX_MODES
from overview_dsp.offline.export.ahap import TRANSIENTS_MS, with_transients
from overview_dsp.offline.export.clip import LEVELS_PER_S, MAX_CLIP_S, Transient
from overview_dsp.offline.export.haptic import with_emphasis
from overview_dsp.offline.export.strikes import DULL_HZ, SHARP_HZ
from overview_dsp.public import counted
from overview_dsp.validation import number

MAX_BYTES = 8_000_000
MAX_ENTRIES = 100_000
_CONTROL = "HapticIntensityControl"

SUFFIXES = (".ahap", ".haptic")
PLAIN = SUFFIXES[0]
PAIRS = ((PLAIN, ".strikes.ahap"), ("_continuous.ahap", "_transients.ahap"))
"""How the two files of an AHAP clip are called: ours, and Meta's."""


@dataclass(frozen=True, eq=False)
class PlayedClip:
    """What a haptic clip plays.

    Attributes
    ----------
    level : float64 (n,)
        Amplitude at each millisecond, 0 to 1.
    transients : tuple of Transient
        Its strikes, in order.
    played : float64 (m,)
        Both together, as the format's player gives it: Core Haptics with transients of 12 ms, the
        Quest.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> _ = ov.export.export(result, "ahap", "match.ahap")
    >>> clip = ov.export.read_clip("match.ahap")
    >>> float(clip.level.max()) <= 1.0
    True
    """

    level: NDArray[np.float64]
    transients: tuple[Transient, ...]
    played: NDArray[np.float64]

    def __repr__(self) -> str:
        return f"<PlayedClip: {len(self.level)} ms, {counted(len(self.transients), 'strike')}>"


def read_clip(path: str | os.PathLike[str]) -> PlayedClip:
    """Read an AHAP or `.haptic` file, detected from its content.

    Parameters
    ----------
    path : str or path
        The file; of an AHAP clip in two files (`x.ahap` and `x.strikes.ahap`, `x_continuous.ahap`
        and `x_transients.ahap`), either one.

    Returns
    -------
    PlayedClip
        Amplitudes and strikes.

    Raises
    ------
    InputError
        Not readable, too large, not JSON, neither of the two, or a broken entry: which one.

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
    return found[0] if len(found) == 1 else _apple(level, strikes)


def paired(path: Path) -> tuple[Path, ...]:
    """The files of the clip that a file is of: vibration and strikes, if they lie beside it."""
    for vibration, strikes in PAIRS:
        for own, other in ((vibration, strikes), (strikes, vibration)):
            # a suffix that is part of the other one: match.strikes.ahap is no vibration
            if not path.name.endswith(own) or (own == PLAIN and path.name.endswith(strikes)):
                continue
            beside = path.with_name(path.name.removesuffix(own) + other)
            if beside.is_file():
                return (path, beside) if own == vibration else (beside, path)
    return (path,)


def clips_in(path: str | os.PathLike[str], kind: str | None) -> dict[str, Path]:
    """The clips of a file or a folder, by the kind of event that each is for.

    Parameters
    ----------
    path
        A clip's file, or a folder with some.
    kind
        Given: of a file, or of a folder's only clip. None: a folder's clips are named after kinds.

    Raises
    ------
    InputError
        No kind for a file, no clip in a folder, several for one kind.
    """
    place = Path(path)
    if not place.is_dir():
        if kind is None:
            raise InputError(f"{place}: for which kind of event? give --as KIND")
        return {kind: place}
    found: dict[str, Path] = {}
    for one in sorted(place.iterdir()):
        if one.suffix.lower() in SUFFIXES and paired(one)[0] == one:
            name = next(
                (
                    one.name.removesuffix(end)
                    for end, _ in reversed(PAIRS)
                    if one.name.endswith(end)
                ),
                one.stem,
            )
            if name in found:
                raise InputError(f"{place}: two clips are called {name}; keep one of them")
            found[name] = one
    if not found:
        raise InputError(f"{place}: no clip is in this folder ({', '.join(SUFFIXES)})")
    if kind is None:
        return found
    if len(found) > 1:
        raise InputError(f"{place}: {len(found)} clips for one kind; leave --as out, or give one")
    (only,) = found.values()
    return {kind: only}


def load_document(path: str | os.PathLike[str]) -> Any:
    """Load a clip's JSON; InputError, a line that names the file, where it can't be."""
    where = os.fspath(path)
    try:
        size = Path(path).stat().st_size
        data = Path(path).read_bytes() if size <= MAX_BYTES else None
    except (OSError, ValueError) as error:
        raise InputError(f"{where}: can't be read ({error})") from None
    if data is None:
        raise InputError(f"{where}: larger than {MAX_BYTES:,} bytes; a clip is a short JSON file")
    try:
        return json.loads(data.decode("utf-8-sig"), parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: not JSON: {error}") from None


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _read(path: Path) -> PlayedClip:
    document = load_document(path)
    try:
        if isinstance(document, dict) and "Pattern" in document:
            return _ahap(document)
        if isinstance(document, dict) and "signals" in document:
            return _haptic(document)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    raise InputError(f"{path}: neither AHAP (with a Pattern) nor .haptic (with signals)")


# --- AHAP ---------------------------------------------------------------------------------------


def _ahap(document: dict[str, Any]) -> PlayedClip:
    spans: list[tuple[float, float, float]] = []
    strikes: list[Transient] = []
    steps: list[tuple[float, float]] = []
    pattern = _entries(document["Pattern"], "Pattern")
    for i, entry in enumerate(pattern):
        place = f"Pattern[{i}]"
        if "Event" in entry:
            event = _table(entry["Event"], f"{place}.Event")
            time = _seconds(event.get("Time"), f"{place}.Event.Time")
            parameters = _parameters(
                event.get("EventParameters", []), f"{place}.Event.EventParameters"
            )
            intensity = parameters.get("HapticIntensity", 1.0)
            kind = event.get("EventType")
            if kind == "HapticTransient":
                strike = intensity**2, parameters.get("HapticSharpness", 0.5)
                strikes.append(Transient(time, *strike, kind=""))
            elif kind == "HapticContinuous":
                length = _seconds(event.get("EventDuration"), f"{place}.Event.EventDuration")
                spans.append((time, time + length, intensity))
            # sounds (AudioContinuous, AudioCustom) vibrate nothing
        elif "ParameterCurve" in entry:
            steps += _curve(_table(entry["ParameterCurve"], place), place)
        elif "Parameter" in entry:
            steps += _step(_table(entry["Parameter"], place), place)
    if not spans and not strikes:
        raise InputError("Pattern: vibrates at no time")
    end = max([stop for _, stop, _ in spans] + [strike.time_s for strike in strikes])
    times = np.arange(_count(end)) / LEVELS_PER_S
    base = np.zeros(len(times))
    for start, stop, intensity in spans:
        inside = (times >= start) & (times <= stop)
        base[inside] = np.maximum(base[inside], intensity)
    if steps:
        steps.sort(key=lambda step: step[0])  # stable: equal times keep their order
        at, value = np.array(steps).T
        # before the first point, intensity is as the events have it
        control = np.where(times < at[0], 1.0, np.interp(times, at, value))
        base *= control
        # a pattern's curves modulate its transients too
        strikes = [
            replace(one, amplitude=one.amplitude * float(control[round(one.time_s * 1000)]) ** 2)
            for one in strikes
        ]
    return _apple(base**2, sorted(strikes, key=lambda strike: strike.time_s))


def _apple(level: NDArray[np.float64], strikes: Sequence[Transient]) -> PlayedClip:
    struck = [(strike.time_s, strike.amplitude) for strike in strikes]
    return PlayedClip(level, tuple(strikes), with_transients(level, struck, TRANSIENTS_MS[0]))


def _curve(curve: dict[str, Any], place: str) -> list[tuple[float, float]]:
    if curve.get("ParameterID") != _CONTROL:
        return []
    start = _seconds(curve.get("Time"), f"{place}.Time")
    points = _entries(curve.get("ParameterCurveControlPoints"), f"{place}.ControlPoints")
    return [
        (
            start + _seconds(point.get("Time"), f"{place}.ControlPoints[{k}].Time"),
            _part(point.get("ParameterValue"), f"{place}.ControlPoints[{k}].ParameterValue"),
        )
        for k, point in enumerate(points)
    ]


def _step(parameter: dict[str, Any], place: str) -> list[tuple[float, float]]:
    if parameter.get("ParameterID") != _CONTROL:
        return []
    time = _seconds(parameter.get("Time"), f"{place}.Time")
    return [(time, _part(parameter.get("ParameterValue"), f"{place}.ParameterValue"))]


def _parameters(entries: Any, place: str) -> dict[str, float]:
    found = {}
    for k, entry in enumerate(_entries(entries, place)):
        value = number(entry.get("ParameterValue"), f"{place}[{k}].ParameterValue")
        if entry.get("ParameterID") in ("HapticIntensity", "HapticSharpness"):
            found[str(entry["ParameterID"])] = _part(value, f"{place}[{k}].ParameterValue")
    return found


# --- .haptic ------------------------------------------------------------------------------------


def _haptic(document: dict[str, Any]) -> PlayedClip:
    place = "signals.continuous.envelopes"
    signals = _table(document["signals"], "signals")
    continuous = _table(signals.get("continuous"), "signals.continuous")
    envelopes = _table(continuous.get("envelopes"), place)
    for k, point in enumerate(_entries(envelopes.get("frequency", []), f"{place}.frequency")):
        # pitch isn't taken, but a broken clip is refused
        _seconds(point.get("time"), f"{place}.frequency[{k}].time")
        _part(point.get("frequency"), f"{place}.frequency[{k}].frequency")
    place += ".amplitude"
    points = _entries(envelopes.get("amplitude"), place)
    if len(points) < 2:
        raise InputError(f"{place}: {len(points)} points; an envelope has two or more")
    times, levels, strikes = [], [], []
    for k, point in enumerate(points):
        here = f"{place}[{k}]"
        times.append(_seconds(point.get("time"), f"{here}.time"))
        levels.append(_part(point.get("amplitude"), f"{here}.amplitude"))
        if k and times[-1] < times[-2]:
            raise InputError(f"{here}.time = {times[-1]:g} is before the point above it")
        if "emphasis" in point:
            emphasis = _table(point["emphasis"], f"{here}.emphasis")
            strength, sharpness = (
                _part(emphasis.get(key), f"{here}.emphasis.{key}")
                for key in ("amplitude", "frequency")
            )
            strikes.append(Transient(times[-1], strength, sharpness, ""))
    if times[-1] <= 0.0:
        raise InputError(f"{place}: the clip has no length")
    grid = np.arange(_count(times[-1])) / LEVELS_PER_S
    level = np.interp(grid, times, levels)
    struck = [(strike.time_s, strike.amplitude, strike.sharpness) for strike in strikes]
    return PlayedClip(level, tuple(strikes), with_emphasis(level, struck))


# --- entries ------------------------------------------------------------------------------------


def _count(end_s: float) -> int:
    return round(end_s * LEVELS_PER_S) + 1


def _entries(value: Any, place: str) -> list[dict[str, Any]]:
    if not isinstance(value, list):
        raise InputError(f"{place} isn't a list")
    if len(value) > MAX_ENTRIES:
        raise InputError(f"{place} has {len(value)} entries; up to {MAX_ENTRIES} are read")
    for k, entry in enumerate(value):
        _table(entry, f"{place}[{k}]")
    return value


def _table(value: Any, place: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{place} isn't an object")
    return value


def _seconds(value: Any, place: str) -> float:
    seconds = number(value, place)
    if not 0.0 <= seconds <= MAX_CLIP_S:
        raise InputError(f"{place} = {seconds:g} s; it is 0 to {MAX_CLIP_S:g}")
    return seconds


def _part(value: Any, place: str) -> float:
    part = number(value, place)
    if not 0.0 <= part <= 1.0:
        raise InputError(f"{place} = {part:g}; it is 0 to 1")
    return part


POINTS = 64
Layer = Literal["tactor", "click", "both"]

_DULL_MS, _SHARP_MS = 60.0, 12.0


def course(clip: PlayedClip, count: int = POINTS) -> tuple[float, ...]:
    """The clip's amplitude, strikes among it, at `count` positions, its highest 1."""
    level = clip.played
    edges = np.linspace(0, len(level), count + 1).astype(np.int64)
    edges = np.minimum(edges[:-1], len(level) - 1)
    highest = np.maximum.reduceat(level, edges)
    if highest.max() <= 0.0:
        raise InputError("the clip is silent")
    return tuple(round(float(value), 4) for value in highest / highest.max())


def modes(clip: PlayedClip) -> tuple[ClickMode, ...]:
    """The clip's strikes as modes, the strongest first, a pitch once."""
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
    ratio = strike.sharpness
    hz = DULL_HZ * (SHARP_HZ / DULL_HZ) ** ratio
    decay = _DULL_MS * (_SHARP_MS / _DULL_MS) ** ratio
    lowest = MODE_PARAMETERS["gain_db"].low
    gain = max(lowest, 20.0 * math.log10(strike.amplitude / loudest))
    return ClickMode(round(hz, 1), round(decay, 1), round(gain, 1))


def with_layer(preset: Preset, kind: str, clip: PlayedClip, layer: Layer) -> Preset:
    """The preset with a clip laid into one of its kinds, which is made from `default` if new."""
    base: EventKind = replace(preset.kinds[preset.kind_for(kind) or DEFAULT_KIND], also=())
    if layer in ("tactor", "both"):
        base = replace(base, points=course(clip))
    # of both, a clip without strikes leaves the click as it is
    if layer == "click" or (layer == "both" and clip.transients):
        base = replace(base, modes=modes(clip))
    return replace(preset, kinds={**preset.kinds, kind: base})
