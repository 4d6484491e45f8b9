"""What a feed may say: events, times, samples, lengths and maps that are allowed."""

from __future__ import annotations

from typing import Literal

import numpy as np

from overview_dsp import validation
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.samples import MAX_VALUE
from overview_dsp.errors import InputError, shown

Map = Literal["whole", "so far"]

MAPS: tuple[Map, ...] = ("whole", "so far")

LONGEST_S = 100 * 366 * 86_400.0
"""A time beyond this is no moment of a feed but a broken clock."""


def checked_event(value: object, where: str) -> Event:
    """An event at a time that is allowed; `where` is what holds it."""
    if not isinstance(value, Event):
        raise InputError(f"{where} holds {shown(value)}; give Event")
    checked_time(value.time_s, "time_s")
    return value


def checked_time(value: object, what: str) -> float:
    """Seconds from the start."""
    hint = f"times are seconds from the start, 0 to {LONGEST_S:g}"
    time_s = validation.number(value, what, hint)
    if not 0.0 <= time_s <= LONGEST_S:
        raise InputError(f"{what} is {time_s!r}; {hint}")
    return time_s


def checked_sample(value: object) -> tuple[float, float]:
    """A sample's time, s, and its value."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise InputError(f"a sample is {shown(value)}; give a time in s and a value")
    hint = f"it is finite, up to {MAX_VALUE:g}"
    level = validation.number(value[1], "a sample's value", hint)
    if abs(level) > MAX_VALUE:
        raise InputError(f"a sample's value is {level!r}; {hint}")
    return checked_time(value[0], "a sample's time"), level


def checked_length(value: object, name: str, rule: str) -> float:
    """Seconds that a feed may last; `name` is the parameter's, `rule` what it has to be."""
    hint = f"{rule} above 0, up to {LONGEST_S:g}"
    length_s = validation.positive(value, name, hint)
    if length_s > LONGEST_S:
        raise InputError(f"{name} is {length_s!r}; {hint}")
    return length_s


def checked_expectation(value: object) -> float | None:
    """How long a feed is expected to last, s, or None."""
    if value is None:
        return None
    return checked_length(value, "expect_s", "the expected length is seconds,")


def checked_map(value: Map) -> Map:
    """How a timeline that grows is laid under the hand."""
    if value not in MAPS:
        raise InputError(f"map is {shown(value)}; it is one of {', '.join(MAPS)}")
    return value
