"""Takes of a session, the one that is recorded and those that have ended, with their recorder."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from overview_dsp.data.readers.native import save_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures.take_writer import Event, TakeWriter, free_name
from overview_dsp.errors import InputError, OutputError, OverviewError
from overview_dsp.live.session.session import Session
from overview_dsp.live.takes.recovery import RecordingMarker, fallback_paths
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.memory_reader import read_inputs

WRITE_EVERY_S = 0.1
"""Interval at which the engine's logs are written, even if the screen or the session is busy."""

STARTED_LATER = "the take started while the disk was touched or moving; a render starts at rest"

JOIN_WITHIN_S = 1.0
"""Time that closing waits for a file system that doesn't respond."""


class Recorder:
    """Writes the events and changes that an engine applies to a take.

    A take that starts at the engine's first sample renders to the samples that were played. A later
    one starts with the present touches, but its render starts with the disk at rest.

    Thread: its own, which `start` creates; any thread may call `close`.

    `path`: present path of the take.
    `differs`: reason why a render of the take isn't bit-identical to the played samples; otherwise
    empty.
    """

    def __init__(
        self,
        engine: Engine,
        path: str | os.PathLike[str],
        header: Mapping[str, Any],
        changes: list[Mapping[str, Any]] | None = None,
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        """Create a take; `changes` were applied before its first sample.

        `say` shows the user a message, from the take's thread.

        InputError, OutputError: the take can't be written.
        """
        self._engine = engine
        self._start_sample, self._events_read, touches = read_inputs(engine.memory)
        self.differs = "" if self._start_sample == 0 else STARTED_LATER
        self._end = 0
        self._events: list[Event] = [(0, source, theta2, True) for source, theta2 in touches]
        self._changes: list[tuple[int, Mapping[str, Any]]] = [(0, one) for one in changes or ()]
        self._pending = list(changes or ())
        self._say = say
        self._stopped = threading.Event()
        self._thread: threading.Thread | None = None
        self._reported: set[str] = set()
        self._busy = threading.Lock()  # a signal may close the take from another thread
        share = engine.preset.number("surface.angle_map")
        header = {"seed": engine.seed, "angle_map": share, **header}
        self._take: TakeWriter | None = TakeWriter(path, engine.sample_rate, header)
        self.path: Path = self._take.path
        self._marker = RecordingMarker(self.path)

    def start(self) -> None:
        """Write in a separate thread until `close`."""
        self._thread = threading.Thread(target=self._run, name="take", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stopped.wait(WRITE_EVERY_S):
            try:
                self.poll()
            except Exception as error:  # an unknown error must not end the take
                self._say_once(f"{self.path}: {type(error).__name__}: {error}; the take continues")

    def poll(self) -> None:
        """Write new events and changes; keep in memory those that can't be written anywhere."""
        with self._busy:
            if self._take is not None:
                self._collect()
                self._write()

    def close(self) -> None:
        """Write the rest and end the take; repeated calls do nothing. Thread: any.

        OutputError: the rest can't be written. The take on disk is valid without it.
        """
        self._stopped.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(JOIN_WITHIN_S)
        if not self._busy.acquire(timeout=JOIN_WITHIN_S):
            raise OutputError(f"{self.path}: the disk doesn't respond; the take ends before now")
        try:
            if self._take is None:
                return
            self._collect()
            error = self._write() or self._try(TakeWriter.finish)
            take, self._take = self._take, None
            self._marker.close()
        finally:
            self._busy.release()
        if error is not None:
            take.close()
            raise OutputError(
                f"{self.path}: {error.strerror}; the take is complete up to {take.played_s:.1f} s"
            )

    def _collect(self) -> None:
        """Read first the engine's present sample, then its logs, complete up to that sample."""
        self._end = self._engine.sample_time - self._start_sample
        try:
            events, self._events_read = self._engine.pop_applied(self._events_read)
        except OverviewError as error:
            self._report_missing(f"{error}; these are missing in the take")
            _, self._events_read, _ = read_inputs(self._engine.memory)
            return
        self._events += [
            (sample - self._start_sample, source, theta2, touching)
            for sample, source, theta2, touching in events.tolist()
        ]
        try:
            changes = self._engine.pop_changes()
        except OverviewError as error:
            self._report_missing(f"{error}; these are missing in the take")
            return
        for sample, change in changes:
            if change is None:
                self._report_missing("a take can't store the surface that was set; it is missing")
            elif change in self._pending:
                self._pending.remove(change)  # requested before the take, and part of its start
            elif sample >= self._start_sample:
                self._changes.append((sample - self._start_sample, change))

    def _write(self) -> OSError | None:
        """Write everything collected; return the error if it can't be written anywhere."""
        played = max([self._end] + [last[-1][0] for last in (self._events, self._changes) if last])
        error = self._try(lambda take: take.append(self._events, self._changes, played))
        if error is None:
            self._events, self._changes = [], []
        else:
            self._say_once(
                f"{self.path}: {error.strerror}, and no other folder is writable; the take stays "
                "in memory until a folder is writable"
            )
        return error

    def _try(self, action: Callable[[TakeWriter], None]) -> OSError | None:
        """Apply an action to the take, in another folder if necessary; return the last error."""
        assert self._take is not None
        while True:
            try:
                action(self._take)
            except OSError as error:
                if not self._move(self._take, error):
                    return error
            else:
                return None

    def _move(self, take: TakeWriter, error: OSError) -> bool:
        """Continue the whole take in a fallback folder; return whether one is writable."""
        for path in fallback_paths(take.path):
            if path.parent == take.path.parent:
                return False
            try:
                self._take = take.continue_at(path)
            except (InputError, OutputError):
                continue
            self.path = path
            self._marker.write(path)
            self._say(f"{take.path}: {error.strerror}; the take continues in {path}")
            return True
        return False

    def _report_missing(self, line: str) -> None:
        self.differs = line
        self._say_once(line)

    def _say_once(self, line: str) -> None:
        if line not in self._reported:
            self._reported.add(line)
            self._say(line)


def timeline_path(path: Path) -> Path:
    """Return the path of the timeline that is saved with a take of a live timeline."""
    return path.with_suffix(".timeline.json")


class Takes:
    """Starts and ends the takes of an engine.

    Thread: control; any thread may call `end`.

    `ended`: paths of the takes that have ended.
    `summaries`: line for the user on each of them.
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
                place = free_name(path)
                if timeline is not None:
                    save_timeline(timeline, timeline_path(place))
                recorder = Recorder(self._engine, place, header, before, self._say)
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
