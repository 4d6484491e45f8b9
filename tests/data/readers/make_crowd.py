"""Made-up crowds for the tests: a murmur, cheers over it, whistles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def murmur(seconds: float, rate: int = 44_100, level_db: float = -25.0, seed: int = 1) -> Any:
    """Noise that falls with frequency, as far voices do, float64 (frames,)."""
    from scipy.signal import lfilter

    noise = np.random.default_rng(seed).normal(size=round(seconds * rate))
    pole = np.exp(-2.0 * np.pi * 500.0 / rate)
    voices = lfilter([1.0 - pole], [1.0, -pole], noise)
    return voices * 10.0 ** (level_db / 20.0) / np.sqrt(np.mean(voices**2))


def swelled(
    sound: NDArray[np.float64], at_s: float, length_s: float, db: float, rate: int = 44_100
) -> Any:
    """The same sound, louder for a while: up within half a second, down again in a second."""
    time = np.arange(len(sound)) / rate
    up = np.clip((time - at_s) / 0.5 + 0.5, 0.0, 1.0)
    down = np.clip((at_s + length_s - time) / 1.0 + 0.5, 0.0, 1.0)
    return sound * 10.0 ** (np.minimum(up, down) * db / 20.0)


def write_long(
    path: Path, seconds: int, rate: int = 44_100, cheer_each_s: int = 300
) -> list[float]:
    """Write stereo murmur with a cheer of 10 s every so often; returns where they begin."""
    import soundfile

    minute = np.stack([murmur(60.0, rate, seed=s) for s in (1, 2)], axis=1).astype(np.float32)
    cheers = [float(t) for t in range(cheer_each_s // 2, seconds - 20, cheer_each_s)]
    with soundfile.SoundFile(str(path), "w", rate, 2, "PCM_16") as file:
        for start in range(0, seconds, 60):
            block = minute[: (seconds - start) * rate].copy()
            for cheer in cheers:
                first = round((cheer - start) * rate)
                if 0 <= first < len(block):
                    block[first : first + 10 * rate] *= 4.0
            file.write(block)
    return cheers
