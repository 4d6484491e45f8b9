"""The intensity curve mixed with its rank."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import overview_dsp as ov
from overview_dsp.kernels.layout import CELLS
from tests.examples import plain_preset

DURATION = 1000.0


def curve(values, gaps=(), known_until_s=None):
    times = np.linspace(0.0, DURATION, len(values))
    return ov.Timeline("curve", DURATION, (), ov.Intensity(times, np.array(values)), gaps,
                       known_until_s=known_until_s)  # fmt: skip


def preset(share, intensity_gain=3.0, **values):
    return plain_preset(surface__intensity_gain=intensity_gain, surface__rank_share=share, **values)


def levels(timeline, made):
    """Intensity as it is felt, up to a constant."""
    friction = ov.build_surface(timeline, made).friction
    return np.log(friction) / np.log1p(made.number("surface.intensity_gain"))


def mostly_low(points=2001):
    random = np.random.default_rng(1)
    return np.clip(0.1 * np.exp(0.8 * random.standard_normal(points)), 0.0, 1.0)


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_a_level_is_mixed_with_the_share_of_time_below_it(share):
    timeline = curve(mostly_low())
    plain = levels(timeline, preset(0.0))
    rank = (stats.rankdata(plain, "average") - 0.5) / len(plain)
    plain -= plain.mean()
    expected = (1.0 - share) * plain + share * (rank - rank.mean())
    felt = levels(timeline, preset(share))
    assert felt - felt.mean() == pytest.approx(expected, abs=1e-4)


def test_equal_values_have_the_middle_of_their_ranks():
    # half of the time 0.2, a quarter 0.4 and a quarter 0.9, with steep edges
    values = np.repeat([0.2, 0.4, 0.9], [500, 250, 250])
    felt = levels(curve(values), preset(1.0))
    low, middle, high = felt[[1000, 40_000, 60_000]]
    assert middle - low == pytest.approx(0.625 - 0.25, abs=2e-3)
    assert high - low == pytest.approx(0.875 - 0.25, abs=2e-3)


@pytest.mark.parametrize("share", [0.5, 1.0])
@pytest.mark.parametrize("points", [(), (0.0, 0.2, 1.0)])
def test_the_mean_of_the_logarithm_stays(share, points):
    timeline = curve(mostly_low())
    made = (replace(preset(one), points=points) for one in (0.0, share))
    before, after = (np.log(ov.build_surface(timeline, one).friction).mean() for one in made)
    assert after == pytest.approx(before, abs=1e-9)


def test_only_times_with_data_have_a_rank():
    values = mostly_low()
    timeline = curve(values)
    times = np.concatenate((np.asarray(timeline.intensity.time_s), [1001.0, 2000.0]))
    longer = ov.Intensity(times, np.concatenate((values, [1.0, 1.0])))
    hidden = ov.Timeline("hidden", 2000.0, (), longer, ((1000.0, 1500.0),), known_until_s=1500.0)
    one, other = levels(timeline, preset(1.0)), levels(hidden, preset(1.0))[: CELLS // 2 + 1]
    # the same curve on the first half
    assert np.diff(one[::2])[:-1] == pytest.approx(np.diff(other)[:-1], abs=2e-3)


@pytest.mark.parametrize("values", [[0.3, 0.3], [7.0, 7.0]])
def test_a_constant_curve_stays_as_it_is(values):
    timeline = curve(values)
    plain, ranked = (ov.build_surface(timeline, preset(share)).friction for share in (0.0, 0.5))
    assert np.array_equal(plain, ranked)


def test_events_are_as_high_as_without():
    events = ov.Event(100.0, "goal"), ov.Event(700.0, "foul")
    timeline = replace(curve(mostly_low()), events=events)
    football = ov.load_preset("football")
    plain = football.with_value("surface.rank_share", 0.0)
    one, other = (ov.build_surface(timeline, made) for made in (plain, football))
    assert np.array_equal(one.release, other.release)
