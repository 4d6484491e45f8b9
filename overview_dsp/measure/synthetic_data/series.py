"""Random series: closing prices of a share, daily temperatures of a town, loudness of a crowd.

Prices are random walks with rare jumps; their volatility (0.7 to 2.5 % a day) varies and reverts
within a month or so. Temperatures are a yearly wave plus noise with a memory of some days; in some
series, consecutive days are missing. Their events are found by the rules for tables.

The quiet level of a crowd varies by one or two decibels; cheers rise by 7 to 18 LU within 2.5 s,
last 2 to 12 s and fade; bursts (a whistle, a bang) last a few tenths of a second.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.loudness import STEPS_PER_S, Steps
from overview_dsp.data.readers.audio.reader import MAPS, timeline_of
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.series.series_reader import series_timeline
from overview_dsp.data.readers.tables.memory import table_of
from overview_dsp.data.timeline import Timeline

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
