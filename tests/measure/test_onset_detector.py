"""The onset detector on clicks whose times are known."""

from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.measure import onset_detector
from overview_dsp.measure.onset_detector import HOP_S, onsets

RATE = 48_000.0


def clicks(times, levels, frequency=2000.0, decay_s=0.03, seconds=1.0, noise=0.0):
    time = np.arange(round(seconds * RATE)) / RATE
    out = noise * np.random.default_rng(0).standard_normal(len(time))
    for start, level in zip(times, levels, strict=True):
        after = np.maximum(time - start, 0.0)
        out += level * np.exp(-6.9 * after / decay_s) * np.sin(2 * np.pi * frequency * after)
    return out.astype(np.float32)


def test_each_click_is_found_within_two_milliseconds():
    times = [0.1, 0.2, 0.35, 0.9]
    found = onsets(clicks(times, [0.5] * 4), RATE)
    assert found.time_s == pytest.approx(times, abs=2e-3)


def test_a_click_12_db_weaker_is_found_30_ms_after_another():
    found = onsets(clicks([0.2, 0.23], [0.8, 0.2]), RATE)
    assert len(found.time_s) == 2


def test_strength_follows_the_clicks_level():
    found = onsets(clicks([0.2, 0.5], [0.4, 0.1]), RATE)
    assert found.level_db[0] - found.level_db[1] == pytest.approx(12.04, abs=0.5)


def test_steady_noise_and_silence_have_no_onset_but_the_first():
    assert len(onsets(np.zeros(48_000, dtype=np.float32), RATE).time_s) == 0
    noise = clicks([], [], noise=0.1)
    assert len(onsets(noise, RATE).time_s) <= 1


def test_a_click_under_noise_18_db_below_it_is_found():
    found = onsets(clicks([0.4], [0.5], noise=0.02), RATE)
    assert np.abs(found.time_s - 0.4).min() < 2e-3


@pytest.mark.parametrize(("rises_db", "sharpest"), [((10, 20, 12), 1), ((20, 12, 15), 0)])
def test_of_onsets_within_5_ms_the_sharpest_one_gives_the_time(monkeypatch, rises_db, sharpest):
    level = np.full(200, -80.0)
    starts = [100, 107, 114]  # a value each 0.25 ms
    for start, rise_db in zip(starts, rises_db, strict=True):
        level[start:] += rise_db
    curve = np.arange(200) * HOP_S, level
    monkeypatch.setattr(onset_detector, "level_curve", lambda signal, sample_rate: curve)
    found = onsets(np.zeros(1, np.float32), RATE)
    assert found.time_s == pytest.approx([starts[sharpest] * HOP_S])
