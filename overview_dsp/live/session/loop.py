"""Loop: repeated replay of a gesture, each time with a restarted engine.

Each pass is therefore bit-identical to an offline render of the gesture.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.inputs.takes_and_lines import TakeInput
from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.session.active_window import ActiveWindow
from overview_dsp.live.session.session import Session
from overview_dsp.signal.engine.coefficients import check_carrier
from overview_dsp.signal.surface.build import build_surface

REPLAYED = {"window", "timeline", "pattern"}
"""Changes of a take that are replayed. Its parameters and presets are replaced by present ones."""

LONGEST_TAIL_S = 5.0
"""Time after the gesture's end at which a pass ends even if the disk still moves."""


class Loop:
    """Restarts the session's engine for each pass of a gesture, and for other callers.

    Thread: control.

    `passes`: number of passes of the present gesture that have started.
    """

    def __init__(
        self,
        session: Session,
        output: ReconnectingStream,
        window: ActiveWindow,
        end_others: Callable[[], None],
        release: Callable[[], None],
    ) -> None:
        """Use `end_others` to end a take and a touch before the engine restarts.

        `release` releases the disk of an engine that could not restart.
        """
        self._session, self._output, self._window = session, output, window
        self._end_others, self._release = end_others, release
        self._gesture: Gesture | None = None
        self.passes = 0

    @property
    def playing(self) -> bool:
        """State of the loop: True while it replays a gesture."""
        return self._gesture is not None

    @property
    def status_text(self) -> str | None:
        """Name and pass of the replayed gesture, for display; None without a replay."""
        return f"{self._name}, pass {self.passes}" if self.playing else None

    def begin(
        self, gesture: Gesture, name: str, repeats: bool = True, whole: Timeline | None = None
    ) -> None:
        """Replay a gesture with the present preset, each pass from the engine's first sample.

        The windows of a take are replayed, and so are the updates of a live timeline. `whole` is
        the timeline that they start from (None: the present one). Parameters and presets of the
        take are ignored. A pass is bit-identical to its offline render unless the user changes
        something during it.
        """
        kept = tuple(change for change in gesture.changes if REPLAYED & change.what.keys())
        if ignored := len(gesture.changes) - len(kept):
            self._session.say(f"{name}: {ignored} changes of parameters and presets are ignored")
        self._gesture = replace(gesture, changes=kept)
        self._name, self._repeats, self.passes = name, repeats, 0
        self._whole = whole or self._window.timeline
        self._input = TakeInput(self._gesture)
        self._start_pass(self._gesture)

    def _start_pass(self, gesture: Gesture) -> None:
        window, whole = self._window, self._whole
        preset, next_choice = window.pop_requested_preset(), window.presets.next_choice
        if next_choice is not None:
            preset = window.presets.choose(next_choice)

        def first() -> None:
            self.passes += 1
            if gesture.changes:
                window.timeline = whole
            self._input = TakeInput(gesture, window.apply_take_change)
            self._input.begin(self._session.engine, 0, whole)

        if gesture.changes:  # the window is one of the changes
            self.restart(whole, (0.0, whole.duration_s), preset, first)
        else:
            self.restart(window.window_timeline, window.window, preset, first)

    def poll(self, at_rest: bool) -> None:
        """Send events that are due; start the next pass, or end, once the disk is at rest."""
        gesture, engine = self._gesture, self._session.engine
        if gesture is None:
            return
        self._input.poll(engine)
        latest = round((gesture.duration_s + LONGEST_TAIL_S) * engine.sample_rate)
        if not self._input.is_over(engine) or not (at_rest or engine.sample_time > latest):
            return
        if self._repeats:
            self._start_pass(gesture)
        else:
            self._gesture = None

    def stop(self) -> None:
        """End the replay and restart the engine."""
        if self.playing:
            self._gesture = None
            window = self._window
            self.restart(window.window_timeline, window.window, window.pop_requested_preset())

    def cancel(self) -> None:
        """End the replay without a restart of the engine, which the caller restarts."""
        self._gesture = None

    def restart(
        self,
        timeline: Timeline,
        window: tuple[float, float],
        preset: Preset,
        first: Callable[[], None] = lambda: None,
    ) -> None:
        """Restart the engine while its output plays; call `first` before its first sample.

        Without an output this does nothing. An output that doesn't respond causes a message.
        """
        if not self._output.playing:
            return
        engine = self._session.engine
        try:
            check_carrier(preset, engine.sample_rate)
            surface = build_surface(timeline, preset)  # before the fade, which it would prolong
        except InputError as error:
            self._session.say(f"{error}; the previous preset stays active")
            preset = engine.preset
            surface = build_surface(timeline, preset)

        def begin() -> None:
            self._session.keep_counts()
            engine.restart(preset, timeline, seed=engine.seed, surface=surface)
            self._window.set_current(timeline, window)
            first()

        self._end_others()
        if not self._output.restart(begin):
            self.cancel()  # the engine goes on in its earlier state
            self._release()
