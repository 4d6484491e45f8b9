"""MIDI input ports. Only this module imports `rtmidi` and `rtmidi2`, when needed.

Either library is enough. python-rtmidi has wheels up to Python 3.12, rtmidi2 also for later ones.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.ports.port import Datagram, PortLostError, QueuedPort

MAX_QUEUED = 4096
LATE_S = 0.05  # longest delay of a message; a longer one means that the two clocks differ
RTMIDI2_QUEUE = 1024
RTMIDI2_SYSTEMS = ("API_MACOSX_CORE", "API_LINUX_ALSA", "API_UNIX_JACK", "API_WINDOWS_MM")

CHECK_EVERY_S = 0.5
ACTIVE_SENSING = 0xFE
SENSED_WITHIN_S = 0.5
"""Longest time between messages of active sensing, which devices send every 0.3 s (MIDI 1.0)."""

_NUMBERS = re.compile(r" \d+:\d+$")


class _System:
    """MIDI input of one system (ALSA, JACK, ...), by either library."""

    def __init__(self, library: Any, api: int) -> None:
        self._is_python_rtmidi = hasattr(library, "get_compiled_api")  # python-rtmidi
        if self._is_python_rtmidi:
            self._input = library.MidiIn(api, name="overview")
        else:
            self._input = library.MidiIn("overview", RTMIDI2_QUEUE, api)
            if self._input.get_current_api() != api:  # it replaces a missing system by another
                raise RuntimeError("MIDI system not available")
        self._opened = False

    def ports(self) -> list[str]:
        """Return the names of the input ports."""
        names = self._input.get_ports() if self._is_python_rtmidi else self._input.ports
        return [str(name) for name in names]

    def open(self, index: int, take: Callable[[bytes, float], None]) -> None:
        """Open a port; `take` is called in a thread of the library.

        Its arguments are a message and the time since the message before, s.
        """
        self._input.ignore_types(True, True, False)  # sysex, time; not active sensing
        if self._is_python_rtmidi:
            self._input.set_callback(lambda event, _: take(bytes(event[0]), event[1]))
            self._input.open_port(index, name="in")
        else:
            self._input.callback = lambda message, _: take(bytes(message), math.inf)
            self._input.open_port(index)
        self._opened = True

    def close(self) -> None:
        """Close the port and the input."""
        if self._opened:
            if self._is_python_rtmidi:
                self._input.cancel_callback()
            else:
                self._input.callback = None
            self._input.close_port()
        if self._is_python_rtmidi:
            self._input.delete()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Suppress what libraries of missing systems write to the standard error."""
    os.environ.setdefault("JACK_NO_START_SERVER", "1")
    stderr = os.dup(2)
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 2)
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(null)


def _library() -> tuple[Any, Iterable[int]]:
    """Return the library and its possible systems; OverviewError without a library."""
    try:
        import rtmidi
    except ImportError:
        try:
            import rtmidi2
        except ImportError:
            raise OverviewError(
                f"MIDI needs python-rtmidi or rtmidi2: {install_command('midi')}"
            ) from None
        return rtmidi2, [getattr(rtmidi2, name) for name in RTMIDI2_SYSTEMS]
    return rtmidi, rtmidi.get_compiled_api()


def _systems() -> list[_System]:
    """Return an unopened input of each available MIDI system; OverviewError as `_library`."""
    library, systems = _library()
    found: list[_System] = []
    with _quiet():
        for api in systems:
            with contextlib.suppress(Exception):  # the libraries raise different classes
                found.append(_System(library, api))
    return found


def midi_ports() -> list[str]:
    """Return the names of the input ports; OverviewError without a library."""
    systems = _systems()
    names = [_plain(name) for one in systems for name in one.ports()]
    for one in systems:
        one.close()
    return list(dict.fromkeys(names))


def _plain(name: str) -> str:
    """Return a port's name without its ALSA numbers, which change."""
    return _NUMBERS.sub("", name)


def _matching(names: list[str], selected: str) -> list[int]:
    """Return the ports with a name, or else those whose names contain it in any case."""
    plain = [_plain(name) for name in names]
    exact = [index for index, name in enumerate(plain) if name == selected]
    return exact or [i for i, name in enumerate(plain) if selected.casefold() in name.casefold()]


class MidiPort(QueuedPort):
    """Open MIDI port, whose messages arrive in a thread of the library."""

    def __init__(self, selected: str) -> None:
        """Open the port with a name, or with a part of a name.

        InputError: no port or several ports match.
        OverviewError: neither python-rtmidi nor rtmidi2 is installed.
        """
        super().__init__(f"midi:{selected}", MAX_QUEUED)
        self._time_s = 0.0  # of the latest message
        self._input, self._port = self._open(selected)
        self._checked_at = time.monotonic()
        self._sensed_at: float | None = None

    def _put_after(self, message: bytes, since_s: float) -> None:
        """Append a message with its time by the system, which a busy thread doesn't delay."""
        now_s = time.monotonic()
        time_s = self._time_s + since_s
        self._time_s = time_s if now_s - LATE_S < time_s < now_s else now_s
        stamped = Datagram(message)
        stamped.time_s = self._time_s
        self.put(stamped)

    def _open(self, selected: str) -> tuple[_System, str]:
        systems = _systems()
        chosen: _System | None = None
        try:
            for one in systems:
                names = one.ports()
                found = _matching(names, selected)
                if len(found) > 1:
                    several = ", ".join(_plain(names[index]) for index in found)
                    raise InputError(f"{self.name}: several ports match: {several}")
                if found:
                    chosen = one
                    one.open(found[0], self._put_after)
                    return one, names[found[0]]
            known = ", ".join(_plain(name) for one in systems for name in one.ports())
            raise InputError(f"{self.name}: no such port; available: {known or 'none'}")
        except RuntimeError as error:  # from the library
            raise InputError(f"{self.name}: can't be opened ({error}); close other programs that "
                             "use it") from None  # fmt: skip
        finally:
            for one in systems:
                if one is not chosen:
                    one.close()

    def receive(self, wait_s: float) -> list[bytes]:
        """Return new messages, as `Port.receive`.

        PortLostError: the port is disconnected, or has stopped sending active sensing.
        """
        found = super().receive(wait_s)
        now = time.monotonic()
        sensing = self._sensed_at is not None or bytes([ACTIVE_SENSING]) in found
        if found and sensing:
            self._sensed_at = now
        if self._sensed_at is not None and now - self._sensed_at > SENSED_WITHIN_S:
            raise PortLostError(f"{self.name}: its active sensing has stopped")
        if now - self._checked_at > CHECK_EVERY_S:
            self._checked_at = now
            if self._port not in self._input.ports():
                raise PortLostError(f"{self.name}: disconnected")
        return [one for one in found if one[0] < 0xF0]

    def close(self) -> None:
        """Close the port."""
        self._input.close()
