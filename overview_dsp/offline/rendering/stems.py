"""Stems: one sound file per channel and one with the trace; loudness of the click channel.

Loudness follows ITU-R BS.1770. Normalisation changes the click channel only; the tactor keeps its
level. Where the gain would raise true peaks above -1 dBFS, a look-ahead limiter lowers it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.data.analysis.loudness import MIN_RATE, SILENCE_LUFS, StepMeter, Steps
from overview_dsp.errors import InputError
from overview_dsp.files.sound import SoundWriter
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.layout import CLICK, TRACE_COLUMNS
from overview_dsp.offline.rendering.limiter import Limiter, TruePeaks
from overview_dsp.units import gain_to_db

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
        self,
        path: Path,
        sample_rate: float,
        subtype: str | None,
        full_torque: float,
        enabled: bool,
        tactors: int = 1,
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
            self._writers = [
                SoundWriter(one, sample_rate, kept, count)
                for one, count in zip(single, (1, tactors), strict=True)
            ]
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
        for writer, signal in zip(self._writers, np.split(samples, [1], axis=1), strict=False):
            writer.write(np.ascontiguousarray(signal))
        curves = trace[:, _COLUMNS].astype(np.float32)
        curves[:, CURVES.index("torque")] /= np.float32(self._full_torque)
        self._writers[-1].write(curves)

    def finish(self) -> None:
        """Write buffered data."""
        for writer in self._writers:
            writer.finish()


CEILING_DBFS = -1.0  # highest true peak after normalisation
_ROUNDS = 8
_LIMITED_ROUNDS = 6  # most renders that approach a loudness with the limiter
_NEAR_LU = 0.05  # difference from the loudness that is near enough, LU
_INTERPOLATION_DB = 0.2  # a true peak of four times the rate may be that much too low, dB
_MOST_LIMITED_DB = 20.0  # highest reduction of a peak; beyond it strong and weak clicks are equal

QUIETEST_LUFS, LOUDEST_LUFS = -60.0, 0.0


def require_loudness(lufs: float) -> float:
    """Return a valid loudness; raise InputError otherwise, including for NaN."""
    hint = " (-23 for broadcast, -16 for phones)"
    return validation.within(lufs, "normalize", QUIETEST_LUFS, LOUDEST_LUFS, " LUFS", hint)


class ClickMeter:
    """Meter for loudness and true peaks of the click channel, fed with blocks of a render."""

    def __init__(self, sample_rate: float) -> None:
        if sample_rate < MIN_RATE or sample_rate != int(sample_rate):
            raise InputError(
                f"sample_rate is {sample_rate:g}; loudness needs a whole number from {MIN_RATE} Hz"
            )
        self._meter = StepMeter(int(sample_rate), (1.0,))
        self._waiting = np.zeros((0, 1), np.float32)
        self.true_peaks = TruePeaks(sample_rate)

    def feed(self, samples: SampleArray) -> None:
        """Feed the next samples, float32 (frames, 2)."""
        click = samples[:, CLICK : CLICK + 1]
        self.true_peaks.feed(click[:, 0])
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


def gain_to(steps: Steps, lufs: float) -> float:
    """Return the linear gain to a loudness; 1 for silence."""
    gain = 1.0
    for _ in range(_ROUNDS if loudness_of(steps) is not None else 0):
        # a gain changes which steps pass the gate at -70 LUFS
        now = replace(steps, energy=steps.energy * gain**2).integrated()
        gain *= gain_of_db(lufs - now)
    return gain


def limited_to(
    lufs: float, sample_rate: float, blocks: Callable[[], Iterable[Any]]
) -> tuple[Limiter, float]:
    """Return the limiter for a loudness, and its linear gain outside of peaks.

    `blocks` renders; each call gives the same blocks. Without peaks above `CEILING_DBFS` one render
    is enough. Otherwise the gain is raised until the limited click has the loudness, in at most six
    more renders, until the highest peak is reduced by 20 dB.
    """
    meter = ClickMeter(sample_rate)
    for block in blocks():
        meter.feed(block.samples)
    peaks, step_frames = meter.true_peaks.finish(), meter.true_peaks.step_frames
    gain_db = gain_to_db(gain_to(meter.steps(), lufs))
    ceiling_db = CEILING_DBFS - _INTERPOLATION_DB
    unlimited_db = ceiling_db - gain_to_db(max(peaks.max(), 1e-12))

    def limiter() -> Limiter:
        return Limiter(peaks, step_frames, gain_of_db(gain_db), gain_of_db(ceiling_db))

    before: tuple[float, float] | None = None
    for _ in range(_LIMITED_ROUNDS if gain_db > unlimited_db else 0):
        gain_db = min(gain_db, unlimited_db + _MOST_LIMITED_DB)
        limited, meter = limiter(), ClickMeter(sample_rate)
        for block in blocks():
            limited.apply(block.samples[:, CLICK])
            meter.feed(block.samples)
        now = meter.steps().integrated()
        if abs(lufs - now) <= _NEAR_LU or (before is not None and gain_db == before[0]):
            break
        slope = 1.0 if before is None else (now - before[1]) / (gain_db - before[0])
        before = gain_db, now
        gain_db += (lufs - now) / min(max(slope, 0.2), 1.0)
    gain_db = min(gain_db, unlimited_db + _MOST_LIMITED_DB)
    return limiter(), gain_of_db(gain_db)


def loudness_of(steps: Steps) -> float | None:
    """Return the gated loudness, LUFS; None for silence."""
    found = steps.integrated()
    return found if found > SILENCE_LUFS else None
