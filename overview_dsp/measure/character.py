"""What is left of a preset's character once it is as strong as any other: levels matched.

Of what a finger and an ear get in a stroke, these don't change with gain:

- *sharpness*: how fast the vibration rises to its knocks, dB/s (median);
- *density*: knocks that are felt apart, a second;
- *rhythm*: how uneven the pauses between them are (their spread over their median; 0 is a ticking);
- *duration*: how long a knock stays within 6 dB of its highest, ms (median);
- *pitch*: of the vibration, Hz;
- *brightness*: where the click's spectrum has its middle, Hz (median over what is loud of it);
- *ring*: how long a click takes to fall by 12 dB, ms (median).

Steps are ratios: a quarter for what touch tells by frequency or length (Israr and Tan 2006: 0.18 to
0.25), a factor of two for sharpness, as in `measure.report`; a quarter for brightness and ring, far
above what an ear needs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.layout import CLICK, TACTOR
from overview_dsp.measure.felt import (
    FALL_DB,
    GESTURES,
    KNOCK_HOP_S,
    STEP_DURATION,
    STEP_SHARPNESS,
    knocks,
    near_peak,
    strokes,
    window_db,
)
from overview_dsp.measure.report import steps_over_strokes
from overview_dsp.offline.rendering.offline import RenderResult, render

LEAST_DENSITY_HZ, LEAST_RHYTHM = 1.0, 0.2
"""Added before ratios are taken: a pulse a second is the least that is called a rhythm, and a fifth
of a pause the least that is called uneven."""

RISE_S = 0.030
_FFT = 2048
_LOUD_DB = 20.0
_RING_DB = 12.0


@dataclass(frozen=True)
class Character:
    """A stroke's character without its level; NaN for what it hasn't.

    Attributes
    ----------
    sharpness : float
        dB/s.
    density_hz, rhythm : float
        Knocks a second, and how uneven they come.
    duration_ms : float
        Of a knock.
    pitch_hz, brightness_hz : float
        Of the vibration and of the click.
    ring_ms : float
        Of a click.

    Examples
    --------
    >>> one = ov.measure.characters(football, match, {"fast": ov.sweep(1.0)})["fast"]
    >>> one.pitch_hz
    250.0
    """

    sharpness: float
    density_hz: float
    rhythm: float
    duration_ms: float
    pitch_hz: float
    brightness_hz: float
    ring_ms: float


_STEPS = {"sharpness": STEP_SHARPNESS}
_LEAST = {"density_hz": LEAST_DENSITY_HZ, "rhythm": LEAST_RHYTHM}


def characters(
    preset: Preset,
    timeline: Timeline,
    gestures: Mapping[str, Gesture] = GESTURES,
    sample_rate: float = 48_000,
) -> dict[str, Character]:
    """Measure the strokes of a preset on a timeline, whatever its gain.

    Parameters
    ----------
    preset : Preset
        What is felt and heard.
    timeline : Timeline
        What it is felt on.
    gestures : mapping of str to Gesture
        By name; slow, medium and fast sweeps and a tap if left out.
    sample_rate : float
        Hz.

    Returns
    -------
    dict of str to Character
        Each gesture's way out, and its recoil.

    Raises
    ------
    InputError
        A preset or a gesture that `render` refuses.

    Examples
    --------
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> quiet = football.with_changes({"tactor.gain_db": -6.0, "click.gain_db": -20.0})
    >>> one, other = (ov.measure.characters(preset, match, sweeps) for preset in (football, quiet))
    >>> ov.measure.level_matched_steps(one, other) < 0.5
    True
    """
    found = {}
    for name, gesture in gestures.items():
        result = render(timeline, preset, gesture, sample_rate)
        for stroke in strokes(result.trace.engaged, result.trace.cursor):
            way = name if stroke.name == "out" else f"{name} {stroke.name}"
            found[way] = _character(result, stroke.start, stroke.stop)
    return found


def level_matched_steps(first: Mapping[str, Character], second: Mapping[str, Character]) -> float:
    """Count the just noticeable steps between two presets once their levels are matched.

    In what they differ most in: the median of its steps over all strokes, recoils, which are much
    the same after any gesture, as one.

    Parameters
    ----------
    first, second : mapping of str to Character
        Of the same gestures on one timeline.

    Returns
    -------
    float
        Steps.

    Examples
    --------
    >>> same = ov.measure.characters(football, match, {"fast": ov.sweep(1.0)})
    >>> ov.measure.level_matched_steps(same, same)
    0.0
    """
    return steps_over_strokes({name: _differences(first[name], second[name]) for name in first})


def _differences(one: Character, other: Character) -> NDArray[np.float64]:
    found = []
    for field, a, b in zip(fields(Character), astuple(one), astuple(other), strict=True):
        least = _LEAST.get(field.name, 0.0)
        ratio = (a + least) / (b + least) if a + least > 0.0 and b + least > 0.0 else math.nan
        found.append(abs(math.log(ratio)) / math.log(_STEPS.get(field.name, STEP_DURATION)))
    return np.array(found)


def _character(result: RenderResult, start: int, stop: int) -> Character:
    rate = result.sample_rate
    level = window_db(result.samples[start:stop, TACTOR], rate, KNOCK_HOP_S)[1]
    peaks = knocks(level)
    pauses = np.diff(peaks)
    reach = round(RISE_S / KNOCK_HOP_S)
    befores = [level[max(0, peak - reach) : peak + 1] for peak in peaks]
    rises = [np.diff(before).max() / KNOCK_HOP_S for before in befores if len(before) > 1]
    lasts = [near_peak(level, int(peak), FALL_DB) * KNOCK_HOP_S * 1000.0 for peak in peaks]
    seconds = (stop - start) / rate
    brightness, ring = _timbre(result, start, stop)
    return Character(
        float(np.median(rises)) if rises else math.nan,
        len(peaks) / seconds,
        float(np.std(pauses) / np.median(pauses)) if len(pauses) > 2 else math.nan,
        float(np.median(lasts)) if lasts else math.nan,
        result.engine.preset.number("tactor.frequency_hz"),
        brightness,
        ring,
    )


def _timbre(result: RenderResult, start: int, stop: int) -> tuple[float, float]:
    """The click's brightness, Hz, and how long it rings, ms."""
    rate = result.sample_rate
    samples = result.samples[start:stop, CLICK].astype(np.float64)
    count = len(samples) // _FFT
    if not count:
        return math.nan, math.nan
    pieces = samples[: count * _FFT].reshape(count, _FFT) * np.hanning(_FFT)
    power = np.abs(np.fft.rfft(pieces, axis=1)) ** 2
    total = power.sum(axis=1)
    if not total.max() > 0.0:
        return math.nan, math.nan
    loud = total >= total.max() * 10.0 ** (-_LOUD_DB / 10.0)
    pitch = np.fft.rfftfreq(_FFT, 1.0 / rate)
    middle = (power[loud] @ pitch) / total[loud]
    level = window_db(result.samples[start:stop, CLICK], rate, KNOCK_HOP_S)[1]
    rings = []
    for peak in knocks(level):
        if level[peak] < level.max() - _LOUD_DB:
            continue
        below = np.flatnonzero(level[peak:] <= level[peak] - _RING_DB)
        if len(below):
            rings.append(below[0] * KNOCK_HOP_S * 1000.0)
    return float(np.median(middle)), float(np.median(rings)) if rings else math.nan
