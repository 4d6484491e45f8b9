"""More events than a surface holds: the strongest of those that fall together strikes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.errors import OverviewWarning
from overview_dsp.kernels.layout import MAX_EVENTS
from overview_dsp.signal.surface.build import build_surface, thin_events
from tests.examples import preset_with, timeline_of

EVENTS = st.lists(st.tuples(st.floats(0.0, 65_536.0), st.integers(0, 5)), min_size=1, max_size=300)


@given(EVENTS, st.integers(1, 50))
def test_the_strongest_event_of_each_interval_is_kept_for_the_others(events, most):
    place = np.array([at for at, _ in events])
    release = np.array([strength for _, strength in events], dtype=np.float64)
    kept, stands_for = thin_events(place, release, most)
    assert 1 <= len(kept) <= most
    assert np.all(np.diff(place[kept]) >= 0.0)
    assert np.array_equal(stands_for[kept], np.arange(len(kept)))
    for number in range(len(kept)):
        together = stands_for == number
        assert release[together].max() == release[kept[number]]
        # nothing of another stretch lies between them
        inside = (place > place[together].min()) & (place < place[together].max())
        assert np.all(stands_for[inside] == number)


def test_events_in_cells_of_their_own_are_all_kept():
    place = np.array([5.5, 0.2, 3.9, 4.0])
    kept, stands_for = thin_events(place, np.ones(4), 4)
    assert list(kept) == [1, 2, 3, 0]
    assert list(stands_for) == [3, 0, 1, 2]


def test_of_equally_strong_events_at_one_position_the_first_is_kept():
    kept, stands_for = thin_events(np.tile([3.5, 1.5, 2.5], 100), np.ones(300), 3)
    assert list(kept) == [1, 2, 0]
    assert list(stands_for) == [2, 0, 1] * 100


def test_a_hundred_thousand_events_are_rendered_with_a_warning_about_merging():
    preset = preset_with(height=2.0, width=0.03)
    timeline = timeline_of(*np.linspace(0.0, 100.0, 100_000))
    with pytest.warns(OverviewWarning, match="the surface keeps 163[0-9]* of 100000 events"):
        surface = build_surface(timeline, preset)
    assert len(surface.position) <= MAX_EVENTS
    assert np.all(np.diff(surface.position) > 0.0)
    with pytest.warns(OverviewWarning, match="keeps"):
        # the disk is still on its way when the hand releases, and for the whole tail
        result = ov.render(timeline, preset, ov.sweep(0.5), tail=1.0)
    assert result.trace.engaged[-1] == 1.0
    assert len(result.strikes.time_s) > 15_000
    assert np.isfinite(result.samples).all()


def test_merged_bristles_belong_to_the_event_that_strikes():
    preset = preset_with(height=2.0, width=0.03)
    kind = ov.EventKind(height=5.0, width_percent=0.03, model="bristle")
    preset = type(preset)("b", "b", "b", preset.values, {"default": kind})
    with pytest.warns(OverviewWarning, match="keeps"):
        surface = build_surface(timeline_of(*np.linspace(0.0, 100.0, 40_000)), preset)
    assert surface.bristles is not None
    owner = surface.bristles.owner
    assert owner.max() == len(surface.position) - 1
    gripped = np.flatnonzero(owner >= 0)
    away = np.abs(surface.position[owner[gripped]] * 65_536 - gripped)
    assert away.max() < 32.0


@pytest.mark.parametrize("most", [1, 7, 30, 120, 200])
@pytest.mark.parametrize("seed", [1, 2])
def test_cells_are_joined_in_pairs_only_as_often_as_needed_and_ties_go_to_the_first(seed, most):
    random = np.random.default_rng(seed)
    place = random.choice([1.0, 0.25], 200) * random.integers(0, 65_536, 200)
    release = random.integers(0, 4, 200).astype(float)
    width = 1
    while len(np.unique(place // width)) > most:
        width *= 2
    kept, stands_for = thin_events(place, release, most)
    assert np.array_equal(np.unique(place // width)[stands_for], place // width)
    for number, index in enumerate(kept):
        (together,) = np.nonzero(stands_for == number)
        assert index == min(together, key=lambda i: (-release[i], place[i], i))
