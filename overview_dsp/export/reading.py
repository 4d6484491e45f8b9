"""Haptic clips of others: AHAP and `.haptic` files, read to what they make a device do.

What comes back is an amplitude for each millisecond and the strikes, by the same laws as exports
are written (`ahap`, `haptic`): so a clip that was exported comes back as it was.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.export.clip import LEVELS_PER_S, MAX_CLIP_S, Transient
from overview_dsp.public.reprs import counted
from overview_dsp.timeline.checks import number

MAX_BYTES = 8_000_000
MAX_ENTRIES = 100_000
_CONTROL = "HapticIntensityControl"


@dataclass(frozen=True, eq=False)
class PlayedClip:
    """What a haptic clip plays.

    Attributes
    ----------
    level : float64 (n,)
        Amplitude at each millisecond, 0 to 1.
    transients : tuple of Transient
        Its strikes, in order.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> _ = ov.export.export(result, "ahap", "match.ahap")
    >>> clip = ov.export.read_clip("match.ahap")
    >>> float(clip.level.max()) <= 1.0
    True
    """

    level: NDArray[np.float64]
    transients: tuple[Transient, ...]

    def __repr__(self) -> str:
        return f"<PlayedClip: {len(self.level)} ms, {counted(len(self.transients), 'strike')}>"


def read_clip(path: str | os.PathLike[str]) -> PlayedClip:
    """Read an AHAP or `.haptic` file, detected from its content.

    Parameters
    ----------
    path : str or path
        The file.

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
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> _ = ov.export.export(result, "ahap", "match.ahap")
    >>> clip = ov.export.read_clip("match.ahap")
    >>> len(clip.level) > 500
    True
    """
    where = os.fspath(path)
    try:
        size = Path(path).stat().st_size
        data = Path(path).read_bytes() if size <= MAX_BYTES else None
    except (OSError, ValueError) as error:
        raise InputError(f"{where}: can't be read ({error})") from None
    if data is None:
        raise InputError(f"{where}: larger than {MAX_BYTES:,} bytes; a clip is a short JSON file")
    try:
        document = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: not JSON: {error}") from None
    try:
        if isinstance(document, dict) and "Pattern" in document:
            return _ahap(document)
        if isinstance(document, dict) and "signals" in document:
            return _haptic(document)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    raise InputError(f"{where}: neither AHAP (with a Pattern) nor .haptic (with signals)")


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
    end = max([stop for _, stop, _ in spans] + [strike.time_s for strike in strikes], default=0.0)
    if end <= 0.0:
        raise InputError("Pattern: vibrates at no time")
    times = np.arange(_count(end)) / LEVELS_PER_S
    base = np.zeros(len(times))
    for start, stop, intensity in spans:
        inside = (times >= start) & (times <= stop)
        base[inside] = np.maximum(base[inside], intensity)
    if steps:
        steps.sort(key=lambda step: step[0])  # stable: equal times keep their order
        at, value = np.array(steps).T
        # before the first point, intensity is as the events have it
        base *= np.where(times < at[0], 1.0, np.interp(times, at, np.clip(value, 0.0, 1.0)))
    return PlayedClip(base**2, tuple(sorted(strikes, key=lambda strike: strike.time_s)))


def _curve(curve: dict[str, Any], place: str) -> list[tuple[float, float]]:
    if curve.get("ParameterID") != _CONTROL:
        return []
    start = _seconds(curve.get("Time"), f"{place}.Time")
    points = _entries(curve.get("ParameterCurveControlPoints"), f"{place}.ControlPoints")
    return [
        (
            start + _seconds(point.get("Time"), f"{place}.ControlPoints[{k}].Time"),
            number(point.get("ParameterValue"), f"{place}.ControlPoints[{k}].ParameterValue"),
        )
        for k, point in enumerate(points)
    ]


def _step(parameter: dict[str, Any], place: str) -> list[tuple[float, float]]:
    if parameter.get("ParameterID") != _CONTROL:
        return []
    time = _seconds(parameter.get("Time"), f"{place}.Time")
    return [(time, number(parameter.get("ParameterValue"), f"{place}.ParameterValue"))]


def _parameters(entries: Any, place: str) -> dict[str, float]:
    found = {}
    for k, entry in enumerate(_entries(entries, place)):
        value = number(entry.get("ParameterValue"), f"{place}[{k}].ParameterValue")
        if entry.get("ParameterID") in ("HapticIntensity", "HapticSharpness"):
            found[str(entry["ParameterID"])] = _unit(value, f"{place}[{k}].ParameterValue")
    return found


# --- .haptic ------------------------------------------------------------------------------------


def _haptic(document: dict[str, Any]) -> PlayedClip:
    place = "signals.continuous.envelopes"
    signals = _table(document["signals"], "signals")
    continuous = _table(signals.get("continuous"), "signals.continuous")
    points = _entries(_table(continuous.get("envelopes"), place).get("amplitude"), place)
    place += ".amplitude"
    if len(points) < 2:
        raise InputError(f"{place}: {len(points)} points; an envelope has two or more")
    times, levels, strikes = [], [], []
    for k, point in enumerate(points):
        here = f"{place}[{k}]"
        times.append(_seconds(point.get("time"), f"{here}.time"))
        levels.append(_unit(number(point.get("amplitude"), f"{here}.amplitude"), here))
        if k and times[-1] < times[-2]:
            raise InputError(f"{here}.time = {times[-1]:g} is before the point above it")
        if "emphasis" in point:
            emphasis = _table(point["emphasis"], f"{here}.emphasis")
            strength, sharpness = (
                _unit(number(emphasis.get(key), f"{here}.emphasis.{key}"), here)
                for key in ("amplitude", "frequency")
            )
            strikes.append(Transient(times[-1], strength, sharpness, ""))
    if times[-1] <= 0.0:
        raise InputError(f"{place}: the clip has no length")
    grid = np.arange(_count(times[-1])) / LEVELS_PER_S
    return PlayedClip(np.interp(grid, times, levels), tuple(strikes))


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


def _unit(part: float, place: str) -> float:
    if not 0.0 <= part <= 1.0:
        raise InputError(f"{place} = {part:g}; it is 0 to 1")
    return part
