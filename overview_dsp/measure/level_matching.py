"""Perceptual features of a preset that do not depend on its level, and distances between presets.

- *sharpness*: steepest rise of the vibration to its pulses, dB/s (median);
- *density*: pulses that are felt separately, per second;
- *rhythm*: spread of the pauses between pulses over their median (0: regular);
- *duration*: time that a pulse stays within 6 dB of its peak, ms (median);
- *pitch*: frequency of the vibration, Hz;
- *brightness*: centroid of the click's spectrum, Hz (median over its loud parts);
- *decay*: time in which a click falls by 12 dB, ms (median).

Just noticeable differences (JNDs) are ratios. They are 1.25 for frequency and duration by touch
(Israr and Tan 2006: 0.18 to 0.25) and 2 for sharpness, as in `measure.report`. They are 1.25 for
brightness and decay, which is far above the threshold of an ear.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.kernels.layout import CLICK, TACTOR
from overview_dsp.measure import perception
from overview_dsp.measure.perceived_level import GESTURES, strokes, window_db
from overview_dsp.measure.report import jnds_over_strokes
from overview_dsp.offline.rendering.offline import RenderResult, render

LEAST_DENSITY_HZ, LEAST_RHYTHM = 1.0, 0.2
"""Values that are added before ratios are taken: the lowest density that is a rhythm, one pulse per
second, and the lowest spread that is uneven, a fifth of a pause."""

RISE_S = 0.030  # time before a pulse in which its steepest rise is sought, s
_FFT = 2048  # frames of a spectrum of the click
_LOUD_DB = 20.0  # range below the highest level in which spectra and clicks count
_DECAY_DB = 12.0

MATCHED_DB = 1.0
"""Largest difference of matched levels, below what a hand or an ear notices."""

_CHANNELS = (("tactor.gain_db", TACTOR), ("click.gain_db", CLICK))


def match_levels(
    first: Preset, second: Preset, timeline: Timeline, gesture: Gesture
) -> tuple[Preset, Preset, str]:
    """Lower the gains of two presets so that a stroke has the same mean level with both.

    Parameters
    ----------
    first, second : Preset
        Presets to match. Vibration and clicks are matched separately; the stronger one is lowered.
    timeline : Timeline
        Timeline of the stroke.
    gesture : Gesture
        Stroke, whose root mean square is compared.

    Returns
    -------
    first, second : Preset
        Presets with changed gains.
    report : str
        Changes and remaining differences as a sentence.

    Raises
    ------
    InputError
        A level can't be matched, as one preset is silent or its gain would be out of range.

    Examples
    --------
    >>> tall = plain.with_value("tactor.gain_db", 3.0)
    >>> _, matched, report = ov.measure.match_levels(plain, tall, match, ov.sweep(1.0))
    >>> round(float(matched.number("tactor.gain_db")))
    0
    """
    pair = [first, second]
    for _ in range(3):  # the limit of the output makes levels depend on gains in a curve
        levels = [_mean_levels_db(one, timeline, gesture) for one in pair]
        apart = [levels[1][i] - levels[0][i] for i in range(2)]
        if not np.isfinite(apart).all():
            raise InputError("levels can't be matched: a preset is silent in this stroke")
        if max(map(abs, apart)) < 0.1 * MATCHED_DB:
            break
        for (id, _), more_db in zip(_CHANNELS, apart, strict=True):
            index = int(more_db > 0.0)
            pair[index] = pair[index].with_value(id, pair[index].number(id) - abs(more_db))
    if max(map(abs, apart)) > MATCHED_DB:
        raise InputError(f"levels can't be matched: {apart[0]:+.1f} dB, {apart[1]:+.1f} dB remain")
    gains = [
        f"{letter} {new.number(id) - old.number(id):+.1f} dB ({id})"
        for letter, new, old in zip("AB", pair, (first, second), strict=True)
        for id, _ in _CHANNELS
        if new.number(id) != old.number(id)
    ]
    remain = f"vibration {apart[0]:+.1f} dB, clicks {apart[1]:+.1f} dB remain"
    return pair[0], pair[1], f"levels matched: {', '.join(gains) or 'no change'}; {remain}"


def _mean_levels_db(preset: Preset, timeline: Timeline, gesture: Gesture) -> list[float]:
    samples = render(timeline, preset, gesture, trace=False).samples.astype(np.float64)
    with np.errstate(divide="ignore"):
        power = [np.mean(samples[:, channel] ** 2) for _, channel in _CHANNELS]
        return [float(10.0 * np.log10(one)) for one in power]


@dataclass(frozen=True)
class PerceptualFeatures:
    """Perceptual features of a stroke without its level; NaN where it has none.

    Attributes
    ----------
    sharpness : float
        Steepest rise, dB/s.
    density_hz, rhythm : float
        Pulses per second, and spread of the pauses.
    duration_ms : float
        Duration of a pulse.
    pitch_hz, brightness_hz : float
        Frequency of the vibration; spectral centroid of the click.
    decay_ms : float
        Decay of a click.

    Examples
    --------
    >>> one = ov.measure.perceptual_features(football, match, {"fast": ov.sweep(1.0)})["fast"]
    >>> one.pitch_hz
    250.0
    """

    sharpness: float
    density_hz: float
    rhythm: float
    duration_ms: float
    pitch_hz: float
    brightness_hz: float
    decay_ms: float

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.4g}" for name, value in vars(self).items())
        return f"PerceptualFeatures({values})"


_JNDS = {"sharpness": perception.JND_SHARPNESS}
_LEAST = {"density_hz": LEAST_DENSITY_HZ, "rhythm": LEAST_RHYTHM}


def perceptual_features(
    preset: Preset,
    timeline: Timeline,
    gestures: Mapping[str, Gesture] = GESTURES,
    sample_rate: float = 48_000,
) -> dict[str, PerceptualFeatures]:
    """Measure the strokes of a preset on a timeline, independent of its gain.

    Parameters
    ----------
    preset : Preset
        Preset that is rendered.
    timeline : Timeline
        Timeline of the surface.
    gestures : mapping of str to Gesture
        Gestures by name; default: slow, medium and fast sweeps and a tap.
    sample_rate : float
        Hz.

    Returns
    -------
    dict of str to PerceptualFeatures
        Features of each gesture's outward stroke and its recoil.

    Raises
    ------
    InputError
        A preset or a gesture that `render` refuses.

    Examples
    --------
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> quiet = football.with_changes({"tactor.gain_db": -6.0, "click.gain_db": -20.0})
    >>> one = ov.measure.perceptual_features(football, match, sweeps)
    >>> other = ov.measure.perceptual_features(quiet, match, sweeps)
    >>> ov.measure.level_matched_distance(one, other) < 0.5
    True
    """
    found = {}
    for name, gesture in gestures.items():
        result = render(timeline, preset, gesture, sample_rate)
        for stroke in strokes(result.trace.engaged, result.trace.cursor):
            stroke_name = name if stroke.name == "out" else f"{name} {stroke.name}"
            found[stroke_name] = _features(result, stroke.start, stroke.stop)
    return found


def level_matched_distance(
    first: Mapping[str, PerceptualFeatures], second: Mapping[str, PerceptualFeatures]
) -> float:
    """Return the just noticeable differences between two presets with matched levels.

    The result is that of the feature that differs most: its median over all strokes. All recoils
    count as one stroke, since they are similar after any gesture.

    Parameters
    ----------
    first, second : mapping of str to PerceptualFeatures
        Features of the same gestures on one timeline.

    Returns
    -------
    float
        Number of JNDs.

    Examples
    --------
    >>> same = ov.measure.perceptual_features(football, match, {"fast": ov.sweep(1.0)})
    >>> ov.measure.level_matched_distance(same, same)
    0.0
    """
    return jnds_over_strokes({name: _differences(first[name], second[name]) for name in first})


def _differences(one: PerceptualFeatures, other: PerceptualFeatures) -> list[float]:
    found = []
    for name, value in vars(one).items():
        least = _LEAST.get(name, 0.0)
        pair = value + least, getattr(other, name) + least
        found.append(perception.ratio_jnds(*pair, _JNDS.get(name, perception.JND_DURATION)))
    return found


def _features(result: RenderResult, start: int, stop: int) -> PerceptualFeatures:
    rate = result.sample_rate
    level = window_db(result.samples[start:stop, TACTOR], rate, perception.PULSE_HOP_S)[1]
    peaks = perception.pulse_indices(level)
    pauses = np.diff(peaks)
    reach = round(RISE_S / perception.PULSE_HOP_S)
    onsets = [level[max(0, peak - reach) : peak + 1] for peak in peaks]
    rises = [np.diff(onset).max() / perception.PULSE_HOP_S for onset in onsets if len(onset) > 1]
    near = [perception.near_peak(level, int(peak), perception.FALL_DB) for peak in peaks]
    durations = [count * perception.PULSE_HOP_S * 1000.0 for count in near]
    seconds = (stop - start) / rate
    brightness, decay = _timbre(result, start, stop)
    return PerceptualFeatures(
        float(np.median(rises)) if rises else math.nan,
        len(peaks) / seconds,
        float(np.std(pauses) / np.median(pauses)) if len(pauses) > 2 else math.nan,
        float(np.median(durations)) if durations else math.nan,
        result.engine.preset.number("tactor.frequency_hz"),
        brightness,
        decay,
    )


def _timbre(result: RenderResult, start: int, stop: int) -> tuple[float, float]:
    """Return brightness (Hz) and decay (ms) of the click."""
    rate = result.sample_rate
    samples = result.samples[start:stop, CLICK].astype(np.float64)
    count = len(samples) // _FFT
    pieces = samples[: count * _FFT].reshape(count, _FFT) * np.hanning(_FFT)
    power = np.abs(np.fft.rfft(pieces, axis=1)) ** 2
    total = power.sum(axis=1)
    if not total.max(initial=0.0) > 0.0:
        return math.nan, math.nan
    loud = total >= total.max() * 10.0 ** (-_LOUD_DB / 10.0)
    pitch = np.fft.rfftfreq(_FFT, 1.0 / rate)
    centroids = (power[loud] @ pitch) / total[loud]
    level = window_db(result.samples[start:stop, CLICK], rate, perception.PULSE_HOP_S)[1]
    decays = []
    for peak in perception.pulse_indices(level):
        below = np.flatnonzero(level[peak:] <= level[peak] - _DECAY_DB)
        if len(below) and level[peak] >= level.max() - _LOUD_DB:
            decays.append(below[0] * perception.PULSE_HOP_S * 1000.0)
    return float(np.median(centroids)), float(np.median(decays)) if decays else math.nan
