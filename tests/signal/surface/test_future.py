"""What hasn't happened yet: a surface of its own, behind a soft end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels.layout import CELLS

PRESETS = ("football", "football-discreet", "series", "crowd", "heart", "ratchet")


@pytest.fixture(scope="module")
def half(match):
    """The match as it is at half time, under its expected length."""
    live = ov.LiveTimeline(expected_duration_s=match.duration_s)
    live.append(events=[event for event in match.events if event.time_s <= 2900.0], clock_s=2900.0)
    return live.snapshot()


@pytest.mark.parametrize("name", PRESETS)
def test_the_future_is_smooth_and_heavier_than_all_the_curve_could_be(half, name):
    preset = ov.load_preset(name)
    surface = ov.build_surface(half, preset)
    now = int(half.known_until_s / half.duration_s * CELLS)
    later = surface.friction[now + int(0.04 * CELLS) :]
    assert np.ptp(later) == 0.0
    bare = preset.number("surface.friction") * (1.0 + preset.number("surface.intensity_gain"))
    assert later[0] > 1.9 * bare
    assert all(position <= (now + 2) / CELLS for position in surface.position)
    strikes = surface.texture_strikes.position
    assert all(strikes <= now + 1)


def test_the_end_is_soft(half, football):
    without = replace(half, events=(), intensity=ov.Intensity([0.0], [0.0]))
    friction = ov.build_surface(without, football).friction
    steps = np.abs(np.diff(friction))
    # from point to point it rises by less than a hundredth of its height
    assert steps.max() < 0.01 * np.ptp(friction)
    assert np.all(np.diff(friction)[int(0.45 * CELLS) :] > -1e-12 * friction.max())


def test_what_has_happened_is_felt_as_it_will_be_when_all_has(half, match, football):
    known = replace(half, known_until_s=None)
    linear = football.with_value("surface.angle_map", 0.0)  # as it is while it grows
    before, after = ov.build_surface(half, football), ov.build_surface(known, linear)
    now = int(half.known_until_s / half.duration_s * CELLS)
    assert np.array_equal(before.friction[: now + 1], after.friction[: now + 1])


def test_a_window_of_the_past_has_no_future_and_one_beyond_now_has(half):
    assert half.window(0.0, 2900.0).known_until_s is None
    assert half.window(2000.0, 4000.0).known_until_s == 900.0
    assert half.window(3000.0, 4000.0).known_until_s == 0.0


def test_a_file_keeps_up_to_where_it_has_happened(half, tmp_path):
    ov.save_timeline(half, tmp_path / "half.json")
    assert ov.load_timeline(tmp_path / "half.json") == half


def test_until_is_within_the_timeline(half):
    for bad in (-1.0, half.duration_s + 1.0, float("nan"), "now"):
        with pytest.raises(ov.InputError, match="known_until_s"):
            replace(half, known_until_s=bad)
    assert replace(half, known_until_s=half.duration_s).known_until_s is None
