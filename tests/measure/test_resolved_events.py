"""Events felt one by one, against levels that are known."""

from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.measure.perceived_level import Stroke, count_resolved_events
from overview_dsp.signal.surface.build import build_surface
from tests.examples import preset_with, timeline_of

RATE = 8000.0
FRAMES = 16_000


def count(places, pulses, rise_db=6.0, width_ms=12.0):
    """Count events at `places` (%), with tactor bursts at `pulses` (%) and a steady cursor."""
    surface = build_surface(timeline_of(*places), preset_with(width=1.0))
    time = np.arange(FRAMES) / RATE
    level = np.full(FRAMES, 0.05)
    for knock in pulses:
        middle = knock / 100.0 * FRAMES / RATE
        level[np.abs(time - middle) < width_ms / 2000.0] = 0.05 * 10 ** (rise_db / 20.0)
    tactor = (level * np.sin(2 * np.pi * 250.0 * time)).astype(np.float32)
    columns = {"cursor": np.linspace(0.0, 1.0, FRAMES)}
    return count_resolved_events(Stroke("out", 0, FRAMES), surface, columns, tactor, RATE)


def test_each_pulse_on_an_event_is_counted():
    assert count([20, 50, 80], [20, 50, 80]) == 3
    assert count([20, 50, 80], [20, 80]) == 2


def test_a_pulse_outside_of_events_is_not_counted():
    assert count([20, 50], [20, 50, 70]) == 2


@pytest.mark.parametrize(("rise_db", "felt"), [(1.8, 0), (3.0, 2)])
def test_a_pulse_that_hardly_rises_is_not_counted(rise_db, felt):
    assert count([20, 80], [20, 80], rise_db) == felt


@pytest.mark.parametrize(("apart_percent", "felt"), [(1.0, 1), (2.0, 2)])
def test_two_pulses_within_30_ms_count_as_one_event(apart_percent, felt):
    # 2 s a sweep: 1 % is 20 ms
    places = [50.0, 50.0 + apart_percent]
    assert count(places, places, width_ms=6.0) == felt
