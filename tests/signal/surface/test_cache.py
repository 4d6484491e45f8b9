"""Surfaces kept for voices that share them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.signal.surface import cache as surface_cache
from overview_dsp.signal.surface.cache import SurfaceCache
from tests.examples import preset_with, timeline_of

PRESET, TIMELINE = preset_with(), timeline_of(50.0)


@pytest.fixture
def built(monkeypatch):
    made = []

    def counted(timeline, preset):
        made.append((timeline, preset))
        return ov.build_surface(timeline, preset)

    monkeypatch.setattr(surface_cache, "build_surface", counted)
    return made


def test_what_does_not_change_the_surface_builds_none(built):
    cache = SurfaceCache()
    first = cache.surface(TIMELINE, PRESET)
    for preset in (PRESET, PRESET.with_changes({"tactor.gain_db": -3.0}), PRESET, PRESET):
        assert cache.surface(TIMELINE, preset) is first
    assert built == [(TIMELINE, PRESET)]
    assert np.array_equal(first.friction, ov.build_surface(TIMELINE, PRESET).friction)


@pytest.mark.parametrize(
    "other",
    [
        (timeline_of(50.0), PRESET),  # equal, but not the same
        (TIMELINE, PRESET.with_changes({"surface.friction": 3e-3})),
        (TIMELINE, replace(PRESET, points=(1.0, 0.0))),
        (TIMELINE, replace(PRESET, kinds={"default": preset_with(height=1.0).kinds["default"]})),
    ],
)
def test_what_changes_the_surface_builds_its_own(built, other):
    cache = SurfaceCache()
    first, second = cache.surface(TIMELINE, PRESET), cache.surface(*other)
    assert second is not first
    assert len(built) == 2
    assert cache.surface(*other) is second
    assert cache.surface(TIMELINE, PRESET) is first
    assert len(built) == 2


def test_the_one_used_longest_ago_goes_first(built):
    cache = SurfaceCache(most=2)
    one, two, three = (PRESET.with_changes({"surface.friction": n * 1e-3}) for n in (1, 2, 3))
    for preset in (one, two, one, three):
        cache.surface(TIMELINE, preset)
    assert len(built) == 3
    cache.surface(TIMELINE, one)
    cache.surface(TIMELINE, three)
    assert len(built) == 3
    cache.surface(TIMELINE, two)
    assert len(built) == 4
    cache.surface(TIMELINE, three)
    assert len(built) == 4
    cache.surface(TIMELINE, one)
    assert len(built) == 5
