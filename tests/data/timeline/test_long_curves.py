"""Curves of many points: kept small, cut without copying, shown at any width with their peaks."""

from __future__ import annotations

import gc
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.readers.data_file import parse_json
from overview_dsp.data.readers.native import MAX_POINTS, decode, encode
from overview_dsp.data.timeline import Intensity, Timeline, curve_points
from overview_dsp.data.timeline import growable_array as store_module
from overview_dsp.data.timeline.curve_builder import CurveBuilder
from overview_dsp.data.timeline.curve_points import Points, RegularTimes
from overview_dsp.data.timeline.growable_array import Store
from overview_dsp.data.timeline.intensity import LONG, WIDENED, CurveWindow, with_peaks
from overview_dsp.data.timeline.minmax_pyramid import BIN, RATIO, build_pyramid
from overview_dsp.errors import InputError, OutputError
from overview_dsp.kernels.layout import CELLS
from tests.examples import plain_preset

N = 1_500_000
STEP = 0.01


def noisy(count: int = N, peaks: dict[int, float] | None = None) -> np.ndarray:
    random = np.random.default_rng(3)
    value = np.sin(np.arange(count) * (4 * np.pi / count)) + 0.05 * random.standard_normal(count)
    for at, height in (peaks or {}).items():
        value[at] = height
    return value


def long_timeline(value: np.ndarray, gaps: tuple[tuple[float, float], ...] = ()) -> Timeline:
    curve = Intensity(RegularTimes(len(value), STEP), value, "x")
    return Timeline("long", (len(value) - 1) * STEP, (), curve, gaps)


# --- times that aren't stored -------------------------------------------------------------------


def test_even_times_read_like_an_array() -> None:
    times = RegularTimes(5, 0.5, 2.0)
    assert times.tolist() == [2.0, 2.5, 3.0, 3.5, 4.0]
    assert (len(times), times[0], times[-1]) == (5, 2.0, 4.0)
    assert times[1:3].tolist() == [2.5, 3.0]
    assert np.asarray(times).tolist() == times.tolist()
    with pytest.raises(IndexError):
        times[5]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((0, 1.0), "no points"),
        ((3, 0.0), "step_s is 0.0, not above 0"),
        ((3, float("nan")), "step_s is nan"),
        ((3, 1.0, -1.0), "first_s is -1.0, before the start"),
        ((3, 1e-9, 1e15), "too close together"),
        ((3, 1e308), "too close together"),
    ],
)
def test_even_times_that_are_none_are_refused(given: tuple, words: str) -> None:
    with pytest.raises(InputError, match=words):
        RegularTimes(*given)


@given(
    st.integers(1, 200),
    st.floats(1e-6, 1e6),
    st.floats(0.0, 1e6),
    st.lists(st.floats(-1e7, 1e9), max_size=20),
)
def test_even_times_are_found_as_in_an_array(
    count: int, step: float, first: float, wanted: list[float]
) -> None:
    try:
        times = RegularTimes(count, step, first)
    except InputError:
        return
    stored = np.asarray(times)
    near = [*wanted, *stored, *np.nextafter(stored, -1), *np.nextafter(stored, 1e300)]
    at = np.array(near)
    assert times.first_from(at).tolist() == np.searchsorted(stored, at, "left").tolist()
    assert times.first_after(at).tolist() == np.searchsorted(stored, at, "right").tolist()


# --- the pyramid --------------------------------------------------------------------------------


@given(st.integers(1, 20_000), st.integers(1, 5000), st.sampled_from((np.float32, np.float64)))
def test_every_bin_has_the_extremes_and_the_mean_of_its_values(
    count: int, chunk: int, dtype: type
) -> None:
    from overview_dsp.data.timeline.minmax_pyramid import PyramidBuilder

    value = np.random.default_rng(count).standard_normal(count).astype(dtype)
    builder = PyramidBuilder(dtype)
    for start in range(0, count, chunk):
        builder.append(value[start : start + chunk])
    levels = builder.finish()
    assert [level.width for level in levels] == [BIN * RATIO**k for k in range(len(levels))]
    for level in levels:
        assert len(level.low) == -(-count // level.width)
        starts = np.arange(0, count, level.width)
        assert np.array_equal(level.low, np.minimum.reduceat(value, starts))
        assert np.array_equal(level.high, np.maximum.reduceat(value, starts))
        whole = count // level.width
        means = (
            value[: whole * level.width].reshape(whole, level.width).mean(axis=1, dtype=np.float64)
        )
        np.testing.assert_allclose(level.mean[:whole], means, atol=2e-6)


@given(st.data())
def test_the_extremes_of_any_stretches_are_exact(data: st.DataObject) -> None:
    count = data.draw(st.sampled_from((1, 17, 1000, 400_000)))
    value = np.random.default_rng(1).standard_normal(count)
    points = Points(RegularTimes(count, 1.0), value)
    edges = data.draw(st.sets(st.integers(0, count), min_size=2, max_size=40))
    ascending = np.array(sorted(edges)[: len(edges) // 2 * 2])
    first, stop = ascending[::2], ascending[1::2]
    inside = np.concatenate([value[a:b] for a, b in zip(first, stop, strict=True)])
    assert points.extremes(first, stop) == (inside.min(), inside.max())


# --- windows ------------------------------------------------------------------------------------


def test_a_long_window_is_a_view_and_a_short_one_is_as_it_ever_was() -> None:
    value = noisy()
    timeline = long_timeline(value)
    assert isinstance(timeline.window(100.0, 9000.0).intensity, CurveWindow)
    stored = Intensity(np.arange(N) * STEP, value, "x")
    for start, end in ((100.0, 400.123), (0.0, 50.0), (14_900.0, 14_999.99)):
        one, other = timeline.intensity.cut(start, end), stored.cut(start, end)  # type: ignore[union-attr]
        assert one == other
        assert not isinstance(one, CurveWindow)


def test_a_window_of_a_window_has_the_values_of_the_same_moments() -> None:
    timeline = long_timeline(noisy())
    at = np.linspace(0.0, 7000.0, 10_001)
    part = timeline.window(1000.003, 13_000.0).window(2000.0, 12_000.0 - 0.5)
    there = timeline.intensity_at(at + 3000.003)
    np.testing.assert_allclose(part.intensity_at(at), there, atol=1e-7)
    assert part.intensity is not None
    assert part.intensity_at(part.duration_s) != 0.0
    assert part.intensity_at([-0.001, part.duration_s + 0.001]).tolist() == [0.0, 0.0]


def test_a_view_materialises_with_its_ends_where_it_is_asked_for_its_points() -> None:
    timeline = long_timeline(noisy())
    part = timeline.window(10.005, 5000.005).intensity
    assert part is not None
    assert part.count == len(part.time_s) == len(part.value)
    assert (part.time_s[0], part.time_s[-1]) == (0.0, part.last_s)
    assert (np.diff(np.asarray(part.time_s)) > 0).all()
    again = Intensity(np.asarray(part.time_s), part.value, "x")
    assert part == again
    assert hash(part) == hash(again)
    probe = np.linspace(0.0, part.last_s, 5001)
    np.testing.assert_allclose(part.at(probe), again.at(probe), atol=1e-7)


def test_a_window_of_a_long_series_costs_no_copy() -> None:
    timeline = long_timeline(noisy())
    timeline.window(1.0, 14_000.0)
    tracemalloc.start()
    timeline.window(1.0, 14_000.0)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 100_000


def test_a_series_too_long_for_a_native_file_is_refused_and_its_windows_are_not() -> None:
    count = MAX_POINTS + 1
    curve = Intensity(RegularTimes(count, 1.0), np.zeros(count, np.float32))
    timeline = Timeline("t", float(count), (), curve)
    with pytest.raises(InputError, match=rf"{count} points.*{MAX_POINTS}.*shorter window"):
        encode(timeline)
    part = timeline.window(0.0, 100_000.0)
    again = decode(parse_json(encode(part).decode(), "x"))
    assert again.intensity == part.intensity


# --- surfaces -----------------------------------------------------------------------------------


def felt(timeline: Timeline) -> np.ndarray:
    preset = plain_preset(surface__friction=1e-3, surface__intensity_gain=1.0)
    return np.log2(ov.build_surface(timeline, preset).friction / 1e-3)


@pytest.mark.parametrize("count", [LONG + 1, 3 * LONG, N])
def test_a_single_high_sample_is_felt_at_its_full_height_at_its_place(count: int) -> None:
    at = count // 3
    friction = felt(long_timeline(noisy(count, {at: 4.0})))
    assert friction.max() == pytest.approx(1.0, rel=1e-6)
    ridge = np.flatnonzero(friction > 0.9) / CELLS * (count - 1)
    assert abs(ridge.mean() - at) <= count / CELLS
    if count > 2 * LONG:  # else it is as it would be interpolated
        assert len(ridge) == pytest.approx(2 * WIDENED * CELLS + 1, abs=2)


def test_noise_is_felt_as_its_mean_and_not_as_its_peaks() -> None:
    value = noisy()
    friction = felt(long_timeline(value))
    low, high = value.min(), value.max()
    smooth = np.sin(np.linspace(0.0, 4 * np.pi, CELLS + 1))
    inner = slice(100, -100)
    # a place holds 23 samples: the mean's own spread is 0.05 / sqrt(23)
    error = friction * (high - low) + low - smooth
    assert np.abs(error[inner]).mean() < 0.012
    assert abs(error[inner].mean()) < 0.002


def test_a_smooth_curve_is_the_same_by_runs_as_by_interpolation() -> None:
    at = np.arange(N)
    value = np.sin(at * (60 * np.pi / N)) + 2.0
    friction = felt(long_timeline(value))
    exact = (np.interp(np.linspace(0, N - 1, CELLS + 1), at, value) - 1.0) / 2.0
    assert np.abs(friction - exact).max() < 2e-3


@pytest.mark.parametrize("window", [(0.0, 14_999.0), (1000.0, 9000.0), (5000.0, 5700.0)])
def test_peaks_are_kept_in_windows_of_every_width(window: tuple[float, float]) -> None:
    timeline = long_timeline(noisy(peaks={530_000: 4.0}))
    friction = felt(timeline.window(*window))
    assert friction.max() == pytest.approx(1.0, rel=1e-6)
    place = (5300.0 - window[0]) / (window[1] - window[0])
    assert abs(friction.argmax() / CELLS - place) < 0.001


def test_up_to_a_point_a_place_it_is_the_interpolation_to_the_bit() -> None:
    value = noisy(LONG)
    for times in (RegularTimes(LONG, STEP), np.arange(LONG) * STEP):
        timeline = Timeline("s", (LONG - 1) * STEP, (), Intensity(times, value))
        at = np.arange(CELLS + 1) * (timeline.duration_s / CELLS)
        assert np.array_equal(
            timeline.normalised_levels(CELLS), timeline.normalised_intensity_at(at)
        )


def test_uneven_times_have_their_samples_at_their_places() -> None:
    # dense, then one sample an hour: where there are none, the line between
    dense = np.arange(200_000) * 0.01
    sparse = 2000.0 + 3600.0 * np.arange(1, 40)
    times = np.concatenate((dense, sparse))
    value = np.concatenate((np.zeros(200_000), np.linspace(0.1, 1.0, 39)))
    value[123_456] = 1.0
    timeline = Timeline("u", float(times[-1]), (), Intensity(times, value))
    levels = timeline.normalised_levels(CELLS)
    at = np.arange(CELLS + 1) * (timeline.duration_s / CELLS)
    late = at > 3000.0
    np.testing.assert_allclose(levels[late], np.interp(at[late], times, value), atol=1e-4)
    assert levels[np.abs(at - 1234.56) < 5.0].max() == 1.0


def test_the_ends_beyond_the_curve_are_bare() -> None:
    curve = Intensity(RegularTimes(N, STEP, 5000.0), noisy() + 5.0, "x")
    levels = Timeline("t", 30_000.0, (), curve).normalised_levels(CELLS)
    at = np.arange(CELLS + 1) * (30_000.0 / CELLS)
    outside = (at < 5000.0) | (at > curve.last_s)
    assert (levels[outside] == 0.0).all()
    assert levels[~outside].max() > 0.9


def test_the_scale_leaves_out_what_lies_in_gaps() -> None:
    value = noisy(peaks={700_000: 99.0})
    with_gap = long_timeline(value, ((6989.995, 7010.005),))
    inside = slice(699_000, 701_001)
    outside = np.delete(value, inside)
    top = value.copy()
    top[inside] = -9.0
    assert with_gap.normalised_intensity_at(top.argmax() * STEP) == pytest.approx(1.0)
    assert with_gap.scale == (outside.min(), outside.max() - outside.min())
    assert long_timeline(value).scale[1] == 99.0 - value.min()


def test_percentiles_of_a_long_curve_are_near_those_of_all_its_values() -> None:
    value = noisy(peaks={5: 1e6})
    curve = Intensity(RegularTimes(N, STEP), value, "x", (2.0, 98.0))
    low, span = Timeline("p", N * STEP, (), curve).scale
    expected = np.percentile(value, (2.0, 98.0))
    assert (low, low + span) == pytest.approx(expected, abs=0.03)


def test_peaks_in_flat_surroundings_and_in_noise() -> None:
    mean = np.zeros(10_000)
    top = np.zeros(10_000)
    top[500] = 1.0
    reach = round(WIDENED * 10_000)
    assert reach == 5
    felt_at = np.flatnonzero(with_peaks(mean, top)).tolist()
    assert felt_at == list(range(500 - reach, 500 + reach + 1))
    random = np.random.default_rng(2)
    top = 0.3 + 0.05 * random.standard_normal(10_000)
    assert with_peaks(mean, top).max() == 0.0
    top[500] = 0.9
    assert with_peaks(mean, top).max() == 0.9


# --- built in chunks ----------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_curve_built_in_chunks_is_the_curve_of_the_whole(dtype: type) -> None:
    value = noisy(200_000).astype(dtype)
    builder = CurveBuilder(dtype)
    for start in range(0, len(value), 7777):
        builder.append(value[start : start + 7777])
    built = builder.finish(step_s=STEP, unit="x")
    whole = Intensity(RegularTimes(len(value), STEP), value, "x")
    assert built == whole
    assert built.value.dtype == dtype
    for one, other in zip(built.points.levels, build_pyramid(value), strict=True):
        assert np.array_equal(one.high, other.high)
    assert builder.gaps(2000.0) == ()


def test_a_long_series_goes_to_a_file_that_nobody_sees_and_that_vanishes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(store_module, "SPILL_BYTES", 100_000)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    builder = CurveBuilder()
    value = noisy(100_000)
    for start in range(0, len(value), 5000):
        builder.append(value[start : start + 5000], np.arange(start, start + 5000) * STEP)
    curve = builder.finish()
    assert isinstance(curve.value, np.memmap)
    assert isinstance(curve.time_s, np.memmap)
    assert np.array_equal(curve.value, value)
    assert os.name == "nt" or os.listdir(tmp_path) == []
    assert curve.points.extremes(np.array([0]), np.array([100_000])) == (value.min(), value.max())
    part = Timeline("t", 999.99, (), curve).window(10.0, 990.0)
    assert ov.build_surface(part, plain_preset()).friction.shape == (CELLS + 1,)
    del curve, part, builder
    gc.collect()
    assert os.listdir(tmp_path) == []


def test_memory_stays_bounded_while_a_long_series_is_built(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(store_module, "SPILL_BYTES", 1 << 20)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    chunk = np.zeros(100_000)
    tracemalloc.start()
    builder = CurveBuilder()
    for _ in range(100):  # 80 MB
        builder.append(chunk)
    builder.finish(step_s=1.0)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 16e6


def test_a_full_temporary_folder_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_module, "SPILL_BYTES", 0)

    class Full:
        def write(self, data: object) -> None:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.TemporaryFile", lambda prefix: Full())
    with pytest.raises(OutputError, match=r"No space left.*TMPDIR"):
        Store(np.float64).append(np.zeros(10))


@given(
    st.lists(st.sampled_from((0.0, 1.0, 2.0, float("nan"))), min_size=1, max_size=60),
    st.integers(1, 20),
    st.booleans(),
)
def test_missing_values_are_gaps_from_the_last_known_to_the_next(
    values: list[float], chunk: int, timed: bool
) -> None:
    builder = CurveBuilder()
    row = np.array(values)
    times = np.arange(len(row)) * 2.0 + 1.0
    for start in range(0, len(row), chunk):
        some = slice(start, start + chunk)
        builder.append(row[some], times[some] if timed else None)
    known = np.flatnonzero(~np.isnan(row))
    if not len(known):
        with pytest.raises(InputError, match="no value"):
            builder.finish(None if timed else 2.0, 1.0)
        return
    curve = builder.finish() if timed else builder.finish(2.0, 1.0)
    assert np.array_equal(curve.time_s, times)
    assert np.array_equal(np.asarray(curve.value)[known], row[known])
    assert set(np.asarray(curve.value)) <= set(row[known])
    edges = [-1, *known.tolist(), len(row)]
    at = [0.0, *times[known].tolist(), 200.0]
    expected = tuple(
        (at[i], at[i + 1]) for i in range(len(edges) - 1) if edges[i + 1] - edges[i] > 1
    )
    assert builder.gaps(200.0) == expected


@pytest.mark.parametrize(
    ("chunks", "step", "words"),
    [
        ([([1.0], None), ([np.inf], None)], 1.0, r"value\[1\] is inf"),
        ([([1.0, -1e301], None)], 1.0, r"value\[1\] is -1e\+301"),
        ([([1.0], [0.0]), ([2.0], [0.0])], None, r"time_s\[1\] is 0\.0, not after.*\(0\.0\)"),
        ([([1.0, 2.0], [0.0, -1.0])], None, r"time_s\[1\] is -1\.0, not after"),
        ([([1.0], [-1.0])], None, r"time_s\[0\] is -1\.0, before the start"),
        ([([1.0], [np.nan])], None, r"time_s\[0\] is nan"),
        ([([1.0], [0.0, 1.0])], None, "1 values has 2 times"),
        ([([1.0], [0.0]), ([1.0], None)], None, "no times, the ones before"),
        ([([1.0], None), ([1.0], [2.0])], None, "has times, the ones before"),
        ([([1.0], None)], None, "times.*or the step"),
        ([([1.0], [0.0])], 1.0, "not both"),
        ([], 1.0, "no value"),
    ],
)
def test_chunks_that_make_no_curve_are_one_line(chunks: list, step: float, words: str) -> None:
    def build() -> None:
        builder = CurveBuilder()
        for values, times in chunks:
            builder.append(values, times)
        builder.finish(step)

    with pytest.raises(InputError, match=words) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_values_beyond_float32_are_refused_where_that_was_asked_for() -> None:
    with pytest.raises(InputError, match=r"float32.*float64"):
        CurveBuilder(np.float32).append([1e39])


@given(st.data(), st.sampled_from([np.float32, np.float64]), st.sampled_from([3, 200]))
def test_the_largest_of_each_run_is_what_numpy_finds(data, dtype, runs):
    random = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    row = (random.standard_normal(600) + data.draw(st.integers(-4, 4))).astype(dtype)
    row[random.random(600) < 0.1] = data.draw(st.sampled_from([0.0, -0.0]))
    starts = np.unique(random.integers(0, 600, runs))
    assert np.array_equal(curve_points._largest(row, starts), np.maximum.reduceat(row, starts))
