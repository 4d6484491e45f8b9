"""Loop of a knob whose own board runs the surface: the surface as a table, the disk, the commands.

| frame (COBS and CRC as `sensors/frames.py`) | payload, little-endian |
|---|---|
| disk | 16, its number, 1 = theta2 is 0 here, eleven float32 (`pack_disk`) |
| part | 17, the table's number, uint16 index of the part, 32 uint16: points, then ten events each |
| use | 18, the table's number, uint16 ms of crossfade, float32 unit |
| alive | 19, 1 = there may be torque |

Frames may be lost. The board reports its state twice per hundredth of a second, and missing frames
are sent again. `alive` is sent every 2 ms; the board ends its torque after 28 ms without a frame.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.parameter import Value
from overview_dsp.devices.force_feedback.watchdog import Watchdog
from overview_dsp.devices.sensors.frames import KNOB_MOTION, KNOB_STATE, framed
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.stream import Sample
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import HALF_TURN

HIGHEST = 65535

DISK_KEYS = ("disk.inertia", "disk.k1", "disk.k2", "clutch.tap_duration_s",
             "input.smoothing_ms")  # fmt: skip
"""Keys of a preset that define a board's disk."""

_DISK = struct.Struct("<11f")
PART_POINTS = 32
PART_EVENTS = 10  # in a part after those of the points

PUSH_UNIT = 1e-8  # N m s
PUSH, PUSH_EXPONENT = 8e-7, 0.65
"""Push of an event as strong as the bare surface, N m s, and how it grows with the height."""


@dataclass(frozen=True, eq=False)
class BoardTable:
    """A surface in the form of a board.

    `unit`: friction of 1 count, N m s/rad.
    `parts`: the numbers of each `part` frame: friction at equal steps along the surface, then the
    first and last step of each event and the push of its knock in `PUSH_UNIT`.
    """

    unit: float
    parts: NDArray[np.uint16]


def board_table(surface: Surface, count: int, bare: float) -> BoardTable:
    """Return a surface for a board with `count` points; `bare` is its friction without events.

    The energy of a crossing is the integral of the friction. So each point is the mean of the
    friction nearest to it, and even narrow events keep their energy. Of the events, the strongest
    are sent, as many as such a board holds.
    """
    friction = surface.resistance
    cells = len(friction) - 1
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (friction[1:] + friction[:-1]))])
    edges = np.clip((np.arange(count + 1) - 0.5) * (cells / (count - 1)), 0.0, cells)
    means = np.diff(np.interp(edges, np.arange(cells + 1), integral)) / np.diff(edges)
    unit = float(means.max()) / HIGHEST
    rows = -(-count // PART_POINTS)
    parts = np.zeros((rows - (-rows // PART_EVENTS), PART_POINTS), dtype=np.uint16)
    parts[:rows].reshape(-1)[:count] = np.clip(np.rint(means / unit), 1, HIGHEST)
    events = np.zeros(((len(parts) - rows) * PART_EVENTS, 3))
    push = PUSH / PUSH_UNIT * (surface.release / bare) ** PUSH_EXPONENT
    kept = np.sort(np.argsort(-push, kind="stable")[: len(events)])
    first, last = surface.span[kept].T * (count - 1)
    # the means smear an edge by one cell
    found = np.stack([np.floor(first) - 1.0, np.floor(last) + 2.0, np.rint(push[kept])], axis=1)
    events[: len(kept)] = np.clip(found, (0, 0, 1), (count - 1, count - 1, HIGHEST))
    parts[rows:, : 3 * PART_EVENTS] = events.reshape(-1, 3 * PART_EVENTS)
    return BoardTable(unit, parts)


def pack_disk(values: Mapping[str, Value], sensor: Sensor) -> bytes:
    """Return the disk of a preset's `values` in the form of a board (`KnobDisk` of `surface.h`).

    `sensor` has the scale of the knob's torque and its turn for the whole timeline.
    """
    inertia, k1, k2, tap_s, smoothing_ms = (float(values[key]) for key in DISK_KEYS)
    per_rad = HALF_TURN / math.radians(sensor.number("motor.turn_deg"))
    return _DISK.pack(
        inertia, k1, k2, tap_s, smoothing_ms * 1e-3,
        *(sensor.number(f"motor.{key}")
          for key in ("board_scale", "knock", "home", "ceiling_nm", "end_nm_per_rad")),
        -per_rad if sensor.values["motor.reverse"] else per_rad,
    )  # fmt: skip


PERIOD_S = 0.002  # time between frames to the board
RESEND_S = 0.02  # time after which a frame that the board doesn't confirm is sent again
FADE_MS = 30
DISK, PART, USE, ALIVE = 16, 17, 18, 19
SHARE = 0.6  # largest share of the wire's capacity for a table
BURST = 400  # largest number of bytes of a table at once


class BoardLoop:
    """Loop of one board.

    `torque` is the latest reported one, N m along theta2; `alive`: whether the board was reporting
    at the latest step.
    """

    def __init__(self, sensor: Sensor, baud: int) -> None:
        """Start the loop for a profile with a motor, on a port with a speed of `baud`."""
        self.torque = 0.0
        self.alive = False
        self._sensor = sensor
        self._per_period = SHARE * 0.1 * baud * PERIOD_S
        self.watchdog = Watchdog()
        self._due = -1e300
        self._surface: Surface | None = None
        self._packed = b""
        self._bare = 1.0
        self._at_start = True
        self._forget()

    def _forget(self) -> None:
        self._state: Mapping[str, float] = {}
        self._table: BoardTable | None = None
        self._table_id = self._disk_id = 0
        self._part = 0
        self._space = 0.0
        self._sent_at = -1e300
        self.torque = 0.0

    def render(self, surface: Surface, values: Mapping[str, Value]) -> None:
        """Let the board run a surface, with the disk of a preset's `values`."""
        if surface is not self._surface:
            self._surface, self._table = surface, None
            self._bare = float(values["surface.friction"])
        packed = pack_disk(values, self._sensor)
        if packed != self._packed:
            self._packed, self._disk_id = packed, 0

    def receive(self, samples: Iterable[Sample], now_s: float) -> None:
        """Process the device's reports that arrived by `now_s`."""
        for _, reading in samples:
            if KNOB_STATE[0] in reading:
                self._state = reading
            elif KNOB_MOTION[0] in reading:
                self.torque = reading["torque_nm"]
            self.watchdog.message_received(now_s)

    def step(self, playing: bool, now_s: float) -> bytes:
        """Return the frames to send, at most every 2 ms; `playing`: there may be torque."""
        self.alive = self.watchdog.alive(now_s)
        if now_s < self._due:
            return b""
        self._due = max(self._due + PERIOD_S, now_s)
        sent = framed(bytes((ALIVE, playing and self.alive)))
        if self.alive and self._state:
            sent += self._update(now_s)
        return sent

    def _update(self, now_s: float) -> bytes:
        state = {name: int(value) for name, value in self._state.items()}
        sent = b""
        resend = now_s - self._sent_at >= RESEND_S
        if not self._disk_id:
            self._disk_id = state["knob_disk"] % 255 + 1
        if state["knob_disk"] == self._disk_id:
            self._at_start = False
        elif resend:
            self._sent_at = now_s
            sent += self._disk()
        if self._table is None and self._surface is not None:
            self._table = board_table(self._surface, state["knob_points"], self._bare)
            known = (0, state["knob_table"], state["knob_filling"])
            self._table_id = next(n for n in range(1, 5) if n not in known)
            self._part, self._space = 0, 0.0
        if self._table is None or state["knob_table"] == self._table_id:
            return sent
        parts = len(self._table.parts)
        filling = state["knob_filling"] == self._table_id
        if filling and state["knob_missing"] >= parts:
            if resend:
                self._sent_at = now_s
                sent += self._use()
            return sent
        self._space = min(self._space + self._per_period, BURST)
        while self._space > 0.0:
            if self._part >= parts:  # again from the first missing part
                self._part = state["knob_missing"] if filling else 0
            part = self._part_of(self._part)
            self._part += 1
            self._space -= len(part)
            sent += part
        return sent

    def _disk(self) -> bytes:
        return framed(bytes((DISK, self._disk_id, self._at_start)) + self._packed)

    def _use(self) -> bytes:
        assert self._table is not None
        head = struct.pack("<BBH", USE, self._table_id, FADE_MS)
        return framed(head + struct.pack("<f", self._table.unit))

    def _part_of(self, part: int) -> bytes:
        assert self._table is not None
        head = struct.pack("<BBH", PART, self._table_id, part)
        return framed(head + self._table.parts[part].astype("<u2").tobytes())

    def end(self) -> bytes:
        """Return the last frame."""
        self.torque = 0.0
        return framed(bytes((ALIVE, 0)))

    def disconnected(self) -> None:
        """Forget the board's state, because its port is closed."""
        self.watchdog.reset()
        self._forget()
        self.alive = False

    @property
    def ready(self) -> bool:
        """True while the board uses the latest table and disk."""
        state = self._state
        return bool(
            self._table is not None
            and state
            and state["knob_table"] == self._table_id
            and state["knob_disk"] == self._disk_id
        )

    def status_text(self, now_s: float) -> str:
        """Return a status text for display."""
        if not self.alive:
            return "no force: the knob's board doesn't report"
        if not self.ready:
            missing = int(self._state.get("knob_missing", 0))
            return f"no force yet: its board receives the surface (part {missing})"
        return (
            f"force {1e3 * self.torque:+.2f} mN·m, computed on its board, "
            f"{self.watchdog.silences} silences"
        )

    def report(self, now_s: float) -> dict[str, Any]:
        """Return the state for a line of JSON."""
        state = self._state
        return {
            "alive": self.alive,
            "on_board": True,
            "ready": self.ready,
            "torque_nm": round(self.torque, 6),
            "steps_per_s": int(state.get("knob_hz", 0)),
            "points": int(state.get("knob_points", 0)),
            "rejected": int(state.get("knob_rejected", 0)),
            "reports_per_s": self.watchdog.hz,
            "silences": self.watchdog.silences,
        }
