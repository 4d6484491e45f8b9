"""Takes of a session: the one that is recorded, and those that have ended."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from overview_dsp.data.readers.native import save_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures.take_writer import free_name
from overview_dsp.errors import OverviewError
from overview_dsp.live.session.session import Session
from overview_dsp.live.takes.recorder import Recorder
from overview_dsp.live.takes.recovery import fallback_paths


def timeline_path(path: Path) -> Path:
    """Return the path of the timeline that is saved with a take of a live timeline."""
    return path.with_suffix(".timeline.json")


class Takes:
    """Starts and ends the takes of an engine.

    Thread: control; any thread may call `end`.

    Attributes
    ----------
    ended : list of str
        Paths of the takes that have ended.
    summaries : list of str
        Line for the user on each of them.
    """

    def __init__(self, session: Session, path: str | os.PathLike[str] | None) -> None:
        """Record to `path`; None makes a name of the present date and time."""
        self._engine, self._say = session.engine, session.say
        self._path = Path(time.strftime("take-%Y%m%d-%H%M%S.csv") if path is None else path)
        self._recorder: Recorder | None = None
        self.ended: list[str] = []
        self.summaries: list[str] = []

    @property
    def recording_path(self) -> Path | None:
        """Path of the take that is recorded; None without one."""
        return None if self._recorder is None else self._recorder.path

    def start_first(self, header: Mapping[str, Any], timeline: Timeline | None) -> None:
        """Record to exactly the given path from the first sample on; errors as `Recorder`.

        `timeline` is the present version of a live timeline, which is saved with the take.
        """
        self._recorder = Recorder(self._engine, self._path, header, None, self._say)
        self._recorder.start()
        if timeline is not None:
            save_timeline(timeline, timeline_path(self._path))

    def start(
        self, before: list[Mapping[str, Any]], header: Mapping[str, Any], timeline: Timeline | None
    ) -> None:
        """Record to a new file, in a fallback folder if necessary.

        `before` are changes that were applied before the first sample; `timeline` is as in
        `start_first`.
        """
        for path in (self._path, *fallback_paths(self._path)):
            try:
                recorder = Recorder(self._engine, free_name(path), header, before, self._say)
                if timeline is not None:
                    save_timeline(timeline, timeline_path(recorder.path))
            except OverviewError as error:
                self._say(str(error))
                continue
            recorder.start()
            self._recorder = recorder
            self._say(f"{recorder.path}: recording; R ends it")
            return

    def end(self) -> None:
        """Save the take that is recorded; without one this does nothing.

        OutputError: a part of the take can't be written.
        """
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            try:
                recorder.close()
            finally:
                self.ended.append(str(recorder.path))
                saved = timeline_path(recorder.path)
                with_timeline = f" with {saved}" if saved.exists() else ""
                exactness = (
                    f"its render differs: {recorder.differs}"
                    if recorder.differs
                    else "its render is bit-identical"
                )
                self.summaries.append(f"take saved as {recorder.path}{with_timeline}; {exactness}")
