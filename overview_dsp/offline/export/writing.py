"""Writers of the haptic formats to which a gesture can be exported."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.atomic import write_file
from overview_dsp.files.sound import save_sound
from overview_dsp.offline.export import ahap, android, haptic, hjif
from overview_dsp.offline.export.clip import Clip, PerceptualError, clip_of, perceptual_error
from overview_dsp.offline.export.document import encoded
from overview_dsp.offline.rendering.offline import RenderResult
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.public import counted, short

POINTS_PER_S = 50.0
"""Default number of amplitude points per second (Meta's studio has 40; fast sweeps need more)."""

Played = dict[str, FloatArray]  # amplitude at each millisecond on each player of a document


def played_by(result: RenderResult[Trace | None], to: str) -> FloatArray:
    """Return the level of a render, at each millisecond, on the first player of a format."""
    clip = clip_of(result)
    _, played, _ = _BAKES[to](clip, max(2, round(POINTS_PER_S * clip.duration_s)))
    return next(iter(played.values()))


@dataclass(frozen=True)
class ExportResult:
    """Result of `export`.

    Attributes
    ----------
    files : tuple of path
        Files in the order of writing.
    error : PerceptualError or None
        Error against the rendered envelope, including strikes, on the first of `players`; None if
        the samples were written.
    points, transients : int
        Number of amplitude points, and number of strikes.
    players : mapping of str to PerceptualError
        Error on each player of the format.

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
"""Function of a clip and a budget of points: files by suffix, levels on players, points used."""


def _ahap(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    vibration, strikes = ahap.vibration_pattern(clip, budget), ahap.strikes_pattern(clip)
    points = sum(len(curve.ParameterCurveControlPoints) for curve in vibration.curves)
    files = {".ahap": encoded(vibration)}
    if clip.transients:
        files[".strikes.ahap"] = encoded(strikes)
    level, _ = ahap.decoded(vibration)
    _, transients = ahap.decoded(strikes) if clip.transients else (level, [])
    played = {
        f"Core Haptics, strikes of {length} ms": ahap.with_transients(level, transients, length)
        for length in ahap.TRANSIENTS_MS
    }
    return files, played, points


def _haptic(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = haptic.document(clip, budget)
    players = {"Quest": haptic.on_quest(made), "Android, steps of 10 ms": haptic.on_android(made)}
    return {".haptic": encoded(made)}, players, len(made.points)


def _hjif(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = hjif.document(clip, budget)
    points = len(made.perceptions[0].channels[0].bands[0].effects[0].keyframes)
    return {".hjif": encoded(made)}, {"MPEG reference": hjif.decoded(made)[2]}, points


def _android(clip: Clip, budget: int) -> tuple[dict[str, bytes], Played, int]:
    made = android.document(clip)
    played = {
        "Android waveform": android.waveform_played(made.waveform),
        "Android envelope effects": android.envelopes_played(made.envelopeEffects),
    }
    files = {".json": encoded(made), ".xml": android.waveform_xml(made.waveform)}
    return files, played, len(made.waveform.timings)


_BAKES: Mapping[str, Bake] = {"ahap": _ahap, "haptic": _haptic, "hjif": _hjif, "android": _android}
"""Writers by format; `wav4` is written from the samples."""

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
        Result of `render`, with trace.
    to : str
        One of `formats()`.
    path : str or path
        Path of the first file; others have the same name with another suffix.
    points_per_s : float
        Amplitude points per second of the clip, 1 to 1000 (formats with fixed steps don't use it).

    Returns
    -------
    ExportResult
        Files and their perceptual error.

    Raises
    ------
    InputError
        The format is unknown, the gesture has no vibration or is too long, or the path can't be
        written.
    OutputError
        The disk is full.

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
        raise InputError(f"result is {quoted(result)}; must be a result of ov.render")
    if not isinstance(to, str) or to not in NAMES:
        raise InputError(f"to is {quoted(to)}; must be one of {', '.join(NAMES)}")
    # written so that NaN fails
    points_per_s = validation.within(points_per_s, "points_per_s", 1.0, 1000.0)
    target = validation.path(path, "path")
    if to == "wav4":
        # for pads with voice coils on channels 3 and 4 (DualSense): clicks on both sides, tactor
        save_sound(target, result.samples[:, [0, 0, 1, 1]], result.sample_rate, "PCM_16")
        return ExportResult((target,), None, 0, 0)
    clip = clip_of(result)
    files, played, points = _BAKES[to](clip, max(2, round(points_per_s * clip.duration_s)))
    stem = target.with_suffix("") if target.suffix else target
    places = [target, *(stem.with_name(stem.name + suffix) for suffix in list(files)[1:])]
    for place, data in zip(places, files.values(), strict=True):
        write_file(place, data)
    players = {
        name: perceptual_error(level, clip.level, clip.transients) for name, level in played.items()
    }
    error = next(iter(players.values()))
    return ExportResult(tuple(places), error, points, len(clip.transients), players)
