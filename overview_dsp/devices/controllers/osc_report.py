"""OSC messages about the disk.

/overview/cursor 0.41                    position on the timeline, 0 to 1
/overview/torque 0.0123                  N m, of the last block
/overview/touching 1
/overview/state running "by osc" ""      the session's state, its reason, and the last stop
/overview/event goal "1-0 Parris" 5340.0 0.8     a passed event: its kind, label, time (s) in the
                                         visible window, and the level of its strike (0 to 1)
"""

from __future__ import annotations

from collections.abc import Iterable

from overview_dsp.data.timeline.event import Event
from overview_dsp.devices.controllers.osc_messages import encode_message

REPEAT_S = 0.5  # time between messages without a change


class OscReport:
    """Sends changes of the disk as OSC datagrams."""

    def __init__(self) -> None:
        self._sent: tuple[object, ...] | None = None
        self._sent_at = 0.0

    def messages(
        self,
        now_s: float,
        cursor: float,
        torque: float,
        touching: bool,
        passed_events: Iterable[tuple[Event, float]],
        session_state: tuple[str, ...] = (),
    ) -> list[bytes]:
        """Return the datagrams to send at `now_s` (of any clock).

        `passed_events` are the events passed since the last call, each with its level.
        `session_state` has name, reason and last stop.
        """
        datagrams = [
            encode_message("/overview/event", [event.kind, event.label, event.time_s, level])
            for event, level in passed_events
        ]
        state = (cursor, torque, touching, session_state)
        if state != self._sent or now_s - self._sent_at >= REPEAT_S:
            self._sent, self._sent_at = state, now_s
            datagrams += [
                encode_message("/overview/cursor", [cursor]),
                encode_message("/overview/torque", [torque]),
                encode_message("/overview/touching", [int(touching)]),
            ]
            if session_state:
                datagrams.append(encode_message("/overview/state", [*session_state]))
        return datagrams
