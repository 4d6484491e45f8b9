"""Serial ports: found, opened, read. `serial` is imported here alone, and late."""

from __future__ import annotations

import contextlib
import errno
import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from overview_dsp.devices.sensors.decoders import DetectedFormat, detect
from overview_dsp.errors import InputError
from overview_dsp.live.ports.port import WAIT_S, Port, PortLostError

BAUD = 115_200
WRITE_S = 0.01
"""How long a write waits for buffer space."""


@dataclass(frozen=True)
class PortInfo:
    """A port: its name, what it says it is, its USB identity (empty if it has none)."""

    device: str
    description: str
    identity: str


class SerialPort(Port):
    """Open serial port."""

    def __init__(self, device: str, baud: int = BAUD) -> None:
        """Open it for this program alone.

        Raises
        ------
        InputError
            No such port, no permission, held by another program, a speed it can't do.
        """
        import serial

        try:
            self._port: Any = serial.Serial(
                device, baud, timeout=WAIT_S, write_timeout=WRITE_S, exclusive=_exclusive()
            )
        except (serial.SerialException, OSError, ValueError) as error:
            raise InputError(f"serial:{device}: {_why(error, baud)}") from None
        self.name = f"serial:{device}"
        self._lost = (serial.SerialException, OSError, TypeError)
        self._full = serial.SerialTimeoutException

    def receive(self, wait_s: float) -> list[bytes]:
        """Return the bytes that have come, as `Port.receive`."""
        try:
            if self._port.timeout != wait_s:  # it is set in the driver
                self._port.timeout = wait_s
            data: bytes = self._port.read(max(1, self._port.in_waiting))
            if self._port.in_waiting:  # what came with the byte that was waited for
                data += self._port.read(self._port.in_waiting)
        except self._lost as error:
            raise PortLostError(f"{self.name}: {error}") from None
        return [data] if data else []

    @property
    def waiting(self) -> int:
        """Bytes received and not yet read; 0 if the device is gone."""
        try:
            return int(self._port.in_waiting)
        except self._lost:  # the next read says so
            return 0

    def write(self, data: bytes) -> bool:
        """Send bytes; return whether all of them were accepted within 10 ms."""
        try:
            self._port.write(data)
        except self._full:
            return False
        except self._lost as error:
            raise PortLostError(f"{self.name}: {error}") from None
        return True

    def close(self) -> None:
        """Close the port; may be called twice."""
        with contextlib.suppress(*self._lost):
            self._port.close()


def _exclusive() -> bool | None:
    return True if os.name == "posix" else None  # Windows never shares a port


def _why(error: Exception, baud: int) -> str:
    code = getattr(error, "errno", None)
    text = str(error)
    if isinstance(error, FileNotFoundError) or code == errno.ENOENT or "FileNotFound" in text:
        return "no such port; `overview devices` lists them"
    if code == errno.EACCES or "PermissionError" in text or "Permission denied" in text:
        return ("not allowed, or held by another program; close that, or (Linux) join the port's "
                "group: sudo usermod -a -G dialout $USER, then log in again")  # fmt: skip
    if code in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text:
        return "held by another program (a serial monitor?); close it and try again"
    if isinstance(error, ValueError):
        return f"{baud} bit/s is no speed of this port; common ones are 9600 and 115200"
    return f"can't be opened ({text})"


def ports() -> list[PortInfo]:
    """The ports of this machine that have a device, by name."""
    from serial.tools import list_ports

    return [
        PortInfo(one.device, one.description, _identity(one))
        for one in sorted(list_ports.comports(), key=lambda one: str(one.device))
        # built-in ports that may not exist say nothing of themselves
        if one.hwid != "n/a"
    ]


def _identity(one: Any) -> str:
    if one.vid is None:
        return ""
    return f"{one.vid:04x}:{one.pid:04x}:{one.serial_number or one.location or ''}"


def find_again(device: str, identity: str) -> str:
    """The port that a device has now, by its USB identity; its old name if that isn't known.

    Raises
    ------
    InputError
        No port has a device of that identity; its old name may be another one's by now.
    """
    if not identity:
        return device
    found = [one.device for one in ports() if one.identity == identity]
    if not found:
        raise InputError(f"serial:{device}: no such port: {identity} isn't plugged in")
    return device if device in found else found[0]


def identity_of(device: str) -> str:
    """A port's USB identity, or an empty text; links to it (/dev/serial/by-id) are followed."""
    names = {device, os.path.realpath(device)}
    return next((one.identity for one in ports() if one.device in names), "")


def listen(devices: list[str], seconds: float, baud: int = BAUD) -> dict[str, str]:
    """Return what each port seems to send, listening to all at once; that may restart a device.

    The words are for the user: a format, why it isn't known, or why the port can't be opened.
    """
    with ThreadPoolExecutor(max(1, len(devices))) as pool:
        heard = pool.map(lambda device: _listen(device, seconds, baud), devices)
        return dict(zip(devices, heard, strict=True))


def _listen(device: str, seconds: float, baud: int) -> str:
    data = bytearray()
    until = time.monotonic() + seconds
    found: DetectedFormat | str | None = None
    try:
        with contextlib.closing(SerialPort(device, baud)) as port:
            while time.monotonic() < until and not isinstance(found, DetectedFormat):
                data += b"".join(port.receive(WAIT_S))
                found = detect(bytes(data[-8192:]))
        if found is None:
            found = detect(bytes(data[-8192:]), timed_out=True)
    except (InputError, PortLostError) as error:
        return str(error)
    silent = f"nothing in {seconds:g} s" if not data else f"{len(data)} bytes, too few to detect"
    return silent if found is None else str(found)
