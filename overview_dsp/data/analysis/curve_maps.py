"""What becomes friction: the level, its change, its activity, its volatility, or another column.

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
    How many rows there are in a window (`counting`).
`--map COLUMN`
    The level of another column.

A change isn't taken over a gap. The first value after one (and the very first) has none of its own:
it takes that of the step after it, so that the curve reaches as far as the data. The same holds for
volatility until half of its window is there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, shown

MAPS = ("level", "change", "activity", "volatility")
"""What a series may be mapped by, besides its columns' names."""

PERCENTILES = (1.0, 99.0)
"""Percentiles of the mapped curve that become 0 and 1: one wild value moves nothing."""

WINDOW_SAMPLES = 20
"""Samples of volatility: a month of trading days."""

NOT_ABOVE_0 = "some values are 0 or below: steps are in the unit of the values, not per cent"
"""Says why a price's steps aren't per cent."""


def span_s(words: str) -> float | None:
    """Return a time above 0 with its unit (`6h`, `30d`) in s; None for what is none."""
    has_unit = words.strip()[-1:].isalpha()
    return (length_s(words) or None) if has_unit else None


@dataclass(frozen=True)
class Map:
    """A wish taken apart: one of `MAPS`, or `column` with its name in `argument`."""

    name: str
    argument: str = ""

    @classmethod
    def of(cls, wish: str | None, headers: frozenset[str]) -> Map:
        """Read a `--map` value; what isn't one of `MAPS` is a column (in `headers`, lower case).

        Raises
        ------
        InputError
            Neither; the line names both.
        """
        if wish is None:
            return cls("level")
        name, _, argument = (part.strip() for part in wish.partition(":"))
        if wish.strip().lower() in headers and wish.strip().lower() not in MAPS:
            return cls("column", wish.strip())
        if name.lower() in MAPS:
            found = cls(name.lower(), argument.lower())
            found.check()
            return found
        raise InputError(
            f"map {shown(wish)}: neither {', '.join(MAPS)}, count nor a column of the table"
        )

    def check(self) -> None:
        """Refuse an argument that its map doesn't take; InputError says what it does."""
        if self.name in ("change", "activity"):
            if self.argument not in ("", "percent", "difference"):
                raise InputError(
                    f"map {self.name}:{shown(self.argument)}: give {self.name}:percent or "
                    f"{self.name}:difference"
                )
        elif self.name == "volatility":
            if self.argument:
                self.window()
        elif self.argument:
            raise InputError(f"map {self.name} takes nothing after it; leave the colon out")

    def window(self) -> tuple[float, bool]:
        """The window of volatility, and whether it is seconds (else samples)."""
        if not self.argument:
            return float(WINDOW_SAMPLES), False
        samples = self.argument.removesuffix(".0")
        if samples.isdecimal() and samples.isascii() and len(samples) < 16 and int(samples) >= 2:
            return float(samples), False
        seconds = span_s(self.argument)
        if seconds is None:
            raise InputError(
                f"map volatility:{shown(self.argument)}: give a window as samples (2 or "
                "more: volatility:20) or as a time (volatility:30d; s, min, h, d, w, y)"
            )
        return seconds, True

    def in_per_cent(self, relative: bool) -> bool:
        """Return whether changes are per cent, `relative` unless asked otherwise."""
        return {"percent": True, "difference": False}.get(self.argument, relative)

    def unit(self, unit: str, relative: bool) -> str:
        """The unit of the curve, of a column's unit."""
        return "%" if relative and self.name not in ("level", "column") else unit

    def words(self, header: str) -> str:
        """What the curve is, of a column's name."""
        if self.name == "volatility":
            span = self.argument if self.window()[1] else f"{self.window()[0]:g} samples"
            return f"the volatility of {header} (standard deviation of changes, last {span})"
        return {
            "change": f"the change of {header} from one sample to the next",
            "activity": f"the activity of {header} (size of its changes)",
        }.get(self.name, f"the level of {header}")


def curve(
    wish: Map, level: NDArray[np.float64], step: NDArray[np.float64], time_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what is mapped of each sample, NaN where the level is missing.

    Parameters
    ----------
    level, step, time_s
        The mapped column, its changes (`steps`) and the times, shape (n,).
    """
    if wish.name in ("level", "column"):
        return level
    wanted = ~np.isnan(level)
    if wish.name == "volatility":
        spread = volatility(step, time_s, *wish.window())
        return filled(np.where(wanted, spread, np.nan), wanted)
    change = filled(step, wanted)
    return change if wish.name == "change" else np.abs(change)


def steps(
    value: NDArray[np.float64],
    breaks: NDArray[np.int64],
    relative: bool,
    factors: dict[int, float] | None = None,
) -> NDArray[np.float64]:
    """Return each value's change from the one before it.

    Parameters
    ----------
    value
        Shape (n,), NaN = missing.
    breaks
        Indices i whose step to i + 1 is a hole.
    relative
        In per cent; a step from 0 or below has none.
    factors
        For samples after a share split, what to multiply them by for the comparison.

    Returns
    -------
    ndarray
        Shape (n,); NaN at the first value, after a gap and where a value is missing.
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


def volatility(
    change: NDArray[np.float64], time_s: NDArray[np.float64], window: float, seconds: bool
) -> NDArray[np.float64]:
    """Return the standard deviation of the changes in the window that ends at each sample.

    NaN where less than half of it (and fewer than two changes) is there.
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

    def total(terms: NDArray[np.float64]) -> NDArray[np.float64]:
        sums = np.concatenate(([0.0], np.cumsum(terms)))
        return np.asarray(sums[end] - sums[begin])

    number = total(known.astype(np.float64))
    least = max(2.0, min(usual, float(known.sum())) / 2.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = total(scaled) / number
        variance = np.maximum(total(scaled**2) / number - mean**2, 0.0)
    return np.where(number >= least, np.sqrt(variance) * size, np.nan)


def filled(value: NDArray[np.float64], wanted: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Give wanted samples without a value that of the next sample that has one, else the last."""
    known = np.flatnonzero(~np.isnan(value))
    if not known.size:
        return np.where(wanted, 0.0, value)
    after = np.searchsorted(known, np.arange(len(value)), side="left")
    nearest = known[np.minimum(after, len(known) - 1)]
    return np.where(wanted & np.isnan(value), value[nearest], value)
