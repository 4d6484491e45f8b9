"""Bluetooth LE sensors: found, opened, heard. `bleak` is imported here alone, and late.

Two kinds of service are known: a UART's (Nordic's: whatever the sensor would say over a wire), and
WitMotion's, whose notifications are made the checked packets that its wire has.
"""

from __future__ import annotations

import asyncio
import threading
from typing import Any

from overview_dsp.devices.sensors.packets import as_wit_packets
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.ports.port import PortLostError, QueuedPort

FIND_WITHIN_S = 10.0
MAX_WAITING = 1000
"""Notifications."""

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

    def __init__(self, wanted: str, bleak: Any = None) -> None:
        """Open the sensor of that address, or whose name has that in it.

        Raises
        ------
        InputError
            None in reach, or of no service that is known.
        OverviewError
            bleak isn't installed.
        """
        super().__init__(f"ble:{wanted}", MAX_WAITING)
        self._wanted = wanted.casefold()
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
            raise InputError(f"{self.name}: {self._fault or 'no answer'}")

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._listen())
        except Exception as error:  # bleak's own, of every system another
            self._fault = self._fault or str(error) or type(error).__name__
        finally:
            self._lost.set()
            self._opened.set()
            self._loop.close()

    async def _listen(self) -> None:
        def is_meant(device: Any, advertised: Any) -> bool:
            name = str(advertised.local_name or device.name or "").casefold()
            return self._wanted == device.address.casefold() or (
                bool(name) and self._wanted in name
            )

        found = await self._bleak.BleakScanner.find_device_by_filter(
            is_meant, timeout=FIND_WITHIN_S
        )
        if found is None:
            self._fault = f"no such sensor in reach within {FIND_WITHIN_S:g} s; is it awake?"
            return
        async with self._bleak.BleakClient(found, lambda client: self._end()) as client:
            known = {one.uuid.lower() for service in client.services
                     for one in service.characteristics}  # fmt: skip
            which = next((one for one in (WITMOTION, UART) if one in known), None)
            if which is None:
                self._fault = "it has no service that is known (a UART's, WitMotion's)"
                return
            await client.start_notify(which, self._notified)
            self._opened.set()
            await self._over.wait()

    def _end(self) -> None:
        self._lost.set()
        self._loop.call_soon_threadsafe(self._over.set)

    def _notified(self, sender: Any, data: bytearray) -> None:
        self.put(as_wit_packets(bytes(data)) or bytes(data))

    def receive(self, wait_s: float) -> list[bytes]:
        """Return the notifications that have come, as `Port.receive`."""
        found = super().receive(wait_s)
        if not found and self._lost.is_set():
            raise PortLostError(f"{self.name}: out of reach")
        return found

    def close(self) -> None:
        """Disconnect from the sensor."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(2.0)
