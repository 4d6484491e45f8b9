"""Game pads by USB and Bluetooth: found, opened, read. hidapi is imported here alone, and late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from overview_dsp.devices.sensors.pads import LENGTHS, TRUE_UNITS, framed
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.ports.port import Port, PortLostError

LONGEST = 512
AT_MOST = 64
"""Reports of a read."""

MADE = {
    (0x054C, 0x0CE6): "dualsense",
    (0x054C, 0x0DF2): "dualsense",
    (0x057E, 0x2006): "joycon",
    (0x057E, 0x2007): "joycon-right",
    (0x057E, 0x2009): "joycon",
}
"""Pads by vendor and product, and what they are."""

_STILL = bytes.fromhex("0001404000014040")  # both motors of a Joy-Con off
_MOTION_ON, _FULL_REPORTS = b"\x40\x01", b"\x03\x30"


@dataclass(frozen=True)
class Pad:
    """A pad that is there: what it is, what it calls itself, where it is opened."""

    kind: str
    name: str
    path: bytes


def _import_hid() -> Any:
    try:
        import hidraw  # of the same package, on Linux: Bluetooth too, and nothing is taken away
    except ImportError:
        try:
            import hid
        except ImportError:
            raise OverviewError(f"game pads need hidapi: {install_command('pads')}") from None
        return hid
    return hidraw


def pads(hid: Any = None) -> list[Pad]:
    """The pads of this machine; OverviewError without hidapi."""
    hid = _import_hid() if hid is None else hid
    return [
        Pad(MADE[one["vendor_id"], one["product_id"]], one["product_string"] or "", one["path"])
        for one in hid.enumerate()
        if (one["vendor_id"], one["product_id"]) in MADE
    ]


def find_pad(wanted: str, hid: Any = None) -> Pad:
    """The pad of that kind or of a name with that in it; "" is whichever there is.

    Raises
    ------
    InputError
        None, or several.
    OverviewError
        hidapi isn't installed.
    """
    there = pads(hid)
    word = wanted.casefold()
    found = [one for one in there if word in one.name.casefold() or word in one.kind]
    if len(found) == 1:
        return found[0]
    known = ", ".join(f"{one.kind} ({one.name})" for one in found or there)
    what = "several are called so" if found else "no such pad; there are"
    raise InputError(f"pad:{wanted}: {what}: {known or 'none'}")


class PadPort(Port):
    """Open game pad."""

    def __init__(self, wanted: str, hid: Any = None) -> None:
        """Open the pad of that name, as `find_pad`, and have it send how it moves.

        Raises
        ------
        InputError
            None or several, no permission, held by another program.
        OverviewError
            hidapi isn't installed.
        """
        hid = _import_hid() if hid is None else hid
        pad = find_pad(wanted, hid)
        self.name = f"pad:{wanted}"
        self._first: list[bytes] = []
        self._pad = hid.device()
        try:
            self._pad.open_path(pad.path)
            self._pad.set_nonblocking(True)
            if pad.kind == "dualsense":
                # that it is asked for makes it send all by Bluetooth too
                units = self._pad.get_feature_report(TRUE_UNITS, LENGTHS[TRUE_UNITS])
                self._first = [framed(bytes(units))]
            else:
                for number, order in enumerate((_MOTION_ON, _FULL_REPORTS)):
                    self._pad.write(bytes([1, number]) + _STILL + order)
        except (OSError, ValueError) as error:
            self._pad.close()
            raise InputError(
                f"{self.name}: can't be opened ({error}); is it held by another program? On Linux "
                "a udev rule may have to allow it (docs/guide/sensors.md)"
            ) from None

    def receive(self, wait_s: float) -> list[bytes]:
        """Return the reports that have come, each behind its length, as `Port.receive`."""
        found, self._first = self._first, []
        wait_ms = round(1e3 * wait_s)
        try:
            while len(found) < AT_MOST and (report := self._pad.read(LONGEST, wait_ms)):
                found.append(framed(bytes(report)))
                wait_ms = 0
        except (OSError, ValueError) as error:
            raise PortLostError(f"{self.name}: {error}") from None
        return found

    def close(self) -> None:
        """Close the pad."""
        self._pad.close()
