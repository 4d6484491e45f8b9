"""SimpleFOC's Commander: a line a command, `M` (or another letter) for the motor.

| sent | means |
|---|---|
| `@0` | answer nothing: at 500 targets a second answers would fill the wire |
| `MC0` | motion control: torque |
| `M0` | target 0 |
| `MMS1000001` | report the target and the shaft's angle |
| `MMD10` | at every tenth call of `motor.monitor()` |
| `ME1`, `ME0` | enable, disable the motor |
| `M-0.0123` | target: A, or V in voltage mode |

Reports are lines of the target and the angle (rad), with a tab between. No command has more than
the 19 characters and the end of a line that its buffer holds.

Source: https://docs.simplefoc.com/commander_motor, src/communication/Commander.cpp and commands.h
of https://github.com/simplefoc/Arduino-FOC (library versions 2.1 and later).
"""

from __future__ import annotations

DECIMALS = 4
"""Of a reported number (`monitor_decimals`), and so of a target sent."""

TARGET_STEP = 10.0**-DECIMALS


class Commander:
    """Lines for one motor."""

    def __init__(self, letter: str, downsample: int) -> None:
        """The motor's `letter`, and at which of its calls it reports."""
        self._letter = letter
        self._downsample = downsample

    def begin(self) -> bytes:
        """Torque control at 0, reports, and power."""
        letter = self._letter
        lines = ("@0", f"{letter}C0", f"{letter}0", f"{letter}MS1000001",
                 f"{letter}MD{self._downsample}", f"{letter}E1")  # fmt: skip
        return "".join(line + "\n" for line in lines).encode()

    def target(self, value: float) -> bytes:
        """A target, to 4 decimals."""
        # adding 0 turns -0 into 0
        return f"{self._letter}{round(value, DECIMALS) + 0.0:.{DECIMALS}f}\n".encode()

    def end(self) -> bytes:
        """No torque and no power."""
        return f"{self._letter}0\n{self._letter}E0\n".encode()
