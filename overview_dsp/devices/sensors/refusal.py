"""Why a stream can't be read, in one line: what came, its two best readings, what settles it."""

from __future__ import annotations

from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    SKIPPED,
)
from overview_dsp.devices.sensors.text_lines import cells_of, numbers_of

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
        f"{count} bytes, and no frame or line that is understood; is the speed (--baud) the "
        "device's? bare bytes without a check can't be told from noise: let it print lines; "
        "its format can be said with --sensor FILE.toml"
    )


UNCHECKED = (
    "WitMotion's packets for radio (55 61) carry no check, so that a wrong byte would move the "
    "hand: use its serial protocol (55 51, 55 52)"
)


def one_number(line: str) -> str:
    """Of lines of a number that could be several things."""
    return (
        f"lines of one number ({shown(line)}): degrees, an encoder's count or a potentiometer? "
        "say it with --sensor roll, --sensor encoder or --sensor potentiometer"
    )


def ambiguous(line: str) -> str:
    """Of a line: as it came, and the two likeliest columns, of which a person is to choose."""
    cells = cells_of(line, widely=True)
    numeric = [numbers_of(cell) is not None for cell in cells]
    count = sum(numeric)
    if not count:
        return f"lines like {shown(line)} have no number: is the speed (--baud) the device's?"
    rest = max(0, count - len(_SIX))
    first, second = _LIKELY.get(
        count,
        ((*_SIX, *(SKIPPED,) * rest), ("t_ms", *_SIX, *(SKIPPED,) * (rest - 1))),
    )
    one, other = (_written(columns, numeric) for columns in (first, second))
    return (
        f"lines like {shown(line)}: which number is which? [stream] columns = {one} or columns = "
        f"{other}, say? write it in a file for --sensor FILE.toml"
    )


def shown(line: str) -> str:
    """A line as it came, cut where it is long."""
    return repr(line if len(line) <= SHOWN else line[:SHOWN] + "…")


def _written(columns: tuple[str, ...], numeric: list[bool]) -> str:
    names = iter(columns)
    cells = (next(names) if number else SKIPPED for number in numeric)
    return "[" + ", ".join(f'"{cell}"' for cell in cells) + "]"
