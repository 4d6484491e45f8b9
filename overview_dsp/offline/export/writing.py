"""The formats a gesture can be baked to, and the files each one writes.

A rendered gesture as a clip: its vibration by the millisecond, and its strikes.

Both are what the engine rendered, so a clip has the physics in it: the speed of the hand, the
recoil, the event that lets go late.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.errors import InputError, shown
from overview_dsp.files.atomic import whole_file
from overview_dsp.files.sound import save_sound
from overview_dsp.offline.export import ahap, android, haptic, hjif
from overview_dsp.offline.export import android as android_player
from overview_dsp.offline.export.clip import FLOOR, LEVELS_PER_S, MAX_CLIP_S, Clip, felt_level
from overview_dsp.offline.export.felt_error import FeltError, felt_error
from overview_dsp.offline.export.strikes import strikes_of
from overview_dsp.offline.rendering.offline import Result
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.public import counted, short


def clip_of(result: Result[Trace | None]) -> Clip:
    """Make a clip of a rendered gesture, up to where its vibration has died away.

    Raises
    ------
    InputError
        It was rendered without a trace, nothing vibrates, or it is longer than ten minutes.
    """
    if result.trace is None:
        raise InputError("rendered without a trace: its envelope is needed, render with trace=True")
    if len(result.samples) > MAX_CLIP_S * result.sample_rate:
        raise InputError(
            f"{len(result.samples) / result.sample_rate:.0f} s of vibration; a clip holds up to "
            f"{MAX_CLIP_S:g} s, use a shorter gesture"
        )
    preset = result.engine.preset
    level = np.minimum(_by_millisecond(result.trace.envelope, result.sample_rate), 1.0)
    if preset.values["tactor.mute"]:
        level[:] = 0.0
    felt = np.flatnonzero(level > FLOOR)
    if not len(felt):
        raise InputError(
            "nothing vibrates in this gesture; use a longer sweep or unmute the tactor"
        )
    level = np.append(level[: felt[-1] + 1], 0.0)
    return Clip(
        result.engine.timeline.title,
        level,
        preset.number("tactor.frequency_hz"),
        strikes_of(result, felt_level(level)),
        result.engine.surface,
    )


def _by_millisecond(envelope: NDArray[np.float64], sample_rate: float) -> NDArray[np.float64]:
    """RMS of the envelope around each millisecond."""
    energy = np.concatenate([[0.0], np.cumsum(envelope * envelope)])
    frames = np.arange(len(energy), dtype=np.float64)
    count = math.ceil(len(envelope) / sample_rate * LEVELS_PER_S) + 1
    edges = (np.arange(count + 1) - 0.5) / LEVELS_PER_S * sample_rate
    edges = np.clip(edges, 0.0, len(envelope))
    width = np.maximum(np.diff(edges), 1e-9)
    mean = np.diff(np.interp(edges, frames, energy)) / width
    return np.asarray(np.sqrt(np.maximum(mean, 0.0)))


POINTS_PER_S = 50.0
"""Amplitude points a second by default (Meta's studio has 40; a sweep of a second needs more)."""

Played = dict[str, NDArray[np.float64]]
"""What each player makes of a document: the amplitude at each millisecond."""


@dataclass(frozen=True)
class Exported:
    """What `export` wrote.

    Attributes
    ----------
    files : tuple of path
        In the order they were written.
    error : FeltError or None
        Against the rendered envelope, strikes included, on the first of `players`; None where the
        samples themselves were written.
    points, transients : int
        How many points of amplitude, and how many strikes.
    players : mapping of str to FeltError
        The same on each player that the format is for.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> ov.export.export(result, "wav4", "pad.wav").files[0].name
    'pad.wav'
    """

    files: tuple[Path, ...]
    error: FeltError | None
    points: int
    transients: int
    players: Mapping[str, FeltError] = field(default_factory=dict)

    def __repr__(self) -> str:
        files = " and ".join(short(path.name) for path in self.files)
        return f"<Exported: {files}, {counted(self.transients, 'strike')}>"


@dataclass(frozen=True)
class Format:
    """A format: its suffix, what it is, and what it writes for (clip, points)."""

    name: str
    suffix: str
    words: str
    bake: Callable[[Clip, int], tuple[dict[str, bytes], Played, int]]


def _text(document: Any) -> bytes:
    return (json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _ahap(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    vibration, strikes = ahap.vibration_pattern(clip, budget), ahap.strikes_pattern(clip)
    points = sum(
        len(entry["ParameterCurve"]["ParameterCurveControlPoints"])
        for entry in vibration["Pattern"]
        if "ParameterCurve" in entry
    )
    files = {".ahap": _text(vibration)}
    if clip.transients:
        files[".strikes.ahap"] = _text(strikes)
    played = {
        f"Core Haptics, strikes of {length} ms": ahap.played(vibration, strikes, length)
        for length in ahap.TRANSIENTS_MS
    }
    return files, played, points


def _haptic(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = haptic.document(clip, budget)
    points = len(made["signals"]["continuous"]["envelopes"]["amplitude"])
    return {".haptic": _text(made)}, {"Quest": haptic.played(made)}, points


def _hjif(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = hjif.document(clip, budget)
    points = len(made["perceptions"][0]["channels"][0]["bands"][0]["effects"][0]["keyframes"])
    return {".hjif": _text(made)}, {"MPEG reference": hjif.played(made)}, points


def _android(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = android.document(clip)
    files = {".json": _text(made), ".xml": android.waveform_xml(clip)}
    played = {
        "Android waveform": android_player.waveform_played(made),
        "Android envelope effects": android_player.envelopes_played(made),
    }
    return files, played, len(made["waveform"]["timings"])


FORMATS: Mapping[str, Format] = MappingProxyType(
    {
        made.name: made
        for made in (
            Format("ahap", ".ahap", "Apple's haptic patterns, vibration and strikes", _ahap),
            Format("haptic", ".haptic", "Meta's haptic clip 1.0", _haptic),
            Format("hjif", ".hjif", "MPEG haptics, with the friction itself", _hjif),
            Format(
                "android", ".json", "Android waveform (JSON, XML) and envelope effects", _android
            ),
        )
    }
)
"""Formats of amplitude points, by name; `wav4` is written besides."""

NAMES = (*FORMATS, "wav4")


def formats() -> tuple[str, ...]:
    """List the formats that `export` writes.

    Returns
    -------
    tuple of str
        Their names.

    Examples
    --------
    >>> ov.export.formats()
    ('ahap', 'haptic', 'hjif', 'android', 'wav4')
    """
    return NAMES


def export(
    result: Result[Trace | None],
    to: str,
    path: str | os.PathLike[str],
    points_per_s: float = POINTS_PER_S,
) -> Exported:
    """Write a rendered gesture in a haptic format.

    Parameters
    ----------
    result : Result
        Of `render`, with its trace.
    to : str
        One of `formats()`.
    path : str or path
        Of the first file; the others lie beside it under the same name.
    points_per_s : float
        Amplitude points to spend, a second of the clip, 1 to 1000 (formats of fixed steps don't
        take it).

    Returns
    -------
    Exported
        The files, and how far they are from what was felt.

    Raises
    ------
    InputError
        An unknown format, nothing to vibrate, too long, a place that can't be written.
    OutputError
        A full disk.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> written = ov.export.export(result, "ahap", "match.ahap")
    >>> [path.name for path in written.files]
    ['match.ahap', 'match.strikes.ahap']
    >>> written.error.median_db < 2.3
    True
    """
    if not hasattr(result, "samples"):
        raise InputError(f"result is {shown(result)}; give what ov.render returns")
    if not isinstance(to, str) or to not in NAMES:
        raise InputError(f"no export format is called {shown(to)}; it is one of {', '.join(NAMES)}")
    # written so that NaN fails
    points_per_s = validation.real(points_per_s, "points_per_s")
    if not 1.0 <= points_per_s <= 1000.0:
        raise InputError(f"{points_per_s:g} points a second; it is 1 to 1000")
    target = validation.path(path, "path")
    if to == "wav4":
        # for pads whose voice coils are channels 3 and 4 (DualSense): clicks on both sides, tactor
        save_sound(target, result.samples[:, [0, 0, 1, 1]], result.sample_rate, "PCM_16")
        return Exported((target,), None, 0, 0)
    clip = clip_of(result)
    budget = max(2, round(points_per_s * clip.duration_s))
    files, played, points = FORMATS[to].bake(clip, budget)
    stem = target.with_suffix("") if target.suffix else target
    written = []
    for suffix, data in files.items():
        place = target if suffix == FORMATS[to].suffix else stem.with_name(stem.name + suffix)
        with whole_file(place) as temporary:
            temporary.write_bytes(data)
        written.append(place)
    players = {name: felt_error(level, clip.level) for name, level in played.items()}
    error = next(iter(players.values()))
    return Exported(tuple(written), error, points, len(clip.transients), players)
