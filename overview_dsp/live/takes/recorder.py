"""What the kernel applies, written to disk as it is played, for a take that replays every bit."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from overview_dsp.design.gestures.growing_take import Event, GrowingTake
from overview_dsp.errors import InputError, OutputError, OverviewError
from overview_dsp.live.takes.recovery import GrowingNote, other_places
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.memory_reader import read_inputs

EVERY_S = 0.1
"""How often the engine's logs are written; a frozen screen or a busy session doesn't delay it."""

BEGUN_LATER = "it begins with the disk held or moving; rendered, the disk is at rest first"

STUCK_S = 1.0
"""How long closing waits for a disk that doesn't answer."""


class Recorder:
    """Writes an engine's applied events and changes to a take, from now on.

    From the engine's first sample on, the take renders to the very samples that were heard. Later,
    it begins with the hands as they hold the disk, but the disk itself, rendered, is at rest first.

    Thread: one, which `start` makes; `close` from any.

    Attributes
    ----------
    path : Path
        Where the take is now.
    differs : str
        Why it doesn't render to what was heard, to the bit; empty if it does.
    """

    def __init__(
        self,
        engine: Engine,
        path: str | os.PathLike[str],
        about: Mapping[str, Any],
        changes: list[Mapping[str, Any]] | None = None,
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        """Begin a take; `changes` were made before and hold at its first sample.

        `say` shows the user a message, from the take's thread.

        Raises
        ------
        InputError, OutputError
            It can't be written.
        """
        self._engine = engine
        self._begin, self._seen, hands = read_inputs(engine.memory)
        self.differs = "" if self._begin == 0 else BEGUN_LATER
        self._now = 0
        self._events: list[Event] = [(0, source, theta2, True) for source, theta2 in hands]
        self._changes: list[tuple[int, Mapping[str, Any]]] = [(0, one) for one in changes or ()]
        self._pending = list(changes or ())
        self._say = say
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        self._said: set[str] = set()
        self._busy = threading.Lock()  # whoever ends the process may close it from elsewhere
        share = engine.preset.number("surface.angle_map")
        about = {"seed": engine.seed, "angle_map": share, **about}
        self._take: GrowingTake | None = GrowingTake(path, engine.sample_rate, about)
        self.path: Path = self._take.path  # where it is now
        self._note = GrowingNote(self.path)

    def start(self) -> None:
        """Write from now on in a thread of its own, until `close`."""
        self._thread = threading.Thread(target=self._run, name="take", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(EVERY_S):
            try:
                self.poll()
            except Exception as error:  # what it is can't be known: the rest may be kept
                self._say_once(f"{self.path}: {type(error).__name__}: {error}; the take goes on")

    def poll(self) -> None:
        """Write what was applied since the last time; what can't be written anywhere is kept."""
        with self._busy:
            if self._take is not None:
                self._collect()
                self._write()

    def close(self) -> None:
        """Write what is left and end the take; may be called twice, from anywhere.

        Raises
        ------
        OutputError
            No place for the rest: the take on disk is whole without it.
        """
        self._over.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(STUCK_S)
        with self._busy:
            if self._take is None:
                return
            self._collect()
            error = self._write() or self._do(GrowingTake.finish)
            take, self._take = self._take, None
            self._note.close()
        if error is not None:
            take.close()
            raise OutputError(
                f"{self.path}: {error.strerror}; the take is whole up to {take.played_s:.1f} s"
            )

    def _collect(self) -> None:
        """What the logs hold now; the sample first, so that nothing before it is missed later."""
        self._now = self._engine.sample_time - self._begin
        try:
            events, self._seen = self._engine.pop_applied(self._seen)
        except OverviewError as error:
            self._miss(f"{error}; these are missing in the take")
            _, self._seen, _ = read_inputs(self._engine.memory)
            return
        self._events += [
            (sample - self._begin, source, theta2, touching)
            for sample, source, theta2, touching in events.tolist()
        ]
        try:
            changes = self._engine.pop_changes()
        except OverviewError as error:
            self._miss(f"{error}; these are missing in the take")
            return
        for sample, what in changes:
            if what is None:
                self._miss("a surface was set that a take can't hold: replayed, it is missing")
            elif what in self._pending:
                self._pending.remove(what)  # asked for before the take, and there from its start
            elif sample >= self._begin:
                self._changes.append((sample - self._begin, what))

    def _write(self) -> OSError | None:
        """Write all that was collected; return the error if it can be written nowhere."""
        played = max([self._now] + [last[-1][0] for last in (self._events, self._changes) if last])
        error = self._do(lambda take: take.append(self._events, self._changes, played))
        if error is None:
            self._events, self._changes = [], []
        else:
            self._say_once(
                f"{self.path}: {error.strerror}, and there is no other place; the take is kept "
                "in memory until there is one"
            )
        return error

    def _do(self, action: Callable[[GrowingTake], None]) -> OSError | None:
        """Do something with the take, here or in another place; return the error if both fail."""
        assert self._take is not None
        while True:
            try:
                action(self._take)
            except OSError as error:
                if not self._move(self._take, error):
                    return error
            else:
                return None

    def _move(self, take: GrowingTake, error: OSError) -> bool:
        """Continue the take in another place, whole up to now; return whether there is one."""
        for place in other_places(take.path):
            if place.parent == take.path.parent:
                return False
            try:
                self._take = take.continued(place)
            except (InputError, OutputError):
                continue
            self.path = place
            self._note.moved(place)
            self._say(f"{take.path}: {error.strerror}; the whole take goes on in {place}")
            return True
        return False

    def _miss(self, line: str) -> None:
        self.differs = line
        self._say_once(line)

    def _say_once(self, line: str) -> None:
        if line not in self._said:
            self._said.add(line)
            self._say(line)
