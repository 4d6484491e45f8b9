"""The pattern that tells of something new: the event itself, met and met again within a moment.

It is a timeline of its own with nothing but that event on it, which the disk is sent over by a
short tap: so it is felt and heard by the same disk, torque and preset as the event on the timeline.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from overview_dsp.data.feeds.feed_lines import event_of
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

PLACE = 0.04
"""Where the event is, 0 to 1 of the surface ..."""

TAP = 0.08
"""... and how far the disk is sent: half of it to be in motion, half to be past the event."""

HOLDS_S = 0.25
"""How long the tap holds, s: the disk is beyond the event by then under every bundled preset."""

LASTS_S = 0.8
"""After so long, from the tap on, the timeline is under the disk again, s."""


def pattern_change(event: Event) -> dict[str, Any]:
    """Return what a recording holds of an event's pattern."""
    return {"pattern": {"kind": event.kind, "weight": event.weight}}


def pattern_of(what: Mapping[str, Any]) -> Timeline:
    """Return the timeline of the pattern of an event's kind and weight; InputError."""
    if not isinstance(what, Mapping) or what.keys() != {"kind", "weight"}:
        raise InputError("a pattern has a kind and a weight")
    event = event_of({"time_s": PLACE, **what})
    return Timeline("something is new", 1.0, (event,))
