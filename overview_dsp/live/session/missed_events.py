"""Visit of the events of a live timeline that are new since the last release.

The pointer touches each new event in order of time and rests there, so new events are felt one by
one. A movement of the pointer ends the visit. Another input that touches takes the disk, as during
any touch.
"""

from __future__ import annotations

from collections import deque

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline import Event
from overview_dsp.errors import InputError
from overview_dsp.live.session.active_window import ActiveWindow
from overview_dsp.live.session.pointer import Pointer
from overview_dsp.live.session.session import Session
from overview_dsp.public import counted
from overview_dsp.units import clock_text

REST_S = 1.0
"""Time at each event, s: the disk arrives and rests, so that events are felt one by one."""

BEYOND = 0.012
"""Distance by which the pointer goes beyond an event, 0 to 1, so that the disk passes it."""


class MissedEvents:
    """New events since the last release, and a visit of them.

    Thread: control.
    """

    def __init__(
        self, session: Session, live: LiveTimeline, window: ActiveWindow, pointer: Pointer
    ) -> None:
        self._session, self._live, self._window, self._pointer = session, live, window, pointer
        self._touched = False
        self._since = live.revision  # at the last release
        self._left: deque[Event] = deque()
        self._target: float | None = None  # position of the present event
        self._next_s = 0.0

    def visit(self, since_s: float | None = None) -> None:
        """Visit the new events, or those from a time of the timeline on.

        Raises
        ------
        InputError
            There are none.
        """
        present = set(self._window.timeline.events)
        if since_s is None:
            changes = self._live.changes_since(self._since)
            found = {change.event for change in changes if change.event in present}
        else:
            found = {event for event in present if event.time_s >= since_s}
        if not found:
            since = "the last release" if since_s is None else clock_text(since_s)
            raise InputError(f"no event is new since {since}")
        self._window.show(0.0, self._window.timeline.duration_s)
        self._left = deque(sorted(found, key=lambda event: event.time_s))
        self._target, self._next_s = self._pointer.position, 0.0
        self._session.say(f"visiting {counted(len(found), 'event')} that you missed")

    def poll(self) -> None:
        """Go on with a visit; remember the time of a release."""
        touched = self._session.engine.touched
        if self._touched and not touched and self._target is None:
            self._since = self._live.revision
        self._touched = touched
        if self._target is None or self._session.played_s < self._next_s:
            return
        if self._pointer.position != self._target or (self._next_s and not self._pointer.touching):
            self._target = None  # the person has taken over
        elif self._left:
            event = self._left.popleft()
            self._pointer.release()  # a new touch: the backlash doesn't stop the disk before it
            self._pointer.touch(float(self._window.angle_map.position_of(event.time_s)) + BEYOND)
            self._target, self._next_s = self._pointer.position, self._session.played_s + REST_S
            text = f"{event.kind.replace('_', ' ')} {event.display_label}".strip()
            self._session.say(f"{text} at {clock_text(event.time_s)}")
        else:
            self._target = None
            self._pointer.release()
