"""Decoder of the JSON messages on `/control`, one object per message.

Messages from the page::

    {"events": [[time_ms, theta2, touching], ...]}   1 to 64, in order: the page's clock
                                                     (`performance.now()`), rad 0 to pi, 0 or 1
    {"pong": host_s, "time_ms": time_ms}             the reply to a ping
    {"show": [start_s, end_s]}                       the window to show
    {"name": "Anna's phone"}                         the input's name; up to 40 characters
    {"mark": ""}                                     set a mark at the disk, with a name

Messages from the host::

    {"ping": host_s}
    {"status": {...}}     see `control`
    {"released": "..."}   reason of a release by the host
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
"""Events per message."""

MAX_NAME = 40
"""Characters of an input's name."""

MAX_TIME_MS = 1e12
"""Upper limit of a page's clock (31 years)."""


@dataclass(frozen=True)
class RemoteEvent:
    """Control event at `time_s` of the page's clock; theta2 in rad, 0 to pi."""

    time_s: float
    theta2: float
    touching: bool


@dataclass(frozen=True)
class Events:
    """Control events in order of time."""

    events: tuple[RemoteEvent, ...]


@dataclass(frozen=True)
class Pong:
    """Times of a ping (s of the host's clock) and of its reply (s of the page's clock)."""

    host_s: float
    page_s: float


@dataclass(frozen=True)
class Show:
    """Request to show a window of the timeline."""

    start_s: float
    end_s: float


@dataclass(frozen=True)
class Name:
    """Name of the input, as other pages show it."""

    name: str


@dataclass(frozen=True)
class Mark:
    """Request to set a mark at the disk's position."""

    name: str


def decode_message(text: str) -> Events | Pong | Show | Name | Mark:
    """Decode a message of a page; raise InputError if it is invalid."""
    fields = json_object(text, "a message")
    keys = fields.keys()
    if keys == {"events"}:
        return _events(fields["events"])
    if keys == {"pong", "time_ms"}:
        return Pong(
            _number(fields["pong"], "pong", 0.0, MAX_TIME_MS),
            _number(fields["time_ms"], "time_ms", 0.0, MAX_TIME_MS) * 1e-3,
        )
    if keys == {"show"}:
        start, end = _list(fields["show"], "show", 2)
        return Show(
            _number(start, "show[0]", 0.0, math.inf), _number(end, "show[1]", 0.0, math.inf)
        )
    if keys == {"name"}:
        return Name(_name(fields, "name"))
    if keys == {"mark"}:
        return Mark(_name(fields, "mark"))
    raise InputError("message keys must be events, pong and time_ms, show, name, or mark")


def _name(fields: dict[str, Any], key: str) -> str:
    value = fields[key]
    if not isinstance(value, str) or len(value) > MAX_NAME or not value.isprintable():
        raise InputError(f"{key} must be one line of up to {MAX_NAME} characters")
    return value


def _events(value: Any) -> Events:
    if not isinstance(value, list) or not 1 <= len(value) <= MAX_EVENTS:
        raise InputError(f"events must be a list of 1 to {MAX_EVENTS}")
    events = []
    for i, row in enumerate(value):
        time_ms, theta2, touching = _list(row, f"events[{i}]", 3)
        if touching not in (0, 1) or not isinstance(touching, int):
            raise InputError(f"events[{i}][2] is {touching!r:.20}; must be 0 or 1")
        events.append(
            RemoteEvent(
                _number(time_ms, f"events[{i}][0]", 0.0, MAX_TIME_MS) * 1e-3,
                _number(theta2, f"events[{i}][1]", 0.0, math.pi),
                bool(touching),
            )
        )
    if any(b.time_s < a.time_s for a, b in itertools.pairwise(events)):
        raise InputError("events must be in order of time")
    return Events(tuple(events))


def _list(value: Any, key: str, length: int) -> list[Any]:
    if not isinstance(value, list) or len(value) != length:
        raise InputError(f"{key} must be a list of {length} numbers")
    return value


def _number(value: Any, key: str, low: float, high: float) -> float:
    return validation.within(validation.number(value, key), key, low, high)


def json_object(text: bytes | str, name: str = "the body") -> dict[str, Any]:
    """Parse a JSON object; errors call the text `name`."""

    def reject(constant: str) -> NoReturn:
        raise InputError(f"{constant} is not valid JSON")

    try:
        plain = text.decode() if isinstance(text, bytes) else text
        fields = json.loads(plain, parse_constant=reject)
    except InputError:
        raise
    except (ValueError, RecursionError):
        fields = None
    if not isinstance(fields, dict):
        raise InputError(f"{name} must be a JSON object")
    return fields
