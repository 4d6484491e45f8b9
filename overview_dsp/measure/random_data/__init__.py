"""Random timelines like real ones, by seed: what an observer of a preset learns from and is asked.

Each generator draws what a reader would read (a match's events, a share's closing prices, a
heart's beats, a crowd's loudness); the reader's own rules make the timeline of it.
"""

from overview_dsp.measure.random_data.choosing import random_timelines
from overview_dsp.measure.random_data.crowd import random_crowd
from overview_dsp.measure.random_data.heart import random_heart
from overview_dsp.measure.random_data.kinds import random_events
from overview_dsp.measure.random_data.match import random_match
from overview_dsp.measure.random_data.series import random_share, random_weather

__all__ = [
    "random_crowd",
    "random_events",
    "random_heart",
    "random_match",
    "random_share",
    "random_timelines",
    "random_weather",
]
