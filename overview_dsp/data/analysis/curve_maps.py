"""Mapping of a series to friction: level, change, activity, volatility, or another column.

`--map level`
    The value itself.
`--map change`
    Each value less the one before: per cent for prices, else in the value's unit
    (`change:percent`, `change:difference` choose).
`--map activity`
    The size of the change, without its sign.
`--map volatility`, `volatility:20`, `volatility:30d`
    Standard deviation of the changes of the last 20 samples, or of the last 30 days (s, min, h, d,
    w, y).
`--map count`, `count:6h`
    Number of rows in a window (`counting`).
`--map COLUMN`
    The level of another column.

There is no change over a gap. The first value, and the first one after a gap, have the change of
the next value, so that the curve is as long as the data. Volatility is extended in the same way
until half of its window has values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, quoted

MAPS = ("level", "change", "activity", "volatility")
"""Mappings of a series, in addition to the names of its columns."""

PERCENTILES = (1.0, 99.0)
"""Percentiles of the mapped curve that become 0 and 1: one outlier has no effect."""

WINDOW_SAMPLES = 20  # default window of volatility, samples: a month of trading days
NOT_ABOVE_0 = "some values are 0 or below: steps are in the unit of the values, not per cent"
"""Note for a price whose steps are not per cent."""


def span_s(text: str) -> float | None:
    """Return the seconds of a time above 0 with a unit (`6h`, `30d`), None for other texts."""
    has_unit = text.strip()[-1:].isalpha()
    return (length_s(text) or None) if has_unit else None


@dataclass(frozen=True)
class Map:
    """Mapping: one of `MAPS`, or `column` with its name in `argument`."""

    name: str
    argument: str = ""

    @classmethod
    def of(cls, option: str | None, headers: frozenset[str]) -> Map:
        """Parse `--map`: one of `MAPS`, or a column in `headers` (lower case); else InputError."""
        if option is None:
            return cls("level")
        name, _, argument = (part.strip() for part in option.partition(":"))
        if option.strip().lower() in headers and option.strip().lower() not in MAPS:
            return cls("column", option.strip())
        if name.lower() in MAPS:
            found = cls(name.lower(), argument.lower())
            found.check()
            return found
        raise InputError(
            f"map is {quoted(option)}; must be {', '.join(MAPS)}, count or a column of the table"
        )

    def check(self) -> None:
        """Raise InputError for an argument that the mapping does not take."""
        if self.name in ("change", "activity"):
            if self.argument not in ("", "percent", "difference"):
                raise InputError(
                    f"map {self.name}:{quoted(self.argument)}: give {self.name}:percent or "
                    f"{self.name}:difference"
                )
        elif self.name == "volatility":
            self.window()
        elif self.argument:
            raise InputError(f"map {self.name} takes no argument; remove the colon")

    def window(self) -> tuple[float, bool]:
        """Return the window of volatility, and whether it is in seconds (else samples)."""
        if not self.argument:
            return float(WINDOW_SAMPLES), False
        samples = self.argument.removesuffix(".0")
        if samples.isdecimal() and samples.isascii() and len(samples) < 16 and int(samples) >= 2:
            return float(samples), False
        seconds = span_s(self.argument)
        if seconds is None:
            raise InputError(
                f"map volatility:{quoted(self.argument)}: give a window as samples (2 or "
                "more: volatility:20) or as a time (volatility:30d; s, min, h, d, w, y)"
            )
        return seconds, True

    def in_per_cent(self, relative: bool) -> bool:
        """Return whether changes are per cent: as requested, else `relative`."""
        return {"percent": True, "difference": False}.get(self.argument, relative)

    def unit(self, unit: str, relative: bool) -> str:
        """Return the unit of the curve from the unit of its column."""
        return "%" if relative and self.name not in ("level", "column") else unit

    def description(self, header: str) -> str:
        """Return a description of the curve from the name of its column."""
        if self.name == "volatility":
            span = self.argument if self.window()[1] else f"{self.window()[0]:g} samples"
            return f"the volatility of {header} (standard deviation of changes, last {span})"
        return {
            "change": f"the change of {header} from one sample to the next",
            "activity": f"the activity of {header} (size of its changes)",
        }.get(self.name, f"the level of {header}")


def curve(mapping: Map, level: FloatArray, step: FloatArray, time_s: FloatArray) -> FloatArray:
    """Return the mapped value of each sample, NaN if the level is missing.

    `step` has the changes (`steps`) of the mapped column `level`.
    """
    if mapping.name in ("level", "column"):
        return level
    present = ~np.isnan(level)
    if mapping.name == "volatility":
        spread = volatility(step, time_s, *mapping.window())
        return filled(np.where(present, spread, np.nan), present)
    change = filled(step, present)
    return change if mapping.name == "change" else np.abs(change)


def steps(
    value: FloatArray, breaks: IntArray, relative: bool, factors: dict[int, float] | None = None
) -> FloatArray:
    """Return the change of each value (NaN = missing) from the one before it.

    It is NaN at the first value, after each of `breaks` (the step from i to i + 1 is a hole) and
    where a value is missing. `relative`: changes are per cent, NaN from 0 or below. `factors`:
    factors for samples after a share split, by their index.
    """
    here = value[1:].copy()
    for index, factor in (factors or {}).items():
        here[index - 1] *= factor
    before = value[:-1]
    change = np.full(value.shape, np.nan)
    if relative:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            change[1:] = np.where(before > 0.0, 100.0 * (here / before - 1.0), np.nan)
    else:
        change[1:] = here - before
    change[breaks + 1] = np.nan
    change[~np.isfinite(change)] = np.nan
    return change


def volatility(change: FloatArray, time_s: FloatArray, window: float, seconds: bool) -> FloatArray:
    """Return the standard deviation of the changes in the window that ends at each sample.

    It is NaN if less than half of the window, or fewer than two changes, have values.
    """
    count = len(change)
    if seconds:
        begin = np.searchsorted(time_s, time_s - window, side="right")
        usual = window / float(np.median(np.diff(time_s)))
    else:
        begin = np.maximum(np.arange(count) + 1 - int(window), 0)
        usual = window
    known = ~np.isnan(change)
    size = float(np.max(np.abs(change[known]), initial=0.0)) or 1.0
    scaled = np.where(known, change, 0.0) / size  # so that squares stay in range
    end = np.arange(count) + 1

    def total(terms: FloatArray) -> FloatArray:
        sums = np.concatenate(([0.0], np.cumsum(terms)))
        return np.asarray(sums[end] - sums[begin])

    number = total(known.astype(np.float64))
    least = max(2.0, min(usual, float(known.sum())) / 2.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = total(scaled) / number
        variance = np.maximum(total(scaled**2) / number - mean**2, 0.0)
    return np.where(number >= least, np.sqrt(variance) * size, np.nan)


def filled(value: FloatArray, present: BoolArray) -> FloatArray:
    """Replace NaN of present samples by the next value, else by the last one."""
    known = np.flatnonzero(~np.isnan(value))
    if not known.size:
        return np.where(present, 0.0, value)
    after = np.searchsorted(known, np.arange(len(value)), side="left")
    nearest = known[np.minimum(after, len(known) - 1)]
    return np.where(present & np.isnan(value), value[nearest], value)
