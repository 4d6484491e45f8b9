"""Lines of JSON objects: `{"t_us": 1000, "ax": 0.0, "ay": 0.0, "az": 9.81}`.

Keys are the names of `COLUMNS`; `acc` and `gyr` with three numbers are short for the six axes.
Other keys are left alone, so that a device may say more.
"""

from __future__ import annotations

import json
import math
from typing import Any

from overview_dsp.devices.sensors.reading import ACCELERATION, ANGULAR_VELOCITY, COLUMNS, Reading

_THREES = {"acc": ACCELERATION, "gyr": ANGULAR_VELOCITY}


def reading_of(line: str) -> Reading | None:
    """The reading of a line; None if it is none."""
    try:
        said = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(said, dict):
        return None
    given: dict[str, Any] = {name: value for name, value in said.items() if name in COLUMNS}
    for short, names in _THREES.items():
        if short in said:
            if not isinstance(said[short], list) or len(said[short]) != len(names):
                return None
            given.update(zip(names, said[short], strict=True))
    if not given or not all(_is_number(value) for value in given.values()):
        return None
    return {name: float(value) for name, value in given.items()}


def _is_number(value: object) -> bool:
    # a bool is a number too: touch may be true or false
    return isinstance(value, int | float) and -1e300 < value < 1e300 and math.isfinite(value)
