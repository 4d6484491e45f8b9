"""Serial ports. Only this module imports `serial`, when needed."""

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
WRITE_TIMEOUT_S = 0.01
"""Longest wait of a write for buffer space."""


@dataclass(frozen=True)
class PortInfo:
    """Serial port: its device name, its description, its USB identity (empty if it has none)."""

    device: str
    description: str
    identity: str


class SerialPort(Port):
    """Open serial port."""

    def __init__(self, device: str, baud: int = BAUD) -> None:
        """Open a port exclusively.

        InputError: the port doesn't exist, isn't permitted, is in use, or doesn't support the
            speed.
        """
        import serial

        try:
            exclusive = True if os.name == "posix" else None  # Windows never shares a port
            self._port: Any = serial.Serial(
                device, baud, timeout=WAIT_S, write_timeout=WRITE_TIMEOUT_S, exclusive=exclusive
            )
        except (serial.SerialException, OSError, ValueError) as error:
            raise InputError(f"serial:{device}: {_reason(error, baud)}") from None
        self.name = f"serial:{device}"
        self._lost_errors = (serial.SerialException, OSError, TypeError)
        self._full_error = serial.SerialTimeoutException

    def receive(self, wait_s: float) -> list[bytes]:
        """Return new bytes, as `Port.receive`."""
        try:
            if self._port.timeout != wait_s:  # an assignment calls the driver
                self._port.timeout = wait_s
            data: bytes = self._port.read(max(1, self._port.in_waiting))
            if self._port.in_waiting:  # bytes that followed the first one
                data += self._port.read(self._port.in_waiting)
        except self._lost_errors as error:
            raise PortLostError(f"{self.name}: {error}") from None
        return [data] if data else []

    @property
    def waiting(self) -> int:
        """Bytes received and not yet read; 0 if the device is disconnected."""
        try:
            return int(self._port.in_waiting)
        except self._lost_errors:  # the next read reports it
            return 0

    def write(self, data: bytes) -> bool:
        """Send bytes; return whether all of them were accepted within 10 ms."""
        try:
            self._port.write(data)
        except self._full_error:
            return False
        except self._lost_errors as error:
            raise PortLostError(f"{self.name}: {error}") from None
        return True

    def close(self) -> None:
        """Close the port; repeated calls do nothing."""
        with contextlib.suppress(*self._lost_errors):
            self._port.close()


def _reason(error: Exception, baud: int) -> str:
    code = getattr(error, "errno", None)
    text = str(error)
    if isinstance(error, FileNotFoundError) or code == errno.ENOENT or "FileNotFound" in text:
        return "no such port; `overview devices` lists all ports"
    if code == errno.EACCES or "PermissionError" in text or "Permission denied" in text:
        return ("not allowed, or used by another program; close that program, or (Linux) join the "
                "port's group: sudo usermod -a -G dialout $USER, then log in again")  # fmt: skip
    if code in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text:
        return "used by another program, such as a serial monitor; close it and try again"
    if isinstance(error, ValueError):
        return f"the port doesn't support {baud} bit/s; common speeds are 9600 and 115200"
    return f"can't be opened ({text})"


def ports() -> list[PortInfo]:
    """Return the serial ports with a device, sorted by name."""
    from serial.tools import list_ports

    return [
        PortInfo(one.device, one.description, _identity(one))
        for one in sorted(list_ports.comports(), key=lambda one: str(one.device))
        # built-in ports that may not exist have no hardware ID
        if one.hwid != "n/a"
    ]


def _identity(one: Any) -> str:
    if one.vid is None:
        return ""
    return f"{one.vid:04x}:{one.pid:04x}:{one.serial_number or one.location or ''}"


def find_device_again(device: str, identity: str) -> str:
    """Return the present port of a device by its USB identity; `device` if that is empty.

    InputError: no port has that identity. Another device may have the old port name now.
    """
    if not identity:
        return device
    found = [one.device for one in ports() if one.identity == identity]
    if not found:
        raise InputError(f"serial:{device}: no such port; connect the device {identity}")
    return device if device in found else found[0]


def usb_identity(device: str) -> str:
    """Return a port's USB identity, or ""; `device` may be a link (/dev/serial/by-id)."""
    names = {device, os.path.realpath(device)}
    return next((one.identity for one in ports() if one.device in names), "")


def listen(devices: list[str], seconds: float, baud: int = BAUD) -> dict[str, str]:
    """Read several ports at once, and return the format that each port sends, as text.

    The text may also be the reason why the format is unknown or the port can't be opened. Opening a
    port restarts some devices.
    """
    with ThreadPoolExecutor(max(1, len(devices))) as pool:
        texts = pool.map(lambda device: _listen(device, seconds, baud), devices)
        return dict(zip(devices, texts, strict=True))


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
    silent = (
        f"{len(data)} bytes, too few to detect a format" if data else f"no data in {seconds:g} s"
    )
    return silent if found is None else str(found)
