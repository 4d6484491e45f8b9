"""PortAudio and its Python binding, sounddevice, which is imported here alone, and late.

It lists the devices of its start only, and can't be ended once its JACK server has died.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from typing import Any

from overview_dsp.errors import OverviewError, require_internals

SOUNDDEVICE = "sounddevice>=0.4.6,<0.6"
"""As pyproject.toml has it. `_StreamBase` is there for library authors; the rest of its inside is
promised to nobody."""

_INTERNALS = (
    "_StreamBase",
    "_ffi.cast",
    "_ffi.dlopen",
    "_lib",
    "_initialized",
    "_initialize",
    "_terminate",
)

SILENT = "none"
"""Device name of no sound."""

PAD = "pad"
"""Device name of whichever output is a game pad with voice coils."""

_ABANDONED: list[Any] = []

_LIBRARY_HINTS = {
    "linux": "install it (Debian, Ubuntu: apt install libportaudio2; Fedora: dnf install "
    "portaudio; Arch: pacman -S portaudio)",
    "darwin": "pip install --force-reinstall sounddevice brings it (or brew install portaudio)",
    "win32": "pip install --force-reinstall sounddevice brings it",
}


def device_named(device: str | None) -> int | str | None:
    """Return a device as PortAudio takes it: a number, a name, None for the default."""
    return int(device) if device is not None and device.isdecimal() else device


def import_sounddevice() -> Any:
    """The sounddevice module.

    Raises
    ------
    OverviewError
        No PortAudio, or a sounddevice that doesn't have what is used here; how to install them.
    """
    try:
        import sounddevice
    except OSError as error:
        hint = _LIBRARY_HINTS.get(sys.platform, _LIBRARY_HINTS["linux"])
        raise OverviewError(f"no PortAudio library ({error}): {hint}") from None
    require_internals(sounddevice, _INTERNALS, SOUNDDEVICE)
    return sounddevice


def rescan() -> None:
    """Let PortAudio look for devices again: it lists those of its start only. No stream is open."""
    sounddevice = import_sounddevice()
    # sounddevice has no public names for these
    if any("JACK" in host["name"] for host in sounddevice.query_hostapis()):
        abandon_library(sounddevice)
    else:
        sounddevice._terminate()
        sounddevice._initialize()


def abandon_library(sounddevice: Any) -> None:
    """Begin anew with a copy of the PortAudio library, and leave the old one as it is.

    Once its JACK server has died, PortAudio can't be terminated (an assertion ends the process),
    so it can't be restarted either; a copy of the file is loaded with a state of its own.
    """
    sounddevice._initialized = 0  # else sounddevice terminates the old one at exit
    handle, path = tempfile.mkstemp(suffix=".so")
    os.close(handle)
    try:
        shutil.copyfile(_loaded_file("libportaudio"), path)
        _ABANDONED.append(sounddevice._lib)  # unloaded, its threads would run into nothing
        sounddevice._lib = sounddevice._ffi.dlopen(path)
    finally:
        os.unlink(path)
    sounddevice._initialize()


def _loaded_file(name: str) -> str:
    """The file of a library that this process has loaded (Linux)."""
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
            found = [line.split(None, 5)[5].strip() for line in maps if name in line]
    except OSError:
        found = []
    for path in found:
        if os.path.isfile(path):
            return path
    raise OverviewError("the JACK server has gone; when it is back, start overview play again")
