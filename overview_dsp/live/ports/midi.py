"""MIDI ports: found, opened, read. `rtmidi` and `rtmidi2` are imported here alone, and late.

Either will do: python-rtmidi has ready-made files up to Python 3.12, rtmidi2 also for later ones.
"""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.ports.port import PortLostError, QueuedPort

MAX_WAITING = 4096
QUEUED = 1024
SYSTEMS_OF_RTMIDI2 = ("API_MACOSX_CORE", "API_LINUX_ALSA", "API_UNIX_JACK", "API_WINDOWS_MM")

LOOK_EVERY_S = 0.5
ACTIVE_SENSING = 0xFE
SENSED_WITHIN_S = 0.5
"""Who sends active sensing does every 0.3 s; then this is silence (MIDI 1.0, active sensing)."""

_NUMBERS = re.compile(r" \d+:\d+$")


class _System:
    """Input of one of the machine's MIDI systems (ALSA, JACK, ...), by either library."""

    def __init__(self, library: Any, api: int) -> None:
        self._is_python_rtmidi = hasattr(library, "get_compiled_api")  # python-rtmidi
        if self._is_python_rtmidi:
            self._input = library.MidiIn(api, name="overview")
        else:
            self._input = library.MidiIn("overview", QUEUED, api)
            if self._input.get_current_api() != api:  # it takes another in place of a missing one
                raise RuntimeError("not this system")
        self._opened = False

    def ports(self) -> list[str]:
        """Names of the ports that messages can come from."""
        names = self._input.get_ports() if self._is_python_rtmidi else self._input.ports
        return [str(name) for name in names]

    def open(self, index: int, take: Callable[[bytes], None]) -> None:
        """Open a port; `take` is called on a thread of its own."""
        self._input.ignore_types(True, True, False)  # sysex, time; not active sensing
        if self._is_python_rtmidi:
            self._input.set_callback(lambda event, _: take(bytes(event[0])))
            self._input.open_port(index, name="in")
        else:
            self._input.callback = lambda message, _: take(bytes(message))
            self._input.open_port(index)
        self._opened = True

    def close(self) -> None:
        """Close what was opened."""
        if self._opened and self._is_python_rtmidi:
            self._input.cancel_callback()
        elif self._opened:
            self._input.callback = None
        if self._opened:
            self._input.close_port()
        if self._is_python_rtmidi:
            self._input.delete()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without what the systems' own libraries write to the terminal where they are missing."""
    os.environ.setdefault("JACK_NO_START_SERVER", "1")  # looking starts no server
    kept = os.dup(2)
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def _library() -> tuple[Any, Iterable[int]]:
    """Return the library and the systems that it may have; OverviewError without one."""
    try:
        import rtmidi
    except ImportError:
        try:
            import rtmidi2
        except ImportError:
            raise OverviewError(
                f"MIDI needs python-rtmidi or rtmidi2: {install_command('midi')}"
            ) from None
        return rtmidi2, [getattr(rtmidi2, name) for name in SYSTEMS_OF_RTMIDI2]
    return rtmidi, rtmidi.get_compiled_api()


def _systems() -> list[_System]:
    """Return an unopened input of each MIDI system that answers; OverviewError as `_library`."""
    library, systems = _library()
    found: list[_System] = []
    with _quiet():
        for api in systems:
            with contextlib.suppress(Exception):  # rtmidi has a class of its own for a missing one
                found.append(_System(library, api))
    return found


def midi_ports() -> list[str]:
    """The names of the ports that messages can come from; OverviewError without rtmidi."""
    systems = _systems()
    names = [_plain(name) for one in systems for name in one.ports()]
    for one in systems:
        one.close()
    return list(dict.fromkeys(names))


def _plain(name: str) -> str:
    """Without the numbers that ALSA gives anew each time."""
    return _NUMBERS.sub("", name)


def _matching(names: list[str], wanted: str) -> list[int]:
    """The ports of that name, whole or a part of it, whatever its case."""
    plain = [_plain(name) for name in names]
    whole = [index for index, name in enumerate(plain) if name == wanted]
    return whole or [i for i, name in enumerate(plain) if wanted.casefold() in name.casefold()]


class MidiPort(QueuedPort):
    """Open MIDI port, whose messages arrive on a thread of rtmidi's."""

    def __init__(self, wanted: str) -> None:
        """Open the port of that name, or the one whose name has that in it.

        Raises
        ------
        InputError
            No such port, or several.
        OverviewError
            Neither python-rtmidi nor rtmidi2 is installed.
        """
        super().__init__(f"midi:{wanted}", MAX_WAITING)
        self._input, self._port = self._open(wanted)
        self._looked_at = time.monotonic()
        self._sensed_at: float | None = None

    def _open(self, wanted: str) -> tuple[_System, str]:
        systems = _systems()
        chosen: _System | None = None
        try:
            for one in systems:
                names = one.ports()
                found = _matching(names, wanted)
                if len(found) > 1:
                    several = ", ".join(_plain(names[index]) for index in found)
                    raise InputError(f"{self.name}: several are called so: {several}")
                if found:
                    chosen = one
                    one.open(found[0], self.put)
                    return one, names[found[0]]
            known = ", ".join(_plain(name) for one in systems for name in one.ports())
            raise InputError(f"{self.name}: no such port; there are: {known or 'none'}")
        except RuntimeError as error:  # rtmidi's
            raise InputError(f"{self.name}: can't be opened ({error}); is it held by another "
                             "program?") from None  # fmt: skip
        finally:
            for one in systems:
                if one is not chosen:
                    one.close()

    def receive(self, wait_s: float) -> list[bytes]:
        """Return the messages that have come, as `Port.receive`.

        Raises
        ------
        PortLostError
            The port is gone, or no longer sends the active sensing that it sent before.
        """
        found = super().receive(wait_s)
        now = time.monotonic()
        sensing = self._sensed_at is not None or bytes([ACTIVE_SENSING]) in found
        if found and sensing:
            self._sensed_at = now
        if self._sensed_at is not None and now - self._sensed_at > SENSED_WITHIN_S:
            raise PortLostError(f"{self.name}: it has stopped to say that it is there")
        if now - self._looked_at > LOOK_EVERY_S:
            self._looked_at = now
            if self._port not in self._input.ports():
                raise PortLostError(f"{self.name}: gone")
        return [one for one in found if one[0] < 0xF0]

    def close(self) -> None:
        """Close the port."""
        self._input.close()
