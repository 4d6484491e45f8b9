"""Simulation of a motor knob with the surface on its own board (with `simulated_motor.py`).

The firmware is `firmware/knob/surface.h`, compiled here (cc, gcc or clang, or `zig cc`) with
`knob_rig.c`. It runs KNOB_HZ times per second with the encoder's angle. This module imports nothing
of the package.
"""

from __future__ import annotations

import ctypes
import functools
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from simulated_motor import Motor

FIRMWARE = Path(__file__).resolve().parents[1] / "firmware" / "knob"

RIG = Path(__file__).with_name("knob_rig.c")

RIG_LATEST = 64


class Rig(ctypes.Structure):
    """Hand, knob, encoder and motor of `knob_rig.c`, with their state."""

    _fields_ = [
        *((name, ctypes.c_double) for name in (
            "inertia", "friction", "damping", "stiffness", "hand_damping", "step", "noise",
            "late_s", "winding_s", "cogging", "cogs", "angle", "speed", "applied", "given",
            "target")),
        ("latest", ctypes.c_double * RIG_LATEST),
        ("ticks", ctypes.c_uint32),
        ("dice", ctypes.c_uint32),
    ]  # fmt: skip


FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")


def compiler() -> list[str] | None:
    """Return the command of a C compiler, or None."""
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    if find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc"]
    return None


@functools.cache
def library(hertz: int, points: int, counts: int) -> ctypes.CDLL:
    """Return the compiled firmware; SystemExit without a compiler."""
    command = compiler()
    if command is None:
        sys.exit("a C compiler is needed (cc, gcc or clang; or pip install ziglang)")
    folder = Path(tempfile.mkdtemp(prefix="simulated-board-"))
    built = folder / "board.so"
    defined = (f"-DKNOB_HZ={hertz}", f"-DKNOB_POINTS={points}",
               f"-DKNOB_RESOLUTION={2.0 * math.pi / counts:.6e}f")  # fmt: skip
    subprocess.run(
        [*command, *FLAGS, *defined, "-shared", "-fPIC", f"-I{FIRMWARE}", RIG, "-lm", "-o", built],
        check=True,
    )
    found = ctypes.CDLL(str(built))
    shutil.rmtree(folder)
    found.board_disk.restype = ctypes.c_float
    found.board_stored.restype = ctypes.c_double
    found.board_stored.argtypes = (ctypes.c_void_p, ctypes.c_double)
    found.board_step.restype = ctypes.c_float
    found.board_step.argtypes = (ctypes.c_void_p, ctypes.c_float)
    found.board_begin.argtypes = (ctypes.c_void_p, ctypes.c_float)
    pointers = ctypes.c_void_p, ctypes.POINTER(Rig), ctypes.c_void_p
    found.rig_run.argtypes = (*pointers, ctypes.c_int, ctypes.c_void_p)
    return found


class BoardMotor(Motor):
    """A knob whose board runs the surface `hertz` times and reports 500 times per second."""

    REPORTS_HZ = 500

    def __init__(
        self,
        hertz: int = 4000,
        points: int = 8193,
        counts: int = 16384,
        inertia: float = 5e-5,
        friction: float = 3e-4,
        damping: float = 1e-5,
    ) -> None:
        self._library = library(hertz, points, counts)
        self._knob = ctypes.create_string_buffer(self._library.board_size())
        self._frame = ctypes.create_string_buffer(24)
        self._applied = 0.0
        super().__init__(inertia=inertia, friction=friction, damping=damping, counts=counts)
        # two steps of the physics for one of the board
        self.dt = 0.5 / hertz
        self._reports_every = 2 * hertz // self.REPORTS_HZ

    def begin(self) -> None:
        """Reset to the state after power-on."""
        super().begin()
        self._applied = 0.0
        self._ticks = 0
        self._library.board_begin(self._knob, self.seen)

    @property
    def seen(self) -> float:
        """The encoder's angle, rad."""
        return (math.floor(self.angle / self.step_rad) + 0.5) * self.step_rad

    @property
    def torque(self) -> float:
        """Present torque of the motor, N m."""
        return self._applied

    @property
    def stored(self) -> float:
        """Energy that the board's pull to the start and its ends store, J."""
        return float(self._library.board_stored(self._knob, self.angle))

    @property
    def ends_step(self) -> bool:
        """True when the board's next step is due."""
        return self._ticks % 2 == 0

    @property
    def disk(self) -> float:
        """Position of the disk, 0 to 1."""
        return float(self._library.board_disk(self._knob))

    @property
    def table(self) -> int:
        """Number of the table in use; 0 = none."""
        return int(self._library.board_table(self._knob))

    def patient(self, path: Callable[[float], float | None]) -> Callable[[float], float | None]:
        """Return a `path` of `Fingers` that starts when the board has its surface."""
        began: list[float] = []

        def waiting(time: float) -> float | None:
            if not began and self.table:
                began.append(time)
            return path(time - began[0]) if began else path(0.0)

        return waiting

    def loop(self, received: bytes) -> bytes:
        """Run the board's loop once with the received bytes; return the bytes to send."""
        if received:
            self._library.board_receive(self._knob, received, len(received))
        if self._ticks % 2 == 0:
            self._applied = self._library.board_step(self._knob, self.seen)
        self._ticks += 1
        if self._ticks % self._reports_every:
            return b""
        now_us = ctypes.c_uint32(round(self.time * 1e6) & 0xFFFFFFFF)
        count = self._library.board_report(self._knob, now_us, self._frame)
        return self._frame.raw[:count]
