"""Lines with words in them, as examples print them: `ypr`, `a/g:`, `Acceleration X: .. m/s^2`.

A line's shape is what is left when its numbers are taken out. A device prints a round of shapes
again and again; a round is learned from three equal ones and makes one reading. The words before a
number say what it is, a word behind it its unit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    COLUMNS,
    QUATERNION,
    Reading,
)

ROUNDS = 3
MOST_LINES = 12
"""Of a round."""

_TOKEN = re.compile(
    r"(?<![A-Za-z0-9_.])(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(?![A-Za-z0-9_])"
    r"|(?P<word>[A-Za-z_][A-Za-z0-9_/^]*)(?P<label>\s*[:=])?"
)
_NUMBER = "#"

_SAME: Mapping[str, str] = {
    name: quantity
    for quantity, names in {
        "acceleration": "a ac acc accl accel acceleration accelerometer",
        "turning": "g gy gyr gyro gyroscope",
        "rotation": "rot rotation rate rrate angular",
        "gravity": "grav gravity",
        "linear": "linear lin areal aworld aaworld aareal user useraccel linacc lacc",
        "angles": "ypr rpy hpr euler orient orientation attitude angle angles ori",
        "quaternion": "quat quaternion q vector",
        "raw": "raw",
        "uniform": "uni",
        "counts": "a/g",
    }.items()
    for name in names.split()
}
_ONE_ANGLE = ("yaw", "pitch", "roll", "heading")
_SILENT = ("calibration", "calib", "cal", "sys")
"""What follows in such a line are marks, not measurements."""

_PARTS = {"r": "w", "real": "w", "i": "x", "j": "y", "k": "z"}
"""Other names of a quaternion's parts."""

_UNITS = {
    "m/s^2": "m/s²", "m/s2": "m/s²", "m/s/s": "m/s²", "g": "g", "mg": "mg",
    "rad/s": "rad/s", "deg/s": "deg/s", "dps": "deg/s", "degrees/s": "deg/s",
    "radians/s": "rad/s",
}  # fmt: skip
_COMPOUND = re.compile(r"(?P<of>[a-z]+?)_?(?P<axis>[wxyz])$")
_AXES = {"acceleration": "xyz", "turning": "xyz", "rotation": "xyz", "gravity": "xyz",
         "linear": "xyz", "angles": "xyz", "quaternion": "wxyz", "bare": "xyz"}  # fmt: skip
_NINE = (*ACCELERATION, *ANGULAR_VELOCITY)

Slot = tuple[str, int]
"""A quantity, and which of its numbers."""


def shape_of(line: str) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """A line's shape, `#` where a number stands, and its numbers."""
    shape, numbers = [], []
    for token in _TOKEN.finditer(line):
        if token["number"] is not None:
            shape.append(_NUMBER)
            numbers.append(float(token["number"]))
        else:
            shape.append(token["word"].lower() + (":" if token["label"] else ""))
    return tuple(shape), tuple(numbers)


def slots_of(shape: Sequence[str]) -> tuple[list[Slot], dict[str, str]]:
    """What each number of a shape is, and the units said of quantities."""
    slots: list[Slot] = []
    units: dict[str, str] = {}
    quantity, axis, nth, silent = "", "", 0, False
    for at, token in enumerate(shape):
        if token == _NUMBER:
            of = quantity or ("bare" if axis else "other")
            place = _AXES[of].find(axis) if axis and of in _AXES else nth
            slots.append(("other", 0) if silent else (of, place))
            nth, axis = nth + 1, ""
            continue
        word = token.rstrip(":")
        follows = shape[at + 1 : at + 2] == (_NUMBER,)
        behind = at > 0 and shape[at - 1] == _NUMBER
        word = _PARTS.get(word, word) if quantity == "quaternion" else word
        compound = _COMPOUND.fullmatch(word)
        if behind and word in _UNITS and token == word and not (word == "g" and follows):
            units[quantity or "bare"] = _UNITS[word]
        elif word in _SILENT:
            silent = True
        elif word in ("w", "x", "y", "z"):
            quantity, axis = ("" if quantity == "other" else quantity), word
        elif compound and compound["of"] in _SAME:
            quantity, axis = _SAME[compound["of"]], compound["axis"]
        elif word in _SAME:
            quantity, nth, axis = _SAME[word], 0, ""
        elif word in _ONE_ANGLE:
            nth = nth if quantity == "angles" else 0
            quantity, axis = "angles", ""
        elif word in COLUMNS and word not in _NINE:
            quantity, nth, axis = word, 0, ""
        else:
            quantity, nth, axis = "other", 0, ""
    return slots, units


@dataclass(frozen=True)
class Round:
    """What a device prints again and again, and which of its numbers make a reading.

    Attributes
    ----------
    shapes : tuple of tuple of str
        Its lines, the first that is needed first.
    columns : mapping
        Of each name of `COLUMNS` in a reading: its line, and which number of that line.
    values : mapping
        What the words say of a profile's keys.
    """

    shapes: tuple[tuple[str, ...], ...]
    columns: Mapping[str, tuple[int, int]]
    values: Mapping[str, str | float] = field(default_factory=dict)


def learned(lines: Sequence[str]) -> tuple[list[tuple[str, ...]], list[list[tuple[float, ...]]]]:
    """The round that the last of `lines` repeat, and the numbers of three; empty if none."""
    read = [one for one in map(shape_of, lines) if one[1]]
    for period in range(1, MOST_LINES + 1):
        latest = read[-ROUNDS * period :]
        if len(latest) < ROUNDS * period:
            break
        shapes = [shape for shape, _ in latest]
        if shapes[:-period] == shapes[period:] and any(len(set(one) - {"#"}) for one in shapes):
            rounds = [[numbers for _, numbers in latest[at : at + period]]
                      for at in range(0, len(latest), period)]  # fmt: skip
            return shapes[:period], rounds
    return [], []


def round_of(
    shapes: Sequence[tuple[str, ...]], bare: str | None = None, counts_known: bool = False
) -> Round | str:
    """What a round's lines make; why nothing can be made of them.

    `bare`: what three numbers labelled x, y, z and nothing else are (acceleration or angles);
    `counts_known`: the counts of `a/g:` are those of a sensor's widest ranges.
    """
    found: dict[Slot, tuple[int, int]] = {}
    units: dict[str, str] = {}
    for line, shape in enumerate(shapes):
        slots, said = slots_of(shape)
        units.update(said)
        for nth, (quantity, place) in enumerate(slots):
            of = (bare or "bare") if quantity == "bare" else quantity
            found.setdefault((of, place), (line, nth))
    kinds = _kinds(found)
    acceleration = next((k for k in ("acceleration", "gravity") if k in kinds), None)
    turning = next((k for k in ("turning", "rotation") if k in kinds), None)
    plain = {name: found[name, 0] for name in COLUMNS if (name, 0) in found}
    values: dict[str, str | float] = {}
    chosen: dict[str, tuple[int, int]]
    six = next((k for k in ("counts", "raw", "uniform") if k in kinds), None)
    if six:
        chosen = {name: found[six, n] for n, name in enumerate(_NINE)}
        if six == "counts" and counts_known:
            values = {
                "acceleration.unit": "g",
                "acceleration.scale": 1.0 / 16384.0,
                "angular_velocity.unit": "deg/s",
                "angular_velocity.scale": 1.0 / 131.0,
            }
        elif six == "raw":
            values = {"angular_velocity.unit": "deg/s"}
    elif acceleration and (turning or not kinds & {"quaternion"}):
        chosen = {name: found[acceleration, n] for n, name in enumerate(ACCELERATION)}
        if turning:
            chosen |= {name: found[turning, n] for n, name in enumerate(ANGULAR_VELOCITY)}
            if turning in units:
                values["angular_velocity.unit"] = units[turning]
        if acceleration in units:
            values["acceleration.unit"] = units[acceleration]
    elif "quaternion" in kinds:
        chosen = {name: found["quaternion", n] for n, name in enumerate(QUATERNION)}
    elif "angles" in kinds:
        chosen = {name: found["angles", n] for n, name in enumerate(ANGLES)}
    elif ("angles", 0) in found and ("angles", 1) not in found:
        chosen = {"roll_deg": found["angles", 0]}
    elif any(name in plain for name in ("roll_deg", "count", "pot", "shaft_rad")):
        chosen = {}
    else:
        return WITHOUT_GRAVITY if "linear" in kinds else ""
    return _begun(tuple(shapes), {**chosen, **plain}, values)


WITHOUT_GRAVITY = (
    "acceleration without gravity, which can't say which way is up: let the sketch print the "
    "quaternion, the angles (ypr) or the whole acceleration"
)


def _kinds(found: Mapping[Slot, object]) -> set[str]:
    """The quantities of which every number is there."""
    needs = {"counts": 6, "raw": 6, "uniform": 6, "quaternion": 4}
    quantities = {quantity for quantity, _ in found}
    return {one for one in quantities if all((one, n) in found for n in range(needs.get(one, 3)))}


def _begun(
    shapes: tuple[tuple[str, ...], ...],
    columns: Mapping[str, tuple[int, int]],
    values: Mapping[str, str | float],
) -> Round:
    """The round, begun where its lines that are needed come soonest together."""
    count = len(shapes)
    needed = {line for line, _ in columns.values()}
    start = min(needed, key=lambda first: max((line - first) % count for line in needed))
    turned = {name: ((line - start) % count, nth) for name, (line, nth) in columns.items()}
    return Round(shapes[start:] + shapes[:start], turned, values)


class LabelledReader:
    """Lines in, a reading at the line that completes a round."""

    def __init__(self, round: Round) -> None:
        """As learned."""
        self._round = round
        self._at = 0
        self._last = max(line for line, _ in round.columns.values())
        self._numbers: list[tuple[float, ...]] = []

    def reading_of(self, line: str) -> Reading | None:
        """A reading; empty while a round goes on, None if the line isn't of it."""
        shape, numbers = shape_of(line)
        if not numbers:
            return {}
        if not all(map(math.isfinite, numbers)):
            return None
        shapes = self._round.shapes
        if shape != shapes[self._at]:
            # a line was lost or damaged: begin again where a round begins
            self._at, self._numbers = 0, []
            if shape != shapes[0]:
                return {} if shape in shapes else None
        self._numbers.append(numbers)
        at, self._at = self._at, (self._at + 1) % len(shapes)
        reading: Reading = {}
        if at == self._last:
            reading = {
                name: self._numbers[line][nth] for name, (line, nth) in self._round.columns.items()
            }
        if self._at == 0:
            self._numbers = []
        return reading
