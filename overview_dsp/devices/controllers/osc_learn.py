"""Which messages of another program are meant: those of what is being moved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from overview_dsp.devices.controllers.midi_map import TOUCH
from overview_dsp.devices.controllers.osc_map import PHONE, OscControl
from overview_dsp.devices.controllers.osc_messages import decode_packet
from overview_dsp.errors import InputError

DEVICE = "device"
"""To learn: the device itself is turned, and says how it lies."""

FEWEST = 6
"""A control is meant when it has been at so many positions, ..."""

BACK = 0.5
"""... has come back by so much of its way, ..."""

SETTLED_S = 1.0
"""... and has found no new end for so long, s."""

LISTENS_S = 1.5
"""What a device says of itself is listened to for so long, s."""

MOST = 2
"""A message of more values is no control's, but what a device says of itself."""

TAILS = (
    ("gravity", "acceleration"), ("grav", "acceleration"), ("accxyz", "acceleration"),
    ("accelerometer", "acceleration"), ("quaternion", "quaternion"), ("quat", "quaternion"),
    ("attitude", "angles"), ("gyro", "angles"),
)  # fmt: skip
"""The end of an address, and what its values are; the first that is heard is taken."""

_COUNTS = {"acceleration": 3, "quaternion": 4, "angles": 3}
_TOLERANCE = 0.02


class _Way:
    """Where one value has been."""

    def __init__(self, value: float, time_s: float) -> None:
        self.seen = {value}
        self.low = self.high = self.value = value
        self.since_s = time_s
        self._furthest = value

    def add(self, value: float, time_s: float) -> None:
        """It is there now."""
        if value < self.low or value > self.high:
            self.low, self.high = min(value, self.low), max(value, self.high)
            self.since_s, self._furthest = time_s, value
        self.value = value
        if len(self.seen) < FEWEST:
            self.seen.add(value)

    def is_done(self, time_s: float) -> bool:
        """Whether it was moved from end to end and back."""
        span = self.high - self.low
        back = abs(self.value - self._furthest) >= BACK * span
        return len(self.seen) >= FEWEST and back and time_s - self.since_s >= SETTLED_S

    @property
    def ends(self) -> tuple[float, float]:
        """What came at its ends; those of a fader that wasn't quite pushed to them are 0 and 1."""
        if abs(self.low) <= _TOLERANCE and abs(self.high - 1.0) <= _TOLERANCE:
            return 0.0, 1.0
        return self.low, self.high


class OscLearner:
    """Datagrams in, one control out."""

    def __init__(self, to: str) -> None:
        """`to`: what the control is to do, as in a file, or `DEVICE`."""
        self._to = to
        self._ways: dict[tuple[str, int], _Way] = {}
        self._heard: dict[str, int] = {}
        self._began_s: float | None = None

    @property
    def ask(self) -> str:
        """What the person is to do."""
        if self._to == DEVICE:
            return "have the app send how the device lies (gravity, or a quaternion)"
        if self._to == TOUCH:
            return "press it"
        return "move it from one end to the other and back, and leave it"

    @property
    def heard(self) -> str:
        """The addresses that came, with how many values each, for a person."""
        return ", ".join(f"{address} ({count})" for address, count in self._heard.items())

    def read(self, data: bytes, time_s: float) -> None:
        """Take a datagram; what is none is left alone."""
        self._began_s = time_s if self._began_s is None else self._began_s
        try:
            messages = decode_packet(data)
        except InputError:
            return
        for address, values in messages:
            if len(self._heard) < 1000:
                self._heard[address] = len(values)
            self._take(address, values, time_s)

    def _take(self, address: str, values: Sequence[Any], time_s: float) -> None:
        if len(values) > MOST or len(self._ways) > 1000:
            return
        for index, value in enumerate(values, 1):
            if not isinstance(value, bool | int | float) or not abs(value) < 1e9:
                continue
            number = float(value)
            way = self._ways.setdefault((address, index), _Way(number, time_s))
            way.add(number, time_s)

    def found(self, time_s: float) -> OscControl | None:
        """The control, once it is known."""
        if self._to == DEVICE:
            return self._device(time_s)
        for (address, index), way in self._ways.items():
            if self._to == TOUCH:
                if way.high >= 1.0 and way.seen <= {0.0, way.high} and way.value == way.high:
                    return OscControl(address, TOUCH, index, (0.0, way.high))
            elif way.is_done(time_s):
                return OscControl(address, self._to, index, way.ends)
        return None

    def _device(self, time_s: float) -> OscControl | None:
        if self._began_s is None or time_s - self._began_s < LISTENS_S:
            return None
        for tail, what in TAILS:
            for address, count in self._heard.items():
                if address.lower().endswith(f"/{tail}") and count == _COUNTS[what]:
                    return OscControl(
                        address, what, axes=PHONE if what != "angles" else ("x", "y", "z")
                    )
        return None
