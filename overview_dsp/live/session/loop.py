"""Loop: a gesture that is replayed pass after pass, each from the first sample of an engine as new.

So each pass is bit-identical to the same gesture rendered offline, whatever was felt before it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.inputs.lines import TakeInput
from overview_dsp.live.output.reconnecting_stream import ReconnectingStream
from overview_dsp.live.session.active_window import ActiveWindow
from overview_dsp.live.session.session import Session
from overview_dsp.signal.engine.coefficients import check_carrier
from overview_dsp.signal.surface.build import build_surface

KEPT = {"window", "timeline", "pattern"}
"""Changes of a take that are replayed; parameters and presets are chosen anew."""

LONGEST_TAIL_S = 5.0
"""A disk that isn't at rest so long after the gesture's end doesn't keep the loop."""


class Loop:
    """Begins the session's engine again, for a pass of a gesture or for anything else.

    Thread: control.

    Attributes
    ----------
    passes : int
        Begun so far of the present gesture.
    """

    def __init__(
        self,
        session: Session,
        output: ReconnectingStream,
        window: ActiveWindow,
        end_others: Callable[[], None],
    ) -> None:
        """`end_others` ends what can't go on with an engine as new: a take, a finger."""
        self._session, self._output, self._window = session, output, window
        self._end_others = end_others
        self._gesture: Gesture | None = None
        self.passes = 0

    @property
    def playing(self) -> bool:
        """Whether a gesture is replayed."""
        return self._gesture is not None

    @property
    def words(self) -> str | None:
        """Text for the user on what is replayed; None for nothing."""
        return f"{self._name}, pass {self.passes}" if self.playing else None

    def begin(
        self, gesture: Gesture, name: str, repeats: bool = True, whole: Timeline | None = None
    ) -> None:
        """Replay a gesture with the present preset, each pass from the engine's first sample.

        A take's windows are shown again, and a timeline that grew grows again, from `whole` on
        (None: the present one); its parameters and presets are left out. Each pass in which nothing
        is changed is bit-identical to its offline render.
        """
        kept = tuple(change for change in gesture.changes if KEPT & change.what.keys())
        if left_out := len(gesture.changes) - len(kept):
            self._session.say(f"{name}: {left_out} changes of parameters and presets are left out")
        self._gesture = replace(gesture, changes=kept)
        self._name, self._repeats, self.passes = name, repeats, 0
        self._whole = whole or self._window.timeline
        self._input = TakeInput(self._gesture)
        self._begin_pass(self._gesture)

    def _begin_pass(self, gesture: Gesture) -> None:
        window, whole = self._window, self._whole
        preset, waiting = window.take_wish(), window.presets.waiting
        if waiting is not None:
            preset = window.presets.choose(waiting)

        def first() -> None:
            self.passes += 1
            if gesture.changes:
                window.timeline = whole
            self._input = TakeInput(gesture, window.change_at)
            self._input.begin(self._session.engine, 0, whole)

        if gesture.changes:  # they say themselves what is shown
            self.restart(whole, (0.0, whole.duration_s), preset, first)
        else:
            self.restart(window.shown, window.window, preset, first)

    def poll(self, at_rest: bool) -> None:
        """Hand over what is due; begin the next pass, or end, once the disk is at rest."""
        gesture, engine = self._gesture, self._session.engine
        if gesture is None:
            return
        self._input.poll(engine)
        latest = round((gesture.duration_s + LONGEST_TAIL_S) * engine.sample_rate)
        if not self._input.is_over(engine) or not (at_rest or engine.sample_time > latest):
            return
        if self._repeats:
            self._begin_pass(gesture)
        else:
            self._gesture = None

    def stop(self) -> None:
        """End the replay, with the engine as new."""
        if self.playing:
            self._gesture = None
            self.restart(self._window.shown, self._window.window, self._window.take_wish())

    def forget(self) -> None:
        """End the replay: the engine is about to begin again."""
        self._gesture = None

    def restart(
        self,
        timeline: Timeline,
        window: tuple[float, float],
        preset: Preset,
        first: Callable[[], None] = lambda: None,
    ) -> None:
        """Begin the engine again while its output plays; `first` is called before its first sample.

        Without an output nothing is done, nor if that doesn't answer: then a message is shown.
        """
        if not self._output.playing:
            return
        engine = self._session.engine
        try:
            check_carrier(preset, engine.sample_rate)
            surface = build_surface(timeline, preset)  # while it still sounds
        except InputError as error:
            self._session.say(f"{error}; the last good one plays on")
            preset = engine.preset
            surface = build_surface(timeline, preset)

        def begin() -> None:
            self._session.keep_counts()
            engine.restart(preset, timeline, seed=engine.seed, surface=surface)
            self._window.put(timeline, window)
            first()

        self._end_others()
        self._output.restart(begin)
