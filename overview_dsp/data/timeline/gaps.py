"""Gaps: the spans of a timeline without data."""

from __future__ import annotations

import itertools

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray
from overview_dsp.errors import InputError, quoted

Gaps = tuple[tuple[float, float], ...]
"""Spans (start_s, end_s), sorted, not overlapping."""


def sorted_gaps(gaps: object, duration_s: float) -> Gaps:
    """Return gaps sorted by start; InputError unless they are pairs 0 <= start < end <= duration_s.

    Two gaps may not overlap.
    """
    hint = "a gap is (start_s, end_s) with 0 <= start < end <= duration"
    if not isinstance(gaps, tuple | list):
        raise InputError(f"gaps is {quoted(gaps)}, not a list; {hint}")
    pairs: list[tuple[float, float]] = []
    for i, gap in enumerate(gaps):
        if not isinstance(gap, tuple | list) or len(gap) != 2:
            raise InputError(f"gaps[{i}] is {quoted(gap)}, not a pair; {hint}")
        start, end = (
            validation.number(edge, f"gaps[{i}][{j}]", hint) for j, edge in enumerate(gap)
        )
        if not 0.0 <= start < end <= duration_s:
            raise InputError(
                f"gaps[{i}] reaches from {start!r} to {end!r} s in a timeline of {duration_s!r} s; "
                f"{hint}"
            )
        pairs.append((start, end))
    pairs.sort()
    for before, after in itertools.pairwise(pairs):
        if after[0] < before[1]:
            raise InputError(
                f"the gaps {before} and {after} overlap; merge them into "
                f"({before[0]!r}, {max(before[1], after[1])!r})"
            )
    return tuple(pairs)


def sorted_reasons(reasons: object, gaps: object) -> tuple[str, ...]:
    """Return the reasons of gaps in the order of the sorted gaps, empty if none is known.

    `reasons` has a text for each of the `gaps`, which are in their original order, or is empty;
    else InputError.
    """
    hint = 'give one text per gap, "" if it is unknown'
    if not isinstance(reasons, tuple | list):
        raise InputError(f"gap_reasons is {quoted(reasons)}, not a list; {hint}")
    texts = [validation.text(reason, f"gap_reasons[{i}]") for i, reason in enumerate(reasons)]
    if not any(texts):
        return ()
    starts = [gap[0] for gap in gaps] if isinstance(gaps, tuple | list) else []
    if len(texts) != len(starts):
        raise InputError(f"there are {len(texts)} gap_reasons for {len(starts)} gaps; {hint}")
    return tuple(text for _, text in sorted(zip(starts, texts, strict=True), key=lambda p: p[0]))


def in_gap(gaps: Gaps, at: FloatArray) -> BoolArray:
    """Return which of the times `at`, shape (n,), lie inside a gap, its two ends excluded."""
    if not gaps:
        return np.zeros(at.shape, dtype=np.bool_)
    starts, ends = np.array(gaps, dtype=np.float64).T
    # only the last gap that starts before a time can contain it
    index = np.searchsorted(starts, at, side="left") - 1
    return np.asarray((index >= 0) & (at < ends[index]), dtype=np.bool_)


def cut_gaps(
    gaps: Gaps, reasons: tuple[str, ...], start: float, end: float
) -> tuple[Gaps, tuple[str, ...]]:
    """Return gaps and reasons from `start` to `end`, on a time axis that begins at `start`."""
    kept: list[tuple[float, float]] = []
    why: list[str] = []
    for i, (low, high) in enumerate(gaps):
        part = (max(low, start) - start, min(high, end) - start)
        # rounding may make a gap empty
        if low < end and high > start and part[0] < part[1]:
            kept.append(part)
            why.append(reasons[i] if reasons else "")
    return tuple(kept), tuple(why) if any(why) else ()
