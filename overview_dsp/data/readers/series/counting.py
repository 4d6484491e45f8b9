"""Number of rows in each window of time as an intensity curve (`--map count`).

This is for earthquakes, commits, log lines or messages: a table with times in any order.
`count:WINDOW` sets the length of a window (s, min, h, d, w, y: `count:6h`). By default, it is the
shortest round length with at most `USUAL_WINDOWS` windows. Windows are aligned to the calendar
(weeks to Monday). The timeline begins with a window, so that each is complete.

Every row with a time counts once and takes 8 bytes. A window without rows is 0, not a gap.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis import curve_maps
from overview_dsp.data.analysis.series_events import Calendar, Series, WindowRules, find_events
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.series.read_plan import HEAD_ROWS
from overview_dsp.data.readers.series.rows import RowReader, with_settled_order
from overview_dsp.data.readers.tables.column_roles import choose_time
from overview_dsp.data.readers.tables.table import Table, first_rows
from overview_dsp.data.timeline.growable_array import Store
from overview_dsp.data.timeline.model import Intensity, Timeline
from overview_dsp.errors import InputError, quoted

MAX_ROWS = 500_000_000
"""Maximum number of rows; their times take 8 bytes each in a temporary file."""

MAX_WINDOWS = 2_000_000
USUAL_WINDOWS = 500
"""Maximum number of windows without a requested length."""

_DAY = 86_400.0
_ROUND_WINDOWS = {
    "1s": 1.0, "5s": 5.0, "10s": 10.0, "30s": 30.0, "1min": 60.0, "5min": 300.0, "15min": 900.0,
    "1h": 3600.0, "6h": 21_600.0, "1d": _DAY, "1w": 7 * _DAY, "30d": 30 * _DAY, "1y": 365.25 * _DAY,
    "10y": 3652.5 * _DAY, "100y": 36_525.0 * _DAY,
}  # fmt: skip


@dataclass(frozen=True)
class _Windows:
    """Consecutive windows: their length as text (`6h`) and in s, start of the first, and number."""

    name: str
    span_s: float
    first_s: float
    count: int


def count_rows(table: Table, options: LoadOptions, title: str) -> Timeline:
    """Return a Timeline whose curve is the number of rows in each window.

    InputError: an option that does not apply, a wrong or too short window, no times, a wrong cell.
    """
    for name in ("value", "rate"):
        if getattr(options, name) is not None:
            raise InputError(f"map count counts rows by their times; leave {name} out")
    assert options.map is not None
    requested = _span(options.map)
    head = first_rows(table, HEAD_ROWS)
    time = with_settled_order(table, choose_time(table, head, options.time, False))
    reader = RowReader(table, time, (), ".", None, options.report_progress)
    store = Store(np.float64)
    low, high = np.inf, -np.inf
    for rows in reader:
        seconds = rows[1]
        store.append(seconds)
        low, high = seconds.min(initial=low), seconds.max(initial=high)
        if store.count > MAX_ROWS:
            raise InputError(f"more than {MAX_ROWS} rows; cut the file into parts")
    if not store.count:
        raise InputError("no row has a time; name another column with time (--time-column)")
    first, last = float(low), float(high)
    if not np.isfinite(last - first) or last - first > 1e15:
        raise InputError("the times span more than 30 million years; check their unit")
    windows = _windows(requested, first, last, reader.time.start(first))
    seconds, counts = store.finish(), np.zeros(windows.count, np.int64)
    for begin in range(0, len(seconds), 1 << 20):
        part = np.asarray(seconds[begin : begin + (1 << 20)])
        at = np.floor((part - windows.first_s) / windows.span_s).astype(np.int64)
        # rounding may put the last row past the last window
        counts += np.bincount(np.clip(at, 0, windows.count - 1), minlength=windows.count)
    return _timeline(table, reader, windows, counts.astype(np.float64), title)


def _span(option: str) -> tuple[str, float] | None:
    """Return the requested window as text and in s, None if it is left out."""
    _, colon, text = (part.strip() for part in option.partition(":"))
    if not colon:
        return None
    seconds = curve_maps.span_s(text)
    if seconds is None:
        raise InputError(
            f"map count:{quoted(text)}: give a window as a time (count:6h; s, min, h, d, w, y)"
        )
    return text, seconds


def _windows(
    requested: tuple[str, float] | None, first: float, last: float, start: datetime | None
) -> _Windows:
    text, span = requested or next(
        (item for item in _ROUND_WINDOWS.items() if (last - first) / item[1] < USUAL_WINDOWS - 1),
        ("1000y", 365_250.0 * _DAY),
    )
    begin = first - _since_window_start(first, span, start)
    count = int((last - begin) // span) + 1
    if count > MAX_WINDOWS:
        raise InputError(
            f"map count:{text} makes {count} windows in {last - first:.6g} s; must be at most "
            f"{MAX_WINDOWS}: give a longer window"
        )
    return _Windows(text, span, begin, count)


def _since_window_start(first: float, span: float, start: datetime | None) -> float:
    """Return the time from the start of the first window to the first row, s."""
    if start is None:
        return first % span
    midnight = start.replace(hour=0, minute=0, second=0, microsecond=0)
    seconds_of_day = (start - midnight).total_seconds()
    since = seconds_of_day % span if span < _DAY else seconds_of_day
    if span % (7 * _DAY) == 0.0:
        since += start.weekday() * _DAY
    # no window before the first day of the calendar
    earliest = datetime.min.replace(tzinfo=start.tzinfo) + timedelta(days=1)
    return since if start - earliest > timedelta(seconds=since) else 0.0


def _timeline(
    table: Table, reader: RowReader, windows: _Windows, counts: FloatArray, title: str
) -> Timeline:
    span = windows.span_s
    duration_s = windows.count * span
    middle = (np.arange(windows.count, dtype=np.float64) + 0.5) * span
    unit = f"per {windows.name.removeprefix('1') if windows.name[1:].isalpha() else windows.name}"
    start = reader.time.start(windows.first_s)
    calendar = Calendar(start, dates_only=False)
    step = np.concatenate(([np.nan], np.diff(counts)))
    series = Series(middle, counts, step, False, unit, calendar)
    events, event_notes = find_events(series, duration_s)
    # the values of the first and last window also hold at the timeline's ends
    time_s = np.concatenate(([0.0], middle, [duration_s]))
    value = np.concatenate((counts[:1], counts, counts[-1:]))
    busiest = int(np.argmax(counts))
    notes = [
        f"{reader.rows} rows, counted in {windows.count} windows of {windows.name} "
        f"(map count:{windows.name}); {counts[busiest]:g} in the fullest, from "
        f"{calendar.text(busiest * span)} on"
    ]
    if reader.skipped:
        notes.append(f"{reader.skipped} rows without a time aren't counted")
    names = " and ".join(quoted(table.columns[i].header) for i in reader.choice.columns)
    return Timeline(
        title=title,
        duration_s=duration_s,
        events=tuple(events),
        intensity=Intensity(time_s, value, unit),
        provenance=(
            f"a {table.kind} table, rows by {names} ({reader.choice.format.description}); "
            "events by rule"
        ),
        notes=(*table.notes, *reader.choice.notes, *notes, *event_notes),
        start=start,
        rules=WindowRules(series, 0.0, duration_s),
    )
