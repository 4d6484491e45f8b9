"""Marks of the user: events of the kind `mark` that are set during a session.

They are felt as the preset's kind `mark`, or as its kind `default` without one, and never move
other events (`angle_map`). A take has them as changes of the timeline. A file keeps them for later
sessions.

Thread: control.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from overview_dsp.data.feeds.feed_lines import event_object, event_of
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.event import MARK
from overview_dsp.data.timeline.model import with_marks
from overview_dsp.errors import InputError
from overview_dsp.files.json_table import read_table, write_table
from overview_dsp.live.session.active_window import ActiveWindow
from overview_dsp.live.session.session import Session
from overview_dsp.units import clock_text
from overview_dsp.validation import prefix_errors


@dataclass(frozen=True)
class MarksFile:
    """File of marks, and the time in it at which the session's timeline starts, s."""

    path: Path
    start_s: float = 0.0


class Marks:
    """Marks of a session.

    `events`: marks in the order in which they were set.

    InputError: the file is damaged.
    """

    def __init__(self, session: Session, window: ActiveWindow, file: MarksFile | None) -> None:
        self._session, self._window, self._file = session, window, file
        self.events: list[Event] = []
        self._others: list[Event] = []  # before the start of the session's timeline
        for event in () if file is None else _read(file.path):
            time_s = event.time_s - (0.0 if file is None else file.start_s)
            if time_s >= 0.0:
                self.events.append(event.moved(time_s))
            else:
                self._others.append(event)
        self._plain = window.timeline
        self._marked = self._with_marks(self._plain)

    def on(self, timeline: Timeline) -> Timeline:
        """Return a timeline with the marks; the same object as long as nothing changes."""
        if timeline is not self._plain:
            self._plain, self._marked = timeline, self._with_marks(timeline)
        return self._marked

    def _with_marks(self, timeline: Timeline) -> Timeline:
        marks = [event for event in self.events if event.time_s <= timeline.duration_s]
        own = [event for event in timeline.events if event.kind == MARK]
        return with_marks(timeline, (*own, *marks)) if marks else timeline

    def set(self, name: str) -> None:
        """Set a mark at the disk's position; InputError where none can be."""
        if self._session.engine.timeline is not self._window.window_timeline:
            raise InputError("a new event is being announced; set the mark after it")
        time_s = self._window.time_at(self._session.engine.meters.cursor)
        known_s = self._window.timeline.known_until_s
        if known_s is not None and time_s > known_s:
            raise InputError(f"the disk is beyond the present, {clock_text(known_s)}; move it back")
        event = Event(round(time_s, 3), MARK, name)
        if event in self.events:
            raise InputError(f"there is a mark at {clock_text(event.time_s)}")
        self._change(
            [*self.events, event], f"{MARK} {name}".strip() + f" at {clock_text(event.time_s)}"
        )

    def undo(self) -> None:
        """Remove the newest mark; InputError without marks."""
        *others, last = self._present()
        self._change(others, f"mark at {clock_text(last.time_s)} removed")

    def rename(self, name: str) -> None:
        """Name the newest mark; InputError without marks."""
        *others, last = self._present()
        self._change(
            [*others, replace(last, label=name)], f"mark at {clock_text(last.time_s)}: {name}"
        )

    def _present(self) -> list[Event]:
        if not self.events:
            raise InputError("there is no mark; `mark` sets one at the disk's position")
        return self.events

    def _change(self, events: list[Event], message: str) -> None:
        self.events = events
        self._marked = self._with_marks(self._plain)
        self._session.say(message)
        if self._file is not None:
            moved = [event.moved(event.time_s + self._file.start_s) for event in events]
            kept = [event_object(event) for event in (*self._others, *moved)]
            write_table(self._file.path, {"title": "Marks", "events": kept})


def _read(path: Path) -> list[Event]:
    table: Mapping[str, Any] = read_table(path, "must have a list of events")
    rows = table.get("events", [])
    with prefix_errors(f"{path}: "):
        events = [event_of(row) for row in rows] if isinstance(rows, list) else None
        if events is None or any(event.kind != MARK for event in events):
            raise InputError(f"events must be a list of the kind {MARK}; correct or delete it")
    return events
