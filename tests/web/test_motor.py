"""A phone's motor: what it is told while a hand sweeps over real matches, at 60 looks a second."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.live.output.stream import connect, run_block
from overview_dsp.units import HALF_TURN
from overview_dsp.web.preset_data import SHORT, vibration_pattern
from tests.web.driving import at, until
from tests.web.exported import opened_host

RATE, BLOCK = 48_000, 128
LOOK_S = 1 / 60
NEAR_S = 0.030
MATCHES = [
    "statsbomb/22936.json",
    "statsbomb/15986.json",
    "statsbomb/69321.json",
    "wyscout/wyscout_v2_match_2499773.json",
    "metrica/Sample_Game_1_RawEventsData.csv",
]

PLAY = """async (looks) => {
    const { Motor } = await import("./modules/vibration.js");
    const calls = [];
    let now = 0;
    const motor = new Motor((pattern) => calls.push([now, [pattern].flat()]), () => []);
    for (const [time, codes, peak] of looks) {
        now = time;
        motor.play(codes, peak, now);
    }
    return calls;
}"""


@pytest.fixture(scope="module")
def matches():
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    if not folder:
        pytest.skip("needs other people's matches: OVERVIEW_TEST_DATA")
    return [ov.load_timeline(Path(folder) / "football" / name) for name in MATCHES]


@pytest.fixture(scope="module")
def script(chromium, site):
    """A page that plays looks to the page's motor: its calls, (ms, on and off times)."""
    with opened_host(site) as host:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(host.url)
        yield lambda looks: page.evaluate(PLAY, looks)
        context.close()


def looks_of(timeline, preset, seconds):
    """What a page sees of a sweep: looks (ms, codes, peak), and when each event was passed (s)."""
    engine = ov.Engine(preset, timeline)
    engine.prepare(RATE, BLOCK)
    connect(engine, None)
    out = np.zeros((BLOCK, 2), np.float32)
    surface = engine.surface
    positions = np.full(len(timeline.events), np.nan)
    positions[surface.event] = surface.position
    passed = np.full(len(positions), np.nan)
    looks, peak, codes = [], 0.0, []
    for i in range(int((seconds + 0.5) * RATE / BLOCK)):
        now = i * BLOCK / RATE
        engine.control(min(now / seconds, 1.0) * HALF_TURN, True)
        run_block(engine, out)
        peak = max(peak, float(np.abs(out[:, 1]).max()))
        strikes = engine.pop_strikes()
        for number in strikes.event:
            if number >= 0:
                codes.append(list(vibration_pattern(timeline.events[number].kind, preset)))
        passed[np.isnan(passed) & (positions <= engine.meters.cursor)] = now
        if now >= (len(looks) + 1) * LOOK_S:
            looks.append([now * 1e3, codes, peak])
            peak, codes = 0.0, []
    return looks, passed


def intervals(calls):
    """When the motor is on, s: a call takes the position of what is left of the one before."""
    on = []
    for i, (begins, pattern) in enumerate(calls):
        until_ms = calls[i + 1][0] if i + 1 < len(calls) else np.inf
        at_ms = begins
        for k, length in enumerate(pattern):
            if k % 2 == 0 and at_ms < until_ms and length > 0:
                on.append([at_ms, min(at_ms + length, until_ms)])
            at_ms += length
    joined = []
    for start, end in on:
        if joined and start - joined[-1][1] < 1e-6:
            joined[-1][1] = end
        else:
            joined.append([start, end])
    return np.array(joined).reshape(-1, 2) / 1e3


@pytest.mark.parametrize("seconds", [1.5, 3.0, 5.0])
def test_the_motor_is_on_at_goals_and_tells_them_from_cards(script, matches, football, seconds):
    goals = found = long_goals = cards = long_cards = 0
    for match in matches:
        looks, passed = looks_of(match, football, seconds)
        calls = script(looks)
        require_whole(calls)
        on = intervals(calls)
        long = on[on[:, 1] - on[:, 0] > 1.25e-3 * SHORT]  # the next goal may cut one short

        def near(times, moment):
            return bool(np.any((times[:, 0] < moment + NEAR_S) & (times[:, 1] > moment - NEAR_S)))

        kinds = np.array([event.kind for event in match.events])
        at_goals = passed[np.isin(kinds, ("goal", "own_goal"))]
        for moment in at_goals:
            goals += 1
            found += near(on, moment)
            long_goals += near(long, moment)
        for moment in passed[np.isin(kinds, ("yellow_card", "red_card"))]:
            if np.abs(at_goals - moment).min() > 0.2:
                cards += 1
                long_cards += near(long, moment)
    print(f"\nsweep of {seconds} s: on at {found} of {goals} goals, told as one at {long_goals}; "
          f"{long_cards} of {cards} cards told as goals")  # fmt: skip
    assert goals == 18
    assert found >= goals * 12 / 13
    assert long_goals >= goals * 12 / 13
    assert long_cards == 0
    assert cards > 8


def require_whole(calls):
    """A browser rounds or refuses what isn't a whole number of ms, and cuts what is long."""
    for _, pattern in calls:
        assert all(one == int(one) and 0 <= one <= 100 for one in pattern), pattern
        assert len(pattern) == 1 or 0 not in pattern


LEVELS = [0.0, 0.01, 0.05, 0.1, 0.3, 0.5, 0.7, 1.0]


def test_the_surface_is_felt_as_pulses_that_grow_with_the_peak(script):
    """On for more of the time the stronger it is, and never so long that an event is lost in it."""
    parts = []
    for level in LEVELS:
        calls = script([[16.7 * i, [], level] for i in range(60)])
        require_whole(calls)
        on = intervals(calls)
        lengths = on[:, 1] - on[:, 0]
        felt = level >= 0.02
        assert (len(on) > 15) == felt
        expected = 0.008 + 0.014 * level**0.5 if felt else 0.0
        assert np.allclose(lengths, expected, atol=1e-3)
        parts.append(float(lengths.sum()))
    assert parts[:2] == [0.0, 0.0]
    assert np.all(np.diff(parts[1:]) > 0.0)
    assert parts[-1] / parts[2] > 1.8


def test_a_goal_interrupts_the_vibration_of_a_foul_and_not_the_reverse(script):
    goal, foul = [80, 40, 35], [14]
    on = intervals(script([[0, [foul], 0], [10, [goal], 0], [40, [foul], 0], [400, [], 0]]))
    lengths = np.round(1e3 * (on[:, 1] - on[:, 0]))
    assert lengths.tolist() == [11, 80, 35]
    both = intervals(script([[0, [foul, goal, foul], 0], [20, [goal], 0], [400, [], 0]]))
    assert np.round(1e3 * (both[:, 1] - both[:, 0])).tolist() == [50, 80, 35]


def test_a_page_tells_its_motor_of_the_goal_that_is_struck(chromium, site):
    with opened_host(site) as host:
        context = chromium.new_context(has_touch=True)
        page = context.new_page()
        page.add_init_script("""
            window.patterns = [];
            navigator.vibrate = (pattern) => { patterns.push([pattern].flat()); return true; };
        """)
        page.goto(host.url)
        until(page, "p.view")
        page.evaluate("overview.settings.output = 'motor'; overview.apply()")
        page.mouse.move(*at(page, 0.68))
        page.mouse.down()
        page.mouse.move(*at(page, 0.75), steps=30)
        until(page, "patterns.some((one) => one.slice(-3).join() === '80,40,35')")
        page.mouse.up()
        context.close()
