"""Weight of each channel of a recording in its loudness, by the position of its speaker.

Weights of ITU-R BS.1770-5, table 3: 1.41 (+1.5 dB) for speakers at ear height, 60 to 120 degrees to
the side, 0 for low-frequency effects, 1 for all others.
"""

from __future__ import annotations

from overview_dsp.files.toml import load_toml

SIDE_WEIGHT = 1.41
"""Weight of the power of a side speaker."""

_TABLES = load_toml(__file__, "tables.toml")
_WEIGHTS = {"LFE": 0.0, "Ls": SIDE_WEIGHT, "Rs": SIDE_WEIGHT}

# bits of the channel mask in a WAVE header for speakers with a weight other than 1
_MASK_LFE = 0x8
_MASK_BACK = (0x10, 0x20)
_MASK_SIDE = (0x200, 0x400)


def layout_of(channels: int, xiph: bool = False) -> tuple[str, ...] | None:
    """Return the usual speakers for a number of channels; None without a usual layout.

    `xiph` selects the order of Vorbis and Opus, in which the centre is second and the LFE last.
    """
    usual = _TABLES["layouts"] | (_TABLES["xiph_layouts"] if xiph else {})
    return tuple(usual[str(channels)]) if str(channels) in usual else None


def weights_of(layout: tuple[str, ...]) -> tuple[float, ...]:
    """Return the weight of each channel's power."""
    return tuple(_WEIGHTS.get(name, 1.0) for name in layout)


def weights_of_mask(mask: int, channels: int) -> tuple[float, ...] | None:
    """Return the weights of a WAVE channel mask; None if it does not cover all channels.

    "Back" speakers without side speakers are the surround speakers of 5.1.
    """
    bits = [1 << i for i in range(32) if mask >> i & 1]
    if len(bits) != channels:
        return None
    side = _MASK_SIDE if any(bit in _MASK_SIDE for bit in bits) else _MASK_BACK
    return tuple(0.0 if bit == _MASK_LFE else SIDE_WEIGHT if bit in side else 1.0 for bit in bits)
