"""Columns of text lines, found from a turn of the device that prints them."""

from __future__ import annotations

from overview_dsp.devices.sensors.labelled_lines import line_shape
from overview_dsp.devices.sensors.lines import LineSplitter
from overview_dsp.devices.sensors.number_meaning import (
    FEWEST,
    ORDERS,
    Meaning,
    best_meaning,
    explain,
)
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    SKIPPED,
    Counters,
)
from overview_dsp.devices.sensors.text_lines import WORD, parse_numbers, split_cells

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
