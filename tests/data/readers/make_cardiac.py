"""Made-up hearts for the tests: beats at chosen times, as ECG, pulse wave and WFDB files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

# (seconds from the R wave, width in seconds, height in mV) of P, Q, R, S and T
_WAVES = (
    (-0.17, 0.025, 0.12),
    (-0.03, 0.008, -0.12),
    (0.0, 0.010, 1.1),
    (0.03, 0.010, -0.25),
    (0.25, 0.05, 0.3),
)


def beat_times(
    seconds: float, bpm: float = 70.0, seed: int = 1, spread: float = 0.02
) -> NDArray[np.float64]:
    """Times of a steady heart whose intervals vary a little."""
    count = int(seconds * bpm / 60.0) + 10
    intervals = 60.0 / bpm * (1.0 + spread * np.random.default_rng(seed).normal(size=count))
    times = 0.4 + np.cumsum(intervals)
    return times[times < seconds - 0.4]


def ecg(
    beats: NDArray[np.float64], seconds: float, rate: float, noise: float = 0.02, seed: int = 1
) -> NDArray[np.float64]:
    """An ECG in mV with breath and noise on it."""
    time = np.arange(round(seconds * rate)) / rate
    found = 0.1 * np.sin(2.0 * np.pi * 0.25 * time)
    found += noise * np.random.default_rng(seed).normal(size=len(time))
    for beat in beats:
        for offset, width, height in _WAVES:
            centre = beat + offset
            low, high = np.searchsorted(time, [centre - 6 * width, centre + 6 * width])
            found[low:high] += height * np.exp(-0.5 * ((time[low:high] - centre) / width) ** 2)
    return found


def with_ectopic_beats(
    every: int, ventricular: bool, noise: float = 0.01, seed: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """An ECG at 250 Hz whose every n-th beat comes early; times of all beats, and of early ones.

    A ventricular one is wide and tall, with a full pause; an atrial one looks like the others.
    """
    random = np.random.default_rng(seed)
    intervals = 0.85 * (1.0 + 0.02 * random.normal(size=148))
    early = np.arange(1 if every == 2 else 7, 147, every)
    intervals[early] = 0.85 * random.uniform(0.55, 0.72, len(early))
    intervals[early + 1] = (
        1.7 - intervals[early] if ventricular else 0.85 * random.uniform(1.05, 1.2, len(early))
    )
    beats = 0.5 + np.cumsum(intervals)
    seconds = float(beats[-1]) + 1.0
    found = ecg(np.delete(beats, early) if ventricular else beats, seconds, 250.0, noise, seed)
    time = np.arange(len(found)) / 250.0
    for beat in beats[early] if ventricular else ():
        found += 1.5 * np.exp(-0.5 * ((time - beat) / 0.035) ** 2)
        found -= 0.45 * np.exp(-0.5 * ((time - beat - 0.15) / 0.06) ** 2)
    return found, beats, beats[early]


def pulse_wave(beats: NDArray[np.float64], seconds: float, rate: float) -> NDArray[np.float64]:
    """A pulse wave whose peaks are at the beats, as a photoplethysmogram shows it."""
    time = np.arange(round(seconds * rate)) / rate
    found = 500.0 + 0.5 * np.random.default_rng(1).normal(size=len(time))
    for beat in beats:
        found += 100.0 * np.exp(-0.5 * ((time - beat) / 0.1) ** 2)
        found += 25.0 * np.exp(-0.5 * ((time - beat - 0.35) / 0.08) ** 2)
    return found


def write_record(
    folder: Path,
    signals: dict[str, NDArray[np.float64]],
    rate: float,
    fmt: str = "16",
    name: str = "made_up",
    **extra: Any,
) -> Path:
    """Write a WFDB record; returns its header."""
    import wfdb

    wfdb.wrsamp(
        name,
        fs=rate,
        units=["mV"] * len(signals),
        sig_name=list(signals),
        p_signal=np.stack(list(signals.values()), axis=1),
        fmt=[fmt] * len(signals),
        write_dir=str(folder),
        **extra,
    )
    return folder / f"{name}.hea"


def annotate(header: Path, frames: list[int], symbols: list[str], suffix: str = "atr") -> Path:
    """Write an annotation file beside a header."""
    import wfdb

    wfdb.wrann(header.stem, suffix, np.array(frames), symbol=symbols, write_dir=str(header.parent))
    return header.with_suffix(f".{suffix}")


def agreement(
    found: NDArray[np.float64], true: NDArray[np.float64], within_s: float = 0.05
) -> tuple[float, float]:
    """Sensitivity and precision: the parts of true and of found beats that have one of the others.

    Each beat counts for one of the others at most.
    """
    matched = i = j = 0
    while i < len(found) and j < len(true):
        if abs(found[i] - true[j]) <= within_s:
            matched, i, j = matched + 1, i + 1, j + 1
        elif found[i] < true[j]:
            i += 1
        else:
            j += 1
    return matched / len(true), matched / len(found)
