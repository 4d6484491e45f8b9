from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

from overview_studies.observers import Observers
from overview_studies.power import estimate_power
from overview_studies.statistics import (
    RESAMPLES,
    difference_interval,
    fit_lapse_profiles,
    fit_psychometric,
    information_bits,
    information_interval,
    mean_interval,
    resample_counts,
    sensitivity,
    sensitivity_2afc,
)
from studies.tests.files import detecting, study_of


def test_sensitivity_is_that_of_the_tables():
    # Macmillan and Creelman: H = 0.69, F = 0.31 is d' = 0.99, c = 0
    d, c = sensitivity(69_000, 100_000, 31_000, 100_000)
    assert d == pytest.approx(0.992, abs=2e-3)
    assert c == pytest.approx(0.0, abs=1e-3)
    # all right and all wrong are finite
    assert math.isfinite(sensitivity(10, 10, 0, 10)[0])
    assert sensitivity_2afc(76_000, 100_000) == pytest.approx(0.999, abs=2e-3)


def test_information_of_known_matrices():
    assert information_bits(np.eye(4) * 1000, corrected=False) == pytest.approx(2.0)
    assert information_bits(np.ones((4, 4)) * 50, corrected=False) == pytest.approx(0.0)
    rng = np.random.default_rng(0)
    guessed = [
        np.bincount(4 * rng.integers(4, size=40) + rng.integers(4, size=40), minlength=16)
        for _ in range(200)
    ]
    plain = [information_bits(one.reshape(4, 4), corrected=False) for one in guessed]
    better = [information_bits(one.reshape(4, 4)) for one in guessed]
    # guesses transfer nothing; a small sample seems to, less so when corrected
    assert np.mean(better) < 0.5 * np.mean(plain)


def test_an_interval_of_a_mean_holds_it_as_often_as_it_says():
    rng = np.random.default_rng(5)
    held = 0
    for _ in range(400):
        one = mean_interval(rng.normal(2.0, 1.0, 12).tolist())
        held += one.low <= 2.0 <= one.high
    assert 0.92 <= held / 400 <= 0.985


def test_a_difference_of_groups_is_resampled_in_both():
    rng = np.random.default_rng(2)
    one = difference_interval(rng.normal(0, 1, 40).tolist(), rng.normal(1, 1, 40).tolist())
    assert one.low < 1.0 < one.high
    # 1.96 * sqrt(2/40) to either side
    assert 0.3 < (one.high - one.low) / 2.0 < 0.6


def test_too_few_have_no_interval():
    assert math.isnan(mean_interval([1.0]).low)
    assert math.isnan(mean_interval([]).mean)


def test_a_fit_finds_the_function_that_made_the_counts():
    levels = np.linspace(0.0, 10.0, 9)
    trials = np.full(9, 4000.0)
    part = 0.5 + (0.5 - 0.02) * norm.cdf((levels - 6.0) / 1.5)
    fitted = fit_psychometric(levels, np.round(part * trials), trials, 0.5)
    assert fitted.threshold == pytest.approx(6.0, abs=0.1)
    assert fitted.width == pytest.approx(1.5, abs=0.15)
    assert fitted.lapse == pytest.approx(0.02, abs=0.01)


def test_a_fit_is_the_most_likely_function():
    """No point of a fine grid, which knows nothing of the fit, is more likely by 1 %."""
    rng = np.random.default_rng(8)
    levels = np.log10([2.0, 4.0, 8.0, 16.0, 32.0])
    for guess in (0.0, 0.5):
        trials = np.full(5, 40.0)
        part = guess + (0.97 - guess) * norm.cdf((levels - 0.9) / 0.25)
        right = rng.binomial(40, part).astype(float)
        fitted = fit_psychometric(levels, right, trials, guess)
        t, w, lapse = np.meshgrid(
            np.linspace(0.3, 1.5, 121), np.geomspace(0.05, 1.5, 80), np.linspace(0.0, 0.06, 13)
        )
        z = (levels[:, None, None, None] - t) / w
        p = np.clip(guess + (1.0 - guess - lapse) * norm.cdf(z), 1e-9, 1.0 - 1e-9)
        k, n = right[:, None, None, None], trials[:, None, None, None]
        likelihood = (k * np.log(p) + (n - k) * np.log(1.0 - p)).sum(axis=0)
        at = np.unravel_index(likelihood.argmax(), likelihood.shape)
        p = np.clip(fitted.at(levels), 1e-9, 1.0 - 1e-9)
        own = float((right * np.log(p) + (trials - right) * np.log(1.0 - p)).sum())
        assert own >= likelihood[at] - 1e-6
        assert fitted.threshold == pytest.approx(t[at], abs=0.02)
        assert fitted.width == pytest.approx(w[at], rel=0.1)  # the grid's own step is 4 %


def test_a_fit_to_uneven_levels_is_the_most_likely_function_of_several():
    levels = [-11.0, -10.0, -9.0, -7.0, -4.0, -3.0, 1.0, 8.0]
    fitted = fit_psychometric(levels, [1, 0, 2, 2, 1, 1, 11, 38], [40] * 8, None, 0.01)
    assert (fitted.threshold, fitted.width) == pytest.approx((2.839, 2.993), abs=1e-3)


def cost_of(levels, right, trials, threshold, width, guess, lapse):
    z = (levels[:, None, None] - threshold) / width
    p = np.clip(guess + (1.0 - guess - lapse) * norm.cdf(z), 1e-9, 1.0 - 1e-9)
    k, n = right[:, None, None], trials[:, None, None]
    return -(k * np.log(p) + (n - k) * np.log(1.0 - p)).sum(axis=0)


@pytest.mark.parametrize("seed", range(30))
def test_no_function_of_a_fine_grid_is_more_likely_than_the_fit(seed):
    rng = np.random.default_rng([11, seed])
    count = rng.integers(4, 10)
    levels = np.sort(rng.choice(np.arange(-12.0, 13.0), count, replace=False))
    span, middle = np.ptp(levels), (levels[0] + levels[-1]) / 2.0
    guess, lapse = (None, 0.5, 0.0)[seed % 3], (0.0, 0.02, 0.06)[seed // 3 % 3]
    low = lapse if guess is None else guess
    trials = np.full(count, float(rng.integers(5, 60)))
    truth = low + (1.0 - low - lapse) * norm.cdf(
        (levels - rng.uniform(-12.0, 12.0)) / rng.uniform(0.5, 12.0)
    )
    right = rng.binomial(trials.astype(int), truth).astype(float)
    fitted = fit_psychometric(levels, right, trials, guess, lapse)
    thresholds, widths = np.meshgrid(
        middle + span * np.linspace(-1.5, 1.5, 241), span * np.geomspace(0.02, 5.0, 201)
    )
    costs = cost_of(levels, right, trials, thresholds, widths, low, lapse)
    assert fitted.cost <= costs.min() + 1e-3


@pytest.mark.parametrize("runs", [20, pytest.param(100, marks=pytest.mark.soak)])
def test_a_d_prime_of_one_and_a_half_is_recovered_within_its_interval(tmp_path, runs):
    study, lists = study_of(tmp_path, detecting())
    found = estimate_power(study, lists, Observers(1.5, spread=0.3), 24, runs, 11)
    (held,) = found["held"].values()
    print(f"d' = 1.5, 24 people: held in {held} of {runs} runs")
    assert held >= 0.93 * runs - (1 if runs < 100 else 0)


def test_widths_of_small_samples_are_as_large_as_those_of_the_observers():
    rng = np.random.default_rng(4)
    levels, trials = np.linspace(-3.0, 3.0, 7), np.full(7, 20.0)
    people = {str(i): (levels, rng.binomial(20, norm.cdf(levels / 1.2)).astype(float), trials)
              for i in range(300)}  # fmt: skip
    widths = fit_lapse_profiles(people).width[:, 0]  # they have no lapses
    # 2.3 % too small without the correction
    assert np.mean(widths) == pytest.approx(1.2, rel=0.015)


def test_an_interval_of_information_is_that_of_all_resamples_of_the_participants():
    rng = np.random.default_rng(6)
    counts = rng.integers(0, 6, (8, 3, 3)) + 10.0 * np.eye(3)
    found = information_interval(counts)
    assert found.mean == pytest.approx(information_bits(counts.sum(axis=0)))
    shares = resample_counts(8)
    assert len(shares) == RESAMPLES == 10_000
    bits = [information_bits(np.tensordot(one, counts, 1)) for one in shares]
    below = np.mean(np.array(bits) < found.low), np.mean(np.array(bits) < found.high)
    # wider than 2.5 and 97.5 %, as eight people are few
    assert 0.0 < below[0] < 0.025
    assert below[1] == pytest.approx(1.0 - below[0], abs=2e-3)
