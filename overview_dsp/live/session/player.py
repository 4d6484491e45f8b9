"""Player: an engine, its output, a window of a timeline, a pointer, takes and a loop.

`OpenedPlayer` opens it on the device that the user chose, and saves the settings at the end. The
user interface (terminal application or JSON lines) polls it often by `commands.poll`, and calls
`touch`, `release` and `tap` as the pointer moves. The output may disconnect and return: the disk is
released, and the session continues.

Thread: control.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from overview_dsp.data.feeds.timeline_diff import timeline_diff
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import load_gesture
from overview_dsp.design.presets.serialization import preset_to_dict
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.files.atomic import require_writable
from overview_dsp.kernels import layout
from overview_dsp.live.output.devices import find_device
from overview_dsp.live.output.portaudio_library import SILENT, device_named
from overview_dsp.live.output.portaudio_stream import CallbackKind
from overview_dsp.live.output.reconnecting_stream import MAX_BLOCK, ReconnectingStream, StreamOpener
from overview_dsp.live.output.settings import OutputSettings, is_pad, resolve_output, save_settings
from overview_dsp.live.output.stream import take_peaks
from overview_dsp.live.session.active_window import SAME_POSITION, ActiveWindow
from overview_dsp.live.session.blind import BlindComparison
from overview_dsp.live.session.live_updates import FollowSettings, LiveUpdates, MissedEvents
from overview_dsp.live.session.loop import Loop
from overview_dsp.live.session.marks import Marks, MarksFile
from overview_dsp.live.session.presets import PresetPair, PresetWatch
from overview_dsp.live.session.session import Pointer, Session, SessionState, Status
from overview_dsp.live.takes.recovery import pop_interrupted_takes
from overview_dsp.live.takes.takes import Takes, timeline_path
from overview_dsp.signal.actuators.stage import read_protection, warn_of_carrier
from overview_dsp.signal.engine.coefficients import announce_compile
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.angle_map import SHARE

_BLIND = "a blind comparison chooses the preset; press a, b or x"


class Player:
    """Live player of a timeline.

    `engine`: prepared engine.
    `output`: output that runs the engine.
    `active_window`: window of the timeline, and the presets.
    `pointer`: input of mouse and keys.
    `takes`: take that is recorded, and takes that have ended.
    `loop`: replay of a gesture.
    `live_updates`: updates of a live timeline; None for a complete one.
    `state`: state at the last poll; any thread may read it.
    `queued_commands`: commands that wait for `commands.poll`.
    `marks`: marks of the user.
    `blind`: blind comparison, during which the presets are chosen by it alone.
    """

    def __init__(
        self,
        timeline: Timeline,
        watch: PresetWatch,
        opener: StreamOpener,
        settings: OutputSettings,
        *,
        sample_rate: float = 48_000,
        max_block_size: int = 8192,
        callback: str = "native",
        record: str | os.PathLike[str] | None = None,
        seed: int = 0,
        other: PresetWatch | None = None,
        follow: FollowSettings | None = None,
        marks: MarksFile | None = None,
    ) -> None:
        """Open the output and start to play; `opener` is called again if the output is lost.

        `record` is the path of takes; with it, the first take starts at once. `other` is the second
        preset to switch to. With `follow`, `timeline` is the present snapshot of a live timeline.
        `marks` keeps the marks of the user.

        OverviewError: the output can't be opened, or the take can't be written.
        """
        self._callback, self._max_block_size = callback, max_block_size
        self.queued_commands: deque[tuple[str, ...]] = deque()
        self.engine = Engine(watch.preset, timeline, seed=seed)
        self.engine.prepare(sample_rate, max_block_size)
        session = self._session = Session(self.engine)
        self.say, self.take_messages = session.say, session.take_messages
        self._presets = PresetPair(watch, other)
        window = self.active_window = ActiveWindow(session, timeline, self._presets)
        self.show, self.time_at = window.show, window.time_at
        self.takes = Takes(session, record)
        self._plain = timeline  # a complete timeline without marks
        self.marks = Marks(session, window, marks)
        self.live_updates = (
            None if follow is None else LiveUpdates(session, follow, window, self.marks)
        )
        self.state = SessionState("starting", "opening the output")
        self.blind: BlindComparison | None = None
        self._ended_replay: str | None = None  # since which nothing has touched the disk
        self.output = ReconnectingStream(session, opener, settings)
        pointer = self.pointer = Pointer(session, self.output)
        self.missed_events = (
            None if follow is None else MissedEvents(session, follow.live, window, pointer)
        )
        self.loop = Loop(
            session, self.output, window, self._end_before_restart, self.pointer.force_release
        )
        try:
            if record is None:
                self.output.open()
            else:
                self.output.open(lambda: self.takes.start_first(*self._take_header))
        except BaseException:
            self.takes.end()
            raise

    # --- the pointer ----------------------------------------------------------------------------

    def touch(self, position: float) -> None:
        """Touch at `position` (0 to 1), or move there during a touch; this ends a replay."""
        self.loop.stop()
        self.pointer.touch(position)

    def release(self) -> None:
        """Release: the disk arrives at the pointer's position, then it recoils."""
        self.pointer.release()

    def tap(self, position: float) -> None:
        """Step to `position` and release at once (paper, figure 6)."""
        self.loop.stop()
        self.pointer.tap(position)

    # --- the window and the presets -------------------------------------------------------------

    @property
    def timeline(self) -> Timeline:
        """Whole timeline."""
        return self.active_window.timeline

    @property
    def window(self) -> tuple[float, float]:
        """Start and end of the window, s."""
        return self.active_window.window

    def zoom(self, factor: float, about: float) -> None:
        """Show `factor` times as much detail about the time at position `about` (0 to 1).

        During a touch the pointer follows that time where `about` can't be kept.
        """
        position = self.active_window.zoom(factor, about)
        if self.pointer.touching and abs(position - about) > SAME_POSITION:
            self._touch_again(position)

    def go_to_event(self, direction: int, position: float) -> None:
        """Touch the event after (1) or before (-1) a position, inside or outside the window."""
        found = self.active_window.neighbour_event_position(direction, position)
        if found is not None:
            self._touch_again(found)

    def _touch_again(self, position: float) -> None:
        """Release and touch, so that the backlash doesn't stop the disk before `position`."""
        self.release()
        self.touch(position)

    def use_preset(self, name: str) -> None:
        """Change to another preset by name or path, and watch its file; InputError."""
        if self.blind is not None:
            raise InputError(_BLIND)
        preset = self._presets.replace(PresetWatch(name, self._presets.linear))
        self.say(f"now {self._presets.name}")
        self.active_window.use(preset)

    def choose_preset(self, index: int) -> None:
        """Change to the first (0) or the second (1) preset.

        During a replay the change waits for the next pass. A second request applies it at once.
        """
        if self.blind is not None:
            self.say(_BLIND)
            return
        again = self._presets.next_choice == index
        if self.loop.playing and not again:
            self._presets.next_choice = index
            self.say(f"next pass: {self._presets.label(index)}; press again to change at once")
            return
        self.say(f"now {self._presets.label(index)}")
        self.active_window.use(self._presets.choose(index))

    # --- the output -----------------------------------------------------------------------------

    def reopen(
        self,
        opener: StreamOpener | None = None,
        settings: OutputSettings | None = None,
        sample_rate: float | None = None,
    ) -> None:
        """Change the output, its settings or the sample rate; a new rate ends a take.

        OverviewError: the new output can't be opened. The present one continues.
        """
        output, engine = self.output, self.engine
        before = output.opener, output.settings, engine.sample_rate
        self.loop.stop()
        self.release()
        try:
            self._open_another(opener or output.opener, settings or output.settings, sample_rate)
        except OverviewError:
            with contextlib.suppress(OverviewError):  # every poll tries again
                self._open_another(*before)
            raise
        actuator = output.settings.actuator
        self.say(
            f"output {output.name}, {engine.sample_rate:g} Hz, {output.block_size} frames, "
            f"{output.settings.channels_text}, actuator {actuator.name if actuator else 'none'}"
        )

    def _open_another(
        self, opener: StreamOpener, settings: OutputSettings, sample_rate: float | None
    ) -> None:
        output = self.output
        output.disconnect()
        output.opener, output.settings = opener, settings
        if sample_rate is not None and sample_rate != self.engine.sample_rate:
            self.takes.end()
            self._session.keep_counts()
            self.engine.prepare(sample_rate, self._max_block_size)
        output.open()

    # --- the session ----------------------------------------------------------------------------

    def queue_command(self, *arguments: str) -> None:
        """Queue a command, which the next `commands.poll` executes; from any thread."""
        self.queued_commands.append(arguments)

    def poll(self) -> Status:
        """Update all parts of the session; return its status."""
        playing = self.output.playing
        if not self.loop.playing and playing:
            if self.live_updates is not None:
                self.live_updates.poll(self.pointer.touching)
            elif (marked := self.marks.on(self._plain)) is not self.timeline:
                self.active_window.update_timeline(marked)
        if self.missed_events is not None and playing:
            self.missed_events.poll()
        self.active_window.poll()
        self.output.poll()
        if self.output.playing:
            self.loop.poll(self.at_rest)
        elif playing:
            self.release()
        return self._status()

    def _find_state(self) -> tuple[str, str]:
        """Return the name of the state and its reason."""
        output, held, replay = self.output, self.engine.active_input, self.loop.status_text
        if not output.playing:
            return "output lost", output.lost_reason
        if output.starting:
            return "starting", f"opening {output.name}"
        if replay is not None:
            self._ended_replay = replay
            return "running", replay
        if held is not None:
            self._ended_replay = None
            return "running", f"by {held[0]}"
        if self._ended_replay is not None:
            return "paused", f"{self._ended_replay}, ended"
        return "no input", "nothing touches the disk"

    def _status(self) -> Status:
        engine, output = self.engine, self.output
        meters = engine.meters
        self.state = self.state.then(*self._find_state())
        click, tactor = take_peaks(engine.memory)
        has_actuator = output.settings.actuator is not None
        recording, updates = self.takes.recording_path, self.live_updates
        return Status(
            state=self.state, time_s=self._session.played_s, cursor=meters.cursor,
            pointer=self.pointer.position, touching=meters.touching and output.playing,
            torque=meters.torque,
            full_torque=engine.preset.number("tactor.reference_torque_mnm") * 1e-3,
            envelope=meters.envelope, strikes=meters.strikes, peak_click=click, peak_tactor=tactor,
            stream=output.meters, frames_lost=output.frames_lost.count,
            dropped=self._session.dropped_events, output=output.name, callback=self._callback,
            sample_rate=engine.sample_rate, block_size=output.block_size, settings=output.settings,
            protected=read_protection(engine.memory, layout.L_ACTUATOR) if has_actuator else None,
            recording=None if recording is None else str(recording), replay=self.loop.status_text,
            following=None if updates is None else updates.status_text,
            messages=self.take_messages(),
        )  # fmt: skip

    @property
    def at_rest(self) -> bool:
        """State of the disk and the output: True after 0.05 s without movement and sound."""
        meters = self.engine.meters
        quiet = 0.05 * self.engine.sample_rate
        return min(meters.silent_samples, meters.still_samples) >= quiet

    def close(self) -> None:
        """Release, fade out, close the output and save the take; repeated calls do nothing.

        InputError, OutputError: the take can't be written.
        """
        self.release()
        try:
            self.output.close()
        finally:
            self.takes.end()

    # --- takes and replays ----------------------------------------------------------------------

    @property
    def _whole(self) -> tuple[float, float]:
        return 0.0, self.timeline.duration_s

    @property
    def _take_header(self) -> tuple[dict[str, Any], Timeline | None]:
        """Header of a take, and the timeline to save with it if that is live."""
        preset = self._presets.preset
        header = {
            "title": self.timeline.title,
            "preset": preset.name,
            "angle_map": preset.number(SHARE),
        }
        return header, None if self.live_updates is None else self.timeline

    def toggle_take(self) -> None:
        """Start a take, or end the present one."""
        path = self.takes.recording_path
        if path is not None:
            try:
                self.takes.end()
            except OverviewError as error:
                self.say(str(error))
            else:
                self.say(f"take saved as {path}; P replays it")
            return
        if self.loop.playing or (self.at_rest and self.engine.active_input is None):
            self.loop.cancel()
            self._start_exact_take()
        if self.takes.recording_path is None:
            # differences at the first sample from the timeline and preset named in the header
            before = self._changes_to(self.window)
            if self.engine.preset != self._presets.preset:
                before.append({"preset": preset_to_dict(self.engine.preset)})
            self.takes.start(before, *self._take_header)

    def _start_exact_take(self) -> None:
        """Restart the engine and start a take at its first sample, which is inaudible at rest.

        The engine restarts with the timeline and preset that the take's header names. Differences
        are applied at once.
        """
        preset = self.active_window.pop_requested_preset()
        changes = self._changes_to(self.window)

        def begin() -> None:
            self.takes.start([], *self._take_header)
            self.active_window.timeline = start
            for change in changes:
                self.active_window.apply_take_change(change, 0)
            if preset != self.engine.preset:
                self.engine.set_preset(preset, 0)

        start = self.timeline if self.live_updates is not None else self._plain
        self.loop.restart(start, self._whole, self._presets.preset, begin)

    def _changes_to(self, window: tuple[float, float]) -> list[Mapping[str, Any]]:
        """Return the changes from the timeline without marks to the present one and a window."""
        shown = None if window == self._whole else list(window)
        if self.live_updates is None and self.timeline is not self._plain:
            return [{"timeline": {**timeline_diff(self._plain, self.timeline), "window": shown}}]
        return [] if shown is None else [{"window": shown}]

    def _end_before_restart(self) -> None:
        """End the take, the touch and the announcement before the engine restarts."""
        self.takes.end()
        self.pointer.touching = self.pointer.used = False
        if self.live_updates is not None:
            self.live_updates.end_announcement()

    def toggle_replay(self) -> None:
        """Replay the last take in a loop, or stop the replay."""
        if self.loop.playing:
            self.loop.stop()
            return
        if self.takes.recording_path is not None:
            self.toggle_take()
        if not self.takes.ended:
            self.say("no take to replay; R starts a take and ends it")
            return
        path = Path(self.takes.ended[-1])
        saved_timeline = timeline_path(path)
        try:
            gesture = load_gesture(path)
            plain = self._plain if self.live_updates is None else None
            whole = load_timeline(saved_timeline) if saved_timeline.exists() else plain
        except InputError as error:
            self.say(str(error))
        else:
            self.loop.begin(gesture, path.name, whole=whole)


@dataclass(frozen=True)
class PlayerSettings:
    """Settings that a player is opened with."""

    preset: str  # name or path
    compare: str | None = None  # second preset to switch to
    linear: bool = False  # whether the presets are used without their angle maps
    window: tuple[float, float] | None = None  # first window, s; None: the whole timeline
    follow: FollowSettings | None = None  # of a live timeline
    device: str | None = None  # name or number; None: the default; "none": no sound; "pad"
    block_size: int = 256  # frames; 0 lets the device choose
    sample_rate: float | None = None  # Hz; None: the device's default
    callback: CallbackKind = "native"
    actuator: str | None = None  # name or file; "none" removes it; None: the last of the device
    # changes to the settings last used with the device, as fields of `SignalSettings`
    click: Mapping[str, Any] = field(default_factory=dict)
    tactor: Mapping[str, Any] = field(default_factory=dict)
    record: str | None = None  # file of a take that starts at the first sample
    seed: int = 0  # of the texture noise
    marks: MarksFile | None = None


class OpenedPlayer:
    """Context manager that opens a player and closes it.

    At the end it saves the take, and the device's settings if they were changed.
    """

    def __init__(
        self,
        timeline: Timeline,
        settings: PlayerSettings,
        note: Callable[[str], None],
        say: Callable[[str], None],
    ) -> None:
        """Open the player; `note` receives messages, `say` one line per take at the end.

        OverviewError: a device, file or value can't be used.
        """
        self._note, self._say = note, say
        self._window = settings.window and timeline.require_window(*settings.window)
        self._opener = StreamOpener(settings.device, settings.block_size, settings.callback)
        if settings.record is not None:
            require_writable(settings.record)
            require_writable(os.path.splitext(settings.record)[0] + ".json")
        for take in pop_interrupted_takes():
            note(f"interrupted take saved as {take} (overview render ... --gesture {take})")
        watch = PresetWatch(settings.preset, settings.linear)
        other = None if settings.compare is None else PresetWatch(settings.compare, settings.linear)
        self._device, rate, channels = None, 48_000.0, 0  # without sound
        if settings.device != SILENT:
            device = find_device(device_named(settings.device))
            self._device, rate, channels = device.full_name, device.sample_rate, device.channels
        changes = settings.click, settings.tactor
        self._resolved = resolve_output(self._device, *changes, settings.actuator, channels)
        output = self._resolved.settings
        if self._device is not None and is_pad(self._device, channels):
            actuator = "none" if output.actuator is None else output.actuator.name
            note(f"{self._device} is a game pad: {output.channels_text}, actuator {actuator}")
        if output.actuator is not None:
            warn_of_carrier(output.actuator, watch.preset.number("tactor.frequency_hz"))
        native = settings.callback == "native" and self._device is not None
        announce_compile("process", "callback" if native else "finish_block")
        self.player = Player(
            timeline, watch, self._opener, output, sample_rate=settings.sample_rate or rate,
            max_block_size=MAX_BLOCK, callback="native" if native else "python",
            record=settings.record, seed=settings.seed, other=other, follow=settings.follow,
            marks=settings.marks,
        )  # fmt: skip

    def __enter__(self) -> Player:
        if self._window is not None:
            self.player.show(*self._window)
        return self.player

    def __exit__(self, *error: object) -> None:
        self.player.close()
        for message in self.player.take_messages():
            self._note(message)
        for line in self.player.takes.summaries:
            self._say(line)
        # settings are saved only if the user did not change to another device
        same = self.player.output.opener is self._opener
        last = self.player.output.settings
        if same and self._device is not None and self._resolved.differ(last):
            save_settings(self._device, last)
