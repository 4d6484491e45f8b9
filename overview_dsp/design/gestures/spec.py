"""Gesture SPEC of the command line: `sweep:4+rest:2+tap:0.8:1.5`, or a take's path."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path

from overview_dsp import validation
from overview_dsp.design.gestures.model import Gesture, joined
from overview_dsp.design.gestures.scripts import arm, flick, pause, scrub, sweep, tap
from overview_dsp.design.gestures.take import load_gesture
from overview_dsp.errors import InputError

FORMS = (
    "sweep:SECONDS[:FROM:TO], tap:POSITION[:HOLD_SECONDS], arm:SECONDS[:REST_SECONDS], "
    "flick[:SECONDS], scrub:POSITION:WIDTH:HZ[:SECONDS], rest:SECONDS, or a take's path (.csv)"
)
DEFAULT = "sweep:4"  # default gesture

_MAKERS: dict[str, tuple[Callable[..., Gesture], tuple[int, ...]]] = {
    "sweep": (sweep, (1, 3)),
    "tap": (tap, (1, 2)),
    "arm": (arm, (1, 2)),
    "flick": (flick, (0, 1)),
    "scrub": (scrub, (3, 4)),
    "rest": (pause, (1,)),
}
"""Function of each form, and the allowed counts of its numbers."""


def parse_gesture(spec: str) -> Gesture:
    """Make the gesture of a SPEC of the command line.

    Parameters
    ----------
    spec : str
        `sweep:SECONDS[:FROM:TO]`, `tap:POSITION[:HOLD_SECONDS]`, `arm:SECONDS[:REST_SECONDS]`,
        `flick[:SECONDS]`, `scrub:POSITION:WIDTH:HZ[:SECONDS]`, `rest:SECONDS` or a take's path
        (.csv); parts are joined with `+`.

    Returns
    -------
    Gesture
        Parts in sequence.

    Raises
    ------
    InputError
        A part is not valid; the error names it and the allowed forms.

    Examples
    --------
    >>> ov.parse_gesture("sweep:2:0:0.6+rest:3+tap:0.8:1.5").duration_s
    6.5
    """
    validation.instance(spec, str, "a gesture", f"allowed: {FORMS}")
    # a take's path may hold any character, a plus too
    if Path(spec).suffix.lower() == ".csv" and os.path.exists(spec):
        return load_gesture(spec)
    made: dict[str, Gesture] = {}
    parts = [part.strip() for part in spec.split("+")]
    for part in parts:
        if part not in made:
            made[part] = _part(part)
    return joined([made[part] for part in parts])


def _part(text: str) -> Gesture:
    name, *arguments = text.split(":")
    if name not in _MAKERS:
        if Path(text).suffix.lower() == ".csv":
            return load_gesture(text)
        raise InputError(f"gesture {text!r} is not valid; allowed: {FORMS}")
    make, counts = _MAKERS[name]
    if len(arguments) not in counts:
        raise InputError(f"gesture {text!r} has {len(arguments)} numbers; allowed: {FORMS}")
    numbers = [_number(argument, text) for argument in arguments]
    return make(*numbers)


def _number(text: str, part: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"gesture {part!r}: {text!r} is not a number; allowed: {FORMS}") from None
    if not math.isfinite(value):
        raise InputError(f"gesture {part!r}: {text} is not finite; allowed: {FORMS}")
    return value
