"""Random timelines: real rates, the crowding of real matches, the readers' own rules."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.analysis.crowd_excitement import crowd_curve

GENERATORS = (
    ov.measure.random_match,
    ov.measure.random_share,
    ov.measure.random_weather,
    ov.measure.random_heart,
    ov.measure.random_crowd,
)


@pytest.fixture(scope="module")
def matches():
    return [ov.measure.random_match(seed) for seed in range(300)]


def kinds_in(timelines):
    return {kind for timeline in timelines for kind in timeline.kinds()}


@pytest.mark.parametrize("generator", GENERATORS)
def test_a_seed_makes_the_same_timeline_and_another_seed_another(generator):
    first, again, other = generator(4), generator(4), generator(5)
    assert first.events == again.events
    assert first.duration_s == again.duration_s
    assert np.array_equal(first.intensity.value, again.intensity.value)
    assert first.events != other.events


@pytest.mark.parametrize(
    ("kind", "least", "most"),
    [
        ("goal", 2.3, 3.1),
        ("own_goal", 0.1, 0.4),
        ("foul", 18.0, 22.0),
        ("near_miss", 9.5, 13.0),
        ("yellow_card", 3.5, 5.0),
        ("red_card", 0.2, 0.6),
        ("period", 3.0, 3.0),
    ],
)
def test_a_match_has_the_rates_of_real_ones(matches, kind, least, most):
    mean = np.mean([match.kinds().get(kind, 0) for match in matches])
    assert least <= mean <= most


def test_matches_have_close_goals_cards_soon_after_goals_and_fouls_with_their_cards(matches):
    goals = close = after = cards = fouled = 0
    for match in matches:
        at = {kind: [e.time_s for e in match.events if e.kind == kind] for kind in match.kinds()}
        scored = sorted(at.get("goal", []) + at.get("own_goal", []))
        booked = at.get("yellow_card", []) + at.get("red_card", [])
        goals += len(scored)
        close += sum(later - sooner < 120.0 for sooner, later in itertools.pairwise(scored))
        after += sum(any(0.0 < card - goal < 480.0 for card in booked) for goal in scored)
        cards += len(booked)
        fouled += sum(card in at["foul"] for card in booked)
    assert close / goals > 0.1
    assert after / goals > 0.3
    assert 0.75 < fouled / cards < 0.95


def test_a_match_has_the_crowds_curve_of_its_own_events(matches):
    match = matches[7]
    derived = crowd_curve(match.events, match.duration_s)
    assert np.allclose(match.intensity.value, derived.value, rtol=1e-12)


def test_a_share_trades_on_weekdays_for_one_to_three_years():
    for seed in range(8):
        share = ov.measure.random_share(seed)
        days = share.intensity.time_s / 86_400.0
        assert all((share.start.weekday() + int(day)) % 7 < 5 for day in days)
        assert len(days) in (252, 504, 756)
        assert {"highest", "lowest", "largest_rise", "largest_fall"} <= set(share.kinds())


def test_weather_has_a_season_and_sometimes_lacks_days():
    made = [ov.measure.random_weather(seed) for seed in range(20)]
    for weather in made:
        day = weather.intensity.time_s / 86_400.0
        season = np.cos(2.0 * np.pi * day / 365.25), np.sin(2.0 * np.pi * day / 365.25)
        together = np.corrcoef(np.stack([weather.intensity.value, *season]))[0, 1:]
        assert np.hypot(*together) > 0.5
    assert 0 < sum(bool(weather.gaps) for weather in made) < 12


def test_random_hearts_have_irregular_beats_and_in_short_ones_each_beat_is_felt():
    made = [ov.measure.random_heart(seed) for seed in range(30)]
    heart = ov.load_preset("heart")
    assert {"premature_atrial", "premature_ventricular", "missed_beat", "rhythm", "flutter"} <= (
        kinds_in(made)
    )
    felt = [bool(ov.build_surface(one, heart).omitted_events) for one in made]
    assert felt == [seed % 3 != 2 for seed in range(30)]
    for one in made:
        assert one.intensity.value.min() > 35.0  # a pause among eight intervals
        assert one.intensity.value.max() < 190.0


def test_crowds_have_cheers_and_bursts():
    made = [ov.measure.random_crowd(seed) for seed in range(6)]
    assert kinds_in(made) == {"cheer", "burst"}
    for kind in ("cheer", "burst"):
        assert 2.0 < np.mean([one.kinds().get(kind, 0) for one in made]) < 25.0


@pytest.mark.parametrize(
    ("preset", "titles"),
    [
        ("football", {"match"}),
        ("football-stadium", {"match"}),
        ("stocks", {"share"}),
        ("weather", {"weather"}),
        ("series", {"share", "weather"}),
        ("heart", {"heart"}),
        ("crowd", {"crowd"}),
        ("plain", {"events"}),
        ("gravel", {"events"}),
    ],
)
def test_each_preset_gets_timelines_of_its_own_kinds(preset, titles):
    loaded = ov.load_preset(preset)
    made = ov.measure.random_timelines(loaded, 4)
    assert {one.title.split()[1] for one in made} == titles
    assert all(loaded.kind_for(kind) is not None for kind in kinds_in(made))


def test_random_events_have_every_kind_and_need_one():
    for seed in range(10):
        made = ov.measure.random_events(list("abcdefgh"), seed)
        assert set(made.kinds()) == set("abcdefgh")
    with pytest.raises(ov.InputError, match="no kinds"):
        ov.measure.random_events([], 0)
