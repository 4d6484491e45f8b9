"""What is new ahead of a hand, join_surfaces to what it touches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.signal.engine.replay import BLEND, join_surfaces
from overview_dsp.signal.surface.build import build_surface

FOOTBALL = ov.load_preset("football")
BEFORE = [(0.0, "period"), (300.0, "foul"), (700.0, "near_miss"), (1400.0, "goal")]


def match(events, now=1500.0, length=5700.0):
    live = ov.LiveTimeline("Home - Away", expected_duration_s=length)
    live.append(events=[ov.Event(float(at), kind) for at, kind in events], clock_s=now)
    return live.padded_snapshot()


def surface(*arguments, **keywords):
    return build_surface(match(*arguments, **keywords), FOOTBALL)


@given(
    st.floats(0.0, 1.0),
    st.lists(st.tuples(st.integers(1500, 3000), st.sampled_from(["goal", "foul"])), max_size=4),
)
def test_a_joined_surface_is_the_old_one_up_to_the_disk_and_the_new_one_beyond(place, came):
    old, new = surface(BEFORE), surface([*BEFORE, *came], now=3000.0)
    one = join_surfaces(old, new, place)
    if one is None:  # what came begins before the place, and so may not come there
        assert place > 1500.0 / 5700.0 - 0.05
        return
    at = np.arange(len(old.friction)) / (len(old.friction) - 1)
    assert np.array_equal(one.friction[at <= place], old.friction[at <= place])
    beyond = at >= place + BLEND
    assert np.array_equal(one.friction[beyond], new.friction[beyond])
    lower, upper = np.minimum(old.friction, new.friction), np.maximum(old.friction, new.friction)
    assert (one.friction >= lower * (1.0 - 1e-12)).all()
    assert (one.friction <= upper * (1.0 + 1e-12)).all()
    met = old.position <= place
    assert np.array_equal(one.position, new.position)
    assert np.array_equal(one.release[: met.sum()], old.release[met])
    assert np.array_equal(one.edges[: met.sum()], old.edges[met])


@pytest.mark.parametrize(
    "other",
    [
        surface([*BEFORE, (500.0, "foul")]),  # behind
        surface(BEFORE[:1] + BEFORE[2:]),  # taken back behind
        build_surface(match(BEFORE), ov.load_preset("plain")),
        build_surface(match(BEFORE), ov.load_preset("creaking-door")),
    ],
)
def test_surfaces_that_differ_behind_the_disk_are_not_joined(other):
    assert join_surfaces(surface(BEFORE), other, 0.2) is None
