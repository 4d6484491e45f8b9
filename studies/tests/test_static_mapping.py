"""The control condition: what a page computes sample by sample, and as strong as the disk."""

from __future__ import annotations

import math

import numpy as np
import pytest

import overview_dsp as ov
from overview_studies.static_mapping import (
    StaticMapping,
    held_levels,
    static_levels,
    static_mapping,
)
from overview_studies.stimuli import stimuli_of
from studies.tests.files import IDENTIFY, design_of

RATE = 48_000


@pytest.fixture(scope="module")
def items(tmp_path_factory):
    return stimuli_of(design_of(tmp_path_factory.mktemp("static"), IDENTIFY))


@pytest.fixture(scope="module")
def item(items):
    return items[0]


@pytest.fixture(scope="module")
def mapping(item):
    return static_mapping(item, RATE)


def as_documented(made, gesture, frames):
    """docs/explanation/study-format.md, line by line, as a page does it."""
    stamps = gesture.stamps(RATE).tolist()
    c = g = start = to = gfrom = gto = 0.0
    ramp = made["ramp"]
    k = ramp
    waves, out, event = [], np.zeros((frames, 2), np.float32), 0
    for n in range(frames):
        while event < len(stamps) and stamps[event] == n:
            theta2, touching = float(gesture.theta2[event]), bool(gesture.touching[event])
            if not gto:
                c = theta2 / math.pi
            start, to = c, theta2 / math.pi
            gfrom, gto = g, 1.0 if touching else 0.0
            k = 0
            event += 1
        p = c
        if k < ramp:
            k += 1
            c = start + (to - start) * (k / ramp)
            g = gfrom + (gto - gfrom) * (k / ramp)
        x = c * 1024
        i = min(math.floor(x), 1023)
        a = made["amplitude"][i] + (made["amplitude"][i + 1] - made["amplitude"][i]) * (x - i)
        tactor = g * a * made["carrier"][n % len(made["carrier"])]
        if gto:
            for click in made["clicks"]:
                place = click["place"]
                if p < place <= c or c <= place < p:
                    waves.append((n, made["waves"][click["wave"]]))
        click = 0.0
        for first, wave in waves:
            if n - first < len(wave):
                click += wave[n - first]
        out[n] = min(max(click, -made["ceiling"]), made["ceiling"]), tactor
    return out


def test_a_render_is_what_a_page_computes_sample_by_sample(mapping):
    gesture = ov.sweep(0.2) + ov.tap(0.7, 0.1) + ov.sweep(0.15, 0.9, 0.1)
    made = mapping.render(gesture, 0.05)
    assert np.array_equal(made, as_documented(mapping.as_json(), gesture, len(made)))
    assert np.abs(made).max(axis=0).min() > 0.01


def test_an_event_is_felt_as_strong_as_in_the_friction_condition(item):
    result = item.render_stimulus()
    surface, trace = result.engine.surface, result.trace
    wanted, _ = held_levels(surface, trace, result.samples[:, 1], RATE)
    assert np.abs(static_levels(item, RATE) - wanted).max() < 0.5


def test_the_speed_of_the_hand_changes_the_disk_and_not_the_static_mapping(items):
    # a soft bump: a hard knock is as strong at any speed, by the preset's compression
    item = next(one for one in items if one.names["answer"] == "foul")
    mapping = static_mapping(item, RATE)

    def strongest(samples):
        return ov.measure.window_db(samples[:, 1], RATE, 0.001)[1].max()

    def held(gesture):
        result = ov.render(item.timeline, item.preset, gesture, seed=item.seed)
        trace = result.trace
        return held_levels(result.engine.surface, trace, result.samples[:, 1], RATE)[0][0]

    slow, fast = ov.sweep(3.0), ov.sweep(0.6)
    static = strongest(mapping.render(slow)) - strongest(mapping.render(fast))
    friction = [held(one) for one in (slow, fast)]
    assert abs(static) < 1.0
    assert friction[1] - friction[0] > 3.0


def test_nothing_sounds_without_a_hand(item, mapping):
    assert not mapping.render(ov.pause(0.2)).any()
    let_go = mapping.render(ov.tap(item.positions(None)[0], 0.1), 0.3)
    assert let_go[: round(0.1 * RATE), 1].any()
    assert not let_go[-round(0.1 * RATE) :].any()


def test_a_click_comes_when_its_place_is_reached_and_not_again_when_it_is_left():
    one = StaticMapping(RATE, 240, np.zeros(1025), np.zeros(1), [(0.5, 0)], [np.array([0.5, 0.25])])
    # the hand rests where it has arrived: a sweep releases at its end
    to = ov.Gesture(
        np.array([0.0, 0.05, 0.1]),
        np.pi * np.array([0.25, 0.5, 0.5]),
        np.array([True, True, False]),
        0.1,
    )
    on = ov.sweep(0.1, 0.5, 0.75)
    held = ov.Gesture(
        np.array([0.0, 0.05, 0.15, 0.2]),
        np.pi * np.array([0.25, 0.5, 0.75, 0.75]),
        np.array([True, True, True, False]),
        0.2,
    )
    assert np.count_nonzero(one.render(held)[:, 0]) == 2
    # alone: reached by the one, only left by the other
    assert np.count_nonzero(one.render(to)[:, 0]) == 2
    assert np.count_nonzero(one.render(on)[:, 0]) == 0
