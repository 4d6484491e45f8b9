"""Frames as a device sends them."""

from __future__ import annotations

from overview_dsp.devices.sensors import frames


def encode_frame(kind, sequence, stamp_us, values):
    """One frame with its zero; `values` as in the payload."""
    head = (kind, sequence & 0xFFFF, stamp_us & 0xFFFFFFFF)
    packing = frames._LAYOUTS[kind][1]
    if packing is frames._SIX:
        values = (*values, *(0,) * (6 - len(values)))
    return frames.framed(packing.pack(*head, *values))
