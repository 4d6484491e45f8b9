"""Stems: one sound file per channel and one with the trace; loudness of the click channel.

Loudness follows ITU-R BS.1770. Normalisation changes the click channel only; the tactor keeps its
level.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.data.analysis.loudness import MIN_RATE, SILENCE_LUFS, StepMeter, Steps
from overview_dsp.errors import InputError
from overview_dsp.files.sound import SoundWriter
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.layout import CLICK, TRACE_COLUMNS

NAMES = ("click", "tactor")
CURVES = ("cursor", "touching", "torque", "envelope")
"""Channels of the trace's file, 0 to 1; torque is relative to the tactor's full torque."""

_COLUMNS = [TRACE_COLUMNS.index(name) for name in CURVES]
SUFFIX = ".wav"


def stem_paths(path: Path) -> tuple[Path, ...]:
    """Return the paths of the stems: OUT.click.wav, OUT.tactor.wav, OUT.trace.wav."""
    return tuple(path.with_name(f"{path.stem}.{name}{SUFFIX}") for name in (*NAMES, "trace"))


class StemWriter(contextlib.ExitStack):
    """Writes the stems of a sound file block by block, if `enabled`."""

    def __init__(
        self, path: Path, sample_rate: float, subtype: str | None, full_torque: float, enabled: bool
    ) -> None:
        """Choose the files; raise InputError if one has the name of the sound file."""
        super().__init__()
        self._full_torque = full_torque
        self._writers: list[SoundWriter] = []
        if enabled:
            *single, trace = stem_paths(path)
            if path in (*single, trace):
                raise InputError(f"{path} is the name of a stem; choose another name")
            kept = subtype if path.suffix.lower() == SUFFIX else None
            self._writers = [SoundWriter(one, sample_rate, kept, 1) for one in single]
            self._writers.append(SoundWriter(trace, sample_rate, "FLOAT", len(CURVES)))

    def __enter__(self) -> StemWriter:
        with contextlib.ExitStack() as stack:
            for writer in self._writers:
                stack.enter_context(writer)
            self.push(stack.pop_all())
        return self

    def write(self, samples: SampleArray, trace: FloatArray | None) -> None:
        """Append a block."""
        if not self._writers or trace is None:
            return
        for channel in range(len(NAMES)):
            self._writers[channel].write(np.ascontiguousarray(samples[:, channel : channel + 1]))
        curves = trace[:, _COLUMNS].astype(np.float32)
        curves[:, CURVES.index("torque")] /= np.float32(self._full_torque)
        self._writers[-1].write(curves)

    def finish(self) -> None:
        """Write buffered data."""
        for writer in self._writers:
            writer.finish()


CEILING_DBFS = -1.0  # highest sample after normalisation
_ROUNDS = 8

QUIETEST_LUFS, LOUDEST_LUFS = -60.0, 0.0


def require_loudness(lufs: float) -> float:
    """Return a valid loudness; raise InputError otherwise, including for NaN."""
    lufs = validation.real(lufs, "normalize")
    if not QUIETEST_LUFS <= lufs <= LOUDEST_LUFS:
        raise InputError(
            f"normalize is {lufs:g} LUFS; must be {QUIETEST_LUFS:g} to {LOUDEST_LUFS:g} ("
            "-23 for broadcast, -16 for phones)"
        )
    return lufs


class ClickMeter:
    """Loudness meter of the click channel, fed with blocks of a render."""

    def __init__(self, sample_rate: float) -> None:
        if sample_rate < MIN_RATE or sample_rate != int(sample_rate):
            raise InputError(
                f"sample_rate is {sample_rate:g}; loudness needs a whole number from {MIN_RATE} Hz"
            )
        self._meter = StepMeter(int(sample_rate), (1.0,))
        self._waiting = np.zeros((0, 1), np.float32)
        self.peak = 0.0

    def feed(self, samples: SampleArray) -> None:
        """Feed the next samples, float32 (frames, 2)."""
        click = samples[:, CLICK : CLICK + 1]
        self.peak = max(self.peak, float(np.abs(click).max(initial=0.0)))
        self._waiting = np.concatenate([self._waiting, click])
        size = self._meter.block_frames
        while len(self._waiting) >= size:
            self._meter.feed(self._waiting[:size])
            self._waiting = self._waiting[size:]

    def steps(self) -> Steps:
        """Return the energy of all steps. Call it once, at the end."""
        if len(self._waiting):
            self._meter.feed(self._waiting)
        return self._meter.finish()

    def gain_to(self, lufs: float) -> float:
        """Return the linear gain to a loudness, limited by the highest sample."""
        steps = self.steps()
        if loudness_of(steps) is None:
            return 1.0
        gain = 1.0
        for _ in range(_ROUNDS):  # a gain changes which steps pass the gate at -70 LUFS
            now = replace(steps, energy=steps.energy * gain**2).integrated()
            gain *= gain_of_db(lufs - now)
        return min(gain, gain_of_db(CEILING_DBFS) / self.peak)


def loudness_of(steps: Steps) -> float | None:
    """Return the gated loudness, LUFS; None for silence."""
    found = steps.integrated()
    return found if found > SILENCE_LUFS else None
