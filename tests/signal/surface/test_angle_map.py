"""The map between time and angle: what it promises to all that convert one into the other."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.signal.surface.angle_map import BETWEEN, FILL, AngleMap
from tests.data.timeline.strategies import timelines
from tests.examples import preset_with, timeline_of

SHARES = st.sampled_from([0.05, 0.3, 0.7, 0.9, 1.0])


def crowded():
    """Twelve events within a minute, three of them at one time, and two far away."""
    close = [1000.0 + 5.0 * i for i in range(10)] + [1020.0, 1020.0]
    events = [ov.Event(at, "foul", str(i)) for i, at in enumerate([*close, 4000.0, 5500.0])]
    events += [ov.Event(0.0, "period"), ov.Event(5700.0, "period")]
    events += [ov.Event(1001.0 + i, "touch", str(i)) for i in range(20)]
    curve = ov.Intensity(np.linspace(0.0, 5700.0, 500), np.linspace(0.0, 1.0, 500))
    return ov.Timeline("crowded", 5700.0, tuple(events), curve)


def mapped(share):
    return preset_with(surface__angle_map=share)


def apart(timeline):
    """The indices of the events that the map keeps apart."""
    inside = enumerate(timeline.events)
    return [
        i for i, e in inside if e.kind not in FILL and 0.0 < e.time_s < timeline.duration_s
    ]  # fmt: skip


def least_gaps(timeline, share):
    """The least width of each gap, by the touches and shots that lie in it."""
    ends = [0.0, *(timeline.events[i].time_s for i in apart(timeline)), timeline.duration_s]
    between = [e.time_s for e in timeline.events if e.kind in BETWEEN]
    counts = np.array([sum(a <= t < b for t in between) for a, b in pairwise(ends)])
    own = max(1 / (len(counts) + counts.sum()), 0.3 / len(counts))
    room = own + counts / (len(counts) + counts.sum())
    return room * min(share, 1.0 / room.sum())


@given(timelines(), SHARES)
def test_the_map_is_monotonic_fixes_the_ends_and_keeps_neighbours_apart(timeline, share):
    made = AngleMap.of(timeline, mapped(share))
    assert (made.time_s[0], made.time_s[-1]) == (0.0, timeline.duration_s)
    assert (made.position[0], made.position[-1]) == (0.0, 1.0)
    assert (np.diff(made.position) > 0.0).all()
    at = made.events[apart(timeline)]
    if len(at) and timeline.known_until_s is None:
        least = least_gaps(timeline, share)
        gaps = np.diff([0.0, *at, 1.0])
        assert (gaps >= least * (1.0 - 1e-9)).all()
        # what isn't widened shrinks by one factor
        given_gaps = np.diff([0.0, *(timeline.events[i].time_s for i in apart(timeline)),
                              timeline.duration_s]) / timeline.duration_s  # fmt: skip
        wide = gaps > least * (1.0 + 1e-9)
        factors = gaps[wide] / given_gaps[wide]
        assert factors == pytest.approx(np.full(len(factors), factors.max(initial=0.0)))
        assert (factors <= 1.0 + 1e-9).all()
    times = np.linspace(0.0, timeline.duration_s, 257)
    assert (np.diff(made.position_of(times)) >= 0.0).all()
    assert (np.diff(made.time_at(np.linspace(0.0, 1.0, 257))) >= 0.0).all()


@given(timelines(), SHARES | st.just(0.0), st.floats(0.0, 1.0))
def test_the_inverse_leads_back(timeline, share, part):
    made = AngleMap.of(timeline, mapped(share))
    time_s = part * timeline.duration_s
    back = made.time_at(made.position_of(time_s))
    assert back == pytest.approx(time_s, abs=1e-12 * timeline.duration_s)
    # flat between events of one time, and nowhere else
    there = float(made.time_at(part))
    if there not in made.time_s:
        assert made.position_of(there) == pytest.approx(part, abs=1e-12)
    for i in apart(timeline):
        event = timeline.events[i]
        assert made.time_at(made.events[i]) == pytest.approx(event.time_s, rel=1e-12, abs=1e-300)


def test_events_of_one_time_keep_their_order_and_the_curve_takes_the_last_ones_place():
    timeline = crowded()
    made = AngleMap.of(timeline, mapped(0.7))
    same = [i for i in apart(timeline) if timeline.events[i].time_s == 1020.0]
    least = least_gaps(timeline, 0.7).min()
    assert np.diff(made.events[same]) == pytest.approx([least, least])
    assert made.position_of(1020.0) == made.events[same[-1]]
    assert made.time_at(made.events[same]).tolist() == [1020.0] * 3


def test_what_fills_a_timeline_up_keeps_its_room_and_moves_with_its_surroundings():
    timeline = crowded()
    without = replace(timeline, events=tuple(e for e in timeline.events if e.kind != "touch"))
    made, bare = AngleMap.of(timeline, mapped(0.7)), AngleMap.of(without, mapped(0.7))
    touches = [i for i, e in enumerate(timeline.events) if e.kind == "touch"]
    times = [timeline.events[i].time_s for i in touches]
    assert np.array_equal(made.events[touches], made.position_of(times))
    assert np.ptp(made.events[touches]) >= 1.5 * np.ptp(bare.position_of(times))


def test_times_and_positions_outside_are_those_of_the_ends():
    made = AngleMap.of(crowded(), mapped(0.7))
    assert made.position_of([-5.0, 1e9]).tolist() == [0.0, 1.0]
    assert made.time_at([-0.1, 1.5]).tolist() == [0.0, 5700.0]
    assert np.isnan(made.position_of(np.nan))


def test_the_surface_lies_where_the_map_says():
    timeline, preset = crowded(), preset_with(width=0.02, surface__angle_map=0.7)
    preset = preset.with_value("surface.intensity_gain", 1.0)
    surface = ov.build_surface(timeline, preset)
    inside = np.isin(surface.event, apart(timeline))
    assert surface.position[inside] == pytest.approx(
        surface.angle_map.events[surface.event[inside]], abs=1e-12
    )
    # the curve too: B at the position of a time is B of its value
    times = np.array([500.0, 1700.0, 3000.0, 5000.0])
    at = surface.friction_at(surface.position_of(times) * np.pi)
    expected = 1e-3 * 2.0 ** timeline.normalised_intensity_at(times)
    assert at == pytest.approx(expected, rel=1e-4)


def test_gaps_lie_where_the_map_says():
    timeline = replace(crowded(), gaps=((1010.0, 1300.0),))
    preset = preset_with(surface__angle_map=0.7, surface__intensity_gain=0.0, height=0.0)
    surface = ov.build_surface(timeline, preset)
    first, last = surface.position_of([1010.0, 1300.0]) * np.pi
    assert last - first > 2.0 * 290.0 / 5700.0 * np.pi
    bare = preset.number("surface.friction")
    assert surface.friction_at([first - 1e-3, last + 1e-3]).tolist() == [bare] * 2
    assert surface.friction_at(first + 1e-3) < 0.2 * bare


def test_while_a_timeline_grows_no_event_that_comes_moves_another():
    growing = replace(crowded(), known_until_s=5600.0)
    assert AngleMap.of(growing, mapped(0.7)).is_linear


def test_a_map_that_is_kept_stays_under_other_events():
    timeline = crowded()
    kept = AngleMap.of(timeline, mapped(0.7))
    more = replace(timeline, events=(*timeline.events, ov.Event(3000.0, "goal")))
    surface = ov.build_surface(more, preset_with(surface__angle_map=0.2), kept)
    assert np.array_equal(surface.angle_map.position, kept.position)
    goal = [e.kind for e in more.events].index("goal")
    assert surface.angle_map.events[goal] == kept.position_of(3000.0)
    with pytest.raises(ov.InputError, match="angle_map is for 5700 s; must be for 100 s"):
        ov.build_surface(timeline_of(50.0), preset_with(), kept)


def test_a_window_has_a_map_of_its_own():
    timeline, preset = crowded(), ov.load_preset("football")
    window = timeline.window(990.0, 1100.0)
    surface = ov.build_surface(window, preset)
    assert surface.time_at([0.0, 1.0]).tolist() == [0.0, 110.0]
    between_first_fouls = least_gaps(window, 0.7)[1]
    assert np.diff(surface.position_of([10.0, 15.0])) == pytest.approx(between_first_fouls)


def test_linear_presets_convert_by_the_duration():
    timeline = crowded()
    surface = ov.build_surface(timeline, ov.load_preset("plain"))
    times = np.array([0.0, 17.3, 5700.0])
    assert np.array_equal(surface.position_of(times), times / 5700.0)
    assert np.array_equal(surface.time_at(times / 5700.0), times / 5700.0 * 5700.0)


@pytest.mark.parametrize("name", ov.bundled_presets())
def test_only_presets_of_matches_map(name):
    share = ov.load_preset(name).number("surface.angle_map")
    assert share == (0.7 if name.startswith("football") else 0.0)
