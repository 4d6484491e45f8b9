"""Actuators: profiles of tactors, voice coils and headphones, with the limits of their drive.

`ov.actuators` loads profiles, drives actuators within their limits and stores the threshold of the
user's sensation. Each name is imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> c2 = ov.actuators.load("c2")
>>> round(c2.resonance_hz), round(c2.rise_ms)
(250, 33)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.public import lazy_names

if TYPE_CHECKING:
    from overview_dsp.signal.actuators.calibration import (
        apply_calibration,
        forget_threshold,
        save_threshold,
    )
    from overview_dsp.signal.actuators.library import actuator_names as names
    from overview_dsp.signal.actuators.library import load_actuator as load
    from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS as PARAMETERS
    from overview_dsp.signal.actuators.model import Actuator
    from overview_dsp.signal.actuators.stage import ActuatorStage, ProtectionReport
    from overview_dsp.signal.actuators.sweep import log_sweep

__all__ = [
    "PARAMETERS",
    "Actuator",
    "ActuatorStage",
    "ProtectionReport",
    "apply_calibration",
    "forget_threshold",
    "load",
    "log_sweep",
    "names",
    "save_threshold",
]

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "PARAMETERS": "model:ACTUATOR_PARAMETERS",
            "Actuator": "model",
            "ActuatorStage": "stage",
            "ProtectionReport": "stage",
            "apply_calibration": "calibration",
            "forget_threshold": "calibration",
            "load": "library:load_actuator",
            "log_sweep": "sweep",
            "names": "library:actuator_names",
            "save_threshold": "calibration",
        },
    )
