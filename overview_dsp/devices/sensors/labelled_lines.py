"""Lines with labels, as example sketches print them: `ypr`, `a/g:`, `Acceleration X: .. m/s^2`.

The shape of a line is the line without its numbers. A device prints a cycle of shapes repeatedly.
Three equal repetitions identify the cycle, and each repetition makes one reading. The words before
a number name its quantity, a word behind it its unit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from overview_dsp.devices.sensors.profile import DETECT
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    COLUMNS,
    INERTIAL,
    QUATERNION,
    Reading,
)
from overview_dsp.files.toml import load_toml

REPETITIONS = 3
MAX_LINES = 12  # maximum number of lines in a cycle

_TOKEN = re.compile(
    r"(?<![A-Za-z0-9_.])(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(?![A-Za-z0-9_])"
    r"|(?P<word>[A-Za-z_][A-Za-z0-9_/^]*)(?P<label>\s*[:=])?"
)
_NUMBER = "#"

_LABELS = load_toml(__file__, "labels.toml")
_QUANTITIES = {name: of for of, names in _LABELS["quantities"].items() for name in names}
_UNITS, _OF_UNIT = _LABELS["units"], _LABELS["quantity_of_unit"]
_AXES, _COUNTS, _OTHER = _LABELS["axes"], _LABELS["values"], _LABELS["other"]
ROLL = {"roll", "roll:"}
_PART = re.compile(r"q_?([0-3]|[wxyzrijk])")
_AXIS = re.compile(r"([wxyz])1?")
_COMPOUND = re.compile(r"(?P<of>[a-z]+?)_?(?P<axis>[wxyz])$")

Slot = tuple[str, int]  # a quantity, and the index of one of its numbers

WITHOUT_GRAVITY = (
    "acceleration without gravity, which can't show the direction of up: let the sketch print the "
    "quaternion, the angles (ypr) or the whole acceleration"
)


def line_shape(line: str) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Return a line's shape, with `#` for each number, and its numbers."""
    shape, numbers = [], []
    for token in _TOKEN.finditer(line):
        if token["number"] is not None:
            shape.append(_NUMBER)
            numbers.append(float(token["number"]))
        else:
            shape.append(token["word"].lower() + (":" if token["label"] else ""))
    return tuple(shape), tuple(numbers)


def name_slots(shape: Sequence[str], quantity: str = "") -> tuple[list[Slot], dict[str, str], str]:
    """Return the slot of each number, the units of the quantities, and the last quantity.

    A line that begins with an axis continues the `quantity` of the line before it. The unit of a
    quaternion is "named" if its parts have names.
    """
    slots: list[Slot] = []
    units: dict[str, str] = {}
    axis, nth, ignored = "", 0, False
    quantity = quantity if shape and _AXIS.fullmatch(shape[0].rstrip(":")) else ""
    for at, token in enumerate(shape):
        if token == _NUMBER:
            of = quantity or ("bare" if axis else "other")
            index = _AXES[of].find(axis) if axis and of in _AXES else nth
            if axis and of == "quaternion":
                units[of] = "named"
            slots.append(("other", 0) if ignored else (of, index))
            nth, axis = nth + 1, ""
            continue
        word = token.rstrip(":")
        before_number = shape[at + 1 : at + 2] == (_NUMBER,)
        after_number = at > 0 and shape[at - 1] == _NUMBER
        part, of_axis = _PART.fullmatch(word), _AXIS.fullmatch(word)
        if part:
            quantity, word = "quaternion", "wxyz"[int(part[1])] if part[1].isdecimal() else part[1]
        elif of_axis:
            word = of_axis[1]
        word = _LABELS["quaternion_parts"].get(word, word) if quantity == "quaternion" else word
        compound = _COMPOUND.fullmatch(word)
        is_unit = after_number and word in _UNITS and token == word
        if is_unit and not (word == "g" and before_number):
            if [name for name, _ in slots[-3:]] == ["other"] * 3:
                slots[-3:] = [(_OF_UNIT[_UNITS[word]], n) for n in range(3)]
                quantity = _OF_UNIT[_UNITS[word]]
            units[quantity or "bare"] = _UNITS[word]
        elif quantity in _OF_UNIT.values() and word in _UNITS and token == word:
            units[quantity] = _UNITS[word]
        elif word in _OTHER["fillers"]:
            pass
        elif word in _OTHER["not_measured"]:
            ignored = True
        elif word in ("w", "x", "y", "z"):
            quantity, axis = ("" if quantity == "other" else quantity), word
        elif compound and compound["of"] in _QUANTITIES:
            quantity, axis = _QUANTITIES[compound["of"]], compound["axis"]
        elif word in _OTHER["one_angle"]:
            nth = nth if quantity == "angles" else 0
            quantity, axis = "angles", ""
        else:
            column = word if word in COLUMNS and word not in INERTIAL else "other"
            quantity, nth, axis = _QUANTITIES.get(word, column), 0, ""
    return slots, units, quantity


@dataclass(frozen=True)
class LineCycle:
    """The lines that a device repeats, and the numbers in them that make a reading.

    `shapes`: shapes of the lines, the first that is needed first.
    `columns`: line, and index of the number in that line, by names of `COLUMNS`.
    `values`: values that the labels determine, by keys of a profile.
    """

    shapes: tuple[tuple[str, ...], ...]
    columns: Mapping[str, tuple[int, int]]
    values: Mapping[str, str | float] = field(default_factory=dict)


def find_cycle(lines: Sequence[str]) -> tuple[list[tuple[str, ...]], list[list[tuple[float, ...]]]]:
    """Return the shapes of the cycle at the end of `lines`, and the numbers of its repetitions.

    Both are empty if the lines have no cycle.
    """
    read: list[tuple[tuple[str, ...], tuple[float, ...]]] = []
    before: tuple[str, ...] = ()
    for shape, numbers in map(line_shape, lines):
        if numbers:
            read.append((before + shape, numbers))
        before = () if numbers else shape  # words alone are the heading of the next line
    for period in range(1, MAX_LINES + 1):
        latest = read[-REPETITIONS * period :]
        if len(latest) < REPETITIONS * period:
            break
        shapes = [shape for shape, _ in latest]
        has_words = any(len(set(one) - {_NUMBER}) for one in shapes)
        if shapes[:-period] == shapes[period:] and has_words:
            repetitions = [[numbers for _, numbers in latest[at : at + period]]
                           for at in range(0, len(latest), period)]  # fmt: skip
            return shapes[:period], repetitions
    return [], []


def cycle_from_shapes(
    shapes: Sequence[tuple[str, ...]], bare: str | None = None, counts_known: bool = False
) -> LineCycle | str:
    """Return the cycle of these shapes; a reason (or an empty text) if it gives no reading.

    `bare`: quantity of three numbers labelled x, y, z only: acceleration or angles.
    `counts_known`: whether the counts of `a/g:` are those of a sensor's most sensitive ranges.
    """
    found: dict[Slot, tuple[int, int]] = {}
    units: dict[str, str] = {}
    last = ""
    for line, shape in enumerate(shapes):
        slots, line_units, last = name_slots(shape, last)
        units.update(line_units)
        for nth, (quantity, index) in enumerate(slots):
            of = (bare or "bare") if quantity == "bare" else quantity
            found.setdefault((of, index), (line, nth))
    complete = {
        quantity
        for quantity, _ in found
        if all((quantity, n) in found for n in range(_COUNTS.get(quantity, 3)))
    }

    def columns(quantity: str, names: Sequence[str]) -> dict[str, tuple[int, int]]:
        return {name: found[quantity, n] for n, name in enumerate(names)}

    def first_complete(*quantities: str) -> str | None:
        return next((one for one in quantities if one in complete), None)

    acceleration = first_complete("acceleration", "gravity")
    gyroscope = first_complete("angular velocity", "rotation")
    six = first_complete("counts", "raw", "uniform")
    named = {name: found[name, 0] for name in COLUMNS if (name, 0) in found}
    values: dict[str, str | float] = {}
    chosen: dict[str, tuple[int, int]] = {}
    if six:
        chosen = columns(six, INERTIAL)
        if six == "counts" and counts_known:
            values = dict(_LABELS["values_of_counts"])
        elif six == "raw":
            values = {"angular_velocity.unit": "deg/s"}
    elif acceleration and (gyroscope or "quaternion" not in complete):
        chosen = columns(acceleration, ACCELERATION)
        if gyroscope:
            chosen |= columns(gyroscope, ANGULAR_VELOCITY)
            if gyroscope in units:
                values["angular_velocity.unit"] = units[gyroscope]
        if acceleration in units:
            values["acceleration.unit"] = units[acceleration]
    elif "quaternion" in complete or all(("quaternion", n) in found for n in (1, 2, 3)):
        # without the real part, which is positive then
        whole = "quaternion" in complete
        chosen = {name: found["quaternion", n] for n, name in enumerate(QUATERNION) if whole or n}
        if whole and "quaternion" not in units:
            values = {"quaternion.order": DETECT}
    elif "angles" in complete:
        chosen = columns("angles", ANGLES)
    elif ("angles", 0) in found and (roll := _roll_slot(shapes)) is not None:
        chosen = {"roll_deg": roll}
    elif not any(name in named for name in ("roll_deg", "count", "pot", "shaft_rad")):
        return WITHOUT_GRAVITY if "linear" in complete else ""
    chosen |= named
    # the cycle starts where its needed lines come soonest together
    count = len(shapes)
    needed = {line for line, _ in chosen.values()}
    start = min(needed, key=lambda first: max((line - first) % count for line in needed))
    moved = {name: ((line - start) % count, nth) for name, (line, nth) in chosen.items()}
    return LineCycle((*shapes[start:], *shapes[:start]), moved, values)


def _roll_slot(shapes: Sequence[tuple[str, ...]]) -> tuple[int, int] | None:
    """Return the number behind the word roll; a single other angle is one, too."""
    for line, shape in enumerate(shapes):
        if ROLL & {*shape}:
            at = min(shape.index(word) for word in ROLL & {*shape})
            return (line, shape[:at].count(_NUMBER)) if _NUMBER in shape[at:] else None
    angles = [
        (line, nth)
        for line, shape in enumerate(shapes)
        for nth, (name, _) in enumerate(name_slots(shape)[0])
        if name == "angles"
    ]
    return angles[0] if len(angles) == 1 else None


class LabelledReader:
    """Readings from the lines of a cycle, each at the line that completes it."""

    def __init__(self, cycle: LineCycle) -> None:
        self._cycle = cycle
        self._at = 0
        self._last = max(line for line, _ in cycle.columns.values())
        self._numbers: list[tuple[float, ...]] = []
        self._heading: tuple[str, ...] = ()

    def parse(self, line: str) -> Reading | None:
        """Return a reading; empty within a cycle, None if the line isn't part of the cycle."""
        shape, numbers = line_shape(line)
        if not numbers:
            self._heading = shape
            return {}
        shape, self._heading = self._heading + shape, ()
        if not all(map(math.isfinite, numbers)):
            return None
        shapes = self._cycle.shapes
        if shape != shapes[self._at]:
            # a line was lost or damaged: wait for the first line of the cycle
            self._at, self._numbers = 0, []
            if shape != shapes[0]:
                return {} if shape in shapes else None
        self._numbers.append(numbers)
        at, self._at = self._at, (self._at + 1) % len(shapes)
        places = self._cycle.columns.items() if at == self._last else ()
        reading = {name: self._numbers[line][nth] for name, (line, nth) in places}
        if self._at == 0:
            self._numbers = []
        return reading
