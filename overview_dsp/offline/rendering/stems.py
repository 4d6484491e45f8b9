"""Each channel as a file of its own, and what the disk did as channels of another: stems.

How loud the click channel is (ITU-R BS.1770), and the gain that brings it to a loudness.

Only what is heard is measured and turned: the tactor stays as strong as it is to feel.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.analysis.loudness import MIN_RATE, SILENCE_LUFS, StepMeter, Steps
from overview_dsp.errors import InputError
from overview_dsp.files.sound import SoundWriter
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.layout import CLICK, TRACE_COLUMNS

NAMES = ("click", "tactor")
CURVES = ("cursor", "touching", "torque", "envelope")
"""Channels of the trace's file: 0 to 1; torque is of the torque that drives the tactor fully."""

_COLUMNS = [TRACE_COLUMNS.index(name) for name in CURVES]
SUFFIX = ".wav"


def stem_paths(path: Path) -> tuple[Path, ...]:
    """The files beside a sound file: OUT.click.wav, OUT.tactor.wav, OUT.trace.wav."""
    return tuple(path.with_name(f"{path.stem}.{name}{SUFFIX}") for name in (*NAMES, "trace"))


class StemWriter(contextlib.ExitStack):
    """Writes the stems of a sound file, block by block; does nothing unless `wanted`."""

    def __init__(
        self, path: Path, sample_rate: float, subtype: str | None, full_torque: float, wanted: bool
    ) -> None:
        """Choose the files; InputError if one would be the sound file itself."""
        super().__init__()
        self._full_torque = full_torque
        self._writers: list[SoundWriter] = []
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
            self.push(stack.pop_all())
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


CEILING_DBFS = -1.0
"""No sample is turned up beyond this."""

_ROUNDS = 8

QUIETEST_LUFS, LOUDEST_LUFS = -60.0, 0.0


def require_loudness(lufs: float) -> float:
    """A loudness that may be asked for; InputError otherwise, NaN too."""
    lufs = validation.real(lufs, "normalize")
    if not QUIETEST_LUFS <= lufs <= LOUDEST_LUFS:
        raise InputError(
            f"{lufs:g} LUFS is out of range; it is {QUIETEST_LUFS:g} to {LOUDEST_LUFS:g}, "
            "-23 for broadcast, -16 for phones"
        )
    return lufs


class ClickMeter:
    """Feed it blocks of a render, for the loudness of its click channel."""

    def __init__(self, sample_rate: float) -> None:
        if sample_rate < MIN_RATE or sample_rate != int(sample_rate):
            raise InputError(
                f"loudness is measured at whole rates of {MIN_RATE} Hz or more, not {sample_rate:g}"
            )
        self._meter = StepMeter(int(sample_rate), (1.0,))
        self._waiting = np.zeros((0, 1), np.float32)
        self.peak = 0.0

    def feed(self, samples: NDArray[np.float32]) -> None:
        """Take the next float32 (frames, 2)."""
        click = samples[:, CLICK : CLICK + 1]
        self.peak = max(self.peak, float(np.abs(click).max(initial=0.0)))
        self._waiting = np.concatenate([self._waiting, click])
        size = self._meter.block_frames
        while len(self._waiting) >= size:
            self._meter.feed(self._waiting[:size])
            self._waiting = self._waiting[size:]

    def steps(self) -> Steps:
        """What was fed, step by step. Call it once, at the end."""
        if len(self._waiting):
            self._meter.feed(self._waiting)
        return self._meter.finish()

    def gain_to(self, lufs: float) -> float:
        """The gain (linear) to a loudness, or as much of it as the highest sample allows."""
        steps = self.steps()
        if loudness_of(steps) is None:
            return 1.0
        gain = 1.0
        for _ in range(_ROUNDS):  # the gate at -70 LUFS opens for more of it, turned up
            now = replace(steps, energy=steps.energy * gain**2).integrated()
            gain *= gain_of_db(lufs - now)
        return min(gain, gain_of_db(CEILING_DBFS) / self.peak)


def loudness_of(steps: Steps) -> float | None:
    """The gated loudness, LUFS; None for silence."""
    found = steps.integrated()
    return found if found > SILENCE_LUFS else None
