"""What every port may say while it is read."""

from __future__ import annotations

from overview_dsp.errors import OverviewError


class PortLostError(OverviewError):
    """The device has been unplugged, or its driver gave up."""
