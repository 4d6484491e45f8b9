"""What a stream of bytes is, detected from its content where that is safe.

Why a stream can't be read, in one line: what came, its two best readings, what settles it.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from overview_dsp.devices.sensors import app_json
from overview_dsp.devices.sensors.app_json import reading_of
from overview_dsp.devices.sensors.frames import FrameDecoder
from overview_dsp.devices.sensors.labelled_lines import (
    LabelledReader,
    Round,
    learned,
    round_of,
    shape_of,
    slots_of,
)
from overview_dsp.devices.sensors.lines import LineDecoder, LineSplitter
from overview_dsp.devices.sensors.orientation import HIGHEST_BIAS_DEG_S
from overview_dsp.devices.sensors.packets import (
    TeapotDecoder,
    WitDecoder,
    teapots_on_end,
    wit_columns,
)
from overview_dsp.devices.sensors.pads import DualSenseDecoder, JoyConDecoder
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    SKIPPED,
    Counters,
    Decoder,
)
from overview_dsp.devices.sensors.text_lines import cells_of, columns_of, numbers_of
from overview_dsp.devices.sensors.text_lines import reading_of as text_reading_of
from overview_dsp.devices.sensors.units import shows_gravity

SHOWN = 100
"""Characters of a line."""

_SIX = ACCELERATION + ANGULAR_VELOCITY
_LIKELY: dict[int, tuple[tuple[str, ...], tuple[str, ...]]] = {
    1: (("roll_deg",), ("pot",)),
    2: (("t_ms", "roll_deg"), ("roll_deg", SKIPPED)),
    3: (ACCELERATION, ANGLES),
    4: (QUATERNION, ("qx", "qy", "qz", "qw")),
    5: (("t_ms", *QUATERNION), ("t_ms", *ACCELERATION, SKIPPED)),
    6: (_SIX, (*ANGLES, SKIPPED, SKIPPED, SKIPPED)),
    7: (("t_ms", *_SIX), (*QUATERNION, SKIPPED, SKIPPED, SKIPPED)),
}


def noise(count: int) -> str:
    """Of bytes that are no lines."""
    return (
        f"{count} bytes, and no frame or line that is understood; is the speed (baud=) the "
        "device's? bare bytes without a check can't be told from noise: let it print lines; "
        "its format can be said with sensor=FILE.toml"
    )


UNCHECKED = (
    "WitMotion's packets for radio (55 61) carry no check, so that a wrong byte would move the "
    "hand: use its serial protocol (55 51, 55 52)"
)


def one_number(line: str) -> str:
    """Of lines of a number that could be several things."""
    return (
        f"lines of one number ({shown(line)}): degrees, an encoder's count or a potentiometer? "
        "say it with sensor=roll, sensor=encoder or sensor=potentiometer"
    )


def ambiguous(line: str) -> str:
    """Of a line: as it came, and the two likeliest columns, of which a person is to choose."""
    cells = cells_of(line, widely=True)
    numeric = [numbers_of(cell) is not None for cell in cells]
    count = sum(numeric)
    if not count:
        return f"lines like {shown(line)} have no number: is the speed (baud=) the device's?"
    rest = max(0, count - len(_SIX))
    first, second = _LIKELY.get(
        count,
        ((*_SIX, *(SKIPPED,) * rest), ("t_ms", *_SIX, *(SKIPPED,) * (rest - 1))),
    )
    one, other = (_written(columns, numeric) for columns in (first, second))
    return (
        f"lines like {shown(line)}: which number is which? [stream] columns = {one} or columns = "
        f"{other}, say? write it in a file for sensor=FILE.toml"
    )


def shown(line: str) -> str:
    """A line as it came, cut where it is long."""
    return repr(line if len(line) <= SHOWN else line[:SHOWN] + "…")


def _written(columns: tuple[str, ...], numeric: list[bool]) -> str:
    names = iter(columns)
    cells = (next(names) if number else SKIPPED for number in numeric)
    return "[" + ", ".join(f'"{cell}"' for cell in cells) + "]"


Format = Literal[
    "frames", "json", "text", "labels", "witmotion", "teapot", "app", "dualsense", "joycon"
]

FRAMES = 2
LINES = 5
"""So many in a row say what a stream is: frames are checked, lines are not."""

BATCHES = 2
"""Of an app, each of several samples."""

MANY_LINES = 25
"""So many say that three numbers never were gravity, or that four are a quaternion."""

ENOUGH = 4096
"""Bytes in which nothing was understood that say that nothing will be."""

UNIT_LENGTH = 0.02
LYING = 0.3
"""Of a sensor that lies face up, the two parts of its quaternion that tilt are smaller."""


@dataclass(frozen=True)
class DetectedFormat:
    """What a stream is: its format; its columns; of labelled lines, their round."""

    format: Format
    columns: tuple[str, ...] = ()
    round: Round | None = None
    values: Mapping[str, str | float] = field(default_factory=dict)
    """What it says of a profile's keys."""

    def decoder(self, counters: Counters) -> Decoder:
        """What reads such a stream."""
        return _FORMATS[self.format][1](counters, self)

    def __str__(self) -> str:
        return _FORMATS[self.format][0] + ",".join(self.columns)


def _text_decoder(counters: Counters, stream: DetectedFormat) -> Decoder:
    return LineDecoder(counters, lambda line: text_reading_of(line, stream.columns))


def _label_decoder(counters: Counters, stream: DetectedFormat) -> Decoder:
    assert stream.round is not None
    return LineDecoder(counters, LabelledReader(stream.round).reading_of)


_FORMATS: Mapping[Format, tuple[str, Callable[[Counters, DetectedFormat], Decoder]]] = {
    "frames": ("binary frames", lambda counters, _: FrameDecoder(counters)),
    "json": ("JSON lines", lambda counters, _: LineDecoder(counters, reading_of)),
    "text": ("lines of ", _text_decoder),
    "labels": ("labelled lines of ", _label_decoder),
    "witmotion": (
        "WitMotion packets of ",
        lambda counters, stream: WitDecoder(counters, stream.columns),
    ),
    "teapot": ("teapot packets", lambda counters, _: TeapotDecoder(counters)),
    "app": (
        "an app's JSON",
        lambda counters, _: LineDecoder(counters, app_json.readings_of, app_json.LONGEST),
    ),
    "dualsense": ("a DualSense's reports", lambda counters, _: DualSenseDecoder(counters)),
    "joycon": ("a Joy-Con's reports", lambda counters, _: JoyConDecoder(counters)),
}
"""By format: it in words, and what reads it."""


def detect(
    data: bytes, over: bool = False, accelerates: bool = False
) -> DetectedFormat | str | None:
    """What a stream is from the bytes so far, why it can't be detected, or None: not yet.

    `over`: a person has waited long enough to be told what came; `accelerates`: three numbers are
    acceleration, whatever gravity says.
    """
    found = _packets(data)
    if found is not None:
        return found
    lines = LineSplitter(Counters(), app_json.LONGEST).feed(data)
    app = _app(lines[-BATCHES:])
    if app is not None:
        return app
    latest = lines[-LINES:]
    if len(lines) >= LINES and all(reading_of(line) is not None for line in latest):
        return DetectedFormat("json")
    text = _text(lines, over, accelerates)
    if text is not None:
        return text
    rounds = _labels(lines, over)
    if rounds is not None:
        return rounds
    return _unknown(data, lines, over)


def detect_columns(
    data: bytes, columns: tuple[str, ...], over: bool
) -> DetectedFormat | str | None:
    """As `detect`, of a stream that is frames or lines of `columns`."""
    if len(FrameDecoder(Counters()).feed(data)) >= FRAMES:
        return DetectedFormat("frames")
    lines = LineSplitter(Counters()).feed(data)
    if any(text_reading_of(line, columns) for line in lines):
        return DetectedFormat("text", columns)
    return _unknown(data, lines, over)


def _packets(data: bytes) -> DetectedFormat | str | None:
    if len(FrameDecoder(Counters()).feed(data)) >= FRAMES:
        return DetectedFormat("frames")
    if teapots_on_end(data):
        return DetectedFormat("teapot")
    columns = wit_columns(data)
    if columns:
        return DetectedFormat("witmotion", columns)
    at = data.find(b"\x55\x61")
    if at >= 0 and all(data[at + 20 * n :][:2] == b"\x55\x61" for n in range(FRAMES + 1)):
        return UNCHECKED
    return None


def _app(lines: Sequence[str]) -> DetectedFormat | str | None:
    read = [app_json.readings_of(line) for line in lines]
    if len(read) < BATCHES or None in read:
        return None
    why = next((one for one in reversed(read) if isinstance(one, str)), None)
    if any(isinstance(one, list) and one for one in read):
        return DetectedFormat("app")
    return None if why is None else f"{shown(lines[-1])}: {why}"


def _text(lines: Sequence[str], over: bool, accelerates: bool) -> DetectedFormat | str | None:
    latest = lines[-LINES:]
    if len(latest) < LINES:
        return None
    headers = [found for found in map(columns_of, lines) if found is not None]
    if headers and all(text_reading_of(line, headers[-1]) for line in latest):
        return DetectedFormat("text", headers[-1])
    rows = [numbers_of(line) for line in lines]
    while rows and None in rows:
        del rows[: rows.index(None) + 1]
    same = [row for row in rows if row is not None and len(row) == len(rows[-1] or ())]
    if len(same) < LINES or len(same) < len(rows[-LINES:]):
        return None
    if any(len(row or ()) != len(same[-1]) for row in rows[-LINES:]):
        return None
    return _numbers(lines[-1], same, len(same) >= MANY_LINES or over, accelerates)


def _numbers(
    line: str, rows: Sequence[tuple[float, ...]], many: bool, accelerates: bool
) -> DetectedFormat | str | None:
    count = len(rows[-1])
    six = ACCELERATION + ANGULAR_VELOCITY
    if count == 1:
        values = [row[0] for row in rows[-LINES:]]
        degrees = "." in line and all(abs(value) <= 180.0 for value in values)
        return DetectedFormat("text", ("roll_deg",)) if degrees else one_number(line)
    if count == len(six) or (count == len(ACCELERATION) and accelerates):
        return DetectedFormat("text", six[:count])
    # of all of them: a gyroscope's three may pass by gravity's size while it is turned
    gravity = shows_gravity(_size(rows))
    if count == len(ACCELERATION):
        if gravity or any(abs(number) > 360.0 for row in rows[:LINES] for number in row):
            return DetectedFormat("text", ACCELERATION)
        if not many:
            return None
        # what rests near zero may be a gyroscope's
        return DetectedFormat("text", ANGLES) if _far(rows) else ambiguous(line)
    if count == 9 and gravity:
        return DetectedFormat("text", (*six, *(SKIPPED,) * 3))
    if count == len(QUATERNION) and all(
        abs(math.hypot(*row) - 1.0) <= UNIT_LENGTH for row in rows[-MANY_LINES:]
    ):
        return _quaternion(line, rows) if many else None
    return ambiguous(line)


def _quaternion(line: str, rows: Sequence[tuple[float, ...]]) -> DetectedFormat | str:
    """Whether the real part is first or last: by the tilt, which is small at the start."""
    a, b, c, _ = (statistics.median(column) for column in zip(*rows[:LINES], strict=True))
    first = math.hypot(b, c) < LYING
    last = math.hypot(a, b) < LYING
    if first == last:
        return ambiguous(line)
    return DetectedFormat("text", QUATERNION if first else ("qx", "qy", "qz", "qw"))


def _labels(lines: Sequence[str], over: bool) -> DetectedFormat | str | None:
    if len(lines) < LINES or reading_of(lines[-1]) is not None:
        return None
    shapes, rounds = learned(lines)
    if not shapes:
        return None
    first = learned(lines[:MANY_LINES])
    if first[0] == shapes:
        rounds = first[1]  # as it rested: what is turned may look like something else
    bare = None
    places = [slots_of(shape)[0] for shape in shapes]
    triples = [
        tuple(numbers[line.index(("bare", n))] for n in range(3))
        for one in rounds
        for line, numbers in zip(places, one, strict=True)
        if all(("bare", n) in line for n in range(3))
    ]
    if triples:
        if shows_gravity(_size(triples)):
            bare = "acceleration"
        elif over or len(lines) >= MANY_LINES:
            if not _far(triples):
                return ambiguous(lines[-1])
            bare = "angles"
        else:
            return None
    counts = [one[0] for one in rounds if shapes[0] and shapes[0][0] == "a/g:"]
    known = bool(counts) and abs(_size(counts) / 16384.0 - 1.0) <= 0.05
    found = round_of(shapes, bare, known)
    if isinstance(found, Round):
        return DetectedFormat("labels", tuple(found.columns), found, found.values)
    return f"lines like {shown(lines[-1])}: {found}" if found else None


def _unknown(data: bytes, lines: Sequence[str], over: bool) -> str | None:
    if not over and len(data) < ENOUGH:
        return None
    if not lines:
        return noise(len(data)) if data else None
    if len(lines) < LINES and all(_promises(line) for line in lines[-2:]):
        return None  # it is only slow
    if len("".join(lines)) < 0.5 * len(data):
        return noise(len(data))
    return ambiguous(lines[-1])


def _promises(line: str) -> bool:
    if numbers_of(line) is not None or app_json.readings_of(line) is not None:
        return True
    return isinstance(round_of([shape_of(line)[0]], "angles"), Round)


def _far(rows: Sequence[Sequence[float]]) -> bool:
    return _size(rows[:MANY_LINES]) > HIGHEST_BIAS_DEG_S


def _size(rows: Sequence[Sequence[float]]) -> float:
    return statistics.median(math.hypot(*row[:3]) for row in rows)
