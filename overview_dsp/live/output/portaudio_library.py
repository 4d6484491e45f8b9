"""PortAudio and its Python binding sounddevice, which only this module imports, when needed.

PortAudio lists only the devices that were connected when it was initialized. It can't be terminated
after its JACK server has died. Its library is never unloaded, because JACK's threads may call it.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import os
import shutil
import sys
import tempfile
import threading
from ctypes.util import find_library
from functools import cache
from typing import Any, Literal

from overview_dsp.errors import OverviewError, require_internals
from overview_dsp.files.toml import load_toml
from overview_dsp.live.output import jack

SOUNDDEVICE = "sounddevice>=0.4.6,<0.6"
"""Version range, as in pyproject.toml. sounddevice offers `_StreamBase` to library authors; its
other private names may change in any version."""

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
"""Device name for playback without sound."""

PAD = "pad"
"""Device name for any output that is a game pad with voice coils."""

JACK_CLIENT = b"overview"
"""Name of the JACK client. PortAudio keeps its address."""

_with_jack: list[ctypes.CDLL] = []
"""PortAudio libraries that have JACK, in the order of their use."""

OPEN_STREAMS: set[Any] = set()
"""Open streams. They must outlive every other reference, because PortAudio calls them."""

ABANDONED: list[Any] = []
"""Streams of JACK servers that don't respond; a frozen server may call them later."""

LIBRARY_LOCK = threading.RLock()
"""Lock for a search for devices, opening and closing; a feed records in a thread of its own."""

_HINTS = load_toml(__file__, "hints.toml")


def platform_hint(missing: Literal["output", "library"]) -> str:
    """Return what to do on this platform without an output, or without the PortAudio library."""
    hints: dict[str, str] = _HINTS[missing]
    return hints.get(sys.platform, hints["linux"])


def device_named(device: str | None) -> int | str | None:
    """Return a device for PortAudio: a number, a name, or None for the default output."""
    return int(device) if device is not None and device.isdecimal() else device


def import_sounddevice() -> Any:
    """Import and return the sounddevice module.

    OverviewError: PortAudio is missing, or this version of sounddevice lacks a name that is used
        here.
    """
    try:
        _prepare()
        import sounddevice
    except OSError as error:
        hint = platform_hint("library")
        raise OverviewError(f"PortAudio library not found ({error}): {hint}") from None
    require_internals(sounddevice, _INTERNALS, SOUNDDEVICE)
    return sounddevice


@cache
def _prepare() -> None:
    """Keep PortAudio loaded, and end it before sounddevice does."""
    if sys.platform == "linux":
        _keep_loaded(find_library("portaudio"))
    import sounddevice  # registers its own end first

    require_internals(sounddevice, _INTERNALS, SOUNDDEVICE)
    if _has_jack(sounddevice):
        jack.watch_server()
    atexit.register(_end)


def _keep_loaded(path: str | None) -> None:
    """Load a PortAudio library for good, and name the JACK client that it will open."""
    with contextlib.suppress(OSError, AttributeError):  # without it, or without JACK
        library = ctypes.CDLL(path, os.RTLD_NOW | os.RTLD_NODELETE)
        library.PaJack_SetClientName(JACK_CLIENT)
        _with_jack.append(library)


def _end() -> None:
    """Close all streams at exit. A JACK client ends with the process, as its server may be dead."""
    for stream in tuple(OPEN_STREAMS):
        stream.close()
    if client_name() is not None:
        import_sounddevice()._initialized = 0


def _has_jack(sounddevice: Any) -> bool:
    """Return whether PortAudio has a client on a JACK server."""
    hosts = sounddevice.query_hostapis()
    return bool(_with_jack) and any("JACK" in host["name"] for host in hosts)


def client_name() -> bytes | None:
    """Return the name of PortAudio's JACK client; None without one."""
    if not _has_jack(import_sounddevice()):
        return None
    found = ctypes.c_char_p()
    _with_jack[-1].PaJack_GetClientName(ctypes.byref(found))
    return found.value


def rescan() -> None:
    """Let PortAudio look for devices again, unless a stream plays or records."""
    if any(stream.active for stream in OPEN_STREAMS):
        return
    sounddevice = import_sounddevice()
    # sounddevice has no public names for these
    client = client_name()
    lives = client is not None and jack.has_client(client)
    if client is not None and not lives:
        _abandon_library(sounddevice)
    elif not OPEN_STREAMS:
        sounddevice._terminate()
        sounddevice._initialize()
    if not lives and _has_jack(sounddevice):
        jack.watch_server()


def _abandon_library(sounddevice: Any) -> None:
    """Initialize a copy of the PortAudio library, and leave the present one loaded.

    After its JACK server has died, PortAudio can't be terminated (an assertion would end the
    process), and so it can't be initialized again. A copy of the library file has its own state.
    """
    sounddevice._initialized = 0
    handle, path = tempfile.mkstemp(suffix=".so")
    os.close(handle)
    try:
        shutil.copyfile(_loaded_file("libportaudio"), path)
        _keep_loaded(path)
        sounddevice._lib = sounddevice._ffi.dlopen(path)
    finally:
        os.unlink(path)
    sounddevice._initialize()


def _loaded_file(name: str) -> str:
    """Return the path of a library that this process has loaded (Linux)."""
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
            found = [line.split(None, 5)[5].strip() for line in maps if name in line]
    except OSError:
        found = []
    path = next(filter(os.path.isfile, found), None)
    if path is None:
        raise OverviewError("the JACK server has stopped; start it, then start overview play again")
    return path
