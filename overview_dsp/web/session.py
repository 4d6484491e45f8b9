"""Live session that pages control over the network.

Thread: `poll` runs in the control thread, everything else in the server's.
"""

from __future__ import annotations

from collections import deque
from typing import Any

from overview_dsp.design.presets.model import Preset
from overview_dsp.live.inputs.input import CombinedInput, Input
from overview_dsp.live.session.player import Player
from overview_dsp.signal.engine.coefficients import check_carrier
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.web.remote_inputs import RemoteInputs


class HostSession(CombinedInput):
    """Player that pages control; also the input that `headless.run` and the screen poll.

    This is the second input of the session, if there is one, and the requests of pages.
    """

    def __init__(self, player: Player, other: Input | None = None) -> None:
        """Control `player`; the session ends with the second input `other`, if there is one."""
        super().__init__({} if other is None else {"other": other})
        self.inputs = RemoteInputs(player.engine)
        self.player = player
        self._windows: deque[tuple[float, float]] = deque(maxlen=1)
        self._presets: deque[Preset] = deque(maxlen=1)

    def show(self, start_s: float, end_s: float) -> None:
        """Show a window at the next poll; raise InputError for an invalid window."""
        self._windows.append(self.player.timeline.require_window(start_s, end_s))

    def use(self, preset: Preset) -> None:
        """Change the preset at the next poll; raise InputError if the engine can't play it."""
        check_carrier(preset, self.player.engine.sample_rate)
        # here an error reaches the page
        build_surface(self.player.active_window.window_timeline, preset)
        self._presets.append(preset)

    def status(self) -> dict[str, Any]:
        """Return the state of the disk for a page."""
        player, preset = self.player, self.player.engine.preset
        meters = player.engine.meters
        return {
            "cursor": round(meters.cursor, 6),
            "touching": meters.touching,
            "torque_nm": meters.torque,
            "envelope": round(meters.envelope, 4),
            "reference_torque_nm": 1e-3 * preset.number("tactor.reference_torque_mnm"),
            "window": list(player.window),
            "preset": preset.name,
            "output_ms": round(player.output.meters.latency_s * 1e3, 2),
        }

    def poll(self, engine: Engine) -> None:
        """Poll the other input, and apply the requests of pages."""
        super().poll(engine)
        while self._windows:
            self.player.show(*self._windows.popleft())
        if self._presets:
            self.player.active_window.use(self._presets.popleft())

    def is_over(self, engine: Engine) -> bool:
        """Return whether the other input has ended; without one, False."""
        return bool(self._inputs) and super().is_over(engine)

    def report(self) -> dict[str, Any]:
        """Return the report of the other input."""
        return dict(super().report().get("other", {}))
