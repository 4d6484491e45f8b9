"""How often something comes, over the latest second."""

from __future__ import annotations

WINDOW_S = 1.0


class Rate:
    """Moments in, their rate out.

    Attributes
    ----------
    hz : float or None
        Of the latest whole second; None before the first.
    """

    def __init__(self) -> None:
        """Nothing has come yet."""
        self.hz: float | None = None
        self._since: float | None = None
        self._count = 0

    def add(self, now_s: float) -> None:
        """It came."""
        if self._since is None:
            self._since = now_s
            return
        self._count += 1
        if now_s - self._since >= WINDOW_S:
            self.hz = self._count / (now_s - self._since)
            self._since, self._count = now_s, 0
