"""Times of an evenly sampled curve, which need not be stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import DTypeLike, NDArray

from overview_dsp.errors import InputError
from overview_dsp.timeline import checks


@dataclass(frozen=True)
class EvenTimes:
    """The times first_s + i * step_s, i = 0 ... count - 1: read like a float64 array.

    Raises
    ------
    InputError
        A count below 1, a step that isn't above 0, a start below 0, or times too far from 0 to
        tell apart.
    """

    count: int
    step_s: float
    first_s: float = 0.0

    def __post_init__(self) -> None:
        if self.count < 1:
            raise InputError("intensity has no points; give one or more")
        checks.positive(self.step_s, "step_s", "give the seconds from one value to the next")
        if checks.number(self.first_s, "first_s", checks.TIME_HINT) < 0.0:
            raise InputError(f"first_s is {self.first_s!r}, before the start; {checks.TIME_HINT}")
        if not np.isfinite(self[-1]) or (self.count > 1 and self[-2] >= self[-1]):
            raise InputError(
                f"{self.count} values {self.step_s!r} s apart lie too close together to tell "
                "apart; count them from 0"
            )

    def __len__(self) -> int:
        return self.count

    @overload
    def __getitem__(self, index: int) -> float: ...
    @overload
    def __getitem__(self, index: slice) -> NDArray[np.float64]: ...
    def __getitem__(self, index: int | slice) -> float | NDArray[np.float64]:
        if isinstance(index, slice):
            return self.at(np.arange(*index.indices(self.count)))
        place = range(self.count)[index]
        return self.first_s + place * self.step_s

    def __array__(
        self, dtype: DTypeLike | None = None, copy: bool | None = None
    ) -> NDArray[np.float64]:
        every = self.at(np.arange(self.count))
        return every if dtype is None else every.astype(dtype)

    def tolist(self) -> list[float]:
        """All of them."""
        every: list[float] = self[:].tolist()
        return every

    def at(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the times of some indices."""
        times: NDArray[np.float64] = self.first_s + index.astype(np.float64) * self.step_s
        return times

    def first_from(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the first index whose time is at or after each of `times` (up to count)."""
        guess = np.ceil(np.clip((times - self.first_s) / self.step_s, 0.0, float(self.count)))
        index = guess.astype(np.int64)
        # rounding may have put it one off
        index -= (index > 0) & (self.at(index - 1) >= times)
        index += (index < self.count) & (self.at(index) < times)
        return index

    def first_after(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the first index whose time is after each of `times` (up to count)."""
        index = self.first_from(times)
        index += (index < self.count) & (self.at(index) <= times)
        return index
