"""The model in C, as a textbook would write it."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.gestures import sweep
from overview_dsp.kernels.layout import CELLS
from overview_dsp.measure.bench import (
    DISK,
    RATE,
    SECONDS,
    SWEEP_S,
    VOICE,
    Contender,
    prepared,
    timed,
)
from tools.bench.building import PEERS, built
from tools.bench.disk import Disk
from tools.bench.plain_settings import Settings, plain_scene, plain_settings

PLAIN = ("-O3", "-march=native")


def sweep_input(frames: int) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Return the angle (rad) and the touch state of the sweep at each sample."""
    gesture = sweep(SWEEP_S)
    latest = np.searchsorted(gesture.stamps(RATE), np.arange(frames), side="right") - 1
    return gesture.theta2[latest], gesture.touching[latest].astype(np.uint8)


class PlainC:
    """plain_voice.c, built with some flags."""

    def __init__(self, library: Path, disk: Disk, settings: Settings) -> None:
        """Load `library`, the built source."""
        self._c = ctypes.CDLL(str(library))
        self._settings = settings
        self._disk = disk
        self._torque = np.empty(len(disk.angles))

    def torque(self) -> NDArray[np.float64]:
        """Return the torque (N m) of the disk alone."""
        self._c.plain_disk(
            ctypes.byref(self._settings),
            pointer(self._disk.friction),
            pointer(self._disk.angles),
            pointer(self._torque),
            ctypes.c_int64(len(self._torque)),
        )
        return self._torque

    def voice(self, scene: Any, angles: NDArray[np.float64], touching: NDArray[np.uint8],
              out: NDArray[np.float32]) -> None:  # fmt: skip
        """Write the full voice into `out`, float32 (frames, 2)."""
        self._c.plain_voice(
            ctypes.byref(self._settings),
            ctypes.byref(scene),
            pointer(angles),
            pointer(touching),
            pointer(out),
            ctypes.c_int64(len(out)),
        )


def pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    """Return the address of an array for C."""
    return ctypes.c_void_p(array.ctypes.data)


def contenders() -> list[Contender]:
    """Build and return the C versions.

    Raises
    ------
    MissingError
        No compiler.
    """
    folder = Path(tempfile.mkdtemp(prefix="overview-bench-"))
    engine = prepared()
    disk = Disk.of(engine)
    out = np.zeros((round(SECONDS * RATE), 2), dtype=np.float32)
    plain = PlainC(built(PEERS / "plain_voice.c", PLAIN, folder), disk, plain_settings(engine))
    scene = plain_scene(engine)
    angles, touching = sweep_input(len(out))
    assert len(disk.friction) == CELLS + 1
    return [
        Contender(
            VOICE,
            f"a textbook version in C, {named(PLAIN)}",
            lambda: timed(SECONDS, lambda: plain.voice(scene, angles, touching, out)),
        ),
        Contender(
            DISK,
            f"a textbook version in C, {named(PLAIN)}",
            lambda: timed(SWEEP_S, plain.torque),
        ),
    ]


def named(flags: tuple[str, ...]) -> str:
    """Return the flags as a table shows them."""
    return " ".join(flag for flag in flags if not flag.startswith("-march"))
