"""Random realistic timelines by seed, for training and evaluating an observer of a preset.

Each generator draws the content of a file (a match's events, a share's closing prices, a heart's
beats, a crowd's loudness). The rules of the file's reader make a timeline of it.

Matches: the mean numbers (Poisson) are those of StatsBomb's open data as read by this project: 2.7
goals, 20 fouls, 9.5 near misses, 3.8 yellow cards. Own goals (a twelfth of the goals) and red cards
(0.3) are 3 and 2 times as frequent as in real matches, so that an observer has enough to learn.
Difficult cases of real matches are drawn too: goals less than two minutes apart, cards in the
minutes after a goal, shots that rebound, and a foul at the same time as its card.

Hearts: the rate lies between 55 and 85 beats per minute, varies with breath and at random, and
rises in one to three episodes by a quarter to two thirds. There are early, missed and other
irregular beats. Two of three recordings last 5 to 30 minutes, in which only unusual beats are
events; the third has fewer than 100 beats, and each is an event.

Series: prices are random walks with rare jumps; their volatility (0.7 to 2.5 % a day) varies and
reverts within a month or so. Temperatures are a yearly wave plus noise with a memory of some days;
in some series, consecutive days are missing. Their events are found by the rules for tables.

Crowds: the quiet level varies by one or two decibels; cheers rise by 7 to 18 LU within 2.5 s, last
2 to 12 s and fade; bursts (a whistle, a bang) last a few tenths of a second.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.crowd_excitement import crowd_curve
from overview_dsp.data.analysis.loudness import STEPS_PER_S, Steps
from overview_dsp.data.analysis.rhythm import NORMAL, Beats
from overview_dsp.data.readers.audio.reader import MAPS, timeline_of
from overview_dsp.data.readers.cardiac.build import Description, heart_timeline
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.series.series_reader import series_timeline
from overview_dsp.data.readers.tables.memory import table_of
from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.design.presets.model import DEFAULT_KIND, Preset
from overview_dsp.errors import InputError

GOALS, FOULS, NEAR_MISSES, YELLOWS, REDS = 2.7, 20.0, 9.5, 3.8, 0.3
OWN_GOAL = 1.0 / 12.0  # share of goals

CLOSE_GOAL, CLOSE_GOAL_S = 0.15, (20.0, 115.0)
"""Share of goals that another one follows, and range of the time between both."""

CARD_AFTER_GOAL, CARD_AFTER_GOAL_S = 0.2, (5.0, 480.0)
REBOUND, REBOUND_S = 0.2, (2.0, 20.0)
FOUL_WITH_CARD = 0.85
HALF_S = 2700.0
STOPPAGE_S = ((40.0, 260.0), (120.0, 460.0))
"""Shortest and longest stoppage time of the first and of the second half."""


def random_match(seed: int) -> Timeline:
    """Generate a football match with realistic numbers of events, some of them close together.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same match.

    Returns
    -------
    Timeline
        Timeline with the event kinds of the preset `football`, and the curve that readers derive.

    Examples
    --------
    >>> match = ov.measure.random_match(3)
    >>> match.kinds()["period"], 5000.0 < match.duration_s < 6200.0
    (3, True)
    """
    rng = validation.random(seed)
    half = HALF_S + rng.uniform(*STOPPAGE_S[0])
    length = half + HALF_S + rng.uniform(*STOPPAGE_S[1])
    found: list[tuple[float, str]] = []

    def random_times(mean_count: float) -> list[float]:
        return list(rng.uniform(10.0, length - 10.0, rng.poisson(mean_count)).tolist())

    for at in random_times(GOALS):
        found.append((at, "own_goal" if rng.random() < OWN_GOAL else "goal"))
        if rng.random() < CLOSE_GOAL:
            found.append((at + rng.uniform(*CLOSE_GOAL_S), "goal"))
        if rng.random() < CARD_AFTER_GOAL:
            kind = "red_card" if rng.random() < 0.1 else "yellow_card"
            found.append((at + rng.uniform(*CARD_AFTER_GOAL_S), kind))
    found += [(at, "yellow_card") for at in random_times(YELLOWS)]
    found += [(at, "red_card") for at in random_times(REDS)]
    for at in random_times(NEAR_MISSES):
        found.append((at, "near_miss"))
        if rng.random() < REBOUND:
            found.append((at + rng.uniform(*REBOUND_S), "near_miss"))
    cards = [at for at, kind in found if kind.endswith("card")]
    found += [(at, "foul") for at in cards if rng.random() < FOUL_WITH_CARD]
    found += [(at, "foul") for at in random_times(max(0.0, FOULS - FOUL_WITH_CARD * len(cards)))]
    events = [Event(at, "period") for at in (0.0, half, length)]
    events += [Event(at, kind) for at, kind in found if at < length]
    return Timeline(
        title=f"random match {seed}",
        duration_s=length,
        events=tuple(events),
        intensity=crowd_curve(events, length),
    )


EVENTS_LENGTH_S = 600.0
EVENTS = 30.0  # mean number of events, about that of a match

CLOSE, CLOSE_S = 0.15, (1.0, 12.0)
"""Share of events that another one follows, and range of the time between both."""


def random_events(kinds: Sequence[str], seed: int) -> Timeline:
    """Generate a timeline with equally frequent events of the given kinds, some close, and a curve.

    Parameters
    ----------
    kinds : sequence of str
        One or more kinds.
    seed : int
        Random seed; the same seed and kinds give the same timeline.

    Returns
    -------
    Timeline
        Timeline of ten minutes, in which each kind occurs.

    Raises
    ------
    InputError
        No kinds.

    Examples
    --------
    >>> sorted(ov.measure.random_events(["bell", "drum"], seed=1).kinds())
    ['bell', 'drum']
    """
    kinds = validation.instances(kinds, str, "kinds", "each is a word: ['goal', 'foul']")
    if not kinds:
        raise InputError("no kinds; name one or more")
    rng = validation.random(seed)
    events: list[Event] = []
    for kind in kinds:
        count = 1 + rng.poisson(max(0.0, EVENTS / len(kinds) / (1.0 + CLOSE) - 1.0))
        for at in rng.uniform(5.0, EVENTS_LENGTH_S - 5.0 - CLOSE_S[1], count).tolist():
            events.append(Event(at, kind))
            if rng.random() < CLOSE:
                other = kinds[int(rng.integers(len(kinds)))]
                events.append(Event(at + rng.uniform(*CLOSE_S), other))
    knots = np.linspace(0.0, EVENTS_LENGTH_S, 13)
    curve = Intensity(knots, np.clip(rng.normal(0.4, 0.25, len(knots)), 0.0, 1.0))
    return Timeline(f"random events {seed}", EVENTS_LENGTH_S, tuple(events), curve)


LONG_S, SHORT_S = (300.0, 1800.0), (40.0, 68.0)
STEADY = ((NORMAL, 0.8), ("bundle_branch_block", 0.1), ("paced", 0.1))
"""Kinds of the regular beats of a recording, and the shares of recordings with them."""

EARLY = (
    ("premature_atrial", 0.45),
    ("premature_ventricular", 0.40),
    ("premature_nodal", 0.05),
    ("premature_supraventricular", 0.05),
    ("fusion", 0.05),
)
MAX_EARLY_SHARE = 0.08  # largest share of early beats

MISSED, RHYTHMS, FAULTS, FLUTTER = 3.0, 2.0, 2.0, 0.35
"""Mean numbers of missed beats, rhythm changes, quality changes and flutters per recording."""


def random_heart(seed: int) -> Timeline:
    """Generate a recording of a heart.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same heart.

    Returns
    -------
    Timeline
        Timeline with the event kinds of the preset `heart`.

    Examples
    --------
    >>> heart = ov.measure.random_heart(1)
    >>> heart.intensity.unit
    'bpm'
    """
    rng = validation.random(seed)
    length = rng.uniform(*(SHORT_S if seed % 3 == 2 else LONG_S))
    usual = _intervals(rng, length)
    usual = usual[: np.searchsorted(np.cumsum(usual), length) + 10]
    steady = _one_of(rng, STEADY)
    early = rng.random(len(usual)) < rng.uniform(0.0, MAX_EARLY_SHARE)
    early[:10] = False  # the regular interval is known from the beats around it
    missed = np.zeros(len(usual), dtype=bool)
    missed[rng.integers(10, len(usual), rng.poisson(MISSED))] = True
    kinds = [steady] * len(usual)
    interval = usual.copy()
    for i in np.flatnonzero(early).tolist():
        kinds[i] = _one_of(rng, EARLY)
        share = rng.uniform(0.2, 0.5)
        interval[i] = usual[i] * (1.0 - share)
        if i + 1 < len(usual):  # the pause that makes up for it
            interval[i + 1] = usual[i + 1] * (1.0 + share)
    interval[missed & ~early] *= 2.0
    time_s = np.cumsum(interval)
    time_s = time_s[time_s < length]
    others = _others(rng, length)
    beats = Beats(time_s, tuple(kinds[: len(time_s)]), ("",) * len(time_s), annotated=True)
    about = Description(f"random heart {seed}", length, "", ())
    return heart_timeline(about, beats, ((), ()), others, LoadOptions())


def _intervals(rng: np.random.Generator, length: float) -> FloatArray:
    """Return the intervals of a regular rhythm, s, for the largest number of beats."""
    count = int(length * 2.5) + 20
    rate = np.full(count, rng.uniform(55.0, 85.0))
    beat = np.arange(count)
    for _ in range(rng.integers(1, 4)):
        middle, width = rng.uniform(0.0, 0.6 * count), rng.uniform(0.03, 0.12) * count
        rate *= 1.0 + rng.uniform(0.25, 0.65) * np.exp(-(((beat - middle) / width) ** 2))
    breath = 0.03 * np.sin(beat * 2.0 * np.pi / rng.uniform(4.0, 6.0))
    drift = np.cumsum(rng.normal(0.0, 0.002, count))
    return np.asarray(60.0 / rate * np.exp(breath + drift + rng.normal(0.0, 0.012, count)))


def _others(rng: np.random.Generator, length: float) -> list[Event]:
    """Return the annotations that are not beats."""
    found = [
        Event(float(at), kind)
        for kind, rate in (("rhythm", RHYTHMS), ("signal_quality", FAULTS))
        for at in rng.uniform(0.0, length, rng.poisson(rate))
    ]
    for at in rng.uniform(0.1 * length, 0.9 * length, rng.poisson(FLUTTER)).tolist():
        duration = min(rng.uniform(4.0, 20.0), length - at)
        found += [Event(at, "flutter", "begins"), Event(at + duration, "flutter", "ends")]
    return found


def _one_of(rng: np.random.Generator, shares: tuple[tuple[str, float], ...]) -> str:
    names, parts = zip(*shares, strict=True)
    return str(names[int(rng.choice(len(names), p=parts))])


TRADING_DAYS = 252  # trading days per year
_FIRST_DAY = np.datetime64("1990-01-01", "D")


def random_share(seed: int) -> Timeline:
    """Generate one to three years of a share's closing prices.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same share.

    Returns
    -------
    Timeline
        Timeline with the event kinds of series.

    Examples
    --------
    >>> share = ov.measure.random_share(5)
    >>> share.kinds()["highest"], share.kinds()["lowest"]
    (1, 1)
    """
    rng = validation.random(seed)
    count = TRADING_DAYS * int(rng.integers(1, 4))
    start = _FIRST_DAY + int(rng.integers(0, 12_000))
    days = np.busday_offset(start, np.arange(count), roll="forward")
    log_volatility = np.log(rng.uniform(0.007, 0.025))
    deviation = 0.0
    steps = np.empty(count)
    for i, (kick, move) in enumerate(rng.standard_normal((count, 2)).tolist()):
        deviation += -deviation / 20.0 + 0.15 * kick
        steps[i] = np.exp(log_volatility + deviation) * move
    # jumps, such as after results: twice per year
    steps += (rng.random(count) < 2.0 / TRADING_DAYS) * rng.normal(0.0, 0.06, count)
    steps += rng.normal(0.0003, 0.0004)
    price = np.round(rng.uniform(10.0, 300.0) * np.exp(np.cumsum(np.clip(steps, -0.25, 0.25))), 2)
    return _timeline_of(days, price, "Close", f"random share {seed}")


def random_weather(seed: int) -> Timeline:
    """Generate one to four years of daily temperatures.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same weather.

    Returns
    -------
    Timeline
        Timeline with the event kinds of series.

    Examples
    --------
    >>> weather = ov.measure.random_weather(5)
    >>> weather.intensity.unit
    '°C'
    """
    rng = validation.random(seed)
    count = 365 * int(rng.integers(1, 5))
    start = _FIRST_DAY + int(rng.integers(0, 12_000))
    days = start + np.arange(count)
    share_of_year = (days - days.astype("datetime64[Y]")).astype(np.float64) / 365.25
    coldest = rng.normal(0.05, 0.02)
    season = -rng.uniform(5.0, 13.0) * np.cos(2.0 * np.pi * (share_of_year - coldest))
    weather = np.empty(count)
    deviation, persistence = 0.0, rng.uniform(0.6, 0.8)
    for i, kick in enumerate(rng.normal(0.0, rng.uniform(2.0, 3.5), count).tolist()):
        deviation = persistence * deviation + kick
        weather[i] = deviation
    value = np.round(rng.uniform(5.0, 18.0) + season + weather, 1)
    if rng.random() < 0.2:  # a station that failed
        first = int(rng.integers(0, count - 40))
        value[first : first + int(rng.integers(5, 40))] = np.nan
    return _timeline_of(days, value, "temperature (°C)", f"random weather {seed}")


def _timeline_of(
    days: NDArray[np.datetime64], values: FloatArray, header: str, title: str
) -> Timeline:
    table = replace(table_of({"Date": days, header: values}), kind="random")
    return series_timeline(table, LoadOptions(), title)


CROWD_LENGTH_S = (180.0, 720.0)
CHEERS_PER_MINUTE, BURSTS_PER_MINUTE = 1.1, 1.4
_CROWD_RATE = 1000  # sample rate that is assumed, Hz; only the energy of each step is used


def random_crowd(seed: int) -> Timeline:
    """Generate the loudness of a crowd, and find its cheers and bursts.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same crowd.

    Returns
    -------
    Timeline
        Timeline with the event kinds of the preset `crowd`.

    Examples
    --------
    >>> crowd = ov.measure.random_crowd(1)
    >>> sorted(crowd.kinds())
    ['burst', 'cheer']
    """
    rng = validation.random(seed)
    length = rng.uniform(*CROWD_LENGTH_S)
    count = int(length * STEPS_PER_S)
    at_s = np.arange(count) / STEPS_PER_S
    drift = np.cumsum(rng.normal(0.0, 0.15, count))
    # without changes slower than half a minute
    slow = drift - np.convolve(np.pad(drift, 150, mode="edge"), np.full(301, 1 / 301), "valid")
    above = np.zeros(count)
    for start in rng.uniform(2.0, length - 5.0, rng.poisson(CHEERS_PER_MINUTE * length / 60.0)):
        rise, hold, fall = rng.uniform(0.5, 2.5), rng.uniform(2.0, 12.0), rng.uniform(2.0, 6.0)
        places = [start, start + rise, start + rise + hold, start + rise + hold + fall]
        height = rng.uniform(7.0, 18.0)
        above = np.maximum(above, np.interp(at_s, places, [0.0, height, 0.9 * height, 0.0]))
    for start in rng.uniform(2.0, length - 5.0, rng.poisson(BURSTS_PER_MINUTE * length / 60.0)):
        inside = (at_s >= start) & (at_s < start + rng.uniform(0.2, 0.7))
        above[inside] = np.maximum(above[inside], rng.uniform(14.0, 26.0))
    loudness = rng.uniform(-36.0, -24.0) + slow + rng.normal(0.0, 0.7, count) + above
    samples = np.full(count, _CROWD_RATE // STEPS_PER_S)
    energy = samples * 10.0 ** (loudness / 10.0)
    steps = Steps(_CROWD_RATE, int(samples.sum()), energy, samples, (), 0)
    return timeline_of(steps, MAPS[0], f"random crowd {seed}", "random", ())


Generator = Callable[[int], Timeline]

_BY_KIND: Mapping[str, Generator] = {
    "goal": random_match,
    "premature": random_heart,
    "cheer": random_crowd,
}
_SERIES = "highest"  # kind of the presets for series
_SERIES_FOR: Mapping[str, Generator] = {"shares": random_share, "weather": random_weather}
"""Generator of a series by a word of `tags.usage`."""


def generators(preset: Preset) -> tuple[Generator, ...]:
    """Return the generators of timelines for a preset, which are used in turn."""
    for kind, generator in _BY_KIND.items():
        if kind in preset.kinds:
            return (generator,)
    if _SERIES in preset.kinds:
        named = [made for word, made in _SERIES_FOR.items() if word in preset.tags.usage]
        return tuple(named or _SERIES_FOR.values())
    own = [kind for kind in preset.kinds if kind != DEFAULT_KIND] or [DEFAULT_KIND]
    return (lambda seed: random_events(own, seed),)


def random_timelines(preset: Preset, count: int, seed: int = 0) -> list[Timeline]:
    """Generate timelines with the event kinds of a preset.

    They are matches for a preset with goals, hearts for one with premature beats, crowds for one
    with cheers, shares and weather (as its tags say, or both in turn) for one with the kind
    `highest`, and random events of all its kinds for any other.

    Parameters
    ----------
    preset : Preset
        Preset with the kinds.
    count : int
        Number of timelines.
    seed : int
        Seed of the first timeline; the others have the next seeds.

    Returns
    -------
    list of Timeline
        Timelines, each with at least one event.

    Examples
    --------
    >>> [made.title for made in ov.measure.random_timelines(ov.load_preset("football"), 2, seed=7)]
    ['random match 7', 'random match 8']
    """
    made = generators(preset)
    return [made[i % len(made)](seed + i) for i in range(count)]
