"""A session's engine as new, while its output plays: what is counted goes on.

Thread: control.
"""

from __future__ import annotations

from collections.abc import Callable

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.session_output import SessionOutput
from overview_dsp.live.under_hand import UnderHand
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
