"""The formats a gesture can be exported to, and the files each one writes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.errors import InputError, shown
from overview_dsp.files.atomic import whole_file
from overview_dsp.files.sound import save_sound
from overview_dsp.offline.export import ahap, android, haptic, hjif
from overview_dsp.offline.export.clip import Clip, PerceptualError, clip_of, perceptual_error
from overview_dsp.offline.export.document import encoded
from overview_dsp.offline.rendering.offline import RenderResult
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.public import counted, short

POINTS_PER_S = 50.0
"""Amplitude points a second by default (Meta's studio has 40; a sweep of a second needs more)."""

Played = dict[str, NDArray[np.float64]]
"""What each player makes of a document: the amplitude at each millisecond."""


@dataclass(frozen=True)
class ExportResult:
    """What `export` wrote.

    Attributes
    ----------
    files : tuple of path
        In the order they were written.
    error : PerceptualError or None
        Against the rendered envelope, strikes included, on the first of `players`; None where the
        samples themselves were written.
    points, transients : int
        How many points of amplitude, and how many strikes.
    players : mapping of str to PerceptualError
        The same on each player that the format is for.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> ov.export.export(result, "wav4", "pad.wav").files[0].name
    'pad.wav'
    """

    files: tuple[Path, ...]
    error: PerceptualError | None
    points: int
    transients: int
    players: Mapping[str, PerceptualError] = field(default_factory=dict)

    def __repr__(self) -> str:
        files = " and ".join(short(path.name) for path in self.files)
        return f"<ExportResult: {files}, {counted(self.transients, 'strike')}>"


Bake = Callable[[Clip, int], tuple[dict[str, bytes], Played, int]]
"""Of a clip and a budget of points: files by suffix, what players make of them, points used."""


def _ahap(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    vibration, strikes = ahap.vibration_pattern(clip, budget), ahap.strikes_pattern(clip)
    points = sum(len(curve.ParameterCurveControlPoints) for curve in vibration.curves)
    files = {".ahap": encoded(vibration)}
    if clip.transients:
        files[".strikes.ahap"] = encoded(strikes)
    level, _ = ahap.decoded(vibration)
    _, struck = ahap.decoded(strikes) if clip.transients else (level, [])
    played = {
        f"Core Haptics, strikes of {length} ms": ahap.with_transients(level, struck, length)
        for length in ahap.TRANSIENTS_MS
    }
    return files, played, points


def _haptic(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = haptic.document(clip, budget)
    played = haptic.with_emphasis(*haptic.decoded(made))
    return {".haptic": encoded(made)}, {"Quest": played}, len(made.points)


def _hjif(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = hjif.document(clip, budget)
    points = len(made.perceptions[0].channels[0].bands[0].effects[0].keyframes)
    return {".hjif": encoded(made)}, {"MPEG reference": hjif.played(made)}, points


def _android(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = android.document(clip)
    played = {
        "Android waveform": android.waveform_played(made.waveform),
        "Android envelope effects": android.envelopes_played(made.envelopeEffects),
    }
    files = {".json": encoded(made), ".xml": android.waveform_xml(made.waveform)}
    return files, played, len(made.waveform.timings)


_BAKES: Mapping[str, Bake] = MappingProxyType(
    {"ahap": _ahap, "haptic": _haptic, "hjif": _hjif, "android": _android}
)
"""By format; `wav4` is written from the samples."""

NAMES = (*_BAKES, "wav4")


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
    result: RenderResult[Trace | None],
    to: str,
    path: str | os.PathLike[str],
    points_per_s: float = POINTS_PER_S,
) -> ExportResult:
    """Write a rendered gesture in a haptic format.

    Parameters
    ----------
    result : RenderResult
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
    ExportResult
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
        return ExportResult((target,), None, 0, 0)
    clip = clip_of(result)
    budget = max(2, round(points_per_s * clip.duration_s))
    files, played, points = _BAKES[to](clip, budget)
    stem = target.with_suffix("") if target.suffix else target
    written: list[Path] = []
    for suffix, data in files.items():
        place = stem.with_name(stem.name + suffix) if written else target
        with whole_file(place) as temporary:
            temporary.write_bytes(data)
        written.append(place)
    players = {name: perceptual_error(level, clip.level) for name, level in played.items()}
    error = next(iter(players.values()))
    return ExportResult(tuple(written), error, points, len(clip.transients), players)
