"""What sounds at the host while pages hold the disk: a player of `live`, reached over the network.

Thread: `poll` is the control thread's, everything else the server's.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from overview_dsp.design.presets.model import Preset
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.session.player import Player
from overview_dsp.signal.engine.coefficients import check_carrier
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.web.hands import RemoteHands


class HostSession(Input):
    """A player under remote hands; also the input that `headless.run` and the screen poll."""

    def __init__(self, player: Player, other: Input | None = None) -> None:
        """`other` is a second input of the session, whose end is the session's."""
        self.hands = RemoteHands(player.engine)
        self._player = player
        self._other = other
        self._wanted: deque[tuple[float, float]] = deque(maxlen=1)
        self._presets: deque[Preset] = deque(maxlen=1)

    def show(self, start_s: float, end_s: float) -> None:
        """Put a part of the timeline under the hand soon; InputError if it isn't one."""
        self._wanted.append(self._player.timeline.require_window(start_s, end_s))

    def use(self, preset: Preset) -> None:
        """Change to a preset soon, gliding and crossfaded; InputError if it can't sound here."""
        check_carrier(preset, self._player.engine.sample_rate)
        build_surface(self._player.shown, preset)  # refused here, where the error reaches the page
        self._presets.append(preset)

    def status(self) -> dict[str, Any]:
        """How the disk is, for a page."""
        player = self._player
        meters = player.engine.meters
        return {
            "cursor": round(meters.cursor, 6),
            "touching": meters.touching,
            "torque_nm": meters.torque,
            "envelope": round(meters.envelope, 4),
            "full_torque_nm": player.engine.preset.number("tactor.reference_torque_mnm") * 1e-3,
            "window": list(player.window),
            "preset": player.engine.preset.name,
            "output_ms": round(player.output.meters.latency_s * 1e3, 2),
        }

    def poll(self, engine: Engine) -> None:
        """Do what pages asked for."""
        if self._other is not None:
            self._other.poll(engine)
        while self._wanted:
            self._player.show(*self._wanted.popleft())
        if self._presets:
            self._player.active_window.use(self._presets.popleft())

    def is_over(self, engine: Engine) -> bool:
        """Whether the other input is over; without one it never is."""
        return self._other is not None and self._other.is_over(engine)

    def take_messages(self) -> tuple[str, ...]:
        """The other input's."""
        return () if self._other is None else self._other.take_messages()

    @property
    def words(self) -> str:
        """The other input's."""
        return "" if self._other is None else self._other.words

    def report(self) -> Mapping[str, Any]:
        """The other input's."""
        return {} if self._other is None else self._other.report()
