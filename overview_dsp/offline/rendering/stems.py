"""Each channel as a file of its own, and what the disk did as channels of another: stems."""

from __future__ import annotations

import contextlib
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.files.sound import SoundWriter
from overview_dsp.kernels.layout import TRACE_COLUMNS

NAMES = ("click", "tactor")
CURVES = ("cursor", "touching", "torque", "envelope")
"""Channels of the trace's file: 0 to 1; torque is of the torque that drives the tactor fully."""

_COLUMNS = [TRACE_COLUMNS.index(name) for name in CURVES]
SUFFIX = ".wav"


def stem_paths(path: Path) -> tuple[Path, ...]:
    """The files beside a sound file: OUT.click.wav, OUT.tactor.wav, OUT.trace.wav."""
    return tuple(path.with_name(f"{path.stem}.{name}{SUFFIX}") for name in (*NAMES, "trace"))


class StemWriter:
    """Writes the stems of a sound file, block by block; does nothing unless `wanted`."""

    def __init__(
        self, path: Path, sample_rate: float, subtype: str | None, full_torque: float, wanted: bool
    ) -> None:
        """Choose the files; InputError if one would be the sound file itself."""
        self._full_torque = full_torque
        self._writers: list[SoundWriter] = []
        self._stack = contextlib.ExitStack()
        if wanted:
            *single, trace = stem_paths(path)
            if path in (*single, trace):
                raise InputError(f"{path}: is the name of a stem; choose another one")
            kept = subtype if path.suffix.lower() == SUFFIX else None
            self._writers = [SoundWriter(one, sample_rate, kept, 1) for one in single]
            self._writers.append(SoundWriter(trace, sample_rate, "FLOAT", len(CURVES)))

    def __enter__(self) -> StemWriter:
        with contextlib.ExitStack() as stack:
            for writer in self._writers:
                stack.enter_context(writer)
            self._stack = stack.pop_all()
        return self

    def write(self, samples: NDArray[np.float32], trace: NDArray[np.float64] | None) -> None:
        """Append a block."""
        if not self._writers or trace is None:
            return
        for channel in range(len(NAMES)):
            self._writers[channel].write(np.ascontiguousarray(samples[:, channel : channel + 1]))
        curves = trace[:, _COLUMNS].astype(np.float32)
        curves[:, CURVES.index("torque")] /= np.float32(self._full_torque)
        self._writers[-1].write(curves)

    def finish(self) -> None:
        """Write what still waits in buffers."""
        for writer in self._writers:
            writer.finish()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stack.__exit__(kind, error, traceback)
