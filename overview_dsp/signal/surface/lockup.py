"""What holds the disk against all that its springs can pull."""

from __future__ import annotations

import math
import warnings

from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewWarning


def warn_of_lockup(preset: Preset, name: str, torque: float, lower: str) -> None:
    """Warn (OverviewWarning) if a torque (N m) can never be overcome by the finger's shaft.

    `name` is what holds, `lower` what to lower.
    """
    most = preset.number("disk.k2") * math.pi
    if torque >= most:
        warnings.warn(
            f"{name} holds the disk against {torque * 1e3:.3g} mN·m, and shaft 2 pulls with "
            f"{most * 1e3:.3g} mN·m at most: stuck there it stays; lower {lower}, or raise disk.k2",
            OverviewWarning,
            stacklevel=5,
        )
