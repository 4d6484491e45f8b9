"""Sensitivity of the skin to vibration, by frequency."""

from __future__ import annotations

import math

BEST_HZ = (200.0, 300.0)
"""Range of highest sensitivity, Hz."""

DB_PER_OCTAVE = 10.0


def pacinian_db(frequency_hz: float) -> float:
    """Return the sensitivity at a frequency relative to 200 to 300 Hz, dB <= 0.

    It falls by 20 dB from 200 to 50 Hz (equal-sensation filter of Google's audio-to-tactile). The
    same slope is assumed above 300 Hz. Thresholds are lowest at 150 to 300 Hz (Brisben, Hsiao,
    Johnson 1999).
    """
    low, high = BEST_HZ
    beyond = max(math.log2(low / frequency_hz), math.log2(frequency_hz / high), 0.0)
    return -DB_PER_OCTAVE * beyond
