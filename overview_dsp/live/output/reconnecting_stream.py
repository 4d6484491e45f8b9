"""Output of a session that is opened again when it is lost, and the frames that it lost."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from overview_dsp.errors import OverviewError
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import Stream, StreamMeters
from overview_dsp.live.output.stream_opener import StreamOpener
from overview_dsp.live.session.session import Session

SLOT_S = 0.5
SLACK_S = 0.002


class FramesLost:
    """Counts gaps of an output; the count only grows.

    An output is a little behind the clock all the time, by what it has delivered last and when it
    is looked at; the least of half a second is nearly free of that. Where it rises by more than a
    block from one half second to the next, frames were lost. A device's own clock, which drifts
    away from the computer's, is none of it.

    Thread: one.
    """

    def __init__(self) -> None:
        self.count = 0
        self.restart()

    def restart(self) -> None:
        """A new output, or one that was paused: what is lost is counted from its next frame on."""
        self._before: float | None = None
        self._least: float | None = None
        self._until = 0.0

    def look(self, now_s: float, frames: int, sample_rate: float, block_size: int) -> None:
        """At `now_s` the output had delivered so many frames since its start; look often."""
        behind = now_s * sample_rate - frames
        if self._least is None:
            self._until = now_s + SLOT_S
        elif now_s >= self._until:
            slack = block_size + SLACK_S * sample_rate
            if self._before is not None and self._least - self._before > slack:
                self.count += round(self._least - self._before)
            self._before, self._least = self._least, None
            self._until = now_s + SLOT_S
        self._least = behind if self._least is None else min(self._least, behind)


LOST_AFTER_S = 1.0
"""An output that hasn't called for so long is lost."""

RETRY_EVERY_S = 1.0


class ReconnectingStream:
    """The output of a session: opened, lost and found again, exchanged for another.

    Thread: control.

    Attributes
    ----------
    opener : StreamOpener
        Opens the output, and opens it again.
    settings : OutputSettings
        Its channels, gains and actuator.
    name : str
        The present one's, or the last one's.
    block_size : int
        Frames.
    """

    def __init__(self, session: Session, opener: StreamOpener, settings: OutputSettings) -> None:
        """Nothing is opened yet."""
        self.opener = opener
        self.settings = settings
        self.name, self.block_size = "", 0
        self._session, self._engine = session, session.engine
        self._stream: Stream | None = None
        self._last = self._earlier = StreamMeters(0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._frames_lost = FramesLost()
        self._polled_at = time.monotonic()
        self._called = (self._polled_at, -1)  # when the device called last, how often until then
        self._retry_at = 0.0

    @property
    def playing(self) -> bool:
        """Whether there is one."""
        return self._stream is not None

    @property
    def meters(self) -> StreamMeters:
        """Meters of the present or last stream, as of the last poll; counts are of all so far."""
        names = ("callbacks", "late", "underflows", "frames")
        return replace(
            self._last,
            **{one: getattr(self._earlier, one) + getattr(self._last, one) for one in names},
        )

    @property
    def frames_lost(self) -> int:
        """Frames of gaps of a block and more, so far."""
        return self._frames_lost.count

    def open(self, before: Callable[[], None] = lambda: None) -> None:
        """Open it and begin to play; `before` is called ahead of the first sample.

        Raises
        ------
        OverviewError
            It can't be opened, or what `before` raised.
        """
        stream = self.opener(self._engine, self.settings)
        try:
            before()
            stream.start()
        except BaseException:
            stream.close()
            raise
        self._stream = stream
        self.name, self.block_size = stream.name, stream.block_size
        self._last = stream.meters
        self._begin_watch()

    def poll(self) -> None:
        """Close an output that is lost; try to open it again now and then."""
        now = time.monotonic()
        if self._stream is None:
            self._retry(now)
            return
        meters = self._stream.meters
        # a process that was suspended hasn't looked for long, which says nothing of the device
        asleep, self._polled_at = now - self._polled_at > LOST_AFTER_S / 2.0, now
        if meters.callbacks != self._called[1] or asleep:
            self._called = (now, meters.callbacks)
        self._last = meters
        if meters.frames:
            self._frames_lost.look(now, meters.frames, self._engine.sample_rate, self.block_size)
        if not self._stream.active or now - self._called[0] > LOST_AFTER_S:
            self._session.say(
                f"output {self.name} is lost: the disk is let go; waiting for it to come back"
            )
            self.give_back()

    def _retry(self, now: float) -> None:
        if now < self._retry_at:
            return
        self._retry_at = now + RETRY_EVERY_S
        try:
            self.open()
        except OverviewError:
            return
        self._session.say(f"output {self.name} is back")

    def set(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings, which glide there."""
        self.settings = settings
        settings.write(self._engine.memory, self._engine.sample_rate)

    def mute(self, signal: str, muted: bool) -> None:
        """Mute a signal (click or tactor) at the device, or let it sound again."""
        self.set(self.settings.changed(**{signal: {"mute": muted}}))

    def restart(self, begin: Callable[[], None]) -> None:
        """Fade out, call `begin` while nothing runs the engine, and play on."""
        assert self._stream is not None
        try:
            self._stream.restart(begin)
        except OverviewError as error:
            self._session.say(str(error))
        self._begin_watch()

    def give_back(self) -> None:
        """Close it, for `open` or `poll` to open another; an error is shown."""
        if self._stream is None:
            return
        self._earlier = self.meters
        self._last = replace(self._last, callbacks=0, late=0, underflows=0, frames=0)
        try:
            self._stream.close()
        except Exception as error:  # PortAudio's own, of a device that is gone
            self._session.say(f"closing it: {error}")
        self._stream = None
        self._retry_at = time.monotonic()

    def close(self) -> None:
        """Fade out and end; may be called twice."""
        if self._stream is not None:
            stream, self._stream = self._stream, None
            stream.close()

    def _begin_watch(self) -> None:
        self._called = (time.monotonic(), -1)
        self._frames_lost.restart()
