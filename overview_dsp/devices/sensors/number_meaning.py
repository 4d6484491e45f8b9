"""Meaning of the numbers of a line or a message, found from how they change in a turn.

The device rests, is turned face down, and back. A quaternion keeps the length 1, an acceleration
keeps the length of gravity, and each shows the turn; one of three angles turns by itself. A
gyroscope turns away from its rest and back twice as often, and a magnetic field has no such length.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from overview_dsp.devices.sensors.labelled_lines import line_shape
from overview_dsp.devices.sensors.lines import WORD, LineSplitter, parse_numbers, split_cells
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    SKIPPED,
    Counters,
)
from overview_dsp.devices.sensors.units import Vector, is_gravity, unit
from overview_dsp.errors import InputError

QUANTITIES = ("quaternion", "acceleration", "angles")  # the best first
ORDERS = ("wxyz", "xyzw")
FEWEST = 50  # smallest number of rows of a rest and a turn
REST_ROWS = 25
AWAY_DEG, BACK_DEG = 90.0, 25.0  # a turn reaches so far, and returns so close
BEYOND_HALF_DEG = 105.0  # no quaternion's parts turn so far, which turn by half the angle
LENGTH_TOLERANCE = 0.02
GRAVITY_TOLERANCE, CALM_SHARE = 0.35, 0.85
"""Relative deviation from gravity during a turn, and the share of rows that stay within it."""

STRAIGHT = 0.8
"""Smallest share of one axis in a direction; with a smaller one, the device is not aligned."""

OTHERS = 0.4  # largest turn of the other two angles, relative to the twist
LARGEST_TURN_DEG, FULL_TURN_RAD_DEG = 210.0, 130.0
"""Largest turn of a wrist, and the smallest one that shows radians."""

FIT = 0.5  # smallest share of gravity's movement that a gyroscope explains

Source = TypeVar("Source", bound=Hashable)
Table = NDArray[np.float64]  # a row per line, a column per number


@dataclass(frozen=True)
class Meaning:
    """Quantity of the numbers from column `at` on.

    `order`: of a quaternion, one of `ORDERS`. `radians`, `twist`: unit of three angles, and which
    of them turns. `gyroscope`: the first column of an angular velocity that fits the acceleration,
    or None. `ups`: direction of up in the sensor's axes, per row; None of three angles.
    """

    quantity: str
    at: int
    order: str = ORDERS[0]
    radians: bool = False
    twist: int = 0
    gyroscope: int | None = None
    ups: Table | None = None


def up_vectors(quaternions: Table) -> Table:
    """Return up in the sensor's own axes of quaternions w, x, y, z, one per row."""
    w, x, y, z = quaternions.T
    vectors: Table = np.stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z], 1
    )
    lengths: Table = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.maximum(lengths, 1e-9)


FACE_UP = 0.3  # largest size of the two tilt parts of a quaternion while the sensor is face up


def order_at_rest(rows: Sequence[Sequence[float]]) -> str | None:
    """Return the order of a quaternion face up at rest, from its small tilt; None if unclear."""
    a, b, c, _ = np.median(np.asarray(rows, dtype=float)[:REST_ROWS], axis=0)
    first, last = math.hypot(b, c) < FACE_UP, math.hypot(a, b) < FACE_UP
    return None if first == last else ORDERS[not first]


def from_rest(table: Table) -> int:
    """Return the first row of the first rest before a turn."""
    if len(table) <= REST_ROWS:
        return 0
    ranges = np.ptp(np.lib.stride_tricks.sliding_window_view(table, REST_ROWS, axis=0), axis=-1)
    quiet = ranges.min(axis=0)
    moving = np.ptp(table, axis=0) > 6.0 * quiet + 1e-9
    still = (ranges[:, moving] <= 3.0 * quiet[moving] + 1e-9).all(axis=1)
    return int(np.argmax(still))


def find_meaning(rows: Sequence[Sequence[float]]) -> Meaning | None:
    """Return what the numbers are, once a rest and a turn there and back show it."""
    table: Table = np.asarray(rows, dtype=float)
    if len(table) < FEWEST or table.shape[1] < 3:
        return None
    table = table[from_rest(table) :]
    four, three = _quaternion(table, ORDERS), _acceleration(table)
    # an acceleration in g and a number near 0 have the length 1 too, and turn twice as far
    overlap = four is not None and three is not None and four[1].at <= three[1].at <= four[1].at + 1
    best = three if overlap or four is None else four
    if best is not None and overlap and best[0].max() < BEYOND_HALF_DEG:
        return None
    return angles_in_turns(table) if best is None else _back(best)


def best_meaning(
    sources: Mapping[Source, Sequence[Sequence[float]]],
) -> list[tuple[Source, Meaning]]:
    """Return the meanings that a turn shows in the rows of several sources, the best first."""
    found = [(source, meaning) for source, rows in sources.items()
             if (meaning := find_meaning(rows)) is not None]  # fmt: skip
    return sorted(found, key=lambda one: QUANTITIES.index(one[1].quantity))


def find_named(table: Table, quantity: str, unordered: bool) -> Meaning | None:
    """Return the turn of the columns of one of `QUANTITIES` (and its gyroscope).

    `unordered`: whether the order of a quaternion's numbers is unknown.
    """
    if quantity == "angles":
        return angles_in_turns(table)
    orders = ORDERS if unordered else ORDERS[:1]
    four = quantity == "quaternion"
    return _back(_quaternion(table, orders) if four else _acceleration(table[:, :3]))


def _back(found: tuple[Table, Meaning] | None) -> Meaning | None:
    return None if found is None or found[0][-1] >= BACK_DEG else found[1]


def axes_in_turn(rest: Vector, ups: Sequence[Vector] | Table) -> tuple[str, str, str]:
    """Return the sensor's axes that are x (of the turn), y and z (up at rest); right-handed.

    InputError: the sensor was tilted, or the turn was about none of its axes.
    """
    up = unit(rest)
    z = max(range(3), key=lambda n: abs(up[n]))
    if abs(up[z]) < STRAIGHT:
        raise InputError(
            "the sensor was tilted: no axis pointed up; put it down face up and start again"
        )
    about = np.abs(np.cross(up, ups)).sum(axis=0).tolist()
    x = max((n for n in range(3) if n != z), key=lambda n: about[n])
    if about[x] < STRAIGHT * math.hypot(*about):
        raise InputError(
            "the turn was about no axis of the sensor: mount the board straight along the "
            "wrist, turn it about that, and start again"
        )
    y = 3 - x - z
    sign_z = 1.0 if up[z] > 0.0 else -1.0
    # y = z cross x
    sign_y = sign_z * (1.0 if (z, x) in ((0, 1), (1, 2), (2, 0)) else -1.0)
    named = ((1.0, x), (sign_y, y), (sign_z, z))
    x_axis, y_axis, z_axis = (f"{'-' if sign < 0.0 else ''}{'xyz'[axis]}" for sign, axis in named)
    return x_axis, y_axis, z_axis


def explain(rows: Sequence[Sequence[float]] | Table) -> str:
    """Return why no turn can be seen in the numbers."""
    table: Table = np.asarray(rows, dtype=float)
    if len(table) < FEWEST or table.shape[1] < 3:
        return "it sends fewer than three numbers at a time, or too few samples"
    if not (np.ptp(table, axis=0) > 4.0 * np.ptp(table[:REST_ROWS], axis=0)).any():
        return "the numbers did not change: turn it face down and back"
    return (
        "its numbers are no quaternion (length 1), no acceleration with gravity (9.81 m/s², 1 g, "
        "1000 mg) and no angles (in degrees or radians): a rate of turn, a magnetic field or an "
        "acceleration without gravity can't show the direction of up"
    )


def _turn_deg(ups: Table) -> Table:
    """Return the turn from the rest at the start, degrees."""
    rest = np.array(unit(tuple(np.median(ups[:REST_ROWS], axis=0))))
    turn: Table = np.degrees(np.arccos(np.clip(ups @ rest, -1.0, 1.0)))
    return turn


def _quaternion(table: Table, orders: Sequence[str]) -> tuple[Table, Meaning] | None:
    found = []
    for at in range(table.shape[1] - 3):
        four = table[:, at : at + 4]
        if np.abs(np.linalg.norm(four, axis=1) - 1.0).max() <= LENGTH_TOLERANCE:
            ups = {one: up_vectors(np.roll(four, ORDERS.index(one), axis=1)) for one in orders}
            found += [Meaning("quaternion", at, order, ups=up) for order, up in ups.items()]
    return _best(found)


def _best(found: Sequence[Meaning]) -> tuple[Table, Meaning] | None:
    """Return the turn of the meaning that turns; of several, that whose axis points up at rest."""
    turns = [(_turn_deg(one.ups), one) for one in found if one.ups is not None]
    most = max((turn.max() for turn, _ in turns), default=0.0)
    likely = [one for one in turns if one[0].max() > max(AWAY_DEG, 0.8 * most)]
    return max(likely, key=lambda one: _straightness(one[1]), default=None)


def _straightness(one: Meaning) -> tuple[bool, float, float]:
    assert one.ups is not None
    up = np.median(one.ups[:REST_ROWS], axis=0)
    return one.gyroscope is not None, round(float(np.abs(up).max()), 2), float(up[2])


def _acceleration(table: Table) -> tuple[Table, Meaning] | None:
    lengths = [np.linalg.norm(table[:, at : at + 3], axis=1) for at in range(table.shape[1] - 2)]
    sizes = [float(np.median(one[:REST_ROWS])) for one in lengths]
    calm = [float(np.mean(np.abs(one - size) < GRAVITY_TOLERANCE * size)) if is_gravity(size)
            else 0.0 for one, size in zip(lengths, sizes, strict=True)]  # fmt: skip
    found = []
    for at, length in enumerate(lengths):
        if calm[at] >= max(CALM_SHARE, max(calm) - 0.01):
            ups = table[:, at : at + 3] / np.maximum(length[:, None], 1e-9)
            found.append(Meaning("acceleration", at, gyroscope=_gyroscope(table, at, ups), ups=ups))
    return _best(found)


def _gyroscope(table: Table, at: int, ups: Table) -> int | None:
    """Return the columns whose turning rate fits the turn of gravity best."""
    ups = (ups[2:] + ups[1:-1] + ups[:-2]) / 3.0
    change, middle = np.diff(ups, axis=0), (ups[1:] + ups[:-1]) / 2.0
    best, column = FIT, None
    for first in range(table.shape[1] - 2):
        if abs(first - at) < 3:
            continue
        rate = table[:, first : first + 3]
        rate = (rate - np.median(rate[:REST_ROWS], axis=0))[1:-2]
        predicted = np.cross(middle, rate)
        size = float((predicted * predicted).sum())
        along = float((predicted * change).sum())
        fit = along * abs(along) / max(size * float((change * change).sum()), 1e-300)
        if fit > best:
            best, column = fit, first
    return column


def angles_in_turns(table: Table) -> Meaning | None:
    """Return the three angles of which one turned twice the same way, and their unit."""
    for at in range(table.shape[1] - 2):
        three = table[:, at : at + 3]
        for radians in (False, True):
            degrees = np.degrees(three) if radians else three
            if np.abs(three).max() > (2.0 * math.pi + 0.1 if radians else 361.0):
                continue
            path = np.unwrap(degrees, period=360.0, axis=0)
            moved = path - np.median(path[:REST_ROWS], axis=0)
            most = np.abs(moved).max(axis=0)
            twist = int(np.argmax(most))
            if np.partition(most, 1)[1] < OTHERS * most[twist] and are_turns(
                moved[:, twist], FULL_TURN_RAD_DEG if radians else AWAY_DEG
            ):
                return Meaning("angles", at, radians=radians, twist=twist)
    return None


def are_turns(moved: Table, smallest: float) -> bool:
    """Return whether two turns in a row go the same way; a rate of turn goes there and back."""
    if abs(moved[-1]) > BACK_DEG or np.abs(moved).max() > LARGEST_TURN_DEG:
        return False
    away = np.concatenate([[False], np.abs(moved) > 0.5 * smallest, [False]])
    starts, ends = np.flatnonzero(np.diff(away))[::2], np.flatnonzero(np.diff(away))[1::2]
    peaks = [moved[a:b][np.argmax(np.abs(moved[a:b]))] for a, b in zip(starts, ends, strict=True)]
    return any(min(p, q) > smallest or max(p, q) < -smallest for p, q in pairwise(peaks))


RETRY_S = 0.2  # time between attempts
MAX_SHAPES = 50


class NumberLearner:
    """Finds the columns of lines whose numbers may mean several things."""

    def __init__(self) -> None:
        self._lines = LineSplitter(Counters())
        self._rows: dict[tuple[str, ...], list[tuple[float, ...]]] = {}
        self._examples: dict[tuple[str, ...], str] = {}
        self._tried = -1e300

    def feed(self, data: bytes, arrival_s: float) -> tuple[str, ...]:
        """Return the columns once they are known, else an empty tuple."""
        for line in self._lines.feed(data):
            shape, numbers = line_shape(line)
            if numbers and (shape in self._rows or len(self._rows) < MAX_SHAPES):
                self._rows.setdefault(shape, []).append(numbers)
                self._examples[shape] = line
        if arrival_s - self._tried < RETRY_S:
            return ()
        self._tried = arrival_s
        found = best_meaning(self._rows)
        columns = (_columns(self._examples[shape], meaning) for shape, meaning in found)
        return next((one for one in columns if one), ())

    @property
    def explanation(self) -> str:
        """Reason why no turn can be seen in any of the lines."""
        most = max(self._rows.values(), key=len, default=[])
        return explain(most) if len(most) >= FEWEST else "too few lines of the same form"


def _columns(line: str, meaning: Meaning) -> tuple[str, ...]:
    """Return the columns of a line's cells; the word at its start selects lines of its kind."""
    names = [SKIPPED] * len(line_shape(line)[1])
    four = QUATERNION if meaning.order == ORDERS[0] else (*QUATERNION[1:], QUATERNION[0])
    block = {"quaternion": four, "acceleration": ACCELERATION, "angles": ANGLES}[meaning.quantity]
    names[meaning.at : meaning.at + len(block)] = block
    if meaning.gyroscope is not None:
        names[meaning.gyroscope : meaning.gyroscope + 3] = ANGULAR_VELOCITY
    for wide in (False, True):
        cells = split_cells(line, wide)
        is_number = [parse_numbers(cell) is not None for cell in cells]
        if sum(is_number) == len(names):
            rest = iter(names)
            columns = [next(rest) if number else SKIPPED for number in is_number]
            if not is_number[0]:
                columns[0] = WORD + cells[0]
            return tuple(columns)
    return ()
