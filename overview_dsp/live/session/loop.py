"""A hand that is played again and again, each time from the engine's first sample on.

So each pass sounds as the same gesture rendered offline, to the bit, whatever was felt before it.

A session's engine as new, while its output plays: what is counted goes on.

Thread: control.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.inputs.lines import TakeInput
from overview_dsp.live.output.reconnecting_stream import SessionOutput
from overview_dsp.live.session.view import UnderHand
from overview_dsp.signal.engine.coefficients import check_carrier
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.build import build_surface


class FreshStart:
    """Begins an engine anew, and adds up what it counts from 0 each time."""

    def __init__(
        self,
        engine: Engine,
        output: SessionOutput,
        under_hand: UnderHand,
        let_go: Callable[[], None],
        say: Callable[[str], None],
    ) -> None:
        """`let_go` ends what can't go on with another engine: a take, a finger."""
        self._engine = engine
        self._output = output
        self._under_hand = under_hand
        self._let_go = let_go
        self._say = say
        self._before_s = 0.0
        self._dropped_before = 0

    @property
    def played_s(self) -> float:
        """How long it has played since the session began, s."""
        return self._before_s + self._engine.sample_time / self._engine.sample_rate

    @property
    def dropped_events(self) -> int:
        """Control events dropped since the session began."""
        return self._dropped_before + self._engine.meters.dropped_events

    def count(self) -> None:
        """The engine is about to count from 0 again."""
        self._before_s, self._dropped_before = self.played_s, self.dropped_events

    def begin(
        self,
        timeline: Timeline,
        window: tuple[float, float],
        preset: Preset,
        first: Callable[[], None] = lambda: None,
    ) -> None:
        """Begin with the engine's first sample on these; `first` is called ahead of it.

        Without an output nothing is done, and neither if it doesn't answer, which is told.
        """
        if not self._output.playing:
            return
        try:
            check_carrier(preset, self._engine.sample_rate)
            surface = build_surface(timeline, preset)  # while it still sounds
        except InputError as error:
            self._say(f"{error}; the last good one plays on")
            preset = self._engine.preset
            surface = build_surface(timeline, preset)

        def anew() -> None:
            self.count()
            self._engine.restart(preset, timeline, seed=self._engine.seed, surface=surface)
            self._under_hand.put(timeline, window)
            first()

        self._let_go()
        self._output.restart(anew)


KEPT = {"window", "timeline", "pattern"}
"""Of a take's changes those of what lies under the hand; parameters and presets are whoever plays
it again's to choose."""

LONGEST_TAIL_S = 5.0
"""A disk that isn't at rest so long after the hand's end doesn't keep the loop."""


class Replay:
    """A hand and what lay under it, pass by pass.

    Thread: control.

    Attributes
    ----------
    loop : bool
        Whether another pass follows the last.
    passes : int
        Begun so far.
    """

    def __init__(self, gesture: Gesture, name: str, loop: bool, whole: Timeline) -> None:
        """`whole` is the timeline that each pass begins on."""
        kept = tuple(change for change in gesture.changes if KEPT & change.what.keys())
        self._gesture = replace(gesture, changes=kept)
        self._whole = whole
        self._name = name
        self.loop = loop
        self.passes = 0
        self._input = TakeInput(self._gesture)

    @property
    def words(self) -> str:
        """What is played, for a person."""
        return f"{self._name}, pass {self.passes}"

    def first(self, under_hand: UnderHand) -> tuple[Timeline, tuple[float, float]]:
        """What each pass begins on: the whole, for a take that says itself what is shown."""
        if self._gesture.changes:
            return self._whole, (0.0, self._whole.duration_s)
        return under_hand.shown, under_hand.window

    def begin(self, engine: Engine, under_hand: UnderHand) -> None:
        """Begin a pass with an engine that is as new and that nothing runs yet."""
        self.passes += 1
        if self._gesture.changes:
            under_hand.timeline = self._whole
        self._input = TakeInput(self._gesture, under_hand.change_at)
        self._input.begin(engine, 0, self._whole)

    def poll(self, engine: Engine) -> None:
        """Hand over what is due soon."""
        self._input.poll(engine)

    def is_over(self, engine: Engine, at_rest: bool) -> bool:
        """Whether the pass is: the hand has ended, and the disk is at rest."""
        rate = engine.sample_rate
        latest = round((self._gesture.duration_s + LONGEST_TAIL_S) * rate)
        return self._input.is_over(engine) and (at_rest or engine.sample_time > latest)


class Replaying:
    """Begins a hand's passes, one after the other, under the preset that is chosen.

    Thread: control.

    Attributes
    ----------
    now : Replay or None
        What is played.
    """

    def __init__(
        self, engine: Engine, under_hand: UnderHand, fresh: FreshStart, say: Callable[[str], None]
    ) -> None:
        """`say` tells the person."""
        self._engine = engine
        self._under_hand = under_hand
        self._fresh = fresh
        self._say = say
        self.now: Replay | None = None

    def begin(self, gesture: Gesture, name: str, loop: bool, whole: Timeline | None) -> None:
        """Play a hand; of a take's changes those of `KEPT`, on `whole` (None: the present one)."""
        left_out = sum(not KEPT & change.what.keys() for change in gesture.changes)
        if left_out:
            self._say(f"{name}: {left_out} changes of parameters and presets are left out")
        self.now = Replay(gesture, name, loop, whole or self._under_hand.timeline)
        self._begin_pass(self.now)

    def poll(self, at_rest: bool) -> None:
        """Hand over what is due; begin the next pass, or end."""
        replay = self.now
        if replay is None:
            return
        replay.poll(self._engine)
        if replay.is_over(self._engine, at_rest):
            if replay.loop:
                self._begin_pass(replay)
            else:
                self.now = None

    def stop(self) -> None:
        """Let go, and be as new."""
        if self.now is not None:
            self.now = None
            under = self._under_hand
            self._fresh.begin(under.shown, under.window, under.take_wish())

    def forget(self) -> None:
        """Nothing is played any more: the engine is about to begin anew."""
        self.now = None

    def _begin_pass(self, replay: Replay) -> None:
        under = self._under_hand
        preset, waiting = under.take_wish(), under.presets.waiting
        if waiting is not None:
            preset = under.presets.choose(waiting)
        self._fresh.begin(
            *replay.first(under),
            preset,
            lambda: replay.begin(self._engine, under),
        )
