"""Orders of the conditions: balanced over the lists, or shuffled in blocks.

They are shuffled by draws that are the same on every machine and with every version of every
library: numpy may change what its generators draw, a list that was preregistered may not change.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from itertools import permutations
from typing import TypeVar

T = TypeVar("T")

_BITS = 64

MOST_FULL = 5
"""Conditions of which every order is used: 120 lists."""


class Seeded:
    """Draws from SHA-256 of its seed and a count."""

    def __init__(self, *seed: int | str) -> None:
        """Each `seed` is a sequence of its own: (7, "list", 3)."""
        self._seed = "\x1f".join(map(str, seed)).encode()
        self._count = 0

    def below(self, n: int) -> int:
        """A whole number from 0 to `n` - 1, each as likely."""
        most = (1 << _BITS) // n * n
        while True:
            self._count += 1
            digest = hashlib.sha256(self._seed + b"\x1f%d" % self._count).digest()
            drawn = int.from_bytes(digest[: _BITS // 8], "big")
            if drawn < most:
                return drawn % n

    def uniform(self, low: float, high: float) -> float:
        """A number from `low` to below `high`."""
        return low + (high - low) * (self.below(1 << 53) / (1 << 53))

    def shuffled(self, items: Sequence[T]) -> list[T]:
        """The items in an order, each as likely (Fisher and Yates)."""
        found = list(items)
        for i in range(len(found) - 1, 0, -1):
            j = self.below(i + 1)
            found[i], found[j] = found[j], found[i]
        return found


def williams_rows(n: int) -> list[tuple[int, ...]]:
    """A Williams square of `n` conditions: every condition as often at every place, and after
    every other one as often.

    `n` rows; twice as many where `n` is odd.
    """
    first = [0]
    for step in range(1, n):
        first.append((first[-1] + (step if step % 2 else -step)) % n)
    rows = [tuple((place + row) % n for place in first) for row in range(n)]
    if n % 2:
        rows += [row[::-1] for row in rows]
    return rows


def full_rows(n: int) -> list[tuple[int, ...]]:
    """Every order of `n` conditions."""
    return list(permutations(range(n)))


def rows_of(order: str, n: int) -> list[tuple[int, ...]]:
    """The rows that lists take in turn; one condition has one."""
    if n == 1:
        return [(0,)]
    return williams_rows(n) if order == "williams" else full_rows(n)


def shuffled_blocks(cells: Sequence[T], repeats: int, chance: Seeded) -> list[list[T]]:
    """Blocks of every cell once, shuffled; none comes twice in a row across their borders."""
    blocks: list[list[T]] = []
    for _ in range(repeats):
        block = chance.shuffled(cells)
        if blocks and len(block) > 1 and block[0] == blocks[-1][-1]:
            other = 1 + chance.below(len(block) - 1)
            block[0], block[other] = block[other], block[0]
        blocks.append(block)
    return blocks
