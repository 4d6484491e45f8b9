"""A live session: an engine, its output, a preset that may change, a source, a recording.

Whoever shows it (a terminal application, lines of JSON) calls `poll` often and the hand's methods
as the hand moves. The output may vanish and come back: the disk is let go, and the session goes on.

Thread: control.
"""

from __future__ import annotations

import os
import time
import warnings
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from overview_dsp.actuators.model import Actuator
from overview_dsp.actuators.stage import Protected, read_protected
from overview_dsp.engine.coefficients import check_carrier
from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.gestures import Gesture, load_gesture
from overview_dsp.gestures.growing_take import free_name
from overview_dsp.gestures.scripts import TAP_S
from overview_dsp.kernels import layout
from overview_dsp.live import commands
from overview_dsp.live.frames_lost import FramesLost
from overview_dsp.live.kept_takes import other_places
from overview_dsp.live.output_settings import OutputSettings
from overview_dsp.live.preset_pair import PresetPair
from overview_dsp.live.preset_watch import PresetWatch
from overview_dsp.live.recorder import Recorder
from overview_dsp.live.replay import Replay
from overview_dsp.live.stream_meters import StreamMeters, take_peaks
from overview_dsp.presets.dicts import preset_to_dict
from overview_dsp.presets.model import Preset
from overview_dsp.surface.build import build_surface
from overview_dsp.surface.model import Surface
from overview_dsp.timeline import Timeline
from overview_dsp.timeline.zooming import Zoom
from overview_dsp.units import HALF_TURN

TAP_SETTLES_S = 0.1
"""A tap holds at least so long: until it is heard, the disk may seem to have arrived."""

LOST_AFTER_S = 1.0
"""An output that hasn't called for so long is lost."""

RETRY_EVERY_S = 1.0


class Stream(Protocol):
    """What runs the engine: a PortAudio output, or a silent one."""

    name: str
    block_size: int

    def start(self) -> None:
        """Begin to play."""

    def restart(self, begin: Callable[[], None]) -> None:
        """Fade out, call `begin` while nothing runs the engine, and play on; OverviewError."""

    def close(self) -> None:
        """Fade out and end."""

    @property
    def active(self) -> bool:
        """Whether it plays."""

    @property
    def meters(self) -> StreamMeters:
        """Counters so far."""


@dataclass(frozen=True)
class Status:
    """How a session stands.

    `time_s` played; `cursor` and `finger` 0 to 1; `torque` and the preset's `full_torque`, N m;
    `peak_click` and `peak_tactor` (linear, as the device got them) since the last poll; the
    output's `callbacks`, `late` ones, `underflows`, `frames` and `frames_lost` (gaps of a block and
    more); control events `dropped`; `load` (part of the time that callbacks take) and their times,
    s; what the actuator's protection did (`protected`); the take that grows (`recording`) and the
    one that plays (`replay`); the tactor's `envelope` (linear) and the `strikes` so far; `messages`
    for the person, new since the last poll.
    """

    time_s: float
    cursor: float
    finger: float
    touching: bool
    torque: float
    full_torque: float
    peak_click: float
    peak_tactor: float
    callbacks: int
    late: int
    underflows: int
    frames: int
    frames_lost: int
    dropped: int
    load: float
    median_s: float
    p99_s: float
    longest_s: float
    latency_s: float
    output: str
    callback: str
    sample_rate: float
    block_size: int
    click_muted: bool
    tactor_muted: bool
    actuator: Actuator | None
    protected: Protected | None
    recording: str | None
    replay: str | None
    envelope: float
    strikes: int
    messages: tuple[str, ...]


class Player:
    """A timeline under a live hand.

    Attributes
    ----------
    timeline : Timeline
        The whole.
    window : (start_s, end_s)
        The part of it under the hand.
    shown : Timeline
        That part, from 0.
    """

    def __init__(
        self,
        timeline: Timeline,
        watch: PresetWatch,
        open_stream: Callable[[Engine, OutputSettings], Stream],
        settings: OutputSettings,
        *,
        sample_rate: float = 48_000,
        max_block_size: int = 8192,
        callback: str = "native",
        record: str | os.PathLike[str] | None = None,
        seed: int = 0,
        other: PresetWatch | None = None,
    ) -> None:
        """Open the output and begin to play; `open_stream` is called again if that is lost.

        `record` is where the takes go; with it, the first one begins at once. `other` is the second
        preset to switch to.

        Raises
        ------
        OverviewError
            The output can't be opened, or the take not written.
        """
        self.timeline = self.shown = timeline
        self.window = (0.0, timeline.duration_s)
        self.settings = settings
        self.outputs = open_stream
        self._callback = callback
        self._messages: deque[str] = deque()
        self._finger = 0.0
        self._touching = False
        self._release_at: float | None = None
        self._wanted_window: tuple[float, float] | None = None
        self._wanted_preset: Preset | None = None
        self.engine = Engine(watch.preset, timeline, seed=seed)
        self._max_block_size = max_block_size
        self.engine.prepare(sample_rate, max_block_size)
        self.takes: list[str] = []  # those that were ended
        self._recorder: Recorder | None = None
        self._take_path = Path(
            time.strftime("take-%Y%m%d-%H%M%S.csv") if record is None else record
        )
        self._presets = PresetPair(watch, other)
        self._replay: Replay | None = None
        self._asked: deque[tuple[str, ...]] = deque()
        self._before_s = 0.0
        self._dropped_before = 0
        self._earlier = (0, 0, 0, 0)
        self._lost = FramesLost()
        self._polled = time.monotonic()
        self._retry_at = 0.0
        self._stream: Stream | None = None
        self._start_stream(record)

    # --- the hand -------------------------------------------------------------------------------

    def touch(self, position: float) -> None:
        """The finger holds at `position` (0 to 1): a tap if it wasn't down, else it moves there.

        It ends a replay: one hand at a time.
        """
        self.stop_replay()
        self._release_at = None
        self._hold(position)

    def release(self) -> None:
        """The finger lets go: the disk recoils."""
        self._release_at = None
        if self._touching:
            self._touching = False
            self.engine.control(self._finger * HALF_TURN, False)

    def tap(self, position: float) -> None:
        """A step to `position`, held until the disk is there, and let go (paper, figure 6)."""
        self.stop_replay()
        if self._touching:
            self.release()
        self._hold(position)
        self._release_at = time.monotonic() + TAP_S

    @property
    def finger(self) -> float:
        """Where the finger holds or held last, 0 to 1."""
        return self._finger

    @property
    def holding(self) -> bool:
        """Whether the finger is down."""
        return self._touching

    def _hold(self, position: float) -> None:
        self._finger = min(max(position, 0.0), 1.0)
        self._touching = True
        if self._stream is not None:  # else nobody would take it, and it would be stale
            self.engine.control(self._finger * HALF_TURN, True)

    # --- what is under it -----------------------------------------------------------------------

    def zoom(self, factor: float, about: float) -> None:
        """Show `factor` times as much detail; the moment under `about` (0 to 1) stays there."""
        wanted = Zoom(self.timeline, *(self._wanted_window or self.window)).scaled(factor, about)
        self.show(*wanted.window)

    def go_to_event(self, direction: int, position: float) -> None:
        """Touch the event after (1) or before (-1) a position of the window, in it or beyond.

        Beyond its end the window moves along.
        """
        zoom = Zoom(self.timeline, *self.window)
        positions = [float(one) for one in self.surface.position]
        near = 1e-6
        if direction > 0:
            wanted = min((one for one in positions if one > position + near), default=None)
            beyond = zoom.next_event_s(zoom.end_s)
        else:
            wanted = max((one for one in positions if one < position - near), default=None)
            beyond = zoom.previous_event_s(zoom.start_s)
        if wanted is None and beyond is not None:
            moved = zoom.showing(beyond)
            self.show(*moved.window)
            wanted = moved.position(beyond)
        if wanted is not None:
            self.touch(wanted)

    def show(self, start_s: float, end_s: float) -> None:
        """Put a part of the timeline under the hand; InputError if it isn't one."""
        if (start_s, end_s) != self.window:
            self.timeline.window(start_s, end_s)
            self._wanted_window = (start_s, end_s)
            self._make_changes()

    def mute_click(self, muted: bool) -> None:
        """Silence the clicks at the device, or let them sound again."""
        self.set_output(self.settings.changed(click={"mute": muted}))

    def mute_tactor(self, muted: bool) -> None:
        """Still the tactor at the device, or let it move again."""
        self.set_output(self.settings.changed(tactor={"mute": muted}))

    def set_output(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings, gliding."""
        self.settings = settings
        settings.write(self.engine.memory, self.engine.sample_rate)

    @property
    def preset(self) -> Preset:
        """The preset that sounds."""
        return self.engine.preset

    @property
    def surface(self) -> Surface:
        """The surface under the hand."""
        return self.engine.surface

    def _make_changes(self) -> None:
        """Hand over what is wanted; what finds no free surface slot waits for the next poll."""
        with warnings.catch_warnings(record=True) as noted:
            warnings.simplefilter("always")
            try:
                self._change()
            except InputError as error:
                self._wanted_preset = None
                self._messages.append(f"{self._presets.name}: {error}; the last good one plays on")
            except OverviewError:
                return  # two surfaces fade already
        self._messages.extend(
            str(one.message) for one in noted if issubclass(one.category, OverviewWarning)
        )

    def _change(self) -> None:
        if self._wanted_window is not None:
            window = self._wanted_window
            shown = self.timeline.window(*window)
            self.engine.set_timeline(shown, window=window)
            self.window, self.shown, self._wanted_window = window, shown, None
        if self._wanted_preset is not None:
            self.engine.set_preset(self._wanted_preset)
            self._wanted_preset = None

    # --- the output -----------------------------------------------------------------------------

    def _start_stream(self, record: str | os.PathLike[str] | None = None) -> None:
        stream = self.outputs(self.engine, self.settings)
        try:
            if record is not None:  # before the first sample
                self._recorder = Recorder(self.engine, record, self._about)
                self._recorder.start()
            stream.start()
        except BaseException:
            stream.close()
            self.end_take()
            raise
        self._stream = stream
        self._output, self._block_size = stream.name, stream.block_size
        self._moved = (time.monotonic(), -1)
        self._last = stream.meters
        self._lost.restart()

    def _watch_stream(self) -> None:
        now = time.monotonic()
        if self._stream is None:
            if now >= self._retry_at:
                self._retry_at = now + RETRY_EVERY_S
                try:
                    self._start_stream()
                except OverviewError:
                    return
                self._messages.append(f"output {self._output} is back")
            return
        meters = self._stream.meters
        # a process that was suspended hasn't looked for long, and says nothing of the device
        asleep, self._polled = now - self._polled > LOST_AFTER_S / 2.0, now
        if meters.callbacks != self._moved[1] or asleep:
            self._moved = (now, meters.callbacks)
        self._last = meters
        if meters.frames:
            self._lost.look(now, meters.frames, self.engine.sample_rate, self._block_size)
        if not self._stream.active or now - self._moved[0] > LOST_AFTER_S:
            self._lose_stream(now)

    def _lose_stream(self, now: float) -> None:
        assert self._stream is not None
        self._messages.append(
            f"output {self._output} is lost: the disk is let go; waiting for it to come back"
        )
        self.release()
        self._close_stream(now)

    def _close_stream(self, now: float) -> None:
        assert self._stream is not None
        counts = (self._last.callbacks, self._last.late, self._last.underflows, self._last.frames)
        self._earlier = tuple(  # type: ignore[assignment]
            a + b for a, b in zip(self._earlier, counts, strict=True)
        )
        self._last = replace(self._last, callbacks=0, late=0, underflows=0, frames=0)
        try:
            self._stream.close()
        except Exception as error:  # PortAudio's own, of a device that is gone
            self._messages.append(f"closing it: {error}")
        self._stream = None
        self._retry_at = now

    def reopen(
        self,
        outputs: Callable[[Engine, OutputSettings], Stream] | None = None,
        settings: OutputSettings | None = None,
        sample_rate: float | None = None,
    ) -> None:
        """Change to another output, other settings of it, another rate (which ends a take).

        Raises
        ------
        OverviewError
            It can't be opened; the present one plays on.
        """
        before = self.outputs, self.settings, self.engine.sample_rate
        self.stop_replay()
        self.release()
        self._open_anew(outputs or self.outputs, settings or self.settings, sample_rate)
        if self._stream is None:
            failure = self._refused
            self._open_anew(*before)
            raise failure
        rate = self.engine.sample_rate
        self.say(f"output {self._output}, {rate:g} Hz, {self._block_size} frames")

    def _open_anew(
        self,
        outputs: Callable[[Engine, OutputSettings], Stream],
        settings: OutputSettings,
        sample_rate: float | None,
    ) -> None:
        if self._stream is not None:
            self._close_stream(time.monotonic())
        self.outputs, self.settings = outputs, settings
        try:
            if sample_rate is not None and sample_rate != self.engine.sample_rate:
                self.end_take()
                self._count_before()
                self.engine.prepare(sample_rate, self._max_block_size)
            self._start_stream()
        except OverviewError as error:
            self._refused = error

    # --- how it stands --------------------------------------------------------------------------

    def poll(self) -> Status:
        """See to everything that is due; how the session stands."""
        if self._release_at is not None:
            left = self._release_at - time.monotonic()
            settled = left <= TAP_S - TAP_SETTLES_S and self.engine.arrived_at is not None
            if left <= 0.0 or settled:
                self.release()
        while self._asked:
            commands.do(self, *self._asked.popleft())
        for line in self._presets.look():
            self._messages.append(line)
        self._wanted_preset = self._presets.take_changed() or self._wanted_preset
        self._make_changes()
        self._watch_stream()
        self._go_on_replaying()
        if self._recorder is not None:
            self._messages.extend(self._recorder.take_messages())
        return self._status()

    def say(self, line: str) -> None:
        """Tell the person; from any thread."""
        self._messages.append(line)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call or `poll`."""
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    def _status(self) -> Status:
        engine, last = self.engine, self._last
        meters = engine.meters
        messages = self.take_messages()
        click, tactor = take_peaks(engine.memory)
        callbacks, late, underflows, frames = self._earlier
        driven = self.settings.actuator
        return Status(
            time_s=self._before_s + engine.sample_time / engine.sample_rate,
            cursor=meters.cursor,
            finger=self._finger,
            touching=meters.touching and self._stream is not None,
            torque=meters.torque,
            full_torque=self.preset.number("tactor.full_torque_mnm") * 1e-3,
            peak_click=click,
            peak_tactor=tactor,
            callbacks=callbacks + last.callbacks,
            late=late + last.late,
            underflows=underflows + last.underflows,
            frames=frames + last.frames,
            frames_lost=self._lost.count,
            dropped=self._dropped_before + meters.dropped_events,
            load=last.load,
            median_s=last.median_s,
            p99_s=last.p99_s,
            longest_s=last.longest_s,
            latency_s=last.latency_s,
            output=self._output,
            callback=self._callback,
            sample_rate=engine.sample_rate,
            block_size=self._block_size,
            click_muted=self.settings.click.mute,
            tactor_muted=self.settings.tactor.mute,
            actuator=driven,
            protected=None if driven is None else read_protected(engine.memory, layout.L_ACTUATOR),
            recording=None if self._recorder is None else str(self._recorder.path),
            replay=None if self._replay is None else self._replay.words,
            envelope=meters.envelope,
            strikes=meters.strikes,
            messages=messages,
        )

    @property
    def latency_s(self) -> float:
        """From a sample to the output, as the device says."""
        return self._last.latency_s

    @property
    def at_rest(self) -> bool:
        """Whether the disk lies still and nothing sounds, for a twentieth of a second."""
        meters = self.engine.meters
        quiet = 0.05 * self.engine.sample_rate
        return min(meters.silent_samples, meters.still_samples) >= quiet

    def close(self) -> None:
        """Let go, fade out, give the output back and save the take; may be called twice.

        Raises
        ------
        InputError, OutputError
            The take can't be written.
        """
        self.release()
        try:
            if self._stream is not None:
                stream, self._stream = self._stream, None
                stream.close()
        finally:
            self.end_take()

    # --- the take -------------------------------------------------------------------------------

    @property
    def _about(self) -> dict[str, str]:
        return {"title": self.timeline.title, "preset": self._presets.preset.name}

    def toggle_take(self) -> None:
        """Begin a take, or end the one that is recorded."""
        if self._recorder is not None:
            path = self._recorder.path
            try:
                self.end_take()
            except OverviewError as error:
                self.say(str(error))
            else:
                self.say(f"{path}: the take; P plays it again")
            return
        self.stop_replay()
        # what holds at its first sample, and isn't in the timeline and the preset as they are named
        before: list[Mapping[str, Any]] = []
        if self.window != (0.0, self.timeline.duration_s):
            before.append({"window": list(self.window)})
        if self.engine.preset != self._presets.preset:
            before.append({"preset": preset_to_dict(self.engine.preset)})
        for path in (self._take_path, *other_places(self._take_path)):
            try:
                recorder = Recorder(self.engine, free_name(path), self._about, before)
            except OverviewError as error:
                self.say(str(error))
                continue
            recorder.start()
            self._recorder = recorder
            self.say(f"{recorder.path}: recording; R ends it")
            return

    def end_take(self) -> None:
        """Save what is recorded; may be called from any thread, and twice; errors as `close`."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            try:
                recorder.close()
            finally:
                self._messages.extend(recorder.take_messages())
                self.takes.append(str(recorder.path))

    # --- the same hand again ----------------------------------------------------------------------

    def toggle_replay(self) -> None:
        """Play the last take again and again, or stop that."""
        if self._replay is not None:
            self.stop_replay()
            return
        if self._recorder is not None:
            self.toggle_take()
        if not self.takes:
            self.say("nothing to replay yet: R begins a take, and ends it")
            return
        try:
            gesture = load_gesture(self.takes[-1])
        except InputError as error:
            self.say(str(error))
        else:
            self.replay(gesture, Path(self.takes[-1]).name)

    def replay(self, gesture: Gesture, name: str, loop: bool = True) -> None:
        """Play a hand through the present preset, each time from the engine's first sample on.

        What else a take recorded but its hands and windows is left out: its presets aren't those
        that are to be felt. Each pass in which nothing is changed sounds as it is rendered offline.
        """
        left_out = sum("window" not in change.what for change in gesture.changes)
        if left_out:
            self.say(f"{name}: {left_out} changes of parameters and presets are left out")
        self._replay = Replay(gesture, name, loop)
        self._begin_pass()

    @property
    def replaying(self) -> bool:
        """Whether a hand is played again."""
        return self._replay is not None

    def stop_replay(self) -> None:
        """Let go, and be as new."""
        if self._replay is not None:
            self._replay = None
            self._restart(self.shown, self.window, lambda: None)

    @property
    def recording(self) -> bool:
        """Whether a take is written."""
        return self._recorder is not None

    def use_preset(self, name: str) -> None:
        """Change to another preset, by name or path, and watch its file; InputError."""
        self._wanted_preset = self._presets.replace(PresetWatch(name))
        self._make_changes()

    def choose_preset(self, which: int) -> None:
        """Change to the first (0) or the second (1) preset: at the loop's start, else at once.

        Chosen twice, it is at once also within a loop.
        """
        again = self._presets.waiting == which
        if self._replay is not None and not again:
            self._presets.waiting = which
            self.say(f"{self._presets.words(which)}: from the loop's start on; again: at once")
            return
        self._wanted_preset = self._presets.choose(which)
        self.say(f"now {self._presets.words(which)}")
        self._make_changes()

    def _go_on_replaying(self) -> None:
        replay = self._replay
        if replay is None or self._stream is None:
            return
        replay.poll(self.engine)
        if replay.is_over(self.engine, self.at_rest):
            if replay.loop:
                self._begin_pass()
            else:
                self._replay = None

    def _begin_pass(self) -> None:
        replay = self._replay
        assert replay is not None
        if self._presets.waiting is not None:
            self._wanted_preset = self._presets.choose(self._presets.waiting)
        timeline, window = replay.first(self)

        def begin() -> None:
            replay.begin(self.engine, self._replay_window, self.timeline)

        self._restart(timeline, window, begin)

    def _replay_window(self, window: tuple[float, float], sample: int) -> None:
        shown = self.timeline.window(*window)
        self.engine.set_timeline(shown, sample, window)
        self.window, self.shown, self._wanted_window = window, shown, None

    def _restart(
        self, timeline: Timeline, window: tuple[float, float], begin: Callable[[], None]
    ) -> None:
        """Begin with the engine's first sample, under the preset that is wanted."""
        if self._stream is None:
            return
        preset, self._wanted_preset = self._wanted_preset or self.engine.preset, None
        try:
            check_carrier(preset, self.engine.sample_rate)
            surface = build_surface(timeline, preset)  # while it still sounds
        except InputError as error:
            self.say(f"{error}; the last good one plays on")
            preset, surface = self.engine.preset, build_surface(timeline, self.engine.preset)

        def anew() -> None:
            self._count_before()
            self.engine.restart(preset, timeline, seed=self.engine.seed, surface=surface)
            self.window, self.shown, self._wanted_window = window, timeline, None
            begin()

        self.end_take()
        self._touching = False
        self._release_at = None
        try:
            self._stream.restart(anew)
        except OverviewError as error:
            self.say(str(error))
        self._lost.restart()
        self._moved = (time.monotonic(), -1)

    def _count_before(self) -> None:
        """The engine counts from 0 again."""
        self._before_s += self.engine.sample_time / self.engine.sample_rate
        self._dropped_before += self.engine.meters.dropped_events

    # --- what others ask for --------------------------------------------------------------------

    def ask(self, *words: str) -> None:
        """Have one of `commands.COMMANDS` done at the next poll; from any thread."""
        self._asked.append(words)
