"""Player: an engine, its output, a window of a timeline, a finger, takes and a loop.

Whoever shows it (a terminal application, lines of JSON) polls it often by `commands.poll`, and
calls `touch`, `release` and `tap` as the finger moves. The output may vanish and come back: the
disk is released, and the session goes on.

Thread: control.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import load_gesture
from overview_dsp.design.presets.dicts import preset_to_dict
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.kernels import layout
from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import take_peaks
from overview_dsp.live.output.stream_opener import StreamOpener
from overview_dsp.live.session.active_window import NEAR, ActiveWindow
from overview_dsp.live.session.finger import Finger
from overview_dsp.live.session.growing import Growing, Growth
from overview_dsp.live.session.loop import Loop
from overview_dsp.live.session.presets import PresetPair, PresetWatch
from overview_dsp.live.session.session import Session
from overview_dsp.live.session.status import Status
from overview_dsp.live.takes.takes import Takes, timeline_beside
from overview_dsp.signal.actuators.stage import read_protection
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.angle_map import SHARE


class Player:
    """A timeline that is played live.

    Attributes
    ----------
    engine : Engine
        Prepared.
    output : ReconnectingStream
        What runs it.
    active_window : ActiveWindow
        The part of the timeline that is felt, and the presets.
    finger : Finger
        Of mouse and keys.
    takes : Takes
        The one that is recorded, and those that were ended.
    loop : Loop
        The gesture that is replayed.
    growing : Growing or None
        What brings a timeline that grows; None for one that is finished.
    asked : deque of tuple of str
        Commands that are waiting for `commands.poll`.
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
        growth: Growth | None = None,
    ) -> None:
        """Open the output and begin to play; `opener` is called again if that is lost.

        `record` is where the takes go; with it, the first one begins at once. `other` is the second
        preset to switch to. With `growth` the timeline, which is its snapshot, grows.

        Raises
        ------
        OverviewError
            The output can't be opened, or the take not written.
        """
        self._callback, self._max_block_size = callback, max_block_size
        self.asked: deque[tuple[str, ...]] = deque()
        self.engine = Engine(watch.preset, timeline, seed=seed)
        self.engine.prepare(sample_rate, max_block_size)
        session = self._session = Session(self.engine)
        self.say, self.take_messages = session.say, session.take_messages
        self._presets = PresetPair(watch, other)
        window = self.active_window = ActiveWindow(session, timeline, self._presets)
        self.takes = Takes(session, record)
        self.growing = None if growth is None else Growing(session, growth, window)
        self.output = ReconnectingStream(session, opener, settings)
        self.finger = Finger(session, self.output)
        self.loop = Loop(session, self.output, window, self._end_before_restart)
        try:
            self.output.open((lambda: None) if record is None else self._begin_first_take)
        except BaseException:
            self.takes.end()
            raise

    # --- the finger -----------------------------------------------------------------------------

    def touch(self, position: float) -> None:
        """Hold at `position` (0 to 1): a tap if it wasn't down, else it moves there.

        It ends a replay: one input at a time.
        """
        self.loop.stop()
        self.finger.touch(position)

    def release(self) -> None:
        """Release: the disk arrives where it was pulled, then it recoils."""
        self.finger.release()

    def tap(self, position: float) -> None:
        """Step to `position` and release at once (paper, figure 6)."""
        self.loop.stop()
        self.finger.tap(position)

    # --- the window and the presets -------------------------------------------------------------

    @property
    def timeline(self) -> Timeline:
        """The whole."""
        return self.active_window.timeline

    @property
    def window(self) -> tuple[float, float]:
        """The part of it that is felt, start and end, s."""
        return self.active_window.window

    @property
    def shown(self) -> Timeline:
        """That part, from 0."""
        return self.active_window.shown

    def moment_s(self, position: float) -> float:
        """Return the moment of the whole, s, at a position of the window, 0 to 1."""
        return self.active_window.moment_s(position)

    def show(self, start_s: float, end_s: float) -> None:
        """Make a part of the timeline the window; InputError if it isn't one."""
        self.active_window.show(start_s, end_s)

    def zoom(self, factor: float, about: float) -> None:
        """Show `factor` times as much detail about the moment under `about` (0 to 1).

        A finger that holds stays on that moment: it goes along where no window has it at `about`.
        """
        position = self.active_window.zoom(factor, about)
        if self.finger.holding and abs(position - about) > NEAR:
            self._set_down(position)

    def go_to_event(self, direction: int, position: float) -> None:
        """Touch the event after (1) or before (-1) a position of the window, in it or beyond."""
        beside = self.active_window.event_beside(direction, position)
        if beside is not None:
            self._set_down(beside)

    def _set_down(self, position: float) -> None:
        """Touch again, so that the disk arrives: it isn't held back by the backlash."""
        self.release()
        self.touch(position)

    def use_preset(self, name: str) -> None:
        """Change to another preset, by name or path, and watch its file; InputError."""
        preset = self._presets.replace(PresetWatch(name, self._presets.linear))
        self.active_window.use(preset)

    def choose_preset(self, which: int) -> None:
        """Change to the first (0) or the second (1) preset: at the loop's start, else at once.

        Chosen twice, it is at once also within a loop.
        """
        again = self._presets.waiting == which
        if self.loop.playing and not again:
            self._presets.waiting = which
            self.say(f"{self._presets.words(which)}: from the loop's start on; again: at once")
            return
        self.say(f"now {self._presets.words(which)}")
        self.active_window.use(self._presets.choose(which))

    # --- the output -----------------------------------------------------------------------------

    def reopen(
        self,
        opener: StreamOpener | None = None,
        settings: OutputSettings | None = None,
        sample_rate: float | None = None,
    ) -> None:
        """Change to another output, other settings of it, another rate (which ends a take).

        Raises
        ------
        OverviewError
            It can't be opened; the present one plays on.
        """
        output, engine = self.output, self.engine
        before = output.opener, output.settings, engine.sample_rate
        self.loop.stop()
        self.release()
        try:
            self._open_another(opener or output.opener, settings or output.settings, sample_rate)
        except OverviewError:
            with contextlib.suppress(OverviewError):  # it is tried again at every poll
                self._open_another(*before)
            raise
        self.say(
            f"output {output.name}, {engine.sample_rate:g} Hz, {output.block_size} frames, "
            f"{output.settings.placed}"
        )

    def _open_another(
        self, opener: StreamOpener, settings: OutputSettings, sample_rate: float | None
    ) -> None:
        output = self.output
        output.give_back()
        output.opener, output.settings = opener, settings
        if sample_rate is not None and sample_rate != self.engine.sample_rate:
            self.takes.end()
            self._session.keep_counts()
            self.engine.prepare(sample_rate, self._max_block_size)
        output.open()

    # --- the session ----------------------------------------------------------------------------

    def ask(self, *words: str) -> None:
        """Have a command done at the next `commands.poll`; from any thread."""
        self.asked.append(words)

    def poll(self) -> Status:
        """Do everything that is due; return the status of the session."""
        playing = self.output.playing
        if self.growing is not None and not self.loop.playing and playing:
            self.growing.poll(self.finger.holding)
        self.active_window.poll()
        self.output.poll()
        if self.output.playing:
            self.loop.poll(self.at_rest)
        elif playing:
            self.release()
        return self._status()

    def _status(self) -> Status:
        engine, output = self.engine, self.output
        meters = engine.meters
        click, tactor = take_peaks(engine.memory)
        driven = output.settings.actuator
        return Status(
            time_s=self._session.played_s,
            cursor=meters.cursor,
            finger=self.finger.position,
            touching=meters.touching and output.playing,
            torque=meters.torque,
            full_torque=engine.preset.number("tactor.full_torque_mnm") * 1e-3,
            envelope=meters.envelope,
            strikes=meters.strikes,
            peak_click=click,
            peak_tactor=tactor,
            stream=output.meters,
            frames_lost=output.frames_lost,
            dropped=self._session.dropped_events,
            output=output.name,
            callback=self._callback,
            sample_rate=engine.sample_rate,
            block_size=output.block_size,
            settings=output.settings,
            protected=None if driven is None else read_protection(engine.memory, layout.L_ACTUATOR),
            recording=None if self.takes.growing is None else str(self.takes.growing),
            replay=self.loop.words,
            following=None if self.growing is None else self.growing.words,
            messages=self.take_messages(),
        )

    @property
    def at_rest(self) -> bool:
        """Whether the disk lies still and nothing sounds, for a twentieth of a second."""
        meters = self.engine.meters
        quiet = 0.05 * self.engine.sample_rate
        return min(meters.silent_samples, meters.still_samples) >= quiet

    def close(self) -> None:
        """Release, fade out, close the output and save the take; may be called twice.

        Raises
        ------
        InputError, OutputError
            The take can't be written.
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
    def _grown(self) -> Timeline | None:
        """The timeline as it is now, if no file holds it."""
        return None if self.growing is None else self.timeline

    @property
    def _about(self) -> dict[str, Any]:
        """Notes in the head of a take."""
        preset = self._presets.preset
        return {
            "title": self.timeline.title,
            "preset": preset.name,
            "angle_map": preset.number(SHARE),
        }

    def _begin_first_take(self) -> None:
        self.takes.begin(self._about, self._grown)

    def toggle_take(self) -> None:
        """Begin a take, or end the one that is recorded."""
        path = self.takes.growing
        if path is not None:
            try:
                self.takes.end()
            except OverviewError as error:
                self.say(str(error))
            else:
                self.say(f"{path}: the take; P plays it again")
            return
        if self.loop.playing or (self.at_rest and self.engine.active_input is None):
            self.loop.forget()
            self._begin_exact_take()
        if self.takes.growing is None:
            # what holds at its first sample, and isn't in the timeline and the preset as named
            before: list[Mapping[str, Any]] = []
            if self.window != self._whole:
                before.append({"window": list(self.window)})
            if self.engine.preset != self._presets.preset:
                before.append({"preset": preset_to_dict(self.engine.preset)})
            self.takes.begin_later(self._about, before, self._grown)

    def _begin_exact_take(self) -> None:
        """Begin a take with an engine that begins again, which nobody notices while it rests.

        It begins on what is named, and what differs from that changes in its first sample.
        """
        window, preset = self.window, self.active_window.take_wish()

        def begin() -> None:
            self.takes.begin_later(self._about, [], self._grown)
            if window != self._whole:
                self.active_window.put_at(window, 0)
            if preset != self.engine.preset:
                self.engine.set_preset(preset, 0)

        self.loop.restart(self.timeline, self._whole, self._presets.preset, begin)

    def _end_before_restart(self) -> None:
        """End what can't go on with an engine that begins again."""
        self.takes.end()
        self.finger.holding = False
        if self.growing is not None:
            self.growing.restarted()

    def toggle_replay(self) -> None:
        """Replay the last take again and again, or stop that."""
        if self.loop.playing:
            self.loop.stop()
            return
        if self.takes.growing is not None:
            self.toggle_take()
        if not self.takes.ended:
            self.say("nothing to replay yet: R begins a take, and ends it")
            return
        path = Path(self.takes.ended[-1])
        beside = timeline_beside(path)
        try:
            gesture = load_gesture(path)
            whole = load_timeline(beside) if beside.exists() else None
        except InputError as error:
            self.say(str(error))
        else:
            self.loop.begin(gesture, path.name, whole=whole)
