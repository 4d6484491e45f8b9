from __future__ import annotations

import io
import os
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import overview_dsp as ov
from overview_dsp.offline.plots.paper import draw, plot_strokes, renders
from overview_dsp.offline.plots.style import KIND_STYLE, extremes, save_figure, styles_of
from overview_dsp.offline.plots.timeline import plot_timeline
from tests.examples import preset_with, timeline_of

FIGURES = ("figure-4", "figure-5", "figure-6")


@pytest.fixture(scope="module")
def results(match, football):
    return renders(match, football)


@pytest.fixture(scope="module")
def drawn(match, results, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")
    return folder, draw(match, results, folder)


def small_match() -> ov.Timeline:
    """One event of every kind the plots know, and two they don't."""
    kinds = [*KIND_STYLE, "comet", "meteor"]
    events = tuple(ov.Event(10.0 + 2.0 * i, kind, f"{kind} x") for i, kind in enumerate(kinds))
    return ov.Timeline("every kind", 100.0, events, None)


def test_the_papers_figures_are_written_as_png_and_svg(drawn):
    folder, files = drawn
    assert [path.name for path in files] == [f"{f}.{s}" for f in FIGURES for s in ("png", "svg")]
    assert sorted(os.listdir(folder)) == sorted(path.name for path in files)


@pytest.mark.parametrize("name", FIGURES)
def test_a_picture_decodes_and_is_not_blank(drawn, name):
    from matplotlib.image import imread

    pixels = imread(drawn[0] / f"{name}.png")
    assert pixels.ndim == 3
    assert min(pixels.shape[:2]) > 300
    grey = pixels[:, :, :3].mean(axis=2)
    assert 0.01 < np.mean(grey < 0.9) < 0.9


@pytest.mark.parametrize("name", FIGURES)
def test_a_drawing_is_well_formed_and_has_its_words_as_text(drawn, name):
    from xml.etree import ElementTree

    root = ElementTree.parse(drawn[0] / f"{name}.svg").getroot()
    assert root.tag.endswith("svg")
    words = " ".join("".join(element.itertext()) for element in root.iter())
    expected = {
        "figure-4": ("World Cup", "goal", "foul", "intensity"),
        "figure-5": ("fast sweep", "slow sweep", "torque", "disk 1", "disk 2", "friction"),
        "figure-6": ("tap", "torque", "disk 1", "disk 2", "friction"),
    }
    for word in expected[name]:
        assert word in words


def test_the_same_figures_give_the_same_bytes(drawn, match, results, tmp_path):
    for first, second in zip(drawn[1], draw(match, results, tmp_path), strict=True):
        assert first.read_bytes() == second.read_bytes()


def test_event_kinds_differ_by_the_shape_of_their_marker_and_not_by_colour_alone():
    styles = styles_of(small_match())
    assert set(styles) == {*KIND_STYLE, "comet", "meteor"}
    markers = [marker for marker, _, _ in styles.values()]
    assert len(set(markers)) == len(markers)
    words = [text for _, _, text in styles.values()]
    assert len(set(words)) == len(words)


def shapes_of(axes) -> dict[str, bytes]:
    """The outline of the marker of each entry of the legend."""
    return {
        str(collection.get_label()): collection.get_paths()[0].vertices.tobytes()
        for collection in axes.collections
        if not str(collection.get_label()).startswith("_")
    }


def test_every_kind_of_the_timeline_is_drawn_with_a_shape_of_its_own():
    figure = plot_timeline(small_match())
    (axes,) = figure.axes
    shapes = shapes_of(axes)
    assert len(shapes) == len(KIND_STYLE) + 2
    assert len(set(shapes.values())) == len(shapes)
    legend = axes.get_legend()
    assert legend is not None
    assert {text.get_text() for text in legend.get_texts()} == set(shapes)


def test_the_events_of_two_teams_have_a_row_each_above_the_curve_and_others_lie_on_it(match):
    (axes,) = plot_timeline(match).axes
    offsets = np.concatenate([np.asarray(one.get_offsets()) for one in axes.collections])
    heights = {
        side: [level for x, level in offsets.tolist() if any(
            event.side == side and abs(event.time_s / 60.0 - x) < 1e-6 for event in match.events
        )]
        for side in (0, 1, 2)
    }  # fmt: skip
    (first,), (second,) = ({*heights[1]}, {*heights[2]})
    assert first > second > max(heights[0])
    assert [text.get_text() for text in axes.texts][:2] == ["France", "Croatia"]
    assert max(axes.get_yticks()) <= 1.18 < second < first < axes.get_ylim()[1]
    plain = tuple(replace(event, side=0) for event in match.events)
    (axes,) = plot_timeline(replace(match, sides=(), events=plain)).axes
    assert axes.get_ylim()[1] == 1.18
    offsets = np.concatenate([np.asarray(one.get_offsets()) for one in axes.collections])
    np.testing.assert_allclose(offsets[:, 1], match.intensity_at(60.0 * offsets[:, 0]), atol=1e-6)


def test_a_kind_has_one_symbol_in_all_pictures():
    kinds = ("goal", "comet", "meteor", "peak", "beat")
    together = styles_of(ov.Timeline("x", 9.0, tuple(ov.Event(1.0, kind) for kind in kinds)))
    assert len({style[0] for style in together.values()}) == len(kinds)
    for kind in kinds:
        assert styles_of(ov.Timeline("x", 9.0, (ov.Event(1.0, kind),)))[kind] == together[kind]


def test_data_are_in_their_unit_beside_what_is_felt():
    values = np.linspace(-40.0, 60.0, 101)
    curve = ov.Intensity(np.arange(101.0), values, "°C", (10.0, 90.0))
    timeline = ov.Timeline("x", 100.0, (ov.Event(50.0, "peak"),), curve)
    (axes,) = plot_timeline(timeline).axes
    assert axes.get_ylabel() == "°C"
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), values)
    assert axes.collections[0].get_offsets()[0].tolist() == [50.0, 10.0]
    (felt,) = axes.child_axes
    assert felt.get_ylabel() == "intensity"
    axes.figure.savefig(io.BytesIO())  # sets the right axis
    low, high = axes.get_ylim()
    np.testing.assert_allclose(felt.get_ylim(), [(low + 30.0) / 80.0, (high + 30.0) / 80.0])


def test_dense_data_are_their_mean_in_the_band_of_their_extremes():
    values = np.random.default_rng(3).standard_normal(100_000)
    values[31_234] = 50.0
    values[77_777] = -60.0
    values[80_000:81_000] = -40.0
    curve = ov.Intensity(np.arange(100_000.0), values, "V")
    (axes,) = plot_timeline(ov.Timeline("x", 99_999.0, (), curve, ((5e4, 6e4),))).axes
    areas = [path.vertices[:, 1] for path in axes.collections[0].get_paths()]
    heights = np.concatenate(areas)
    assert (heights.min(), heights.max()) == (-60.0, 50.0)
    x, mean = axes.lines[0].get_data()
    assert np.nanmax(mean) < 1.0
    column = x[1] - x[0]  # columns at the edges of the gap have known points
    inside = (x > 5e4 / 3600.0 + column) & (x < 6e4 / 3600.0 - column)
    assert np.isnan(mean[inside]).all()
    assert np.nanmin(mean) == pytest.approx(-40.0)


def test_a_wide_gap_is_named_in_the_picture():
    curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 1.0]))
    (axes,) = plot_timeline(ov.Timeline("x", 10.0, (), curve, ((2.0, 4.0), (6.0, 6.1)))).axes
    assert [text.get_text() for text in axes.texts] == ["no data"]
    assert "no data (2)" in [text.get_text() for text in axes.get_legend().get_texts()]


def test_events_without_a_curve_have_a_row_a_kind():
    events = (ov.Event(1.0, "talk"), ov.Event(4.0, "laugh"), ov.Event(6.0, "laugh"))
    (axes,) = plot_timeline(ov.Timeline("x", 9.0, events)).axes
    assert [text.get_text() for text in axes.get_yticklabels()] == ["laugh", "talk"]
    assert sorted({float(c.get_offsets()[0][1]) for c in axes.collections}) == [0.0, 1.0]


def test_a_recording_is_drawn_under_its_rate():
    signal = ov.Intensity(np.arange(1000.0) / 100.0, np.sin(np.arange(1000.0)), "MLII")
    rate = ov.Intensity(np.array([0.0, 9.0]), np.array([60.0, 80.0]), "bpm")
    timeline = ov.Timeline("x", 10.0, (), rate, signal=signal)
    above, below = plot_timeline(timeline).axes
    assert (above.get_ylabel(), below.get_ylabel()) == ("bpm", "MLII")
    np.testing.assert_array_equal(below.lines[0].get_ydata(), signal.value)
    part = timeline.window(2.0, 4.0)
    assert part.signal.last_s == 2.0
    assert len(plot_timeline(part).axes) == 2


def test_the_timelines_events_are_where_they_happen():
    figure = plot_timeline(small_match())
    (axes,) = figure.axes
    drawn = sorted(
        float(x)
        for collection in axes.collections
        for x in np.asarray(collection.get_offsets())[:, 0]
        if not str(collection.get_label()).startswith("_")
    )
    assert drawn == [event.time_s for event in small_match().events]


def test_strikes_are_marked_by_kind_at_their_times():
    some = ("goal", "own_goal", "yellow_card", "peak", "comet", "meteor")
    events = tuple(event for event in small_match().events if event.kind in some)
    timeline = replace(small_match(), events=events)
    preset = preset_with(height=20.0)
    kinds = {**preset.kinds, **dict.fromkeys(timeline.kinds(), preset.kinds["default"])}
    result = ov.render(timeline, replace(preset, kinds=kinds), ov.sweep(0.4), 8000)
    figure = plot_strokes([("a sweep", result)], timeline, "a title")
    shapes = shapes_of(figure.axes[0])
    assert {"goal", "comet", "meteor"} <= set(shapes)
    assert len(set(shapes.values())) == len(shapes)
    goals = next(c for c in figure.axes[0].collections if c.get_label() == "goal")
    struck = result.strikes.time_s[
        [timeline.events[event].kind == "goal" for event in result.strikes.event]
    ]
    assert np.asarray(goals.get_offsets())[:, 0].tolist() == struck.tolist()


def test_the_finger_is_drawn_beside_a_clutch_that_slips():
    timeline, hand = timeline_of(), ov.tap(0.75, 0.2)
    preset = preset_with().with_changes(
        {"clutch.max_speed_ratio": 1.1, "clutch.tap_duration_s": 2.0}
    )
    result = ov.render(timeline, preset, hand, 8000)
    panel = plot_strokes([("a tap", result)], timeline, "a title", [hand]).axes[4]
    disk, finger = (
        np.asarray(line.get_ydata()) for line in panel.get_lines() if len(line.get_ydata()) > 2
    )
    assert finger.max() == np.pi * 0.75
    # the clutch has let go: the disk is pulled from behind the finger
    held = finger > 0.0
    assert np.min(disk[held]) < 0.5 * finger.max()


@pytest.mark.parametrize(
    ("timeline", "gesture"),
    [
        (timeline_of(), ov.tap(0.5, 0.1)),
        (timeline_of(50.0), ov.pause(0.1)),
        (timeline_of(50.0), ov.tap(0.0, 0.1)),
    ],
    ids=["no events", "no touch", "no movement"],
)
def test_a_gesture_without_events_can_be_drawn(timeline, gesture, recwarn, tmp_path):
    result = ov.render(timeline, preset_with(), gesture, 8000)
    save_figure(plot_strokes([("nothing", result)], timeline, "nothing"), tmp_path / "a")
    assert not recwarn.list


def test_a_timeline_without_events_or_without_a_curve_can_be_drawn(recwarn):
    for timeline in (timeline_of(), timeline_of(3.0)):
        plot_timeline(timeline).savefig(io.BytesIO())
    assert not recwarn.list


@pytest.mark.parametrize("stem", ["no/a", "file/a"])
def test_a_picture_that_cannot_be_written_is_an_error_of_one_line(tmp_path, stem):
    (tmp_path / "file").write_text("")
    with pytest.raises(ov.InputError, match="can't be written") as error:
        save_figure(plot_timeline(timeline_of()), tmp_path / stem)
    assert "\n" not in str(error.value)
    assert os.listdir(tmp_path) == ["file"]


@given(
    hnp.arrays(np.float64, st.integers(0, 400), elements=st.floats(-1e9, 1e9)),
    st.integers(1, 60),
)
def test_a_curve_with_fewer_points_keeps_its_lowest_and_its_highest(values, points):
    at = np.arange(len(values), dtype=np.float64)
    x, y = extremes(at, values, points)
    assert len(x) == len(y) <= max(len(values), 2 * points)
    if len(values):
        assert (y.min(), y.max()) == (values.min(), values.max())
        assert (np.diff(x) >= 0.0).all()
        # nothing is moved by more than a step
        step = max(1.0, len(values) / points)
        for place, value in zip(x, y, strict=True):
            assert np.abs(at[values == value] - place).min() <= step


def test_a_short_curve_is_left_as_it_is():
    x, y = np.arange(20.0), np.sin(np.arange(20.0))
    assert extremes(x, y, 10) == (x, y)
