"""A game pad as an output: a DualSense by USB is a sound card, its coils channels 3 and 4."""

from __future__ import annotations

from overview_dsp.live.output_settings import OutputSettings, SignalSettings

NAMES = ("dualsense", "wireless controller")
"""What its card is called, by the system and the pad's age; an older pad's has two channels."""

CHANNELS = 4
SETTINGS = OutputSettings(SignalSettings((1, 2)), SignalSettings((3, 4)))
"""Clicks for both ears at its socket, the tactor's signal for both hands."""

ACTUATOR = "dualsense"


def is_pad(name: str, channels: int) -> bool:
    """Whether an output of that name and number of channels is such a pad."""
    return channels >= CHANNELS and any(word in name.casefold() for word in NAMES)
