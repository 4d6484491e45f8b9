"""What a finger gets of the curve itself: its range, its steps, its shape, among events too."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.units import JUST_NOTICEABLE_DB
from tests.feel.curves import (
    RAMPS,
    RATE,
    curve_of,
    grain_db,
    loader,
    made_up_prices,
    real_prices,
    real_share_years,
    shape_lessons,
    shapes_told,
    steps_of,
    third_of_windows,
    thirds_told,
    years_of_files,
)
from tests.parameters import first_in_gate

CURVED = ("series", "stocks", "weather", "heart", "crowd", "plain")
SERIES = ("series", "stocks", "weather")
"""Those whose shapes are told apart, each on curves with events."""

LOUDNESS_STEP_DB = 1.0
"""One step of level to the ear, which is finer than the skin's (Miller 1947: 0.5 to 1 dB of noise);
the grain goes with the root of the power, so that its range is half of the friction's."""

TOLD = {2.0: 0.90, 4.0: 0.95, 8.0: 0.95}


@pytest.mark.parametrize("course", RAMPS)
@pytest.mark.parametrize("name", CURVED)
def test_a_curve_spans_four_steps_of_equal_size(name, course):
    steps = steps_of(ov.load_preset(name), course)
    assert steps.sum() >= 9.0
    assert steps.max() - steps.min() <= JUST_NOTICEABLE_DB / 2.0


@pytest.mark.parametrize("name", CURVED)
def test_a_disk_on_a_low_curve_does_not_ring(name):
    preset = ov.load_preset(name)
    for levels in ([0.0, 0.0], *RAMPS.values()):
        for gesture in (ov.sweep(1.0), ov.sweep(4.0), ov.tap(1.0, 3.0), ov.tap(0.5, 3.0)):
            trace = ov.render(curve_of(levels), preset, gesture, RATE).trace
            assert trace.cursor.max() <= trace.theta2.max() / np.pi + 0.05
            assert trace.cursor.min() >= -0.01


@pytest.mark.filterwarnings("ignore:preset .* has no:overview_dsp.OverviewWarning")
@pytest.mark.parametrize("data", ["made-up-share", "world-cup-final-2018"])
@pytest.mark.parametrize("name", CURVED)
def test_a_full_tap_unfolds_so_that_it_can_be_read_and_recoils_more_slowly(name, data):
    result = ov.render(ov.load_timeline(data), ov.load_preset(name), ov.tap(1.0, 4.0), 16_000)
    trace = result.trace
    released = trace.time[trace.engaged > 0.5][-1]
    out = trace.time[np.argmax(trace.cursor >= 0.95)]
    back = trace.time[(trace.time > released) & (trace.cursor <= 0.05)][0] - released
    assert 0.9 <= out <= 2.5
    assert back > out


@pytest.mark.parametrize("name", CURVED)
def test_the_grain_carries_the_curve_to_the_ear_and_is_silent_at_rest(name):
    preset = ov.load_preset(name).with_values(surface__material="none")
    low, high = grain_db(preset)
    assert -50.0 <= high <= -32.0
    assert high - low >= 5.0 * LOUDNESS_STEP_DB
    rate = 48_000
    result = ov.render(curve_of(RAMPS["rising"]), preset, ov.sweep(4.0) + ov.pause(0.1), rate)
    spectrum = np.abs(np.fft.rfft(result.samples[: 4 * rate, 0])) ** 2
    above = np.fft.rfftfreq(4 * rate, 1.0 / rate) > 500.0
    assert spectrum[above].sum() >= 0.5 * spectrum.sum()
    assert not result.samples[-480:, 0].any()


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    return loader(tmp_path_factory.mktemp("curves") / "year.csv")


@pytest.fixture(scope="module")
def lessons(loaded):
    return shape_lessons(loaded)


@pytest.mark.parametrize("seconds", TOLD)
@pytest.mark.parametrize("name", first_in_gate(SERIES))
def test_rising_falling_flat_valley_and_hill_are_told_apart(lessons, name, seconds):
    assert shapes_told(lessons, ov.load_preset(name), seconds).mean() >= TOLD[seconds]


@pytest.fixture(scope="module")
def share_years(loaded, data_folder):
    """The bundled year and 44 real ones."""
    return real_share_years(data_folder, loaded)


@pytest.mark.parametrize("seconds", [4.0, 8.0])
@pytest.mark.parametrize("name", ["series", "stocks"])
def test_the_highest_and_the_lowest_third_of_a_share_year_are_felt(
    loaded, share_years, name, seconds
):
    assert thirds_told(loaded, share_years, ov.load_preset(name), seconds).mean() >= 0.88


def test_events_that_fill_a_window_up_do_not_hide_the_trend_of_a_share_year(tmp_path, data_folder):
    """Years as windows of files of many: learnt from made-up ones, asked about real ones."""
    learnt = years_of_files(made_up_prices(18), tmp_path)[:60]
    asked = years_of_files(real_prices(data_folder), tmp_path)
    assert np.mean([len(year.events) for year in asked]) > 80.0
    for name in ("series", "stocks"):
        preset = ov.load_preset(name)
        told = [third_of_windows(learnt, asked, preset, seconds) for seconds in (2.0, 4.0)]
        assert np.mean(told) >= 0.85
