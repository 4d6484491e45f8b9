"""Units that people write and those of the physics; the steps in which a level is felt."""

from __future__ import annotations

import math

HALF_TURN = math.pi
"""The input angle of the whole timeline, rad (the paper's 180 degrees)."""

FELT_WINDOW_S = 0.010
"""Felt level is the RMS over windows of this length."""

JUST_NOTICEABLE_DB = 2.5
"""One step of amplitude on the skin (Israr and Tan 2006: 2.2 to 2.5 dB)."""

DAYS_FROM_S = 2 * 86_400.0
"""A span as long as this is told in days."""


def gain_to_db(gain: float) -> float:
    """Level in dB of an amplitude ratio; minus infinity for 0."""
    return 20.0 * math.log10(gain) if gain > 0.0 else -math.inf


def clock_text(seconds: float) -> str:
    """`1:02:03.4`-style text of a duration in seconds, without leading zero fields."""
    sign = "-" if seconds < 0 else ""
    tenths = round(abs(seconds) * 10)
    minutes, tenths = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    rest = f"{tenths // 10:02d}.{tenths % 10}"
    return f"{sign}{hours}:{minutes:02d}:{rest}" if hours else f"{sign}{minutes}:{rest}"


def span_text(seconds: float) -> str:
    """Return a duration for a person: `1:37:30.5`, or days where there are many."""
    return f"{seconds / 86_400.0:.6g} days" if seconds >= DAYS_FROM_S else clock_text(seconds)
