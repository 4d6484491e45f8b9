"""Whatever comes over the WebSocket is a checked message or one clear line."""

from __future__ import annotations

import contextlib
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.errors import InputError
from overview_dsp.web.messages import (
    MAX_EVENTS,
    MAX_NAME,
    MAX_TIME_MS,
    Events,
    Mark,
    Pong,
    RemoteEvent,
    Show,
    decode_message,
)

numbers = st.floats() | st.integers() | st.booleans() | st.none() | st.text(max_size=4)
values = st.recursive(
    numbers,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["events", "pong", "time_ms", "show", "mark", "x"]), inner, max_size=3
        )
    ),
    max_leaves=12,
)
events = st.lists(
    st.tuples(
        st.floats(0.0, MAX_TIME_MS), st.floats(0.0, math.pi), st.sampled_from([0, 1, True, False])
    ),
    min_size=1,
    max_size=MAX_EVENTS,
)


def is_sound(message):
    """Whether what was decoded is within what the hands take."""
    if isinstance(message, Events):
        times = [one.time_s for one in message.events]
        return (
            1 <= len(times) <= MAX_EVENTS
            and times == sorted(times)
            and all(
                math.isfinite(one.time_s)
                and 0.0 <= one.theta2 <= math.pi
                and isinstance(one.touching, bool)
                for one in message.events
            )
        )
    if isinstance(message, Pong):
        return math.isfinite(message.host_s) and math.isfinite(message.page_s)
    if isinstance(message, Mark):
        return len(message.name) <= MAX_NAME and message.name.isprintable()
    return isinstance(message, Show) and math.isfinite(message.start_s + message.end_s)


@given(st.text(max_size=200) | values.map(json.dumps))
def test_any_text_is_a_sound_message_or_a_one_line_error(text):
    message = None
    with contextlib.suppress(InputError):
        message = decode_message(text)
    assert message is None or is_sound(message)


@given(events)
def test_events_come_through_to_the_bit(rows):
    rows.sort(key=lambda row: row[0])
    message = decode_message(json.dumps({"events": rows}))
    assert isinstance(message, Events)
    assert message.events == tuple(
        RemoteEvent(time * 1e-3, theta2, bool(touching)) for time, theta2, touching in rows
    )


def test_pong_and_show_messages_are_decoded():
    assert decode_message('{"pong": 1.5, "time_ms": 2000}') == Pong(1.5, 2.0)
    assert decode_message('{"show": [1, 2]}') == Show(1.0, 2.0)


def test_nesting_and_long_numbers_give_a_one_line_error():
    for text in (
        "[" * 100_000,
        '{"show": [0, ' + "9" * 5000 + "]}",
        '{"pong": 1e400, "time_ms": 1}',
    ):
        with pytest.raises(InputError):
            decode_message(text)
