"""Runs of marked samples."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from overview_dsp.arrays import BoolArray

Spans = list[tuple[int, int]]
"""First samples of runs, and the samples after their ends."""


def runs(marked: BoolArray) -> Spans:
    """Return the runs of True values."""
    edges = np.flatnonzero(np.diff(marked.view(np.int8), prepend=0, append=0)).reshape(-1, 2)
    return [(first, end) for first, end in edges.tolist()]


def merged(spans: Iterable[tuple[int, int]], distance: float) -> Spans:
    """Return spans in order; those less than `distance` from each other are one."""
    found: Spans = []
    for first, end in sorted(spans):
        if found and first - found[-1][1] < distance:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((first, end))
    return found


class RunFinder:
    """Finder of the long runs of marked samples in a signal, block by block.

    `lost`: number of marked samples in runs shorter than `shortest`.
    """

    def __init__(self, shortest: float) -> None:
        self.lost = 0
        self._shortest = shortest
        self._found: Spans = []
        self._open: int | None = None
        self._done = 0

    def feed(self, marked: BoolArray, before: int = 0) -> None:
        """Process the next samples; a run begins `before` samples ahead of its first mark."""
        if not marked[0]:
            self._close(self._done)
        for first, end in runs(marked):
            if self._open is None:
                self._open = self._done + first - before
            if end < len(marked):
                self._close(self._done + end)
        self._done += len(marked)

    def finish(self) -> Spans:
        """Return the long runs."""
        self._close(self._done)
        return self._found

    def _close(self, end: int) -> None:
        first, self._open = self._open, None
        if first is None:
            return
        if end - first >= self._shortest:
            self._found.append((first, end))
        else:
            self.lost += end - first
