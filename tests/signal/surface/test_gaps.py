"""Missing data: a surface of its own, felt as such, drawn as such."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.library import bundled_presets
from overview_dsp.kernels.layout import CELLS
from overview_dsp.measure.perceived_level import stroke_feel, strokes, window_db
from overview_dsp.measure.perception import JND_DB
from overview_dsp.offline.plots.paper import plot_strokes
from overview_dsp.offline.plots.timeline import plot_timeline
from overview_dsp.signal.surface.patterns import GROOVE, MIN_GAP_CELLS, ribs
from overview_dsp.units import JUST_NOTICEABLE_DB
from tests.examples import plain_preset, timeline_of

SWEEPS = (2.0, 3.0, 4.0, 6.0)
CASES = [(name, seconds) for name in bundled_presets() for seconds in SWEEPS]

CLEAR = ("crowd", "plain", "series", "weather", "football")
SMOOTH = [(name, seconds) for name, seconds in CASES if name.startswith(CLEAR)]
"""Presets whose base surface shows the data alone; others have teeth, beats, detents or slip."""

RATE = 16_000
"""The disk and its vibration are the same at any rate."""

SILENT_DB = -90.0
"""Nothing is felt below what a 16-bit output can give."""

BASE, GAP, HIGH, WAVES, FOULS = (0.12, 0.25), (0.3, 0.5), (0.58, 0.7), (0.78, 0.95), (0.0, 0.1)


def with_gaps(*gaps, duration=100.0):
    flat = ov.Intensity(np.array([0.0, duration]), np.array([0.0, 0.0]))
    return ov.Timeline("gaps", duration, (), flat, gaps=gaps)


def series_with_a_gap(gaps=((28.0, 52.0),)):
    """Two events, nothing, a gap, the top of the scale, and waves as long as the ribs of a gap."""
    at = np.linspace(0.0, 100.0, 5001)
    level = np.interp(at, [52.0, 53.0, 74.0, 75.0], [0.0, 1.0, 1.0, 0.0])
    level[at > 76.0] = 0.5 - 0.5 * np.cos(2.0 * np.pi * at[at > 76.0] / 2.0)
    events = (ov.Event(4.0, "foul"), ov.Event(7.0, "foul"))
    return ov.Timeline("a gap", 100.0, events, ov.Intensity(at, level), gaps=gaps)


def levels(result, part):
    """The levels (dB) while the disk moves out over a part of the timeline, as far as felt."""
    first, last = result.engine.surface.position_of(100.0 * np.array(part))
    (out, *_) = strokes(result.trace.touching, result.trace.cursor)
    starts, level = window_db(result.samples[out.start : out.stop, 1], result.sample_rate, 0.002)
    middle = (starts + 0.005 * result.sample_rate).astype(int)
    cursor = result.trace.cursor[out.start : out.stop][np.minimum(middle, out.stop - out.start - 1)]
    return np.maximum(level[(cursor > first) & (cursor < last)], SILENT_DB)


@pytest.fixture(scope="module")
def felt():
    timeline = series_with_a_gap()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ov.OverviewWarning)  # most have no fouls
        return {
            (name, seconds): ov.render(timeline, ov.load_preset(name), ov.sweep(seconds), RATE)
            for name, seconds in CASES
        }


def swing(result, part):
    level = levels(result, part)
    return np.percentile(level, 95) - np.percentile(level, 5)


@pytest.mark.parametrize("case", SMOOTH)
def test_a_gap_alternates_as_neither_a_level_nor_a_wave_of_the_data_does(felt, case):
    assert swing(felt[case], GAP) >= 3.0 * JUST_NOTICEABLE_DB
    for part in (BASE, HIGH, WAVES):
        assert swing(felt[case], GAP) - swing(felt[case], part) >= 1.5 * JUST_NOTICEABLE_DB


@pytest.mark.parametrize("case", SMOOTH)
def test_a_gaps_grooves_are_felt_below_the_bare_surface_and_its_ribs_above(felt, case):
    bare = np.median(levels(felt[case], BASE))
    gap = levels(felt[case], GAP)
    assert np.percentile(gap, 5) <= max(bare - JUST_NOTICEABLE_DB, SILENT_DB)
    assert np.percentile(gap, 95) >= bare + JND_DB


@pytest.mark.parametrize("case", CASES)
def test_a_gap_is_felt_apart_from_all_that_is_data(felt, case):
    """On a surface with teeth or clicks of its own too: by its level, or by how much it swings."""
    gap = levels(felt[case], GAP)
    for part in (BASE, HIGH, WAVES):
        level = np.median(gap) - np.median(levels(felt[case], part))
        change = swing(felt[case], GAP) - swing(felt[case], part)
        assert max(abs(level), abs(change)) >= 1.5 * JUST_NOTICEABLE_DB, part


@pytest.mark.parametrize("seconds", SWEEPS)
def test_a_gap_is_quieter_than_the_softest_event_and_strikes_nothing(felt, seconds):
    result = felt["football", seconds]
    (out, *_) = strokes(result.trace.touching, result.trace.cursor)
    surface = result.engine.surface
    feel = stroke_feel(out, surface, result.trace, result.samples[:, 1], result.sample_rate)
    assert feel.event_db.min() - levels(result, GAP).max() >= JUST_NOTICEABLE_DB
    assert sorted(result.strikes.event.tolist()) == [0, 0, 1, 1]


def test_a_gap_has_equal_ribs_and_begins_and_ends_with_a_groove():
    preset = plain_preset(surface__gap_height=3.0, surface__gap_period_percent=2.0)
    friction = ov.build_surface(with_gaps((20.0, 60.0)), preset).friction / 1e-3
    place = np.arange(CELLS + 1) / CELLS
    inside = (place >= 0.2) & (place <= 0.6)
    assert (friction[~inside] == 1.0).all()
    gap = friction[inside]
    assert gap.min() == pytest.approx(GROOVE, abs=1e-4)
    assert gap.max() == pytest.approx(3.0, abs=1e-4)
    assert gap[[0, -1]] == pytest.approx([GROOVE, GROOVE], abs=1e-3)
    crests = np.flatnonzero((gap[1:-1] > gap[:-2]) & (gap[1:-1] >= gap[2:]) & (gap[1:-1] > 2.0))
    assert len(crests) == 20
    assert np.diff(crests) == pytest.approx(0.02 * CELLS, abs=2.0)
    assert gap.mean() < 3.0 / 2.0


def test_events_in_a_gap_stay_where_and_as_high_as_they_are():
    timeline = timeline_of(40.0)
    preset = ov.load_preset("football")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        there = ov.build_surface(
            ov.Timeline("e", 100.0, timeline.events, None, gaps=((30.0, 50.0),)), preset
        )
        bare = ov.build_surface(timeline, preset)
    assert np.array_equal(there.position, bare.position)
    assert np.array_equal(there.release, bare.release)
    at = round(0.4 * CELLS)
    rise = bare.friction[at] - bare.friction.min()
    assert there.friction[at] - rise <= preset.number("surface.friction") * 1.8 + 1e-12


def test_without_gaps_the_parameters_of_gaps_change_no_bit(match, football):
    other = football.with_values(surface__gap_height=9.0, surface__gap_period_percent=0.3)
    assert np.array_equal(
        ov.build_surface(match, football).friction, ov.build_surface(match, other).friction
    )


def test_values_inside_a_gap_are_not_felt():
    at = np.array([0.0, 30.0, 40.0, 50.0, 100.0])
    quiet = ov.Intensity(at, np.array([0.5, 0.5, 0.0, 0.5, 0.5]))
    loud = ov.Intensity(at, np.array([0.5, 0.5, 1.0, 0.5, 0.5]))
    preset = plain_preset(surface__intensity_gain=4.0)
    one, other = (
        ov.build_surface(ov.Timeline("t", 100.0, (), curve, gaps=((30.0, 50.0),)), preset)
        for curve in (quiet, loud)
    )
    assert np.array_equal(one.friction, other.friction)


def test_a_gap_too_narrow_for_a_rib_is_a_groove_and_is_named():
    gaps = ((20.0, 20.5), (50.0, 50.001), (70.0, 80.0))
    with pytest.warns(ov.OverviewWarning, match="2 gaps are too narrow.*narrowest: 0.001 s") as got:
        surface = ov.build_surface(with_gaps(*gaps), plain_preset())
    assert len(got) == 1
    place = np.arange(CELLS + 1) / CELLS
    first = surface.friction[(place > 0.2001) & (place < 0.2049)]
    assert first == pytest.approx(np.full(len(first), GROOVE * 1e-3))
    tiny = surface.friction[(place > 0.49) & (place < 0.51)]
    assert MIN_GAP_CELLS - 1 <= np.count_nonzero(tiny < 0.5e-3) <= MIN_GAP_CELLS + 1


def test_a_zoom_into_a_narrow_gap_shows_its_ribs_without_a_warning():
    timeline = with_gaps((20.0, 20.5))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        surface = ov.build_surface(timeline.window(19.0, 22.0), plain_preset())
    assert surface.friction.max() == pytest.approx(1.8e-3, rel=1e-3)


@given(st.data())
def test_every_gap_of_any_list_has_points_on_the_table_and_nothing_else_has(data):
    edges = sorted(data.draw(st.sets(st.floats(0.0, 100.0, allow_subnormal=False), max_size=30)))
    gaps = tuple(zip(edges[::2], edges[1::2], strict=False))
    if not gaps:
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ov.OverviewWarning)
        inside, friction = ribs(gaps, 100.0, 4096, 2.0, 2.0)
    assert len(friction) == np.count_nonzero(inside)
    assert np.isfinite(friction).all()
    assert (friction >= GROOVE).all()
    assert (friction <= 2.0).all()
    place = np.arange(4097) / 4096 * 100.0
    near = MIN_GAP_CELLS / 4096 * 100.0
    for start, end in gaps:
        assert inside[(place >= start) & (place <= end)].all()
        assert inside[(place >= start - near) & (place <= end + near)].any()
    allowed = np.zeros(4097, dtype=bool)
    for start, end in gaps:
        allowed |= (place >= start - near) & (place <= end + near)
    assert not inside[~allowed].any()


def test_a_timelines_gaps_are_hatched_and_no_line_is_drawn_over_them():
    figure = plot_timeline(series_with_a_gap())
    (axes,) = figure.axes
    (band,) = [patch for patch in axes.patches if patch.get_hatch()]
    box = band.get_extents().transformed(axes.transData.inverted())
    assert (box.x0, box.x1) == pytest.approx((28.0, 52.0))
    curve = max(axes.lines, key=lambda line: len(line.get_xdata()))
    x, y = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
    column = x[1] - x[0]  # columns at the edges of the gap have known points
    assert np.isnan(y[(x > 28.0 + column) & (x < 52.0 - column)]).all()
    assert np.isfinite(y[(x < 28.0) | (x > 52.0)]).all()
    legend = axes.get_legend()
    assert legend is not None
    assert "no data (1)" in [text.get_text() for text in legend.get_texts()]
    (axes,) = plot_timeline(with_gaps()).axes
    assert not [patch for patch in axes.patches if patch.get_hatch()]


def test_the_surface_under_the_disk_is_hatched_where_data_is_missing(football):
    timeline = series_with_a_gap()
    linear = football.with_values(surface__angle_map=0.0)
    result = ov.render(timeline, linear, ov.sweep(0.5), 8000)
    axes = plot_strokes([("a sweep", result)], timeline, "a title").axes[3]
    (band,) = [patch for patch in axes.patches if patch.get_hatch()]
    box = band.get_extents().transformed(axes.transData.inverted())
    gap = result.engine.surface.position_of(timeline.gaps[0]) * np.pi
    assert (box.y0, box.y1) == pytest.approx(tuple(gap))
