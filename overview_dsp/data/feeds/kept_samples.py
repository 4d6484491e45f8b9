"""The samples of a feed, in order, in bounded memory."""

from __future__ import annotations

from array import array
from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

MAX_SAMPLES = 65_536
"""Most samples that are kept: nine minutes' worth more than a match's at ten a second, and as many
as a surface looks at one by one. When there are more, each two become one."""


class KeptSamples:
    """A curve's points; one that comes again for a time takes the place of the first.

    Where they are too many, each two next to each other become the larger one: a cheer stays as
    high as it was.
    """

    def __init__(self) -> None:
        self._time_s = array("d")
        self._value = array("d")

    def __len__(self) -> int:
        return len(self._time_s)

    @property
    def last_s(self) -> float:
        """The latest sample's time, s."""
        return self._time_s[-1]

    def put(self, time_s: float, value: float) -> bool:
        """Keep a sample; whether it is new."""
        times = self._time_s
        if not times or time_s > times[-1]:
            times.append(time_s)
            self._value.append(value)
        else:
            place = bisect_left(times, time_s)
            if times[place] == time_s:
                if self._value[place] == value:
                    return False
                self._value[place] = value
                return True
            times.insert(place, time_s)
            self._value.insert(place, value)
        if len(times) > MAX_SAMPLES:
            self._halve()
        return True

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Copies of the times (s) and the values."""
        return np.array(self._time_s, np.float64), np.array(self._value, np.float64)

    def _halve(self) -> None:
        times, values = self.arrays()
        count = len(times) // 2 * 2
        pair = values[:count].reshape(-1, 2)
        kept = np.arange(0, count, 2) + np.argmax(pair, axis=1)
        # the newest stays, so that the curve still reaches to where it did
        kept = np.unique(np.append(kept, len(times) - 1))
        self._time_s = array("d", times[kept])
        self._value = array("d", values[kept])
