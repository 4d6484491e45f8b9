"""An amplitude curve as few straight pieces, the points spent where they are felt.

A step in amplitude is felt by its ratio, so the error is measured in dB. Points are added one by
one, in the piece where most is wrong for longest and there at the worst point (Ramer, Douglas and
Peucker's split, with a queue), until the budget is spent or no error is a third of a step.

What a JSON value must look like: small checks that say every fault with its place.

A shape is called with a value, its place and a list that takes the faults, a line each.
"""

from __future__ import annotations

import heapq
import itertools
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import shown
from overview_dsp.offline.export.clip import FLOOR
from overview_dsp.units import JUST_NOTICEABLE_DB

GOOD_ENOUGH_DB = JUST_NOTICEABLE_DB / 3.0


def felt_db(amplitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitude in dB of full scale, silent below `FLOOR`."""
    return 20.0 * np.log10(np.maximum(amplitude, FLOOR))


def breakpoints(
    level: NDArray[np.float64],
    budget: int,
    kept: Iterable[int] = (),
) -> NDArray[np.int64]:
    """The positions to join by straight lines, both ends among them.

    Parameters
    ----------
    level : float64 (n,), n >= 2
    budget
        How many positions, 2 or more; those that must be are there even if they are more.
    kept
        Places that must be there.

    Returns
    -------
    int64 (m,), ascending
    """
    last = len(level) - 1
    target = felt_db(level)
    positions = {0, last}
    positions.update(position for position in kept if 0 < position < last)
    queue: list[tuple[float, int, int, int]] = []

    def measure(first: int, end: int) -> None:
        low, high = first + 1, end - 1
        if high < low:
            return
        inside = np.arange(low, high + 1)
        line = level[first] + (level[end] - level[first]) * (inside - first) / (end - first)
        error = np.abs(felt_db(line) - target[low : high + 1])
        worst = int(np.argmax(error))
        if error[worst] >= GOOD_ENOUGH_DB:
            heapq.heappush(queue, (-float(error.sum()), low + worst, first, end))

    ordered = sorted(positions)
    for first, end in itertools.pairwise(ordered):
        measure(first, end)
    while queue and len(positions) < budget:
        _, position, first, end = heapq.heappop(queue)
        positions.add(position)
        measure(first, position)
        measure(position, end)
    return np.array(sorted(positions), dtype=np.int64)


Shape = Callable[[Any, str, list[str]], None]


def number(low: float = -math.inf, high: float = math.inf, above: float = -math.inf) -> Shape:
    """A finite number from `low` to `high`, more than `above`."""

    def check(value: Any, place: str, faults: list[str]) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float):
            faults.append(f"{place} is {shown(value)}; it is a number")
        elif not math.isfinite(value) or not low <= value <= high or value <= above:
            least = f"more than {above:g}" if above > low else f"{low:g}"
            faults.append(f"{place} = {shown(value)}; it is {least} to {high:g}")

    return check


def whole(low: float = -math.inf, high: float = math.inf) -> Shape:
    """A whole number, written as one."""

    def check(value: Any, place: str, faults: list[str]) -> None:
        if isinstance(value, bool) or not isinstance(value, int):
            faults.append(f"{place} is {shown(value)}; it is a whole number")
        elif not low <= value <= high:
            faults.append(f"{place} = {shown(value)}; it is {low:g} to {high:g}")

    return check


def text(pattern: str = "") -> Shape:
    """A text, all of which matches."""

    def check(value: Any, place: str, faults: list[str]) -> None:
        if not isinstance(value, str):
            faults.append(f"{place} is {shown(value)}; it is a text")
        elif pattern and not re.fullmatch(pattern, value):
            faults.append(f"{place} is {shown(value)}; it is like {pattern}")

    return check


def one_of(*allowed: Any) -> Shape:
    """One of some values."""

    def check(value: Any, place: str, faults: list[str]) -> None:
        if isinstance(value, bool | dict | list) or value not in allowed:
            listed = ", ".join(str(one) for one in allowed)
            faults.append(f"{place} is {shown(value)}; it is one of {listed}")

    return check


def flag(value: Any, place: str, faults: list[str]) -> None:
    """True or false."""
    if not isinstance(value, bool):
        faults.append(f"{place} is {shown(value)}; it is true or false")


def many(item: Shape, least: int = 0, most: float = math.inf) -> Shape:
    """A list of so many."""

    def check(value: Any, place: str, faults: list[str]) -> None:
        if not isinstance(value, list):
            faults.append(f"{place} is {shown(value)}; it is a list")
            return
        if not least <= len(value) <= most:
            faults.append(f"{place} has {len(value)} entries; it has {least} to {most:g}")
        for k, one in enumerate(value):
            item(one, f"{place}[{k}]", faults)

    return check


def record(required: Mapping[str, Shape], optional: Mapping[str, Shape] | None = None) -> Shape:
    """An object with these keys and no others."""
    known = {**required, **(optional or {})}

    def check(value: Any, place: str, faults: list[str]) -> None:
        if not isinstance(value, dict):
            faults.append(f"{place or 'the document'} is {shown(value)}; it is an object")
            return
        begin = f"{place}." if place else ""
        faults += [f"{begin}{key} is missing" for key in required if key not in value]
        faults += [
            f"{begin}{shown(key)[1:-1]} is no key of it; those are {', '.join(known)}"
            for key in value
            if key not in known
        ]
        for key, shape in known.items():
            if key in value:
                shape(value[key], f"{begin}{key}", faults)

    return check


def ascending(
    values: Collection[Any], place: str, faults: list[str], strictly: bool = False
) -> None:
    """Say where numbers fall (or stay, if `strictly`)."""
    before: Any = -math.inf
    for k, value in enumerate(values):
        if value < before or (strictly and value == before):
            faults.append(f"{place}[{k}] = {value:g} comes after {before:g}; times ascend")
        before = value
