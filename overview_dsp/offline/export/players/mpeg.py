"""The MPEG haptics reference decoder (ISO/IEC 23090-31), for what HJIF documents hold.

Channels and effects are summed as signals: what has one frequency adds by its phase, which counts
from the effect's position; different frequencies add in energy. A wave's amplitude is linear
between keyframes. A transient is 22 ms of 90.9 Hz (two cycles), whatever is asked of it. Gains
multiply.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import LEVELS_PER_S

TRANSIENT_MS, TRANSIENT_HZ = 22, 1000.0 / 11.0


def played(hjif: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude of a document's vibrotactile perceptions; a tick is a millisecond."""
    parts = [
        part
        for perception in hjif["perceptions"]
        if perception["perception_modality"] == "Vibrotactile"
        for channel in perception["channels"]
        for band in channel["bands"]
        for effect in band["effects"]
        for part in _parts(band["band_type"], effect, channel["gain"])
    ]
    count = max((start + len(amplitude) for start, amplitude, _, _ in parts), default=1)
    phasors: dict[float, NDArray[np.complex128]] = {}
    for start, amplitude, hz, phase in parts:
        summed = phasors.setdefault(hz, np.zeros(count, np.complex128))
        turn = phase - 2.0 * np.pi * hz * start / LEVELS_PER_S
        summed[start : start + len(amplitude)] += amplitude * np.exp(1j * turn)
    energy = np.zeros(count)
    for summed in phasors.values():
        energy += np.abs(summed) ** 2
    return np.asarray(np.sqrt(energy))


def _parts(
    band: str, effect: dict[str, Any], gain: float
) -> list[tuple[int, NDArray[np.float64], float, float]]:
    """(start, amplitude at each millisecond, Hz, phase) of an effect's waves."""
    frames, position = effect["keyframes"], effect["position"]
    if band == "Transient":
        return [
            (
                position + frame["relative_position"],
                np.full(TRANSIENT_MS, gain * frame["amplitude_modulation"]),
                TRANSIENT_HZ,
                0.0,
            )
            for frame in frames
        ]
    at = [frame["relative_position"] for frame in frames]
    amplitude = np.interp(
        np.arange(at[-1] + 1), at, [gain * frame["amplitude_modulation"] for frame in frames]
    )
    return [(position, amplitude, frames[0]["frequency_modulation"], effect["phase"])]
