"""A made-up share's year: strong at the start, weaker towards now, a little better of late.

Run it (`python -m tests.data.readers.made_up_share`, or by its path) to write the
bundled file anew.
"""

from __future__ import annotations

from dataclasses import replace
from datetime import date, datetime, timedelta
from pathlib import Path

import numpy as np

from overview_dsp.data.analysis.series_events import rules_of
from overview_dsp.data.readers.native import save_timeline
from overview_dsp.data.timeline.model import Event, Intensity, Timeline

BUNDLED_FILE = Path(__file__).parents[3] / "overview_dsp/data/readers/bundled/made_up_share.json"

DAY_S = 86_400.0
FIRST, LAST = date(2024, 1, 2), date(2024, 12, 31)
HALT = (date(2024, 6, 3), date(2024, 7, 12))
"""The last day before trade was halted and the first after it: a gap."""

TREND = ((0, 92.0), (60, 100.0), (130, 84.0), (200, 66.0), (270, 48.0), (322, 39.0), (364, 51.0))
"""Day and price, made up."""


def share() -> Timeline:
    """Trading days and their prices, the extremes, months."""
    days = np.array(
        [
            day
            for day in range((LAST - FIRST).days + 1)
            if (FIRST + timedelta(days=day)).weekday() < 5
            and not HALT[0] < FIRST + timedelta(days=day) < HALT[1]
        ]
    )
    random = np.random.default_rng(57)
    trend = np.interp(days, *np.array(TREND).T)
    price = np.round(
        trend * np.exp(np.convolve(random.normal(0.0, 0.012, len(days)), [1, 0.6, 0.3], "same")), 2
    )
    highest, lowest = int(price.argmax()), int(price.argmin())
    moves = np.where(np.diff(days) > 4, 0.0, np.abs(np.diff(np.log(price))))
    largest = np.argsort(moves)[::-1][:1] + 1
    events = [
        Event(float(days[highest]) * DAY_S, "record_high", f"{price[highest]:.2f}, year's highest"),
        Event(float(days[lowest]) * DAY_S, "record_low", f"{price[lowest]:.2f}, year's lowest"),
    ]
    events += [
        Event(
            float(days[i]) * DAY_S, "largest_rise", f"{price[i] / price[i - 1] - 1:+.1%} in a day"
        )
        for i in sorted(largest)
        if i not in (highest, lowest)
    ]
    first_of = [date(2024, month, 1) for month in range(2, 13)]
    events += [Event((day - FIRST).days * DAY_S, "month", f"{day:%B %Y}") for day in first_of]
    timeline = Timeline(
        title="A made-up share, 2024",
        duration_s=float(days[-1]) * DAY_S,
        events=tuple(events),
        intensity=Intensity(days * DAY_S, price, "price, made up"),
        gaps=(((HALT[0] - FIRST).days * DAY_S, (HALT[1] - FIRST).days * DAY_S),),
        provenance="made up: no share had these prices",
        notes=("everything in it is made up, the halt of trade in June and July too",),
        start=datetime(FIRST.year, FIRST.month, FIRST.day),
    )
    assert timeline.intensity is not None
    # a share's steps are per cent; windows find their own turning points, moves and crossings
    return replace(timeline, rules=rules_of(timeline.intensity, True, timeline))


if __name__ == "__main__":
    save_timeline(share(), BUNDLED_FILE)
