"""How much each channel of a recording counts in its loudness, by where its speaker stands.

ITU-R BS.1770-5, table 3: 1 for the front, 1.41 (+1.5 dB) for a speaker 60 to 120 degrees to the
side at ear height, 1 for one further back or above, 0 for low-frequency effects.
"""

from __future__ import annotations

SIDE = 1.41
"""What a side speaker's power is multiplied by."""

# names as libsndfile prints them; "r" are the rear ones of 7.1, behind 120 degrees
_LAYOUTS: dict[int, tuple[str, ...]] = {
    1: ("M",),
    2: ("L", "R"),
    3: ("L", "R", "C"),
    4: ("L", "R", "Ls", "Rs"),
    5: ("L", "R", "C", "Ls", "Rs"),
    6: ("L", "R", "C", "LFE", "Ls", "Rs"),
    7: ("L", "R", "C", "LFE", "Cs", "Ls", "Rs"),
    8: ("L", "R", "C", "LFE", "Lr", "Rr", "Ls", "Rs"),
}
# Xiph's order, which libsndfile leaves as it is (Vorbis I specification, 4.3.9)
_XIPH_LAYOUTS: dict[int, tuple[str, ...]] = {
    3: ("L", "C", "R"),
    5: ("L", "C", "R", "Ls", "Rs"),
    6: ("L", "C", "R", "Ls", "Rs", "LFE"),
    7: ("L", "C", "R", "Ls", "Rs", "Cs", "LFE"),
    8: ("L", "C", "R", "Ls", "Rs", "Lr", "Rr", "LFE"),
}
_WEIGHTS = {"LFE": 0.0, "Ls": SIDE, "Rs": SIDE}

# bits of a WAVE header's channel mask that aren't 1
_MASK_LFE = 0x8
_MASK_BACK = (0x10, 0x20)
_MASK_SIDE = (0x200, 0x400)


def layout_of(channels: int, xiph: bool = False) -> tuple[str, ...] | None:
    """Return the usual speakers of so many channels, None if there is no usual layout.

    Parameters
    ----------
    channels
        How many, 1 or more.
    xiph
        The order of Vorbis and Opus, where the centre is second and the LFE last.
    """
    return (_XIPH_LAYOUTS if xiph else {}).get(channels) or _LAYOUTS.get(channels)


def weights_of(layout: tuple[str, ...]) -> tuple[float, ...]:
    """Return what each channel's power is multiplied by."""
    return tuple(_WEIGHTS.get(name, 1.0) for name in layout)


def weights_of_mask(mask: int, channels: int) -> tuple[float, ...] | None:
    """Return the weights of a WAVE channel mask; None if it doesn't name all channels.

    "Back" speakers without side ones are 5.1's surrounds, and count as such.
    """
    bits = [1 << i for i in range(32) if mask >> i & 1]
    if len(bits) != channels:
        return None
    side = _MASK_SIDE if any(bit in _MASK_SIDE for bit in bits) else _MASK_BACK
    return tuple(0.0 if bit == _MASK_LFE else SIDE if bit in side else 1.0 for bit in bits)
