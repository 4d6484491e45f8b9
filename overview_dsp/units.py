"""Units of input angles, levels and durations."""

from __future__ import annotations

import math

HALF_TURN = math.pi  # input angle of the whole timeline, rad (180 degrees in the paper)
FELT_WINDOW_S = 0.010  # window of the RMS that is the felt level, s

JUST_NOTICEABLE_DB = 2.5
"""Just-noticeable difference of amplitude on the skin (Israr and Tan 2006: 2.2 to 2.5 dB)."""

DAYS_FROM_S = 2 * 86_400.0  # shortest duration that is written in days, s


def gain_to_db(gain: float) -> float:
    """Return the level in dB of an amplitude ratio; minus infinity for 0."""
    return 20.0 * math.log10(gain) if gain > 0.0 else -math.inf


def clock_text(seconds: float) -> str:
    """Return a duration (s) as `1:02:03.4`, without leading zero fields."""
    sign = "-" if seconds < 0 else ""
    tenths = round(abs(seconds) * 10)
    minutes, tenths = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    rest = f"{tenths // 10:02d}.{tenths % 10}"
    return f"{sign}{hours}:{minutes:02d}:{rest}" if hours else f"{sign}{minutes}:{rest}"


def span_text(seconds: float) -> str:
    """Return a duration (s) as `1:37:30.5`, or in days if it is long."""
    return f"{seconds / 86_400.0:.6g} days" if seconds >= DAYS_FROM_S else clock_text(seconds)
