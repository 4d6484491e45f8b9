"""Detection of a stream's format from its content, and the decoders of all formats.

A stream that can't be read is reported in one line: the data received, the two likeliest readings,
and the setting that decides.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from overview_dsp.devices.sensors.app_json import LONGEST, parse_app_batch, parse_json_line
from overview_dsp.devices.sensors.calibration import HIGHEST_BIAS_DEG_S
from overview_dsp.devices.sensors.frames import FrameDecoder
from overview_dsp.devices.sensors.labelled_lines import (
    LabelledReader,
    LineCycle,
    cycle_from_shapes,
    find_cycle,
    line_shape,
    name_slots,
)
from overview_dsp.devices.sensors.lines import (
    LineDecoder,
    LineSplitter,
    parse_header,
    parse_numbers,
    parse_row,
    split_cells,
)
from overview_dsp.devices.sensors.number_meaning import order_at_rest
from overview_dsp.devices.sensors.packets import TeapotDecoder, WitDecoder, has_teapots, wit_columns
from overview_dsp.devices.sensors.pads import DualSenseDecoder, JoyConDecoder
from overview_dsp.devices.sensors.profile import DETECT
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    INERTIAL,
    QUATERNION,
    SKIPPED,
    Counters,
    Decoder,
    has,
)
from overview_dsp.devices.sensors.units import is_gravity

MAX_SHOWN = 100  # maximum number of characters of a line in a message
_REAL_LAST = ("qx", "qy", "qz", "qw")
_LIKELY: dict[int, tuple[tuple[str, ...], tuple[str, ...]]] = {
    1: (("roll_deg",), ("pot",)),
    2: (("t_ms", "roll_deg"), ("roll_deg", SKIPPED)),
    3: (ACCELERATION, ANGLES),
    4: (QUATERNION, _REAL_LAST),
    5: (("t_ms", *QUATERNION), ("t_ms", *ACCELERATION, SKIPPED)),
    6: (INERTIAL, (*ANGLES, SKIPPED, SKIPPED, SKIPPED)),
    7: (("t_ms", *INERTIAL), (*QUATERNION, SKIPPED, SKIPPED, SKIPPED)),
}
"""The two likeliest columns of lines, by their count of numbers."""


def noise_message(count: int) -> str:
    """Return the message for bytes in no known format."""
    return (
        f"{count} bytes without a valid frame or line; check the device's speed (baud=). Binary "
        "data without a check can't be distinguished from noise: let the device print lines, or "
        "set the format in a file for sensor=FILE.toml"
    )


UNCHECKED_MESSAGE = (
    "WitMotion's radio packets (55 61) carry no check, so a wrong byte would move the disk: use "
    "its serial protocol (55 51, 55 52)"
)


AMBIGUOUS = "which number is which?"  # part of the message for an ambiguous line


def ambiguous_message(line: str) -> str:
    """Return the message for an ambiguous line: the line and its two likeliest columns."""
    cells = split_cells(line, wide=True)
    numeric = [parse_numbers(cell) is not None for cell in cells]
    count = sum(numeric)
    if not count:
        return f"lines like {quote_line(line)} have no number; check the device's speed (baud=)"
    rest = max(0, count - len(INERTIAL))
    both = _LIKELY.get(
        count, ((*INERTIAL, *(SKIPPED,) * rest), ("t_ms", *INERTIAL, *(SKIPPED,) * (rest - 1)))
    )
    names = (iter(columns) for columns in both)
    listed = ([f'"{next(one) if number else SKIPPED}"' for number in numeric] for one in names)
    one, other = (f"[{', '.join(cells)}]" for cells in listed)
    return (
        f"lines like {quote_line(line)}: {AMBIGUOUS} `overview sensor setup` finds it "
        f"in a turn; or write it in a file for sensor=FILE.toml: [stream] columns = {one} or "
        f"columns = {other}, for example"
    )


def quote_line(line: str) -> str:
    """Return a received line in quotes, cut if it is long."""
    return repr(line if len(line) <= MAX_SHOWN else line[:MAX_SHOWN] + "…")


FRAMES = 2
LINES = 5
"""Consecutive frames or lines that identify a format; frames have a check, lines have none."""

BATCHES = 2  # batches of an app, each with several samples, that identify it

MANY_LINES = 25
"""Lines after which three numbers can't be gravity, or four numbers are a quaternion."""

LENGTH_TOLERANCE = 0.02
UPRIGHT = 0.8  # smallest share of gravity along z of six bare numbers
LABELLED_TOLERANCE = 0.05  # largest deviation of a labelled quaternion from the length 1

ENOUGH = 4096  # bytes without valid data after which detection fails


@dataclass(frozen=True)
class DetectedFormat:
    """Format of a stream, its columns, and the cycle of labelled lines."""

    format: str  # one of `_FORMATS`
    columns: tuple[str, ...] = ()
    cycle: LineCycle | None = None
    values: Mapping[str, str | float] = field(default_factory=dict)
    """Values that the stream determines, by keys of a profile."""

    def decoder(self, counters: Counters) -> Decoder:
        """Return a decoder of such a stream."""
        return _FORMATS[self.format][1](counters, self)

    def __str__(self) -> str:
        return _FORMATS[self.format][0] + ",".join(self.columns)


def _label_decoder(counters: Counters, stream: DetectedFormat) -> Decoder:
    assert stream.cycle is not None
    return LineDecoder(counters, LabelledReader(stream.cycle).parse)


_FORMATS: Mapping[str, tuple[str, Callable[[Counters, DetectedFormat], Decoder]]] = {
    "frames": ("binary frames", lambda counters, _: FrameDecoder(counters)),
    "json": ("JSON lines", lambda counters, _: LineDecoder(counters, parse_json_line)),
    "text": (
        "lines of ",
        lambda counters, stream: LineDecoder(counters, partial(parse_row, columns=stream.columns)),
    ),
    "labels": ("labelled lines of ", _label_decoder),
    "witmotion": (
        "WitMotion packets of ",
        lambda counters, stream: WitDecoder(counters, stream.columns),
    ),
    "teapot": ("teapot packets", lambda counters, _: TeapotDecoder(counters)),
    "app": ("an app's JSON", lambda counters, _: LineDecoder(counters, parse_app_batch, LONGEST)),
    "dualsense": ("a DualSense's reports", lambda counters, _: DualSenseDecoder(counters)),
    "joycon": ("a Joy-Con's reports", lambda counters, _: JoyConDecoder(counters)),
}
"""Name for display and decoder of each format."""


def detect(
    data: bytes, timed_out: bool = False, acceleration_known: bool = False
) -> DetectedFormat | str | None:
    """Return the format of a stream's first bytes, why it can't be detected, or None for too few.

    `timed_out`: whether to report a stream that would need more data.
    `acceleration_known`: whether three numbers are an acceleration, without regard to gravity.
    """
    lines = LineSplitter(Counters(), LONGEST).feed(data)
    return (
        _detect_packets(data)
        or _detect_app(lines[-BATCHES:])
        or _detect_json(lines[-LINES:])
        or _detect_text(lines, timed_out, acceleration_known)
        or _detect_labels(lines, timed_out)
        or _unknown(data, lines, timed_out)
    )


def detect_columns(
    data: bytes, columns: tuple[str, ...], timed_out: bool
) -> DetectedFormat | str | None:
    """Return the format as `detect`, of a stream of frames or lines of `columns`."""
    if _has_frames(data):
        return DetectedFormat("frames")
    lines = LineSplitter(Counters()).feed(data)
    if any(parse_row(line, columns) for line in lines):
        return DetectedFormat("text", columns)
    return _unknown(data, lines, timed_out)


def _has_frames(data: bytes) -> bool:
    return len(FrameDecoder(Counters()).feed(data)) >= FRAMES


def _detect_packets(data: bytes) -> DetectedFormat | str | None:
    if _has_frames(data):
        return DetectedFormat("frames")
    if has_teapots(data):
        return DetectedFormat("teapot")
    columns = wit_columns(data)
    if columns:
        return DetectedFormat("witmotion", columns)
    at = data.find(b"\x55\x61")
    if at >= 0 and all(data[at + 20 * n :][:2] == b"\x55\x61" for n in range(FRAMES + 1)):
        return UNCHECKED_MESSAGE
    return None


def _detect_app(lines: Sequence[str]) -> DetectedFormat | str | None:
    read = [parse_app_batch(line) for line in lines]
    if len(read) < BATCHES or None in read:
        return None
    reason = next((one for one in reversed(read) if isinstance(one, str)), None)
    if any(isinstance(one, list) and one for one in read):
        return DetectedFormat("app")
    return None if reason is None else f"{quote_line(lines[-1])}: {reason}"


def _detect_json(lines: Sequence[str]) -> DetectedFormat | None:
    valid = len(lines) == LINES and all(parse_json_line(line) is not None for line in lines)
    return DetectedFormat("json") if valid else None


def _detect_text(
    lines: Sequence[str], timed_out: bool, acceleration_known: bool
) -> DetectedFormat | str | None:
    latest = lines[-LINES:]
    if len(latest) < LINES:
        return None
    headers = [found for found in map(parse_header, lines) if found is not None]
    if headers and all(parse_row(line, headers[-1]) for line in latest):
        return DetectedFormat("text", headers[-1])
    rows: list[tuple[float, ...]] = []
    for numbers in map(parse_numbers, lines):
        if numbers is None:
            rows.clear()
        else:
            rows.append(numbers)
    same = [row for row in rows if len(row) == len(rows[-1])]
    if len(same) < LINES or same[-LINES:] != rows[-LINES:]:
        return None
    many = len(same) >= MANY_LINES or timed_out
    return _detect_numbers(lines[-1], same, many, acceleration_known)


def _detect_numbers(
    line: str, rows: Sequence[tuple[float, ...]], many: bool, acceleration_known: bool
) -> DetectedFormat | str | None:
    count = len(rows[-1])
    if count == 1:
        if "." in line and all(abs(row[0]) <= 180.0 for row in rows[-LINES:]):
            return DetectedFormat("text", ("roll_deg",))
        return (
            f"lines of one number ({quote_line(line)}): degrees, an encoder's count or a "
            "potentiometer? choose sensor=roll, sensor=encoder or sensor=potentiometer"
        )
    if count in (len(ACCELERATION), len(INERTIAL)) and acceleration_known:
        return DetectedFormat("text", INERTIAL[:count])
    # all rows count: a moving gyroscope may pass through the size of gravity
    if count == len(ACCELERATION):
        if is_gravity(_size(rows)) or any(abs(n) > 360.0 for row in rows[:LINES] for n in row):
            return DetectedFormat("text", ACCELERATION)
        if not many:
            return None
        # numbers near zero at rest may be those of a gyroscope
        return DetectedFormat("text", ANGLES) if _is_large(rows) else ambiguous_message(line)
    if count == len(QUATERNION) and all(
        abs(math.hypot(*row) - 1.0) <= LENGTH_TOLERANCE for row in rows[-MANY_LINES:]
    ):
        order = order_at_rest(rows)
        columns = _REAL_LAST if order == "xyzw" else QUATERNION
        values = {} if order else {"quaternion.order": DETECT}
        return DetectedFormat("text", columns, values=values) if many else None
    if count in (6, 9) and is_gravity(size := _size(rows)):
        upright = abs(statistics.median(row[2] for row in rows)) > UPRIGHT * size
        if upright and not is_gravity(_size([row[3:] for row in rows])):
            return DetectedFormat("text", (*INERTIAL, *(SKIPPED,) * (count - len(INERTIAL))))
    return ambiguous_message(line)


def _detect_labels(lines: Sequence[str], timed_out: bool) -> DetectedFormat | str | None:
    if len(lines) < LINES or parse_json_line(lines[-1]) is not None:
        return None
    shapes, repetitions = find_cycle(lines)
    if not shapes:
        return None
    first = find_cycle(lines[:MANY_LINES])
    if first[0] == shapes:
        repetitions = first[1]  # at rest: later numbers may resemble another quantity
    bare, last = None, ""
    slots = []
    for shape in shapes:
        named, _, last = name_slots(shape, last)
        slots.append(named)
    triples = [
        tuple(values[n] for n in range(3))
        for one in repetitions
        if len(values := {of[1]: number for line, numbers in zip(slots, one, strict=True)
                          for of, number in reversed([*zip(line, numbers, strict=True)])
                          if of[0] == "bare"}) == 3
    ]  # fmt: skip
    if triples:
        if is_gravity(_size(triples)):
            bare = "acceleration"
        elif not timed_out and len(lines) < MANY_LINES:
            return None
        elif not _is_large(triples):
            return ambiguous_message(lines[-1])
        else:
            bare = "angles"
    counts = [one[0] for one in repetitions if shapes[0] and shapes[0][0] == "a/g:"]
    known = bool(counts) and abs(_size(counts) / 16384.0 - 1.0) <= 0.05
    found = cycle_from_shapes(shapes, bare, known)
    if isinstance(found, str):
        return f"lines like {quote_line(lines[-1])}: {found}" if found else None
    cycle = _checked_cycle(found, lines, timed_out)
    if cycle is None:
        return None
    return DetectedFormat("labels", tuple(cycle.columns), cycle, cycle.values)


def _checked_cycle(cycle: LineCycle, lines: Sequence[str], timed_out: bool) -> LineCycle | None:
    """Return the cycle, with the order of its quaternion, if its numbers fit the labels."""
    reader = LabelledReader(cycle)
    read = [one for line in lines if (one := reader.parse(line))]
    names = QUATERNION if has(cycle.columns, QUATERNION) else ACCELERATION
    if not read or not has(cycle.columns, names):
        return cycle
    rows = [tuple(one[name] for name in names) for one in read]
    sizes = [math.hypot(*row) for row in rows[:MANY_LINES]]
    if names == ACCELERATION:
        return cycle if is_gravity(statistics.median(sizes)) else None
    if not all(abs(one - 1.0) <= LABELLED_TOLERANCE for one in sizes):
        return None
    if "quaternion.order" not in cycle.values:
        return cycle
    if len(rows) < MANY_LINES and not timed_out:
        return None
    order = order_at_rest(rows) or cycle.values["quaternion.order"]
    return replace(cycle, values={**cycle.values, "quaternion.order": order})


def _unknown(data: bytes, lines: Sequence[str], timed_out: bool) -> str | None:
    if not timed_out and len(data) < ENOUGH:
        return None
    if not lines:
        return noise_message(len(data)) if data else None
    if len(lines) < LINES and all(map(_may_be_valid, lines[-2:])):
        return None  # the device is only slow
    if len("".join(lines)) < 0.5 * len(data):
        return noise_message(len(data))
    return ambiguous_message(lines[-1])


def _may_be_valid(line: str) -> bool:
    if parse_numbers(line) is not None or parse_app_batch(line) is not None:
        return True
    return isinstance(cycle_from_shapes([line_shape(line)[0]], "angles"), LineCycle)


def _is_large(rows: Sequence[Sequence[float]]) -> bool:
    return _size(rows[:MANY_LINES]) > HIGHEST_BIAS_DEG_S


def _size(rows: Sequence[Sequence[float]]) -> float:
    return statistics.median(math.hypot(*row[:3]) for row in rows)
