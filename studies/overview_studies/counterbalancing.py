"""Orders of conditions and trials, balanced over the lists or shuffled in blocks.

The random draws use SHA-256, so they are the same on every machine and with every library version.
A generator of numpy may change its draws, but a preregistered list must not change.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from itertools import permutations
from typing import TypeVar

T = TypeVar("T")

_BITS = 64

MAX_FULL_CONDITIONS = 5
"""Maximum number of conditions with all orders: 120 lists."""


class RandomStream:
    """Reproducible random draws from SHA-256 of a seed and a counter."""

    def __init__(self, *seed: int | str) -> None:
        """Start an independent stream for `seed`, such as (7, "list", 3)."""
        self._seed = "\x1f".join(map(str, seed)).encode()
        self._count = 0

    def below(self, n: int) -> int:
        """Return a uniform integer from 0 to `n` - 1."""
        limit = (1 << _BITS) // n * n
        while True:
            self._count += 1
            digest = hashlib.sha256(self._seed + b"\x1f%d" % self._count).digest()
            drawn = int.from_bytes(digest[: _BITS // 8], "big")
            if drawn < limit:
                return drawn % n

    def uniform(self, low: float, high: float) -> float:
        """Return a number from `low` to below `high`."""
        return low + (high - low) * (self.below(1 << 53) / (1 << 53))

    def shuffled(self, items: Sequence[T]) -> list[T]:
        """Return the items in a random order (Fisher and Yates)."""
        found = list(items)
        for i in range(len(found) - 1, 0, -1):
            j = self.below(i + 1)
            found[i], found[j] = found[j], found[i]
        return found


def williams_rows(n: int) -> list[tuple[int, ...]]:
    """Return a Williams square of `n` conditions: `n` rows, or twice as many if `n` is odd.

    Every condition is equally often at every position and after every other condition.
    """
    first = [0]
    for step in range(1, n):
        first.append((first[-1] + (step if step % 2 else -step)) % n)
    rows = [tuple((position + row) % n for position in first) for row in range(n)]
    if n % 2:
        rows += [row[::-1] for row in rows]
    return rows


def full_rows(n: int) -> list[tuple[int, ...]]:
    """Return every order of `n` conditions."""
    return list(permutations(range(n)))


def rows_of(order: str, n: int) -> list[tuple[int, ...]]:
    """Return the rows that lists use in turn; a single condition has one row."""
    if n == 1:
        return [(0,)]
    return williams_rows(n) if order == "williams" else full_rows(n)


def shuffled_blocks(cells: Sequence[T], repeats: int, stream: RandomStream) -> list[list[T]]:
    """Return shuffled blocks with every cell once.

    The last cell of a block never equals the first cell of the next one.
    """
    blocks: list[list[T]] = []
    for _ in range(repeats):
        block = stream.shuffled(cells)
        if blocks and len(block) > 1 and block[0] == blocks[-1][-1]:
            other = 1 + stream.below(len(block) - 1)
            block[0], block[other] = block[other], block[0]
        blocks.append(block)
    return blocks
