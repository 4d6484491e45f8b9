"""What `kernels/derive.py` makes of a parameter or a click, one at a time."""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels import derive, layout
from overview_dsp.kernels.math_functions import plain

one_pole = plain(derive.one_pole)


def write_click(m, mode, rate):
    """Give kind 0 of the first surface of a memory block a single mode."""
    w = m.view(np.int64)
    m[layout.S_SAMPLE_RATE] = rate
    w[layout.SURFACES + layout.KIND_CLICK] = 1
    at = layout.SURFACES + layout.CLICKS
    m[at + layout.CLICK_FREQUENCY_HZ] = mode.frequency_hz
    m[at + layout.CLICK_DECAY_MS] = mode.decay_ms
    m[at + layout.CLICK_GAIN_DB] = mode.gain_db
    derive.derive_clicks(m, w, layout.SURFACES)


def mode_coefficients(mode, rate):
    """A mode's columns in a surface, or None where it would fold back."""
    m = np.zeros(layout.SURFACES + layout.SLOT_SIZE)
    write_click(m, mode, rate)
    heard = m.view(np.int64)[layout.SURFACES + layout.KIND_MODES]
    return m[layout.SURFACES + layout.MODES :][: layout.MODE_SIZE] if heard else None


def ring_samples(mode, rate):
    """How many samples a kind of that mode rings."""
    m = np.zeros(layout.SURFACES + layout.SLOT_SIZE)
    write_click(m, mode, rate)
    return int(m.view(np.int64)[layout.SURFACES + layout.KIND_RING])
