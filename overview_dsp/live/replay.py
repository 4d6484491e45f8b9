"""A hand that is played again and again, each time from the engine's first sample on.

So each pass sounds as the same gesture rendered offline, to the bit, whatever was felt before it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from overview_dsp.engine.engine import Engine
from overview_dsp.gestures import Gesture
from overview_dsp.live.inputs import TakeInput
from overview_dsp.live.under_hand import UnderHand
from overview_dsp.timeline import Timeline

LONGEST_TAIL_S = 5.0
"""A disk that isn't at rest so long after the hand's end doesn't keep the loop."""


class Replay:
    """A hand and its windows, pass by pass.

    Thread: control.

    Attributes
    ----------
    loop : bool
        Whether another pass follows the last.
    passes : int
        Begun so far.
    """

    def __init__(self, gesture: Gesture, name: str, loop: bool) -> None:
        windows = tuple(change for change in gesture.changes if "window" in change.what)
        self._gesture = replace(gesture, changes=windows)
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
            return under_hand.timeline, (0.0, under_hand.timeline.duration_s)
        return under_hand.shown, under_hand.window

    def begin(
        self,
        engine: Engine,
        show: Callable[[tuple[float, float], int], None],
        whole: Timeline,
    ) -> None:
        """Begin a pass with an engine that is as new and that nothing runs yet.

        `show` puts a window under the hand at a sample.
        """
        self.passes += 1
        self._input = TakeInput(self._gesture, lambda what, at: show(tuple(what["window"]), at))
        self._input.begin(engine, 0, whole)

    def poll(self, engine: Engine) -> None:
        """Hand over what is due soon."""
        self._input.poll(engine)

    def is_over(self, engine: Engine, at_rest: bool) -> bool:
        """Whether the pass is: the hand has ended, and the disk is at rest."""
        rate = engine.sample_rate
        latest = round((self._gesture.duration_s + LONGEST_TAIL_S) * rate)
        return self._input.is_over(engine) and (at_rest or engine.sample_time > latest)
