"""Chance that is the same on every machine and with every version of every library.

numpy may change what its generators draw; a list that was preregistered may not change.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")

_BITS = 64


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
