"""Output of a session, with its opener. It opens again after it was lost, counting lost frames."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.output import portaudio_library as library
from overview_dsp.live.output.devices import OutputDevice, find_device, same_device
from overview_dsp.live.output.jack import Connections
from overview_dsp.live.output.portaudio_stream import CallbackKind, OutputStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import FADE_WITHIN_S, NullStream, Stream, StreamMeters
from overview_dsp.live.session.session import Session
from overview_dsp.signal.engine.engine import Engine

MAX_BLOCK = 8192


@dataclass
class StreamOpener:
    """Callable that opens a stream on one device.

    Attributes
    ----------
    device : str or None
        Output; None is the default, `SILENT` no sound. A name or number is looked up at the first
        opening; later ones use that output only.
    block_size : int
        Block size in frames; 0 lets the device choose.
    callback : str
        Kind of callback, as in `OutputStream`.
    rescans : bool
        Whether PortAudio looks for new devices first. The second call and later ones always do.
    """

    device: str | None
    block_size: int
    callback: CallbackKind
    rescans: bool = False
    _known: OutputDevice | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        if not 0 <= self.block_size <= MAX_BLOCK:
            raise InputError(f"block size {self.block_size} must be 0 to {MAX_BLOCK} frames")

    def __call__(self, engine: Engine, settings: OutputSettings) -> Stream:
        """Open a stream for an engine; errors as in `OutputStream`."""
        if self.device == library.SILENT:
            return NullStream(engine, self.block_size or 256, settings)
        with library.LIBRARY_LOCK:
            if self.rescans:
                library.rescan()
            self.rescans = True
            known, device = self._known, library.device_named(self.device)
            if known is not None:
                device = same_device(known).index
            stream = OutputStream(engine, device, self.block_size, settings, self.callback)
            if self.device not in (None, library.PAD):
                self._known = find_device(stream.index)
        return stream


MINIMUM_OVER_S = 0.5  # time over which the minimum of the delay is taken
SLACK_S = 0.002  # rise of the minimum, beyond a block, that is not a loss


class FramesLost:
    """Counter of the frames that an output lost in gaps.

    The delay of the delivered frames behind the clock varies with the blocks and with the time of
    each look. Its minimum over half a second hardly does. If that minimum rises by more than a
    block from one half second to the next, frames were lost. A clock drift of the device is slower
    and isn't counted.

    Thread: one.
    """

    def __init__(self) -> None:
        self.count = 0
        self.restart()

    def restart(self) -> None:
        """Count from the next frame on: the output is new or was paused."""
        self._before: float | None = None
        self._least: float | None = None
        self._until = 0.0

    def update(self, now_s: float, frames: int, sample_rate: float, block_size: int) -> None:
        """Take account of the frames delivered from the start until `now_s`; call this often."""
        behind = now_s * sample_rate - frames
        if self._least is None:
            self._until = now_s + MINIMUM_OVER_S
        elif now_s >= self._until:
            slack = block_size + SLACK_S * sample_rate
            if self._before is not None and self._least - self._before > slack:
                self.count += round(self._least - self._before)
            self._before, self._least = self._least, None
            self._until = now_s + MINIMUM_OVER_S
        self._least = behind if self._least is None else min(self._least, behind)


LOST_AFTER_S = 0.8
"""Time without a callback after which an output is lost; three blocks, if they take longer."""

RETRY_EVERY_S = 1.0


class ReconnectingStream:
    """Output of a session, which is opened again after it was lost and may be replaced.

    Thread: control.

    Attributes
    ----------
    opener : StreamOpener
        Opener of the output.
    settings : OutputSettings
        Channels, gains and actuator.
    name : str
        Name of the present or last stream.
    block_size : int
        Block size in frames.
    lost_reason : str
        Reason why the output doesn't play; empty while it plays.
    """

    def __init__(self, session: Session, opener: StreamOpener, settings: OutputSettings) -> None:
        """Prepare without opening the output."""
        self.opener = opener
        self.settings = settings
        self.name, self.block_size, self.lost_reason = "", 0, ""
        self._session, self._engine = session, session.engine
        self._stream: Stream | None = None
        self._frozen = False
        self._connections: Connections | None = None
        self._last = self._earlier = StreamMeters(0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.frames_lost = FramesLost()
        self._polled_at = time.monotonic()
        self._called = (self._polled_at, -1)  # time of the last new callback, number of callbacks
        self._retry_at = 0.0

    @property
    def playing(self) -> bool:
        """State of the output: True while a stream is open and its server responds."""
        return self._stream is not None and not self._frozen

    @property
    def starting(self) -> bool:
        """State of the output: True until the first callback of an open stream."""
        return self.playing and self._last.callbacks == 0

    @property
    def meters(self) -> StreamMeters:
        """Meters of the present or last stream at the last poll; counts are sums of all streams."""
        names = ("callbacks", "late", "underflows", "frames")
        return replace(
            self._last,
            **{one: getattr(self._earlier, one) + getattr(self._last, one) for one in names},
        )

    def open(self, before: Callable[[], None] = lambda: None) -> None:
        """Open the output and start to play; call `before` before the first sample.

        OverviewError: the output can't be opened, or `before` failed.
        """
        stream = self.opener(self._engine, self.settings)
        if stream.name == self.name:
            stream.connections = self._connections
        try:
            before()
            stream.start()
        except BaseException:
            stream.close()
            raise
        self._say_missing(stream)
        self._stream = stream
        self.name, self.block_size = stream.name, stream.block_size
        self._last, self.lost_reason = stream.meters, ""
        self._begin_watch()

    def _say_missing(self, stream: Stream) -> None:
        if missing := stream.missing_connections:
            gone = ", ".join(missing)
            self._session.say(f"output {stream.name}: not reconnected to {gone}, which are gone")

    def poll(self) -> None:
        """Close an output that is lost; try once per second to open it again."""
        now = time.monotonic()
        if self._stream is None:
            self._retry(now)
            return
        meters = self._stream.meters
        # a long time between polls means that this process was suspended, not that the device is
        asleep, self._polled_at = now - self._polled_at > LOST_AFTER_S / 2.0, now
        if meters.callbacks != self._called[1] or asleep:
            self._called = (now, meters.callbacks)
            if self._frozen and not asleep:
                self._frozen, self.lost_reason = False, ""
                self.frames_lost.restart()
                self._session.say(f"output {self.name} reconnected")
        self._last = meters
        if meters.frames:
            self.frames_lost.update(now, meters.frames, self._engine.sample_rate, self.block_size)
        late = now - self._called[0] > max(LOST_AFTER_S, 3.0 * self._block_s)
        if late and self._may_be_frozen:
            self._report_frozen()
        elif late or not self._stream.active:
            self._session.say(
                f"output {self.name} disconnected; disk released, waiting for the output"
            )
            self.disconnect()
            self.lost_reason = f"{self.name} disconnected"

    @property
    def _block_s(self) -> float:
        return self.block_size / self._engine.sample_rate

    @property
    def _may_be_frozen(self) -> bool:
        stream = self._stream
        return stream is not None and stream.active and stream.waits_for_server

    def _report_frozen(self) -> None:
        if not self._frozen and self._stream is not None:
            self._frozen, self.lost_reason = True, f"{self.name} doesn't respond"
            self._called = (time.monotonic(), self._stream.meters.callbacks)
            self._session.say(
                f"output {self.name} doesn't respond; disk released, waiting for its server"
            )

    def _responds(self) -> bool:
        """Wait a short time for a callback; return whether there was one."""
        assert self._stream is not None
        within_s = max(FADE_WITHIN_S, 3.0 * self._block_s)
        until, before = time.monotonic() + within_s, self._stream.meters.callbacks
        while (same := self._stream.meters.callbacks == before) and time.monotonic() < until:
            time.sleep(0.002)
        return not same

    def _retry(self, now: float) -> None:
        if now < self._retry_at:
            return
        self._retry_at = now + RETRY_EVERY_S
        try:
            self.open()
        except OverviewError as error:
            self.lost_reason = self.lost_reason or str(error)
            return
        self._session.say(f"output {self.name} reconnected")

    def set(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings smoothly."""
        self.settings = settings
        settings.write(self._engine.memory, self._engine.sample_rate)

    def restart(self, begin: Callable[[], None]) -> bool:
        """Fade out, call `begin` while nothing runs the engine, and continue to play.

        The result is False, with a message, if the output doesn't respond; `begin` isn't called.
        """
        assert self._stream is not None
        try:
            self._stream.restart(begin)
        except OverviewError as error:
            if self._may_be_frozen:
                self._report_frozen()
            else:
                self._session.say(str(error))
            return False
        self._say_missing(self._stream)
        self._begin_watch()
        return True

    def disconnect(self) -> None:
        """Close the stream so that `open` or `poll` can open another; show an error.

        OverviewError: the output's server doesn't respond; opening another stream would wait for
            it.
        """
        if self._stream is None:
            return
        if self._may_be_frozen and (self._frozen or not self._responds()):
            self._report_frozen()
            raise OverviewError(f"output {self.name} doesn't respond; start its server again")
        self._frozen = False
        self._earlier = self.meters
        self._last = replace(self._last, callbacks=0, late=0, underflows=0, frames=0)
        try:
            self._stream.close()
        except Exception as error:  # from PortAudio, if the device is disconnected
            self._session.say(f"error while closing output {self.name}: {error}")
        self._connections = self._stream.connections
        self._stream = None
        self._retry_at = time.monotonic()

    def close(self) -> None:
        """Fade out and end; repeated calls do nothing."""
        if self._stream is not None:
            stream, self._stream = self._stream, None
            stream.close()

    def _begin_watch(self) -> None:
        self._called = (time.monotonic(), -1)
        self.frames_lost.restart()
