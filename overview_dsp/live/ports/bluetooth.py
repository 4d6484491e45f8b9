"""Bluetooth LE sensors. Only this module imports `bleak`, when needed.

Two services are supported. Nordic's UART service carries the bytes that a sensor would send over a
wire. WitMotion's notifications are converted to the packets that its sensors send over a wire.
"""

from __future__ import annotations

import asyncio
import threading
from typing import Any

from overview_dsp.devices.sensors.packets import packets_from_notification
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.ports.port import PortLostError, QueuedPort

FIND_WITHIN_S = 10.0
MAX_QUEUED = 1000
"""Maximum number of queued notifications."""

UART = "6e400003-b5a3-f393-e0a9-e50e24dcca9e"
WITMOTION = "0000ffe4-0000-1000-8000-00805f9a34fb"


def _import_bleak() -> Any:
    try:
        import bleak
    except ImportError:
        raise OverviewError(f"Bluetooth sensors need bleak: {install_command('ble')}") from None
    return bleak


class BlePort(QueuedPort):
    """Open Bluetooth sensor, whose notifications arrive on a thread of their own."""

    def __init__(self, selected: str, bleak: Any = None) -> None:
        """Open the sensor with an address, or with a part of a name.

        InputError: no such sensor is in range, or it has no supported service.
        OverviewError: bleak isn't installed.
        """
        super().__init__(f"ble:{selected}", MAX_QUEUED)
        self._selected = selected.casefold()
        self._bleak = _import_bleak() if bleak is None else bleak
        self._lost = threading.Event()
        self._opened = threading.Event()
        self._fault = ""
        self._loop = asyncio.new_event_loop()
        self._over = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name=self.name, daemon=True)
        self._thread.start()
        self._opened.wait(2.0 * FIND_WITHIN_S)
        if self._fault or not self._opened.is_set():
            self.close()
            raise InputError(f"{self.name}: {self._fault or 'no answer; try again'}")

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._listen())
        except Exception as error:  # bleak raises different errors on each system
            self._fault = self._fault or str(error) or type(error).__name__
        finally:
            self._lost.set()
            self._opened.set()
            self._loop.close()

    async def _listen(self) -> None:
        def matches(device: Any, advertised: Any) -> bool:
            name = str(advertised.local_name or device.name or "").casefold()
            return self._selected == device.address.casefold() or (
                bool(name) and self._selected in name
            )

        found = await self._bleak.BleakScanner.find_device_by_filter(matches, timeout=FIND_WITHIN_S)
        if found is None:
            self._fault = f"no such sensor found within {FIND_WITHIN_S:g} s; switch it on"
            return
        async with self._bleak.BleakClient(found, lambda client: self._end()) as client:
            known = {one.uuid.lower() for service in client.services
                     for one in service.characteristics}  # fmt: skip
            which = next((one for one in (WITMOTION, UART) if one in known), None)
            if which is None:
                self._fault = "it has no supported service; must be Nordic UART or WitMotion"
                return
            await client.start_notify(
                which, lambda _, data: self.put(packets_from_notification(data) or bytes(data))
            )
            self._opened.set()
            await self._over.wait()

    def _end(self) -> None:
        self._lost.set()
        self._loop.call_soon_threadsafe(self._over.set)

    def receive(self, wait_s: float) -> list[bytes]:
        """Return new notifications, as `Port.receive`."""
        found = super().receive(wait_s)
        if not found and self._lost.is_set():
            raise PortLostError(f"{self.name}: out of range")
        return found

    def close(self) -> None:
        """Disconnect from the sensor."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(2.0)
