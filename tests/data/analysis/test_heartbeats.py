"""Beats found in made-up signals whose beats are known, and in real annotated ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overview_dsp.data.analysis import heartbeats
from overview_dsp.data.analysis.heart_signal import Samples, SilenceFinder
from overview_dsp.data.analysis.heartbeats import Detection, find_beats
from overview_dsp.data.analysis.rhythm import MISSED, NORMAL, beat_events, mean_rate
from overview_dsp.data.readers.cardiac.build import beats_of
from tests.data.readers.make_cardiac import (
    agreement,
    beat_times,
    ecg,
    pulse_wave,
    with_ectopic_beats,
)
from tests.data.readers.make_noise import RealNoise, electrode_noise, with_noise


def found_in(samples: Any, rate: float, what: str | None = None) -> Detection:
    return find_beats(Samples("x", rate, np.asarray(samples, np.float32)), what)


@pytest.mark.parametrize("rate", [50, 64, 100, 128, 250, 360, 500, 1000, 257.3])
@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_every_beat_of_a_steady_heart_is_found_at_every_rate(rate: float, turned: float) -> None:
    beats = beat_times(60.0)
    found = found_in(turned * ecg(beats, 60.0, rate), rate)
    assert found.what == "ECG"
    assert agreement(found.beats / rate, beats) == (1.0, 1.0)
    assert found.silent == []


@pytest.mark.parametrize("bpm", [38.0, 60.0, 120.0, 185.0])
def test_slow_and_quick_hearts_are_followed(bpm: float) -> None:
    beats = beat_times(90.0, bpm)
    found = found_in(ecg(beats, 90.0, 250.0), 250.0)
    assert min(agreement(found.beats / 250.0, beats)) >= 0.99


@pytest.mark.parametrize("noise", [0.005, 0.02, 0.05])
@pytest.mark.parametrize("bpm", [38.0, 70.0, 160.0])
def test_no_beat_is_found_where_one_is_missing(bpm: float, noise: float) -> None:
    beats = np.delete(beat_times(60.0, bpm), [10, 25])
    found = found_in(ecg(beats, 60.0, 250.0, noise), 250.0)
    assert agreement(found.beats / 250.0, beats) == (1.0, 1.0)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 2e4])
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_the_unit_and_the_offset_do_not_matter(scale: float, offset: float) -> None:
    beats = beat_times(30.0)
    found = found_in(scale * (ecg(beats, 30.0, 250.0) + offset), 250.0)
    assert agreement(found.beats / 250.0, beats) == (1.0, 1.0)


@pytest.mark.parametrize("rate", [50, 100, 500])
def test_a_pulse_wave_is_distinguished_from_an_ecg_and_its_peaks_are_found(rate: float) -> None:
    beats = beat_times(60.0)
    found = found_in(pulse_wave(beats, 60.0, rate), rate)
    assert found.what == "pulse wave"
    assert min(agreement(found.beats / rate, beats)) >= 0.98


def test_a_stretch_of_noise_in_a_pulse_wave_is_a_gap() -> None:
    beats = beat_times(120.0)
    samples = pulse_wave(beats, 120.0, 100.0)
    noise = electrode_noise(40.0, 100.0, 1)[:4000]
    samples[4000:8000] = np.median(samples) + 60.0 * noise
    found = found_in(samples, 100.0)
    assert found.what == "pulse wave"
    lost = np.zeros(len(samples), bool)
    for first, end in found.noisy:
        lost[first:end] = True
    assert lost[4000:8000].mean() > 0.9
    assert lost[:2500].mean() + lost[9500:].mean() == 0.0
    marks = np.rint(beats * 100.0).astype(np.int64)
    assert min(agreement(found.beats / 100.0, beats[~lost[marks]])) >= 0.97


def test_blocks_leave_no_seam(monkeypatch: pytest.MonkeyPatch) -> None:
    beats = beat_times(300.0)
    samples = ecg(beats, 300.0, 250.0)
    whole = found_in(samples, 250.0)
    monkeypatch.setattr(heartbeats, "BLOCK_S", 17.0)
    parts = found_in(samples, 250.0)
    assert np.array_equal(whole.beats, parts.beats)


def test_missing_and_flat_stretches_are_found_and_searched_around() -> None:
    beats = beat_times(60.0)
    samples = ecg(beats, 60.0, 250.0)
    samples[250 * 10 : 250 * 15] = np.nan
    samples[250 * 30 : 250 * 36] = samples[250 * 30]
    samples[250 * 50] = np.nan
    found = found_in(samples, 250.0)
    assert found.silent == [(2500, 3750), (7500, 9000)]
    assert found.lost == 1
    kept = beats[~((beats > 9.9) & (beats < 15.1)) & ~((beats > 29.9) & (beats < 36.1))]
    assert min(agreement(found.beats / 250.0, kept)) >= 0.98


def test_nothing_is_found_in_nothing() -> None:
    for samples in (np.zeros(5000), np.full(5000, np.nan), np.zeros(1)):
        assert len(found_in(samples, 250.0).beats) == 0


def test_stretches_are_the_same_however_the_signal_is_cut() -> None:
    samples = np.random.default_rng(1).normal(size=5000)
    samples[:400] = 3.0
    samples[900:1000] = np.nan
    samples[2000:2600] = 0.0
    samples[4690:] = np.nan
    for size in (5000, 1000, 333, 7):
        finder = SilenceFinder(100.0)
        for first in range(0, 5000, size):
            finder.feed(samples[first : first + size])
        assert finder.finish() == [(0, 400), (900, 1000), (2000, 2600), (4690, 5000)]


def ectopic(every: int = 9) -> tuple[Any, Any]:
    """An ECG at 250 Hz whose every ninth beat comes early, wide and tall; the beats' times."""
    intervals = np.full(150, 0.85)
    early = np.arange(7, 150, every)
    intervals[early] = 0.5
    intervals[np.minimum(early + 1, 149)] = 1.2
    beats = 0.5 + np.cumsum(intervals)
    seconds = beats[-1] + 1.0
    samples = ecg(np.delete(beats, early), seconds, 250.0, 0.03)
    time = np.arange(len(samples)) / 250.0
    for beat in beats[early]:
        samples += 1.5 * np.exp(-0.5 * ((time - beat) / 0.035) ** 2)
        samples -= 0.45 * np.exp(-0.5 * ((time - beat - 0.15) / 0.06) ** 2)
    return samples, beats


def test_early_beats_of_another_shape_are_found() -> None:
    samples, beats = ectopic()
    found = found_in(samples, 250.0)
    assert agreement(found.beats / 250.0, beats) == (1.0, 1.0)
    assert found.noisy == []


def test_a_heart_without_any_rhythm_is_followed() -> None:
    beats = np.cumsum(np.random.default_rng(3).uniform(0.38, 1.1, 150))
    found = found_in(ecg(beats, beats[-1] + 1.0, 250.0, 0.03), 250.0)
    assert agreement(found.beats / 250.0, beats) == (1.0, 1.0)


# NeuroKit2's rodrigues2021 has 1.000 / 0.953 and 0.895 / 0.792 in the stress test itself, and
# 0.98 / 0.91 and 0.90 / 0.77 in this noise (docs/explanation/hearts.md)
@pytest.mark.parametrize(
    ("name", "snr_db", "sensitivity", "precision"),
    [
        ("118e24", 12.0, 0.995, 0.97),
        ("118e24", 6.0, 0.975, 0.975),
        ("100", 12.0, 0.999, 0.985),
        ("100", 6.0, 0.99, 0.985),
    ],
)
def test_beats_are_found_in_noise(
    name: str, snr_db: float, sensitivity: float, precision: float, data_folder: Path
) -> None:
    samples, rate, beats = annotated(data_folder, name)
    samples, beats = samples[:108_000], beats[beats < 300.0]
    marks = np.rint(beats * rate).astype(np.int64)
    scores = []
    for seed in (1, 2, 3):
        noisy = with_noise(samples, rate, marks, snr_db, seed)
        search = find_beats(Samples("x", rate, noisy.astype(np.float32)), "ECG", gaps=False)
        scores.append(agreement(search.beats / rate, beats, 0.15))
    found, right = np.mean(scores, axis=0)
    assert found >= sensitivity
    assert right >= precision


@pytest.mark.parametrize("seed", [1, 2])
def test_what_is_too_noisy_is_left_out_and_the_rest_is_right(seed: int) -> None:
    beats = beat_times(180.0)
    samples = ecg(beats, 180.0, 250.0)
    marks = np.rint(beats * 250.0).astype(np.int64)
    samples[15_000:30_000] = with_noise(
        samples[15_000:30_000],
        250.0,
        marks[(marks >= 15_000) & (marks < 30_000)] - 15_000,
        -6,
        seed,
    )
    found = found_in(samples, 250.0)
    noisy = np.zeros(len(samples), bool)
    for first, end in found.noisy:
        noisy[first:end] = True
    assert noisy[15_000:30_000].mean() > 0.9
    assert not noisy[:14_000].any()
    assert not noisy[31_000:].any()
    assert not noisy[found.beats].any()
    assert min(agreement(found.beats / 250.0, beats[~noisy[marks]])) > 0.96


@pytest.mark.parametrize(
    ("snr_db", "most_gaps"),
    [(12.0, 0.02), (9.0, 0.02), (6.0, 0.1), (4.0, 0.25), (2.0, 1.0), (0.0, 1.0)],
)
def test_what_is_no_gap_under_real_noise_is_right(
    snr_db: float, most_gaps: float, data_folder: Path
) -> None:
    noise = RealNoise(data_folder)
    true = named = right = 0.0
    gaps, wrong_pulses = [], 0
    for name, channel in (("118e24", 0), ("100", 0), ("100", 1)):
        samples, rate, beats = annotated(data_folder, name, channel)
        samples, beats = samples[:108_000], beats[beats < 300.0]
        marks = np.rint(beats * rate).astype(np.int64)
        for offset in (0, 3000, 7000):
            found = found_in(noise.added(samples, marks, snr_db, offset), rate)
            clear = np.ones(len(samples), bool)
            for first, end in found.noisy:
                clear[first:end] = False
            gaps.append(1.0 - clear.mean())
            kept = beats[clear[marks]]
            if not len(found.beats):
                continue
            scores = agreement(found.beats / rate, kept, 0.15)
            assert min(scores) >= 0.9
            true, named = true + len(kept), named + len(found.beats)
            right += scores[0] * len(kept)
            spans = tuple((first / rate, end / rate) for first, end in found.noisy)
            pulse, known = (mean_rate(at, spans) for at in (found.beats / rate, kept))
            wrong_pulses += known is not None and abs((pulse or 0.0) / known - 1.0) > 0.05
    assert min(right / true, right / named) >= 0.98
    assert np.mean(gaps) <= most_gaps
    assert wrong_pulses <= 1


def test_real_noise_without_a_heart_is_a_gap(data_folder: Path) -> None:
    loop = RealNoise(data_folder).loop
    for offset in (0, 3000, 7000):
        samples = np.resize(np.roll(loop, -offset), 36_000)
        found = found_in(samples, 360.0)
        assert sum(end - first for first, end in found.noisy) >= 0.89 * len(samples)


@pytest.mark.parametrize("snr_db", [None, 18.0])
@pytest.mark.parametrize("every", [2, 9])
@pytest.mark.parametrize(("ventricular", "least"), [(True, 0.95), (False, 0.9)])
def test_ectopic_beats_are_named(
    ventricular: bool, least: float, every: int, snr_db: float | None
) -> None:
    samples, beats, early = with_ectopic_beats(every, ventricular)
    if snr_db is not None:
        marks = np.rint(beats * 250.0).astype(np.int64)
        samples = with_noise(samples, 250.0, marks, snr_db, 3)
    found = found_in(samples, 250.0)
    events, _ = beat_events(beats_of(found, 250.0), ())
    named = np.array([event.time_s for event in events if event.kind not in (NORMAL, MISSED)])
    hit, right = agreement(named, early, 0.1)
    assert hit >= least
    assert right >= 0.93
    assert sum(event.kind == MISSED for event in events) <= 1


@pytest.mark.parametrize("seconds", [10.0, 40.0, 120.0])
@pytest.mark.parametrize("seed", [5, 6, 7])
def test_no_heart_is_found_in_noise_alone(seconds: float, seed: int) -> None:
    white = np.random.default_rng(seed).normal(size=round(seconds * 250.0))
    for samples in (electrode_noise(seconds, 250.0, seed), white):
        found = found_in(samples, 250.0, "ECG")
        assert len(found.beats) == 0
        assert found.noisy == [(0, len(samples))]


@pytest.mark.parametrize("seconds", [8.0, 11.0])
def test_a_short_recording_with_little_noise_is_kept(seconds: float) -> None:
    beats = beat_times(seconds)
    marks = np.rint(beats * 250.0).astype(np.int64)
    samples = with_noise(ecg(beats, seconds, 250.0), 250.0, marks, 18.0, 3)
    found = found_in(samples, 250.0)
    assert found.noisy == []
    assert agreement(found.beats / 250.0, beats, 0.15) == (1.0, 1.0)


def test_a_clean_signal_has_no_noisy_stretch(data_folder: Path) -> None:
    for name in ("100", "118e24"):
        samples, rate, _ = annotated(data_folder, name)
        assert found_in(samples, rate).noisy == []


def annotated(folder: Path, name: str, channel: int = 0) -> tuple[Any, float, Any]:
    """Samples, rate and the annotated beats of a real recording."""
    if name == "118e24":
        samples = np.loadtxt(folder / "ecg" / "118e24.csv")
        return samples, 360.0, np.loadtxt(folder / "ecg" / "118e24_ann.csv") / 360.0
    wfdb = pytest.importorskip("wfdb", reason="needs the extra [ecg]")
    record = wfdb.rdrecord(str(folder / "ecg" / name))
    said = wfdb.rdann(str(folder / "ecg" / name), "atr")
    beats = said.sample[np.isin(said.symbol, ["N", "A", "V"])]
    return record.p_signal[:, channel], record.fs, beats / record.fs


@pytest.mark.parametrize(
    ("name", "channel", "count", "least"),
    # the three beats that V5 hardly shows aren't found there
    [("100", 0, 2273, 1.0), ("100", 1, 2273, 0.998), ("118e24", 0, 167, 1.0)],
)
def test_real_beats_are_within_50_ms_of_their_annotations(
    name: str, channel: int, count: int, least: float, data_folder: Path
) -> None:
    samples, rate, beats = annotated(data_folder, name, channel)
    found = found_in(samples, rate)
    assert len(beats) == count
    assert min(agreement(found.beats / rate, beats)) >= least


def test_real_beats_that_point_down_are_found_too(data_folder: Path) -> None:
    for name in ("100", "118e24"):
        samples, rate, beats = annotated(data_folder, name)
        assert min(agreement(found_in(-samples, rate).beats / rate, beats)) >= 0.99
