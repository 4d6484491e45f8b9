from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import SHAPES
from overview_dsp.kernels.layout import CELLS
from overview_dsp.signal.surface.build import MIN_WIDTH_CELLS
from overview_dsp.signal.surface.profiles import profile
from tests.data.timeline.strategies import timelines, without_ticks
from tests.design.presets.strategies import presets
from tests.examples import plain_preset, preset_with, timeline_of

PLACES = np.arange(CELLS + 1) / CELLS


@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
@given(timelines(), presets())
def test_any_preset_on_any_timeline_gives_a_surface_with_friction_everywhere(timeline, preset):
    surface = ov.build_surface(timeline, preset)
    assert surface.friction.shape == (CELLS + 1,)
    assert np.isfinite(surface.friction).all()
    bare = preset.number("surface.friction")
    if preset.number("surface.rank_share"):  # which lowers the base, to keep the mean
        bare /= 1.0 + preset.number("surface.intensity_gain")
    assert (surface.friction > 0.09 * bare).all()
    if not timeline.gaps:
        assert (surface.friction >= bare).all()
    felt = [
        i
        for i, event in enumerate(timeline.events)
        if (preset.kind_for(event.kind) or "default") not in surface.omitted_events
    ]
    count = len(felt)
    assert sorted(surface.event.tolist()) == felt
    assert count + sum(surface.omitted_events.values()) == len(timeline.events)
    assert (np.diff(surface.position) >= 0.0).all()
    assert ((surface.position > 0.0) & (surface.position < 1.0)).all()
    assert surface.span.shape == (count, 2)
    assert (surface.span[:, 0] < surface.span[:, 1]).all()
    for name in ("release", "kind", "event"):
        assert getattr(surface, name).shape == (count,)


def test_an_enormous_weight_makes_a_wall_and_not_an_infinity():
    event = ov.Event(5.0, "default", weight=1.7e308)
    timeline = ov.Timeline("heavy", 10.0, (event,), None)
    surface = ov.build_surface(timeline, preset_with(height=1000.0, surface__friction=0.1))
    assert np.isfinite(surface.friction).all()
    assert np.isfinite(surface.release).all()


def test_a_bare_surface_is_the_presets_friction_all_over():
    surface = ov.build_surface(timeline_of(), plain_preset(surface__friction=2e-3))
    assert (surface.friction == 2e-3).all()
    assert len(surface.position) == 0


def test_equal_steps_of_the_intensity_are_equal_ratios_of_friction():
    curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 1.0]))
    timeline = ov.Timeline("ramp", 10.0, (), curve)
    preset = plain_preset(surface__friction=1e-3, surface__intensity_gain=4.0)
    surface = ov.build_surface(timeline, preset)
    assert np.allclose(surface.friction, 1e-3 * 5.0**PLACES, rtol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_an_event_adds_its_profile_times_height_and_weight(shape):
    event = ov.Event(40.0, "default", weight=1.5)
    timeline = ov.Timeline("one", 100.0, (event,), None)
    preset = preset_with(height=20.0, width=2.0, shape=shape, surface__friction=1e-3)
    friction = ov.build_surface(timeline, preset).friction
    expected = 1e-3 + 20.0 * 1.5 * 1e-3 * profile(shape, PLACES * 100.0 - 40.0, 2.0)
    # a gaussian's far foot is left out
    assert np.allclose(friction, expected, rtol=0.0, atol=2e-5 * 0.03)
    assert friction.max() == pytest.approx(31e-3, rel=1e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_profile_is_as_wide_as_it_says_at_half_its_height(shape):
    surface = ov.build_surface(timeline_of(50.0), preset_with(height=9.0, width=3.0, shape=shape))
    bare = surface.friction.min()
    above = surface.friction - bare >= 0.5 * (surface.friction.max() - bare)
    assert np.count_nonzero(above) / CELLS == pytest.approx(0.03, abs=3 / CELLS)


def test_overlapping_profiles_combine_by_their_maximum():
    preset = preset_with(height=10.0, width=4.0)
    one = ov.build_surface(timeline_of(49.0), preset).friction
    other = ov.build_surface(timeline_of(51.0), preset).friction
    both = ov.build_surface(timeline_of(49.0, 51.0), preset).friction
    assert np.array_equal(both, np.maximum(one, other))


def test_every_event_keeps_its_own_place_where_profiles_overlap():
    surface = ov.build_surface(timeline_of(49.9, 50.1), preset_with(width=4.0))
    assert surface.position.tolist() == [0.499, 0.501]


@pytest.mark.parametrize("shape", SHAPES)
def test_an_events_span_is_where_its_profile_exceeds_a_tenth_of_its_height(shape):
    preset = preset_with(height=10.0, width=2.0, shape=shape, surface__friction=1e-3)
    surface = ov.build_surface(timeline_of(30.0), preset)
    measured = PLACES[surface.friction - 1e-3 > 0.1 * 10.0 * 1e-3]
    first, last = surface.span[0]
    assert first == pytest.approx(measured[0], abs=1.5 / CELLS)
    assert last == pytest.approx(measured[-1], abs=1.5 / CELLS)
    assert surface.in_span(
        np.array([first - 0.001, first + 0.001, 0.3, last + 0.001])
    ).tolist() == [
        False,
        True,
        True,
        False,
    ]


def test_a_span_goes_on_beyond_the_ends_where_the_lookup_stays_in_the_event():
    surface = ov.build_surface(timeline_of(0.0, 50.0, 100.0), preset_with(width=1.0))
    assert surface.span[0, 0] == -math.inf
    assert surface.span[2, 1] == math.inf
    assert np.isfinite(surface.span[1]).all()
    assert surface.in_span(np.array([-0.5, 1.5])).all()
    first_only = np.array([True, False, False])
    assert surface.in_span(np.array([0.0, 0.5, 1.0]), first_only).tolist() == [True, False, False]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("width", [0.1, 1.0, 10.0])
def test_events_at_the_very_ends_strike_half_a_width_inside(shape, width):
    preset = preset_with(height=30.0, width=width, shape=shape)
    surface = ov.build_surface(timeline_of(0.0, 50.0, 100.0), preset)
    half = width / 200.0
    assert surface.position == pytest.approx([half, 0.5, 1.0 - half])
    # and let something go there
    assert (surface.release >= 0.4 * surface.release[1]).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_a_hand_that_crosses_the_timeline_hears_the_events_at_its_ends(shape):
    timeline = timeline_of(0.0, 100.0)
    preset = preset_with(height=3.0, width=1.0, shape=shape)
    result = ov.render(timeline, preset, ov.sweep(0.5), 8000, trace=False)
    assert result.strikes.event.tolist() == [0, 1, 1, 0]
    assert (result.strikes.level > 0.0).all()
    assert np.abs(result.samples[:, 0]).max() > 0.0


def test_unknown_kinds_take_the_default_and_are_named_in_a_warning():
    known = ov.Event(20.0, "goal")
    events = (known, ov.Event(50.0, "streaker"), ov.Event(80.0, "dog"))
    timeline = ov.Timeline("odd", 100.0, events, None)
    kinds = {
        "goal": ov.EventKind(height=50.0, width_percent=1.0),
        "default": ov.EventKind(height=5.0, width_percent=2.0),
    }
    preset = replace(plain_preset(), kinds=kinds)
    with pytest.warns(ov.OverviewWarning) as caught:
        surface = ov.build_surface(timeline, preset)
    assert len(caught) == 1
    assert "dog, streaker" in str(caught[0].message)
    assert "goal" in str(caught[0].message)
    named = [surface.kind_names[kind] for kind in surface.kind]
    assert named == ["goal", "default", "default"]
    assert surface.friction_at(0.5 * math.pi) == pytest.approx(6e-3, rel=1e-3)
    assert surface.friction_at(0.2 * math.pi) == pytest.approx(51e-3, rel=1e-3)


def test_known_kinds_give_no_warning(match, football):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ov.build_surface(match, football)


def ms_preset(milliseconds: float) -> ov.Preset:
    kind = ov.EventKind(height=10.0, width_ms=milliseconds)
    return replace(plain_preset(), kinds={"default": kind, "rare": kind})


def width_of(surface: ov.Surface) -> float:
    bare = surface.friction.min()
    return (
        np.count_nonzero(surface.friction - bare >= 0.5 * (surface.friction.max() - bare)) / CELLS
    )


def cut(timeline, start_s, end_s):
    """A window without its ticks."""
    part = timeline.window(start_s, end_s)
    return replace(part, events=tuple(without_ticks(part)))


def test_a_width_in_milliseconds_grows_as_the_hand_zooms_in():
    timeline = timeline_of(50.0)
    whole = width_of(ov.build_surface(timeline, ms_preset(1000.0)))
    part = width_of(ov.build_surface(cut(timeline, 40.0, 60.0), ms_preset(1000.0)))
    assert whole == pytest.approx(0.01, abs=2 / CELLS)
    assert part == pytest.approx(0.05, abs=2 / CELLS)


def test_a_width_in_percent_is_the_same_at_any_zoom():
    timeline, preset = timeline_of(50.0), preset_with(width=2.0)
    whole = width_of(ov.build_surface(timeline, preset))
    part = width_of(ov.build_surface(cut(timeline, 40.0, 60.0), preset))
    assert whole == part == pytest.approx(0.02, abs=2 / CELLS)


def test_a_width_below_what_the_surface_resolves_is_widened_with_a_warning():
    with pytest.warns(
        ov.OverviewWarning, match=r"kinds\.default\.width_ms is 1 of 100 s"
    ) as caught:
        surface = ov.build_surface(timeline_of(50.0), ms_preset(1.0))
    # once: the other kind has no event here
    assert len(caught) == 1
    narrowest = MIN_WIDTH_CELLS / CELLS
    assert f"widened to {narrowest * 100e3:.3g} ms" in str(caught[0].message)
    assert width_of(surface) == pytest.approx(narrowest, abs=1.5 / CELLS)
    assert surface.friction.max() == pytest.approx(11e-3, rel=0.1)


def test_a_kinds_level_is_added_to_its_modes():
    kind = ov.EventKind(
        3.0, 1.0, gain_db=-6.0, modes=(ov.ClickMode(440.0, 20.0, -3.0), ov.ClickMode(900.0, 5.0))
    )
    preset = replace(plain_preset(), kinds={"default": kind})
    (modes,) = ov.build_surface(timeline_of(50.0), preset).kind_modes
    assert [mode.gain_db for mode in modes] == [-9.0, -6.0]


@given(st.floats(-10.0, 10.0))
def test_the_friction_between_two_points_is_on_the_line_between_them(phi):
    surface = ov.build_surface(timeline_of(50.0), preset_with(width=5.0))
    at = min(max(phi / math.pi, 0.0), 1.0) * CELLS
    low = min(int(at), CELLS - 1)
    part = at - low
    expected = surface.friction[low] * (1.0 - part) + surface.friction[low + 1] * part
    assert surface.friction_at(phi) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("count", "felt"), [(100, True), (101, False)])
def test_events_denser_than_their_spacing_wait_for_a_zoom(count, felt):
    events = [ov.Event(float(i), "tick") for i in range(count)] + [ov.Event(50.5, "goal")]
    timeline = ov.Timeline(title="", duration_s=float(count), events=tuple(events))
    kinds = {
        "default": ov.EventKind(height=4.0, width_percent=0.1),
        "tick": ov.EventKind(height=4.0, width_percent=0.1, spacing_percent=1.0),
    }
    surface = ov.build_surface(timeline, ov.Preset("x", "", "", {}, kinds))
    assert len(surface.event) == (count + 1 if felt else 1)
    assert surface.omitted_events == ({} if felt else {"tick": count})
