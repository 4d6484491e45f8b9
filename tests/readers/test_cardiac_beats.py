"""Beats found in made-up signals whose beats are known, and in real annotated ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overview_dsp.errors import InputError
from overview_dsp.readers.cardiac import detection, extra
from overview_dsp.readers.cardiac.detection import Detection, find_beats
from overview_dsp.readers.cardiac.signal import SilenceFinder
from overview_dsp.readers.cardiac.table import Samples
from tests.readers.make_cardiac import agreement, beat_times, ecg, pulse_wave

pytest.importorskip("sleepecg", reason="needs the extra [ecg]")


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


def test_blocks_leave_no_seam(monkeypatch: pytest.MonkeyPatch) -> None:
    beats = beat_times(300.0)
    samples = ecg(beats, 300.0, 250.0)
    whole = found_in(samples, 250.0)
    monkeypatch.setattr(detection, "BLOCK_S", 17.0)
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


def test_a_missing_package_is_one_line_that_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(name: str) -> None:
        raise ImportError(f"No module named '{name}'")

    monkeypatch.setattr(extra.importlib, "import_module", fail)
    with pytest.raises(InputError, match=r"sleepecg .*pip install 'overview-dsp\[ecg\]'"):
        found_in(ecg(beat_times(20.0), 20.0, 250.0), 250.0)


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
