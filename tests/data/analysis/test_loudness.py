"""Loudness against its definition, EBU Tech 3341's cases and a second implementation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from overview_dsp.data.analysis.loudness import (
    MOMENTARY_STEPS,
    SHORT_TERM_STEPS,
    StepMeter,
    Steps,
    k_weighting,
)
from overview_dsp.data.readers.audio.channels import layout_of, weights_of, weights_of_mask
from tests.data.readers.make_crowd import murmur, swelled

STEREO = (1.0, 1.0)


def sine(*parts: tuple[float, float], rate: int = 48_000, hz: float = 1000.0) -> Any:
    """A sine of parts (peak dBFS, seconds), its phase running through."""
    gain = np.concatenate([np.full(round(s * rate), 10.0 ** (db / 20.0)) for db, s in parts])
    return gain * np.sin(2.0 * np.pi * hz * np.arange(len(gain)) / rate)


def measured(sound: Any, rate: int = 48_000, weights: tuple[float, ...] = STEREO) -> Steps:
    if sound.ndim == 1:
        sound = np.stack([sound] * len(weights), axis=1)
    meter = StepMeter(rate, weights)
    size = meter.block_frames
    for first in range(0, len(sound), size):
        meter.feed(sound[first : first + size])
    return meter.finish()


def test_the_filters_are_the_recommendations_at_48_khz() -> None:
    table = [
        [1.53512486, -2.69169619, 1.19839281, 1.0, -1.69065929, 0.73248077],
        [1.0, -2.0, 1.0, 1.0, -1.99004745, 0.99007225],
    ]
    assert np.abs(k_weighting(48_000) - table).max() < 1e-7


@pytest.mark.parametrize("rate", [8000, 11_025, 16_000, 22_050, 44_100, 48_000, 96_000, 192_000])
def test_a_sine_at_997_hz_reads_its_level_at_every_rate(rate: int) -> None:
    steps = measured(sine((-23.0, 8.0), rate=rate, hz=997.0), rate)
    tolerance = 0.1 if rate >= 16_000 else 0.2  # the bilinear transform bends the shelf
    for width in (MOMENTARY_STEPS, SHORT_TERM_STEPS):
        assert np.abs(steps.loudness(width)[5:-5] + 23.0).max() <= tolerance
    assert steps.integrated() == pytest.approx(-23.0, abs=tolerance)


def test_one_full_scale_channel_reads_3_lu_less() -> None:
    steps = measured(sine((0.0, 5.0), hz=997.0), weights=(1.0,))
    assert steps.integrated() == pytest.approx(-3.01, abs=0.01)


@pytest.mark.parametrize(
    ("parts", "integrated"),
    [
        ([(-23, 20)], -23.0),
        ([(-33, 20)], -33.0),
        ([(-36, 10), (-23, 60), (-36, 10)], -23.0),
        ([(-72, 10), (-36, 10), (-23, 60), (-36, 10), (-72, 10)], -23.0),
        ([(-26, 20), (-20, 20.1), (-26, 20)], -23.0),
    ],
)
def test_tech_3341_cases_1_to_5(parts: list[tuple[float, float]], integrated: float) -> None:
    assert measured(sine(*parts)).integrated() == pytest.approx(integrated, abs=0.1)


def test_tech_3341_case_6_weights_the_surround_channels() -> None:
    sound = np.stack([sine((db, 20.0)) for db in (-28, -28, -24, -30, -30)], axis=1)
    layout = layout_of(5)
    assert layout is not None
    assert measured(sound, weights=weights_of(layout)).integrated() == pytest.approx(-23, abs=0.1)


def test_tech_3341_case_9_short_term_is_even() -> None:
    short = measured(sine(*[(-20, 1.34), (-30, 1.66)] * 5)).loudness(SHORT_TERM_STEPS)
    assert np.abs(short[15:-15] + 23.0).max() <= 0.1


@pytest.mark.parametrize("i", range(0, 20, 3))
def test_tech_3341_case_10_short_term_finds_three_seconds(i: int) -> None:
    sound = sine((-200, i * 0.15), (-23, 3.0), (-200, 1.0))
    loudest = measured(sound).loudness(SHORT_TERM_STEPS)[15:-15].max(initial=-70.0)
    # before 1.5 s a centred window is cut at the start, and full later
    assert loudest == pytest.approx(-23.0, abs=0.1)


def test_tech_3341_case_12_momentary_is_even() -> None:
    momentary = measured(sine(*[(-20, 0.18), (-30, 0.22)] * 25)).loudness(MOMENTARY_STEPS)
    assert np.abs(momentary[5:-5] + 23.0).max() <= 0.1


@pytest.mark.parametrize("rate", [22_050, 44_100, 48_000, 96_000])
def test_another_implementation_agrees(rate: int) -> None:
    pyloudnorm = pytest.importorskip("pyloudnorm", reason="needs pyloudnorm")
    left = swelled(murmur(20.0, rate), 8.0, 5.0, 12.0, rate)
    sound = np.stack([left, murmur(20.0, rate, seed=2)], axis=1)
    steps = measured(sound, rate)
    other = pyloudnorm.Meter(rate, filter_class="DeMan")
    assert steps.integrated() == pytest.approx(other.integrated_loudness(sound), abs=0.02)
    # its blocks of 3 s by themselves: with one block nothing is gated
    short = steps.loudness(SHORT_TERM_STEPS)
    for middle in (5.0, 9.5, 12.0):
        first, last = round((middle - 1.5) * rate), round((middle + 1.5) * rate)
        whole = pyloudnorm.Meter(rate, filter_class="DeMan", block_size=3.0)
        # a run-in, so that its filters have settled too
        part = whole.integrated_loudness(sound[first:last])
        assert short[round(middle * 10)] == pytest.approx(part, abs=0.05)


def test_how_the_blocks_are_cut_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from overview_dsp.data.analysis import loudness

    sound = murmur(7.3, 11_025)
    whole = measured(sound, 11_025)
    monkeypatch.setattr(loudness, "_BLOCK_SAMPLES", 1)
    parts = measured(sound, 11_025)
    assert np.array_equal(whole.count, parts.count)
    assert np.allclose(whole.energy, parts.energy, rtol=1e-9)


def test_silence_is_the_absolute_gate_and_nothing_is_below() -> None:
    steps = measured(np.zeros(48_000 * 5))
    assert (steps.loudness(SHORT_TERM_STEPS) == -70.0).all()
    assert steps.integrated() == -70.0


def test_missing_samples_are_found_across_blocks_and_harm_nothing_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from overview_dsp.data.analysis import loudness

    monkeypatch.setattr(loudness, "_BLOCK_SAMPLES", 1)  # blocks of one second
    sound = sine((-23.0, 10.0))
    sound[48_000 * 3 - 100 : 48_000 * 5 + 7] = np.nan
    sound[48_000 * 7 : 48_000 * 8] = np.inf
    sound[48_000 * 9] = np.nan
    steps = measured(sound)
    assert steps.missing == (
        (48_000 * 3 - 100, 48_000 * 5 + 7),
        (48_000 * 7, 48_000 * 8),
    )
    assert steps.lost == 1
    momentary = steps.loudness(MOMENTARY_STEPS)
    assert np.isnan(momentary[33:47]).all()
    known = momentary[~np.isnan(momentary)]
    assert np.abs(known[3:] + 23.0).max() <= 0.6  # where the filters start anew they swing a little
    assert steps.integrated() == pytest.approx(-23.0, abs=0.1)


def test_missing_samples_at_both_ends_are_runs_too() -> None:
    sound = sine((-23.0, 3.0))
    sound[: 48_000 // 2] = sound[-48_000:] = np.nan
    assert measured(sound).missing == ((0, 24_000), (96_000, 144_000))


def test_channels_count_by_their_place() -> None:
    assert weights_of(layout_of(6) or ()) == (1, 1, 1, 0, 1.41, 1.41)
    assert weights_of(layout_of(6, xiph=True) or ()) == (1, 1, 1, 1.41, 1.41, 0)
    assert weights_of_mask(0x3F, 6) == (1, 1, 1, 0, 1.41, 1.41)
    assert weights_of_mask(0x63F, 8) == (1, 1, 1, 0, 1, 1, 1.41, 1.41)
    assert weights_of_mask(0x33, 4) == (1, 1, 1.41, 1.41)
    assert weights_of_mask(0x3, 6) is None
    assert layout_of(11) is None


def test_samples_missing_in_one_channel_only_harm_nothing_else() -> None:
    sound = np.stack([sine((-20.0, 8.0))] * 2, axis=1)
    sound[96_000:100_000, 1] = np.nan
    steps = measured(sound)
    assert np.isfinite(steps.energy).all()
    assert int(steps.count.sum()) == len(sound) - 4000
    assert steps.integrated() == pytest.approx(-20.0, abs=0.2)
