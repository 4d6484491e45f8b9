"""Times of an evenly sampled curve, which need not be stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import DTypeLike, NDArray

from overview_dsp import validation
from overview_dsp.errors import InputError


@dataclass(frozen=True)
class EvenTimes:
    """The times first_s + i * step_s, i = 0 ... count - 1, read like a float64 array.

    Parameters
    ----------
    count : int
        How many, at least 1.
    step_s : float
        Seconds from one to the next, > 0.
    first_s : float
        The first one, s, >= 0.

    Raises
    ------
    InputError
        A count below 1, a step that isn't above 0, a start below 0, or times too far from 0 to
        be distinguished.

    Examples
    --------
    >>> times = ov.EvenTimes(count=7200, step_s=0.5)
    >>> curve = ov.Intensity(times, np.zeros(7200, dtype=np.float32))
    >>> curve.last_s
    3599.5
    """

    count: int
    step_s: float
    first_s: float = 0.0

    def __post_init__(self) -> None:
        if not 1 <= validation.whole(self.count, "count") < 2**53:
            raise InputError("intensity has no points, or too many to count; give one or more")
        validation.positive(self.step_s, "step_s", "give the seconds from one value to the next")
        if validation.number(self.first_s, "first_s", validation.TIME_HINT) < 0.0:
            raise InputError(
                f"first_s is {self.first_s!r}, before the start; {validation.TIME_HINT}"
            )
        if not np.isfinite(self[-1]) or (self.count > 1 and self[-2] >= self[-1]):
            raise InputError(
                f"{self.count} values {self.step_s!r} s apart lie too close together to be "
                "distinguished; count them from 0"
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
        """List all of them.

        Returns
        -------
        list of float
            Seconds.

        Examples
        --------
        >>> times = ov.EvenTimes(count=3, step_s=0.5)
        >>> times.tolist()
        [0.0, 0.5, 1.0]
        """
        every: list[float] = self[:].tolist()
        return every

    def at(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Look up the times of some indices.

        Parameters
        ----------
        index : int64 (n,)
            From 0.

        Returns
        -------
        float64 (n,)
            Seconds.

        Examples
        --------
        >>> times = ov.EvenTimes(count=3, step_s=0.5)
        >>> times.at(np.array([2]))
        array([1.])
        """
        times = index.astype(np.float64)
        times *= self.step_s
        times += self.first_s
        return times

    def first_from(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Find the first index whose time is at or after each of some times.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        int64 (n,)
            Up to `count`.

        Examples
        --------
        >>> times = ov.EvenTimes(count=3, step_s=0.5)
        >>> times.first_from(np.array([0.5, 0.6]))
        array([1, 2])
        """
        guess = (times - self.first_s) / self.step_s
        np.ceil(np.clip(guess, 0.0, float(self.count), out=guess), out=guess)
        index = guess.astype(np.int64)
        # rounding may have put it one off
        index -= (self.at(index - 1) >= times) & (index > 0)
        index += (self.at(index) < times) & (index < self.count)
        return index

    def first_after(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Find the first index whose time is after each of some times.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        int64 (n,)
            Up to `count`.

        Examples
        --------
        >>> times = ov.EvenTimes(count=3, step_s=0.5)
        >>> times.first_after(np.array([0.5, 0.6]))
        array([2, 2])
        """
        index = self.first_from(times)
        index += (index < self.count) & (self.at(index) <= times)
        return index
