"""How outputs are named."""

from __future__ import annotations

SILENT = "none"
"""The device that isn't one."""

PAD = "pad"
"""Whichever output is a game pad with coils."""


def device_named(device: str | None) -> int | str | None:
    """The device as PortAudio takes it: a number, a name, None for the default."""
    return int(device) if device is not None and device.isdecimal() else device
