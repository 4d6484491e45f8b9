"""A live session: an engine, its output, a preset that may change, a source, a recording.

Whoever shows it (a terminal application, lines of JSON) calls `poll` often and the hand's methods
as the hand moves. The output may vanish and come back: the disk is let go, and the session goes on.

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
from overview_dsp.design.gestures import Gesture, load_gesture
from overview_dsp.design.presets.dicts import preset_to_dict
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.kernels import layout
from overview_dsp.live.output.reconnecting_stream import SessionOutput
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import OpenStream, take_peaks
from overview_dsp.live.session import commands
from overview_dsp.live.session.finger import Finger
from overview_dsp.live.session.growing import Growing, Growth
from overview_dsp.live.session.loop import FreshStart, Replaying
from overview_dsp.live.session.presets import PresetPair, PresetWatch
from overview_dsp.live.session.status import Status
from overview_dsp.live.session.view import NEAR, UnderHand
from overview_dsp.live.takes.takes import Takes, timeline_beside
from overview_dsp.signal.actuators.stage import read_protected
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.angle_map import SHARE
from overview_dsp.signal.surface.model import Surface


class Player:
    """A timeline under a live hand."""

    def __init__(
        self,
        timeline: Timeline,
        watch: PresetWatch,
        open_stream: OpenStream,
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
        """Open the output and begin to play; `open_stream` is called again if that is lost.

        `record` is where the takes go; with it, the first one begins at once. `other` is the second
        preset to switch to. With `growth` the timeline, which is its snapshot, grows.

        Raises
        ------
        OverviewError
            The output can't be opened, or the take not written.
        """
        self._callback = callback
        self._messages: deque[str] = deque()
        self._asked: deque[tuple[str, ...]] = deque()
        self.engine = Engine(watch.preset, timeline, seed=seed)
        self._max_block_size = max_block_size
        self.engine.prepare(sample_rate, max_block_size)
        self._presets = PresetPair(watch, other)
        self.under_hand = UnderHand(self.engine, timeline, self._presets, self.say)
        self._takes = Takes(self.engine, record, self.say)
        self._growing: Growing | None = None
        if growth is not None:
            self._growing = Growing(self.engine, growth, self.under_hand, self.say)
        self._output = SessionOutput(self.engine, open_stream, settings, self.say, self.release)
        self._finger = Finger(self.engine, lambda: self._output.playing)
        self._fresh = FreshStart(
            self.engine, self._output, self.under_hand, self._let_go_of_all, self.say
        )
        self._replaying = Replaying(self.engine, self.under_hand, self._fresh, self.say)
        try:
            self._output.open((lambda: None) if record is None else self._begin_first_take)
        except BaseException:
            self.end_take()
            raise

    # --- the hand -------------------------------------------------------------------------------

    def touch(self, position: float) -> None:
        """The finger holds at `position` (0 to 1): a tap if it wasn't down, else it moves there.

        It ends a replay: one hand at a time.
        """
        self.stop_replay()
        self._finger.touch(position)

    def release(self) -> None:
        """The finger releases: the disk arrives where it was pulled, then it recoils."""
        self._finger.release()

    def tap(self, position: float) -> None:
        """A step to `position` that is released at once (paper, figure 6)."""
        self.stop_replay()
        self._finger.tap(position)

    @property
    def finger(self) -> float:
        """Where the finger holds or held last, 0 to 1."""
        return self._finger.position

    @property
    def holding(self) -> bool:
        """Whether the finger is down."""
        return self._finger.holding

    # --- what is under it -----------------------------------------------------------------------

    @property
    def timeline(self) -> Timeline:
        """The whole."""
        return self.under_hand.timeline

    @property
    def window(self) -> tuple[float, float]:
        """The part of it under the hand, start and end, s."""
        return self.under_hand.window

    @property
    def growing(self) -> Growing | None:
        """What brings a timeline that grows; None for one that is finished."""
        return self._growing

    @property
    def shown(self) -> Timeline:
        """That part, from 0."""
        return self.under_hand.shown

    @property
    def preset(self) -> Preset:
        """The preset that sounds."""
        return self.engine.preset

    @property
    def surface(self) -> Surface:
        """The surface under the hand."""
        return self.engine.surface

    def moment_s(self, position: float) -> float:
        """The moment of the whole, s, at a position of the window, 0 to 1."""
        return self.under_hand.moment_s(position)

    def zoom(self, factor: float, about: float) -> None:
        """Show `factor` times as much detail about the moment under `about` (0 to 1).

        A finger that holds stays on that moment: it goes along where no window has it at `about`.
        """
        place = self.under_hand.zoom(factor, about)
        if self.holding and abs(place - about) > NEAR:
            self._set_down(place)

    def show(self, start_s: float, end_s: float) -> None:
        """Put a part of the timeline under the hand; InputError if it isn't one."""
        self.under_hand.show(start_s, end_s)

    def go_to_event(self, direction: int, position: float) -> None:
        """Touch the event after (1) or before (-1) a position of the window, in it or beyond."""
        place = self.under_hand.event_beside(direction, position)
        if place is not None:
            self._set_down(place)

    def _set_down(self, place: float) -> None:
        """Touch anew, so that the disk arrives: it isn't held back by the backlash."""
        self.release()
        self.touch(place)

    def use_preset(self, name: str) -> None:
        """Change to another preset, by name or path, and watch its file; InputError."""
        self.under_hand.use(self._presets.replace(PresetWatch(name, self._presets.linear)))

    def choose_preset(self, which: int) -> None:
        """Change to the first (0) or the second (1) preset: at the loop's start, else at once.

        Chosen twice, it is at once also within a loop.
        """
        again = self._presets.waiting == which
        if self.replaying and not again:
            self._presets.waiting = which
            self.say(f"{self._presets.words(which)}: from the loop's start on; again: at once")
            return
        self.say(f"now {self._presets.words(which)}")
        self.under_hand.use(self._presets.choose(which))

    # --- the output -----------------------------------------------------------------------------

    @property
    def outputs(self) -> OpenStream:
        """What opens the output."""
        return self._output.opened_by

    @property
    def settings(self) -> OutputSettings:
        """The output's."""
        return self._output.settings

    def set_output(self, settings: OutputSettings) -> None:
        """Change gains, mutes, delays and ceilings, gliding."""
        self._output.set(settings)

    def mute_click(self, muted: bool) -> None:
        """Silence the clicks at the device, or let them sound again."""
        self.set_output(self.settings.changed(click={"mute": muted}))

    def mute_tactor(self, muted: bool) -> None:
        """Still the tactor at the device, or let it move again."""
        self.set_output(self.settings.changed(tactor={"mute": muted}))

    def reopen(
        self,
        outputs: OpenStream | None = None,
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
        try:
            self._open_anew(outputs or self.outputs, settings or self.settings, sample_rate)
        except OverviewError:
            with contextlib.suppress(OverviewError):  # it is tried again at every poll
                self._open_anew(*before)
            raise
        rate = self.engine.sample_rate
        self.say(
            f"output {self._output.name}, {rate:g} Hz, {self._output.block_size} frames, "
            f"{self.settings.placed}"
        )

    def _open_anew(
        self, outputs: OpenStream, settings: OutputSettings, sample_rate: float | None
    ) -> None:
        output = self._output
        output.give_back()
        output.opened_by, output.settings = outputs, settings
        if sample_rate is not None and sample_rate != self.engine.sample_rate:
            self.end_take()
            self._fresh.count()
            self.engine.prepare(sample_rate, self._max_block_size)
        output.open()

    # --- how it stands --------------------------------------------------------------------------

    def poll(self) -> Status:
        """See to everything that is due; how the session stands."""
        if self._growing is not None and self._replaying.now is None and self._output.playing:
            self._growing.poll(self.holding)
        while self._asked:
            commands.do(self, *self._asked.popleft())
        self.under_hand.poll()
        self._output.poll()
        if self._output.playing:
            self._replaying.poll(self.at_rest)
        self._takes.poll()
        return self._status()

    def ask(self, *words: str) -> None:
        """Have one of `commands.COMMANDS` done at the next poll; from any thread."""
        self._asked.append(words)

    def say(self, line: str) -> None:
        """Tell the person; from any thread."""
        self._messages.append(line)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call or `poll`."""
        return tuple(self._messages.popleft() for _ in range(len(self._messages)))

    def _status(self) -> Status:
        engine, output = self.engine, self._output
        meters, stream = engine.meters, output.meters
        click, tactor = take_peaks(engine.memory)
        driven = self.settings.actuator
        return Status(
            time_s=self._fresh.played_s,
            cursor=meters.cursor,
            finger=self.finger,
            touching=meters.touching and output.playing,
            torque=meters.torque,
            full_torque=self.preset.number("tactor.full_torque_mnm") * 1e-3,
            peak_click=click,
            peak_tactor=tactor,
            callbacks=stream.callbacks,
            late=stream.late,
            underflows=stream.underflows,
            frames=stream.frames,
            frames_lost=output.frames_lost,
            dropped=self._fresh.dropped_events,
            load=stream.load,
            median_s=stream.median_s,
            p99_s=stream.p99_s,
            longest_s=stream.longest_s,
            latency_s=stream.latency_s,
            output=output.name,
            callback=self._callback,
            sample_rate=engine.sample_rate,
            block_size=output.block_size,
            click_muted=self.settings.click.mute,
            tactor_muted=self.settings.tactor.mute,
            actuator=driven,
            protected=None if driven is None else read_protected(engine.memory, layout.L_ACTUATOR),
            recording=None if self._takes.growing is None else str(self._takes.growing),
            replay=None if self._replaying.now is None else self._replaying.now.words,
            envelope=meters.envelope,
            strikes=meters.strikes,
            following=None if self._growing is None else self._growing.words,
            messages=self.take_messages(),
        )

    @property
    def latency_s(self) -> float:
        """From a sample to the output, as the device says."""
        return self._output.meters.latency_s

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
            self._output.close()
        finally:
            self.end_take()

    # --- the take -------------------------------------------------------------------------------

    @property
    def takes(self) -> list[str]:
        """The files of the takes that were ended."""
        return self._takes.ended

    @property
    def recording(self) -> bool:
        """Whether a take is written."""
        return self._takes.growing is not None

    @property
    def ended_takes(self) -> list[str]:
        """A line for the person on each of them."""
        return self._takes.words

    @property
    def _whole(self) -> tuple[float, float]:
        return 0.0, self.timeline.duration_s

    @property
    def _grown(self) -> Timeline | None:
        """The timeline as it is now, if no file holds it."""
        return None if self._growing is None else self.timeline

    @property
    def _about(self) -> dict[str, Any]:
        preset = self._presets.preset
        return {
            "title": self.timeline.title,
            "preset": preset.name,
            "angle_map": preset.number(SHARE),
        }

    def _begin_first_take(self) -> None:
        self._takes.begin(self._about, self._grown)

    def toggle_take(self) -> None:
        """Begin a take, or end the one that is recorded."""
        path = self._takes.growing
        if path is not None:
            try:
                self.end_take()
            except OverviewError as error:
                self.say(str(error))
            else:
                self.say(f"{path}: the take; P plays it again")
            return
        if self.replaying or (self.at_rest and self.engine.holder is None):
            self._replaying.forget()
            self._begin_exact_take()
        if not self.recording:
            # what holds at its first sample, and isn't in the timeline and the preset as named
            before: list[Mapping[str, Any]] = []
            if self.window != self._whole:
                before.append({"window": list(self.window)})
            if self.preset != self._presets.preset:
                before.append({"preset": preset_to_dict(self.preset)})
            self._takes.begin_later(self._about, before, self._grown)

    def _begin_exact_take(self) -> None:
        """Begin a take with an engine that begins anew, which nobody notices while it rests.

        It begins on what is named, and what differs from that changes in its first sample.
        """
        window, preset = self.window, self.under_hand.take_wish()

        def begin() -> None:
            self._takes.begin_later(self._about, [], self._grown)
            if window != self._whole:
                self.under_hand.put_at(window, 0)
            if preset != self.preset:
                self.engine.set_preset(preset, 0)

        self._fresh.begin(self.timeline, self._whole, self._presets.preset, begin)

    def _let_go_of_all(self) -> None:
        """Of what can't go on with an engine as new."""
        self.end_take()
        self._finger.forget()
        if self._growing is not None:
            self._growing.restarted()

    def end_take(self) -> None:
        """Save what is recorded; may be called from any thread, and twice; errors as `close`."""
        self._takes.end()

    # --- the same hand again ----------------------------------------------------------------------

    def toggle_replay(self) -> None:
        """Play the last take again and again, or stop that."""
        if self.replaying:
            self.stop_replay()
            return
        if self.recording:
            self.toggle_take()
        if not self.takes:
            self.say("nothing to replay yet: R begins a take, and ends it")
            return
        path = Path(self.takes[-1])
        beside = timeline_beside(path)
        try:
            gesture = load_gesture(path)
            whole = load_timeline(beside) if beside.exists() else None
        except InputError as error:
            self.say(str(error))
        else:
            self.replay(gesture, path.name, whole=whole)

    def replay(
        self, gesture: Gesture, name: str, loop: bool = True, whole: Timeline | None = None
    ) -> None:
        """Play a hand through the present preset, each time from the engine's first sample on.

        A take's windows are shown again, and a timeline that grew grows again, from `whole` on
        (None: the present one). Its parameters and presets are left out: they aren't those that are
        to be felt. Each pass in which nothing is changed sounds as it is rendered offline.
        """
        self._replaying.begin(gesture, name, loop, whole)

    @property
    def replaying(self) -> bool:
        """Whether a hand is played again."""
        return self._replaying.now is not None

    def stop_replay(self) -> None:
        """Let go, and be as new."""
        self._replaying.stop()
