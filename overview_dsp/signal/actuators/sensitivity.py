"""What the skin feels of a vibration, by its frequency."""

from __future__ import annotations

import math

BEST_HZ = (200.0, 300.0)
"""Where the skin feels most."""

DB_AN_OCTAVE = 10.0


def pacinian_db(frequency_hz: float) -> float:
    """How much weaker a vibration is felt than one of the same amplitude at 200 to 300 Hz, dB <= 0.

    20 dB from 200 to 50 Hz (the equal-sensation filter of Google's audio-to-tactile), the same
    slope taken above 300 Hz; the threshold is lowest at 150 to 300 Hz (Brisben, Hsiao, Johnson
    1999).
    """
    low, high = BEST_HZ
    beyond = max(math.log2(low / frequency_hz), math.log2(frequency_hz / high), 0.0)
    return -DB_AN_OCTAVE * beyond
