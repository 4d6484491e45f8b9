"""What sounds at the host while pages hold the disk: a player of `live`, reached over the network.

Thread: `poll` is the control thread's, everything else the server's.
"""

from __future__ import annotations

from collections import deque
from typing import Any

from overview_dsp.engine import Engine
from overview_dsp.live.player import Input, Player
from overview_dsp.web.hands import RemoteHands


class HostSession:
    """A player under remote hands; also the input that `headless.run` and the screen poll."""

    def __init__(self, player: Player, other: Input | None = None) -> None:
        """`other` is a second input of the session, whose end is the session's."""
        self.hands = RemoteHands(player.engine)
        self._player = player
        self._other = other
        self._wanted: deque[tuple[float, float]] = deque(maxlen=1)

    def show(self, start_s: float, end_s: float) -> None:
        """Put a part of the timeline under the hand soon; InputError if it isn't one."""
        self._wanted.append(self._player.timeline.require_window(start_s, end_s))

    def status(self) -> dict[str, Any]:
        """How the disk is, for a page."""
        player = self._player
        meters = player.engine.meters
        return {
            "cursor": round(meters.cursor, 6),
            "touching": meters.touching,
            "torque_nm": meters.torque,
            "full_torque_nm": player.preset.number("tactor.full_torque_mnm") * 1e-3,
            "window": list(player.window),
            "output_ms": round(player.latency_s * 1e3, 2),
        }

    def poll(self, engine: Engine) -> None:
        """Do what pages asked for."""
        if self._other is not None:
            self._other.poll(engine)
        while self._wanted:
            self._player.show(*self._wanted.popleft())

    def is_over(self, engine: Engine) -> bool:
        """Whether the other input is over; without one it never is."""
        return self._other is not None and self._other.is_over(engine)
