"""Game pads by USB and Bluetooth. Only this module imports hidapi, when needed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from overview_dsp.devices.sensors.pads import (
    CALIBRATION,
    JOYCON_MEMORY,
    LENGTHS,
    READ_MEMORY,
    framed,
)
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.ports.port import Port, PortLostError

MAX_BYTES = 512
"""Maximum size of a report."""

MAX_REPORTS = 64
"""Maximum number of reports per read."""

KINDS = {
    (0x054C, 0x0CE6): "dualsense", (0x054C, 0x0DF2): "dualsense",
    (0x057E, 0x2006): "joycon", (0x057E, 0x2007): "joycon-right", (0x057E, 0x2009): "joycon",
}  # fmt: skip
"""Kind of pad by USB vendor and product."""

_MOTORS_OFF = bytes.fromhex("0001404000014040")  # both motors of a Joy-Con
_MOTION_ON, _FULL_REPORTS = b"\x40\x01", b"\x03\x30"


@dataclass(frozen=True)
class Pad:
    """Connected game pad: its kind, its name, and the path to open it by."""

    kind: str
    name: str
    path: bytes


def _import_hid() -> Any:
    try:
        import hidraw  # part of hidapi on Linux; it also finds Bluetooth and detaches no driver
    except ImportError:
        try:
            import hid
        except ImportError:
            raise OverviewError(f"game pads need hidapi: {install_command('pads')}") from None
        return hid
    return hidraw


def pads(hid: Any = None) -> list[Pad]:
    """Return the connected game pads; OverviewError without hidapi."""
    hid = _import_hid() if hid is None else hid
    return [
        Pad(KINDS[one["vendor_id"], one["product_id"]], one["product_string"] or "", one["path"])
        for one in hid.enumerate()
        if (one["vendor_id"], one["product_id"]) in KINDS
    ]


def find_pad(selected: str, hid: Any = None) -> Pad:
    """Return the only pad whose kind or name contains `selected`, which may be empty.

    InputError: no pad or several pads match.
    OverviewError: hidapi isn't installed.
    """
    connected = pads(hid)
    text = selected.casefold()
    found = [one for one in connected if text in one.name.casefold() or text in one.kind]
    if len(found) == 1:
        return found[0]
    known = ", ".join(f"{one.kind} ({one.name})" for one in found or connected)
    problem = "several pads match" if found else "no such pad; available"
    raise InputError(f"pad:{selected}: {problem}: {known or 'none'}")


class PadPort(Port):
    """Open game pad."""

    def __init__(self, selected: str, hid: Any = None) -> None:
        """Open the pad that `find_pad` finds, and enable its motion reports.

        InputError: no pad or several pads match, or the pad can't be opened.
        OverviewError: hidapi isn't installed.
        """
        hid = _import_hid() if hid is None else hid
        pad = find_pad(selected, hid)
        self.name = f"pad:{selected}"
        self._first: list[bytes] = []
        self._pad = hid.device()
        try:
            self._pad.open_path(pad.path)
            self._pad.set_nonblocking(True)
            if pad.kind == "dualsense":
                # by Bluetooth, this request also enables full reports
                units = self._pad.get_feature_report(CALIBRATION, LENGTHS[CALIBRATION])
                self._first = [framed(bytes(units))]
            else:
                reads = [bytes([READ_MEMORY]) + address.to_bytes(4, "little") + bytes([count])
                         for address, count in JOYCON_MEMORY]  # fmt: skip
                for number, command in enumerate((*reads, _MOTION_ON, _FULL_REPORTS)):
                    self._pad.write(bytes([1, number]) + _MOTORS_OFF + command)
        except (OSError, ValueError) as error:
            self._pad.close()
            raise InputError(
                f"{self.name}: can't be opened ({error}); close other programs that use it. Linux "
                "may need a udev rule (docs/guide/sensors.md)"
            ) from None

    def receive(self, wait_s: float) -> list[bytes]:
        """Return new reports, each preceded by its length, as `Port.receive`."""
        found, self._first = self._first, []
        wait_ms = round(1e3 * wait_s)
        try:
            while len(found) < MAX_REPORTS and (report := self._pad.read(MAX_BYTES, wait_ms)):
                found.append(framed(bytes(report)))
                wait_ms = 0
        except (OSError, ValueError) as error:
            raise PortLostError(f"{self.name}: {error}") from None
        return found

    def close(self) -> None:
        """Close the pad."""
        self._pad.close()
