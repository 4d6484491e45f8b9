"""Labels of a series: its values and times as text."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

from overview_dsp.units import clock_text


def value_text(value: float, unit: str = "") -> str:
    """Return `702.1`, `35.6 °C`, `1251000`, `3.5 %`."""
    figures = f"{value:.6g}"
    if "e" in figures and abs(value) < 1e15:
        figures = f"{value:.0f}"
    return f"{figures} {unit}" if unit else figures


@dataclass(frozen=True)
class Calendar:
    """Names the times of a series: a date where it has only those, else a date and a clock.

    Parameters
    ----------
    start
        The moment of time 0; None gives clock times from 0.
    dates_only
        All samples are at the same time of day.
    """

    start: datetime | None
    dates_only: bool

    def text(self, time_s: float) -> str:
        """Return `2012-09-19`, `2012-09-19 16:00`, `12:30.5`."""
        if self.start is None:
            return clock_text(time_s)
        try:
            moment = self.start + timedelta(seconds=time_s)
        except OverflowError:  # rounding took the calendar's last moment past it
            moment = datetime.max
        if self.dates_only:
            return f"{moment.date().isoformat()}"
        whole = moment.replace(tzinfo=None)
        if whole.microsecond:
            return whole.isoformat(" ", "milliseconds")
        return whole.isoformat(" ", "seconds" if whole.second else "minutes")
