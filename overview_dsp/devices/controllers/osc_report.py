"""What OSC says of the disk.

/overview/cursor 0.41                    where it is on the timeline, 0 to 1
/overview/torque 0.0123                  N m, as of the last block
/overview/touching 1
/overview/event goal "1-0 Parris" 5340.0 0.8     one was passed: its kind, label, time (s) in the
                                         timeline shown, and how hard it was struck (0 to 1)
"""

from __future__ import annotations

from collections.abc import Iterable

from overview_dsp.data.timeline.event import Event
from overview_dsp.devices.controllers.osc_messages import encode_message

STILL_EVERY_S = 0.5
"""How often it is said while nothing changes."""


class OscReport:
    """What is new, as datagrams."""

    def __init__(self) -> None:
        """Nothing has been said yet."""
        self._said: tuple[float, float, bool] | None = None
        self._said_at = 0.0

    def due(
        self,
        now_s: float,
        cursor: float,
        torque: float,
        touching: bool,
        struck: Iterable[tuple[Event, float]],
    ) -> list[bytes]:
        """What is to be sent at `now_s` (of any clock); `struck`: events passed, and how hard."""
        sent = [
            encode_message("/overview/event", [event.kind, event.label, event.time_s, level])
            for event, level in struck
        ]
        state = (cursor, torque, touching)
        if state != self._said or now_s - self._said_at >= STILL_EVERY_S:
            self._said, self._said_at = state, now_s
            sent += [
                encode_message("/overview/cursor", [cursor]),
                encode_message("/overview/torque", [torque]),
                encode_message("/overview/touching", [int(touching)]),
            ]
        return sent
