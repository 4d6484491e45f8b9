"""The points of a curve over time, checked on construction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from overview_dsp import validation
from overview_dsp.data.timeline.curve_checks import (
    as_given,
    checked_percentiles,
    float_points,
    require_increasing,
    require_values,
)
from overview_dsp.data.timeline.even_times import EvenTimes
from overview_dsp.data.timeline.minmax_pyramid import CHUNK, Values
from overview_dsp.data.timeline.samples import Points, Times
from overview_dsp.errors import InputError

EXTREMES = (0.0, 100.0)
"""Percentiles of the smallest and the largest value."""


@dataclass(frozen=True, eq=False)
class CurvePoints:
    """The fields of an `Intensity`, which says what each is."""

    time_s: Times
    value: Values
    unit: str = ""
    percentiles: tuple[float, float] = EXTREMES

    def __post_init__(self) -> None:
        if isinstance(self.time_s, EvenTimes):
            time_s: Times = self.time_s
            value = as_given(self.value, "intensity.value")
        else:
            time_s = float_points(self.time_s, "intensity.time_s")
            value = float_points(self.value, "intensity.value")
        validation.text(self.unit, "intensity.unit")
        if len(time_s) != len(value):
            raise InputError(
                f"intensity.time_s has {len(time_s)} points and intensity.value {len(value)}; "
                "give one value for each time"
            )
        if len(time_s) == 0:
            raise InputError(
                "intensity has no points; give two or more, or one for a constant, "
                "or leave the intensity out"
            )
        if not isinstance(time_s, EvenTimes):
            require_increasing(time_s)
        for start in range(0, len(value), CHUNK):
            require_values(np.asarray(value[start : start + CHUNK]), start)
        object.__setattr__(self, "percentiles", checked_percentiles(self.percentiles))
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "value", value)

    @classmethod
    def checked(
        cls, points: Points, unit: str = "", percentiles: tuple[float, float] = EXTREMES
    ) -> Self:
        """Make a curve of points that were checked already, which are not copied.

        Parameters
        ----------
        points : Points
            Of another curve, or of a `CurveBuilder`.
        unit : str
            What the values are, for a person.
        percentiles : (float, float)
            As in the constructor.

        Returns
        -------
        Intensity
            The curve.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> ov.Intensity.checked(curve.points, unit="km/h").unit
        'km/h'
        """
        curve = object.__new__(cls)
        curve.__dict__.update(
            time_s=points.time_s,
            value=points.value,
            unit=validation.text(unit, "intensity.unit"),
            percentiles=checked_percentiles(percentiles),
            points=points,
        )
        return curve

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, CurvePoints):
            return NotImplemented
        return (
            self.unit == other.unit
            and self.percentiles == other.percentiles
            and self.count == other.count
            and _same_times(self.time_s, other.time_s)
            and np.array_equal(self.value, other.value)
        )

    def __hash__(self) -> int:
        return hash((self.unit, self.percentiles, self.count, self.first_s, self.last_s))

    @property
    def count(self) -> int:
        """How many points there are."""
        return len(self.value)

    @property
    def first_s(self) -> float:
        """The first point's time, s."""
        return float(self.time_s[0])

    @property
    def last_s(self) -> float:
        """The last point's time, s."""
        return float(self.time_s[-1])

    @property
    def is_constant(self) -> bool:
        """Whether it is a curve of one point, which has that value at all times."""
        return self.count == 1

    @cached_property
    def points(self) -> Points:
        """The points, however many, with what was worked out of them."""
        return Points(self.time_s, self.value)

    @property
    def _shift(self) -> float:
        """What to add to a time of this curve for the time of its points."""
        return 0.0

    @property
    def _between(self) -> tuple[int, int]:
        """The first point's index and the last one's + 1."""
        return 0, self.count


def _same_times(one: Times, other: Times) -> bool:
    if isinstance(one, EvenTimes) and isinstance(other, EvenTimes):
        return one == other
    return np.array_equal(one, other)
