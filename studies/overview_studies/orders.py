"""In which order the conditions come: balanced over the lists, or shuffled in blocks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from typing import TypeVar

from overview_studies.seeded import Seeded

T = TypeVar("T")

MOST_FULL = 5
"""Conditions of which every order is used: 120 lists."""


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
