"""Updates of a session's live timeline, and announcements of its new events.

During a touch the positions of all events stay. New data wait until the release, or for a chosen
time. In the layout `whole`, data ahead of disk and input are updated at once, because no position
changes. A new event that is strong enough, or one that is withdrawn, is announced by a haptic
pattern while nothing touches the disk.

During a visit of the new events since the last release, the pointer touches each of them in order
of time and rests there, so new events are felt one by one. A movement of the pointer ends the
visit. Another input that touches takes the disk, as during any touch.
"""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass

from overview_dsp.data.feeds.follower import Follower
from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.feeds.timeline_diff import (
    ANNOUNCEMENT_S,
    TAP_HOLD_S,
    TAP_POSITION,
    announcement_change,
)
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.presets.model import DEFAULT_KIND, Preset
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.inputs.feeds import parse_layout
from overview_dsp.live.session.active_window import ActiveWindow
from overview_dsp.live.session.marks import Marks
from overview_dsp.live.session.session import Pointer, Session
from overview_dsp.public import counted
from overview_dsp.signal.engine.replay import set_pattern
from overview_dsp.units import HALF_TURN, clock_text

UPDATE_EVERY_S = 0.05
"""Shortest time between two surfaces. New data are felt within 0.1 s."""

MARGIN = 0.05
"""Distance from the disk and its input beyond which data may change during a touch (0 to 1)."""

MAX_AGE_S = 180.0
"""Greatest age of an event, on the feed's clock, at which it is announced."""

LAYOUT_KEY = "follow.layout"

DISCREET = "in company"
"""Use of presets that announce nothing unless the user asks for it."""


@dataclass(frozen=True)
class FollowSettings:
    """Settings by which a session follows a live timeline."""

    live: LiveTimeline
    follower: Follower | None = None  # reader of its feed; None: the program adds the data itself
    after_s: float | None = None  # of a touch, until new data are applied; None: at the release
    # Event kind: events of at least its strength are announced; "none" announces none. None
    # announces own goals and stronger events, and nothing with a discreet preset.
    announce: str | None = None
    layout_is_explicit: bool = False  # chosen by the user; otherwise the preset may choose it
    preset: str | None = None  # suggested, where it is known before any data arrive

    def use_preset_layout(self, preset: Preset) -> None:
        """Use the preset's layout unless the user chose one."""
        layout = str(preset.values[LAYOUT_KEY])
        if layout != "auto" and not self.layout_is_explicit:
            self.live.layout = parse_layout(layout)


class LiveUpdates:
    """Updates a session's window from its live timeline, and announces new events.

    Thread: control.

    `live`: live timeline that is followed.
    `announced`: latest announced events, up to 100, the newest last.
    """

    def __init__(
        self, session: Session, follow: FollowSettings, window: ActiveWindow, marks: Marks
    ) -> None:
        self._engine, self._say, self._window = session.engine, session.say, window
        self._marks = marks
        self._follow, self.live = follow, follow.live
        self._seen = follow.live.revision
        self._touched_since: float | None = None
        self._next_update = 0.0
        self._next_event: Event | None = None
        self._next_is_withdrawn = False
        self._announcement: tuple[float, bool] | None = None  # its start; whether its tap touches
        self._must_update = False
        self._failed: tuple[Timeline, float] | None = None  # data and position of an update
        self._preset_layout = self._engine.preset.values[LAYOUT_KEY]
        self.announced: list[Event] = []

    @property
    def status_text(self) -> str:
        """Status for display: the time up to which there are data."""
        follower = self._follow.follower
        if follower is None:
            return f"data until {clock_text(self.live.now_s)}"
        return follower.status_text

    def poll(self, pointer_touches: bool) -> None:
        """Apply new data and announce new events as far as the present touch allows it."""
        now = time.monotonic()
        if self._follow.follower is not None:
            for line in self._follow.follower.take_messages():
                self._say(line)
        layout = self._engine.preset.values[LAYOUT_KEY]
        if layout != self._preset_layout:
            self._preset_layout = layout
            self._follow.use_preset_layout(self._engine.preset)
        self._read_changes()
        touched = pointer_touches or self._is_touched()
        self._touched_since = None if not touched else self._touched_since or now
        if self._announcement is not None:
            self._continue_announcement(now, pointer_touches, touched)
            return
        if now < self._next_update:
            return
        after_s = math.inf if self._follow.after_s is None else self._follow.after_s
        snapshot = self._marks.on(self.live.padded_snapshot())
        if self._touched_since is not None and now - self._touched_since < after_s:
            self._update_future(snapshot, now)
            return
        if snapshot is not self._window.timeline or self._must_update:
            if not self._window.update_timeline(snapshot, only_untouched=not touched):
                return  # two surfaces are being crossfaded, or a touch has begun
            self._must_update = touched  # the angle map was kept for the touch
            self._next_update = now + UPDATE_EVERY_S
            self._touched_since = now if touched else None
        if self._next_event is not None and not touched:
            self._announce(self._next_event, now)

    def _update_future(self, snapshot: Timeline, now: float) -> None:
        """Apply only the data that are ahead of the disk and of its input."""
        window, holder = self._window, self._engine.active_input
        is_new = self.live.layout == "whole" and snapshot is not window.timeline
        if not is_new or holder is None or window.timeline.known_until_s is None:
            return
        position = max(self._engine.meters.cursor, holder[1] / HALF_TURN) + MARGIN
        known = window.timeline.known_until_s / window.timeline.duration_s
        failed = self._failed
        tried = failed is not None and failed[0] is snapshot and position >= failed[1] - MARGIN
        if tried or position >= known + MARGIN:
            return
        if window.update_future(snapshot, position):
            self._must_update = True  # all of the data follow at the release
            self._next_update = now + UPDATE_EVERY_S
        else:
            self._failed = (snapshot, position)

    def _is_touched(self) -> bool:
        """Return whether an input other than the announcement's tap moves the disk."""
        engine, holder = self._engine, self._engine.active_input
        if self._announcement is not None:
            tap = ("touch", TAP_POSITION * HALF_TURN) if self._announcement[1] else None
            return holder not in (None, tap)
        # after a release the disk still moves to its last input
        arrives = engine.meters.engaged and engine.preset.values["disk.release"] == "recoil"
        return engine.touched or arrives

    def end_announcement(self) -> None:
        """Forget the present announcement: the engine was restarted."""
        self._announcement = None

    # --- new events -----------------------------------------------------------------------------

    def _read_changes(self) -> None:
        changes = self.live.changes_since(self._seen)
        if not changes:
            return
        self._seen = changes[-1].revision
        preset, announce = self._engine.preset, self._follow.announce
        least = self._least_strength(preset)
        # whether new events are shown as text, but not announced
        silent = announce == "none" or (announce is None and DISCREET in preset.tags.usage)
        added = {change.event.kind for change in changes if change.action == "added"}
        for change in changes:
            event = change.event
            strength = _strength(preset, event)
            if strength < least:
                continue
            text = f"{event.kind.replace('_', ' ')} {event.display_label}".strip()
            at = clock_text(event.time_s)
            if change.action == "retracted":
                self._say(f"retracted: {text} at {at}")
                if self._next_event == event:
                    self._next_event = None
                elif not silent and event.kind not in added:  # otherwise it is a correction
                    self._next_event, self._next_is_withdrawn = event, True
                continue
            self._say(f"new: {text} at {at}")
            recent = event.time_s >= self.live.now_s - MAX_AGE_S
            stronger = self._next_event is None or strength >= _strength(preset, self._next_event)
            if recent and stronger and not silent:
                self._next_event, self._next_is_withdrawn = event, False

    def _least_strength(self, preset: Preset) -> float:
        """Return the strength from which on an event is reported and announced."""
        kind = preset.kinds.get(self._follow.announce or "own_goal")
        if kind is not None:
            return kind.height
        named = [one.height for name, one in preset.kinds.items() if name != DEFAULT_KIND]
        return max(named or [preset.kinds[DEFAULT_KIND].height])

    # --- announcements --------------------------------------------------------------------------

    def _announce(self, event: Event, now: float) -> None:
        """Set the event's pattern as the surface and tap it."""
        self._next_event = None
        try:
            set_pattern(self._engine, announcement_change(event, self._next_is_withdrawn))
        except InputError:
            return
        except OverviewError:  # two surfaces are being crossfaded: try again at the next poll
            self._next_event = event
            return
        self._engine.control(TAP_POSITION * HALF_TURN, True)
        self._announcement = (now, True)
        if not self._next_is_withdrawn:
            self.announced = [*self.announced[-99:], event]

    def _continue_announcement(self, now: float, pointer_touches: bool, touched: bool) -> None:
        """Release the tap and restore the timeline when it is time; at once during a touch."""
        assert self._announcement is not None
        start, taps = self._announcement
        if taps and (touched or now >= start + TAP_HOLD_S):
            if not pointer_touches:  # a touch of the pointer has replaced the tap
                self._engine.control(TAP_POSITION * HALF_TURN, False)
            self._announcement = (start, False)
        if touched or now >= start + ANNOUNCEMENT_S:
            self._announcement = None
            self._must_update = not self._window.update_timeline(
                self._marks.on(self.live.padded_snapshot())
            )


def _strength(preset: Preset, event: Event) -> float:
    kind = preset.kinds[preset.kind_for(event.kind) or DEFAULT_KIND]
    return kind.height * event.weight


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

        InputError: there are none.
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
            self._target = None  # the user has taken over
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
