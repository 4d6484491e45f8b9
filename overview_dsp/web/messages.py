"""What pages send as JSON, checked: what comes over `/control`, a JSON object a message.

From the page::

    {"events": [[time_ms, theta2, touching], ...]}   1 to 64, in order: the page's clock
                                                     (`performance.now()`), rad 0 to pi, 0 or 1
    {"pong": host_s, "time_ms": time_ms}             the answer to a ping, at once
    {"show": [start_s, end_s]}                       the part of the timeline to put under the hand
    {"name": "Anna's phone"}                         whose hand it is, for the others; up to 40

From the host::

    {"ping": host_s}
    {"status": {...}}     see `control`
    {"released": "..."}   the disk was let go, and why
"""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import dataclass
from typing import Any, NoReturn

from overview_dsp import validation
from overview_dsp.errors import InputError

MAX_MESSAGE_BYTES = 8192
MAX_EVENTS = 64
"""Events of a message."""

MAX_NAME = 40
"""Characters of a hand's name."""

MAX_TIME_MS = 1e12
"""No page has been open for thirty years."""


@dataclass(frozen=True)
class RemoteEvent:
    """A hand's event at `time_s` of the page's clock; theta2 rad, 0 to pi."""

    time_s: float
    theta2: float
    touching: bool


@dataclass(frozen=True)
class Events:
    """What a hand did, in order."""

    events: tuple[RemoteEvent, ...]


@dataclass(frozen=True)
class Pong:
    """When a ping left here (s of our clock) and was answered (s of the page's)."""

    host_s: float
    page_s: float


@dataclass(frozen=True)
class Show:
    """A part of the timeline to put under the hand."""

    start_s: float
    end_s: float


@dataclass(frozen=True)
class Name:
    """Whose hand it is."""

    name: str


def decode_message(text: str) -> Events | Pong | Show | Name:
    """A message of a page; InputError, in a line, for anything else."""
    found = json_object(text, "a message")
    keys = found.keys()
    if keys == {"events"}:
        return _events(found["events"])
    if keys == {"pong", "time_ms"}:
        return Pong(
            _number(found["pong"], "pong", 0.0, MAX_TIME_MS),
            _number(found["time_ms"], "time_ms", 0.0, MAX_TIME_MS) * 1e-3,
        )
    if keys == {"show"}:
        start, end = _row(found["show"], "show", 2)
        return Show(
            _number(start, "show[0]", 0.0, math.inf), _number(end, "show[1]", 0.0, math.inf)
        )
    if keys == {"name"}:
        return Name(_name(found["name"]))
    raise InputError("a message has the keys events, pong and time_ms, show, or name")


def _name(given: Any) -> str:
    if not isinstance(given, str) or len(given) > MAX_NAME or not given.isprintable():
        raise InputError(f"name is a text of up to {MAX_NAME} characters, on one line")
    return given


def _events(given: Any) -> Events:
    if not isinstance(given, list) or not 1 <= len(given) <= MAX_EVENTS:
        raise InputError(f"events is a list of 1 to {MAX_EVENTS}")
    events = []
    for i, row in enumerate(given):
        time_ms, theta2, touching = _row(row, f"events[{i}]", 3)
        if touching not in (0, 1) or not isinstance(touching, int):
            raise InputError(f"events[{i}][2] is 0 or 1")
        events.append(
            RemoteEvent(
                _number(time_ms, f"events[{i}][0]", 0.0, MAX_TIME_MS) * 1e-3,
                _number(theta2, f"events[{i}][1]", 0.0, math.pi),
                bool(touching),
            )
        )
    if any(b.time_s < a.time_s for a, b in itertools.pairwise(events)):
        raise InputError("events are in order of time")
    return Events(tuple(events))


def _row(given: Any, where: str, length: int) -> list[Any]:
    if not isinstance(given, list) or len(given) != length:
        raise InputError(f"{where} is a list of {length} numbers")
    return given


def _number(given: Any, where: str, low: float, high: float) -> float:
    value = validation.number(given, where)
    if not low <= value <= high:
        raise InputError(f"{where} is out of range; it is finite, {low:g} to {high:g}")
    return value


def json_object(text: bytes | str, what: str = "the body") -> dict[str, Any]:
    """Return the JSON object of a body, or of another text that errors call `what`."""

    def refuse(name: str) -> NoReturn:
        raise InputError(f"{name} is no number of JSON's")

    try:
        plain = text.decode() if isinstance(text, bytes) else text
        found = json.loads(plain, parse_constant=refuse)
    except InputError:
        raise
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError(f"{what} is a JSON object")
    return found
