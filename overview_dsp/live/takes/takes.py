"""The takes of a session: the one that grows, and those that were ended."""

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
from overview_dsp.live.takes.recovery import other_places


def timeline_beside(path: Path) -> Path:
    """Where the timeline is that a take begins on, if it was growing."""
    return path.with_suffix(".timeline.json")


class Takes:
    """Begins takes of an engine and ends them.

    Thread: control; `end` from any.

    Attributes
    ----------
    ended : list of str
        The files of those that were ended.
    words : list of str
        A line for the person on each of them.
    """

    def __init__(self, session: Session, path: str | os.PathLike[str] | None) -> None:
        """`path` is where they go (None: a name by the clock)."""
        self._engine, self._say = session.engine, session.say
        self._path = Path(time.strftime("take-%Y%m%d-%H%M%S.csv") if path is None else path)
        self._recorder: Recorder | None = None
        self.ended: list[str] = []
        self.words: list[str] = []

    @property
    def growing(self) -> Path | None:
        """Where the one is that grows."""
        return None if self._recorder is None else self._recorder.path

    def begin(self, about: Mapping[str, Any], timeline: Timeline | None = None) -> None:
        """Begin one at its very place, from the engine's first sample on; errors as `Recorder`.

        `timeline` is what it begins on where no file holds that: it is written beside the take.
        """
        self._recorder = Recorder(self._engine, self._path, about, None, self._say)
        self._recorder.start()
        if timeline is not None:
            save_timeline(timeline, timeline_beside(self._path))

    def begin_later(
        self,
        about: Mapping[str, Any],
        before: list[Mapping[str, Any]],
        timeline: Timeline | None = None,
    ) -> None:
        """Begin one that replaces none, where there is a place for it.

        `before` are changes that hold at its first sample; `timeline` as `begin`.
        """
        for path in (self._path, *other_places(self._path)):
            try:
                recorder = Recorder(self._engine, free_name(path), about, before, self._say)
                if timeline is not None:
                    save_timeline(timeline, timeline_beside(recorder.path))
            except OverviewError as error:
                self._say(str(error))
                continue
            recorder.start()
            self._recorder = recorder
            self._say(f"{recorder.path}: recording; R ends it")
            return

    def end(self) -> None:
        """Save the one that grows; may be called twice.

        Raises
        ------
        OutputError
            A part of it can't be written.
        """
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            try:
                recorder.close()
            finally:
                self.ended.append(str(recorder.path))
                what = f"its hands; {recorder.differs}" if recorder.differs else "to the bit"
                beside = timeline_beside(recorder.path)
                on = f", on {beside}" if beside.exists() else ""
                self.words.append(f"{recorder.path}: the take, {what}{on}")
