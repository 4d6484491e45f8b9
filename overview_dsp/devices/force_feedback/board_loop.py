"""A knob that runs the surface on its own board: what it is sent until it has it, what it says.

| frame (COBS and CRC as `sensors/frames.py`) | payload, little-endian |
|---|---|
| disk | 16, its number, 1 = theta2 is 0 here, twelve float32 (`board_table.pack_disk`) |
| part | 17, the table's number, uint16 which part, 32 uint16 |
| use | 18, the table's number, uint16 ms of crossfade, two float32 (unit, hard) |
| alive | 19, 1 = there may be torque |

Frames may be lost: the board says twice a hundredth of a second what it has, and what it lacks is
sent again. `alive` goes out every 2 ms; the board ends its torque when nothing came for 28 ms.

What a knob's own board runs: the surface's friction as a small table, and the disk.
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
from overview_dsp.devices.force_feedback.motion import Rate
from overview_dsp.devices.force_feedback.watchdog import Watchdog
from overview_dsp.devices.sensors.frames import KNOB_MOTION, KNOB_STATE, framed
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.stream import Sample
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import HALF_TURN

HIGHEST = 65535

HARD = 1.0 / 3.0
"""Where between the bare surface (0) and the highest friction (1), in ratios, half of a blow
counts: above a card's flanks and below a goal."""

DISK_KEYS = ("disk.inertia", "disk.k1", "disk.k2", "clutch.max_speed_ratio",
             "clutch.tap_duration_s", "input.smoothing_ms")  # fmt: skip
"""Of a preset, what a board's disk is made of."""

_DISK = struct.Struct("<12f")


@dataclass(frozen=True, eq=False)
class BoardTable:
    """A surface as a board holds it.

    Attributes
    ----------
    points : uint16 (n,)
        Friction at equal steps from one end of the surface to the other, each the mean of its cell.
    unit : float
        What 1 of them is, N m s/rad.
    hard : float
        Friction of so much gives half its knock, N m s/rad.
    """

    points: NDArray[np.uint16]
    unit: float
    hard: float


def board_table(surface: Surface, count: int) -> BoardTable:
    """A surface's friction in `count` points.

    What a crossing costs is the integral of the friction, so a point is the mean of all that is
    nearer to it than to the next one: nothing is lost, however narrow.
    """
    friction = surface.resistance
    cells = len(friction) - 1
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (friction[1:] + friction[:-1]))])
    edges = np.clip((np.arange(count + 1) - 0.5) * (cells / (count - 1)), 0.0, cells)
    # the integral of what is linear between the cells
    whole = np.minimum(edges.astype(np.int64), cells - 1)
    part = edges - whole
    integral = summed[whole] + part * (
        friction[whole] + 0.5 * part * (friction[whole + 1] - friction[whole])
    )
    means = np.diff(integral) / np.diff(edges)
    unit = float(means.max()) / HIGHEST
    points = np.clip(np.rint(means / unit), 1, HIGHEST).astype(np.uint16)
    bare = float(np.median(means))
    return BoardTable(points, unit, bare * (float(means.max()) / bare) ** HARD)


def pack_disk(values: Mapping[str, Value], sensor: Sensor) -> bytes:
    """The disk of a preset's `values`, as a board takes it (`KnobDisk` of `surface.h`).

    `sensor` says how much of it the knob gives, and how far it is turned for the timeline.
    """
    inertia, k1, k2, ratio, tap_s, smoothing_ms = (float(values[key]) for key in DISK_KEYS)
    per_rad = HALF_TURN / math.radians(sensor.number("motor.turn_deg"))
    return _DISK.pack(
        inertia, k1, k2, ratio, tap_s * (ratio or 1.0), smoothing_ms * 1e-3,
        sensor.number("motor.board_scale"), sensor.number("motor.impact_gain"),
        sensor.number("motor.recoil_gain"), sensor.number("motor.ceiling_nm"),
        sensor.number("motor.end_nm_per_rad"),
        -per_rad if sensor.values["motor.reverse"] else per_rad,
    )  # fmt: skip


PERIOD_S = 0.002
"""Between words to the board."""

AGAIN_S = 0.02
"""What the board doesn't say that it has is sent again so often."""

FADE_MS = 30
DISK, PART, USE, ALIVE = 16, 17, 18, 19
PART_POINTS = 32
SHARE = 0.6
"""Of what the wire carries, how much a table may take."""

BURST = 400
"""Bytes of it in one go."""


class BoardLoop:
    """One board.

    Attributes
    ----------
    torque : float
        The latest that it reported, N m along theta2.
    alive : bool
        Whether it spoke as of the latest step.
    """

    def __init__(self, sensor: Sensor, baud: int) -> None:
        """For a profile with a motor, on a port of that speed."""
        self.torque = 0.0
        self.alive = False
        self._sensor = sensor
        self._per_period = SHARE * 0.1 * baud * PERIOD_S
        self._watchdog = Watchdog()
        self._rate = Rate()
        self._due = -1e300
        self._written = 0
        self._surface: Surface | None = None
        self._packed = b""
        self._begin = True
        self._forget()

    def _forget(self) -> None:
        self._state: Mapping[str, float] = {}
        self._table: BoardTable | None = None
        self._table_id = self._disk_id = 0
        self._part = 0
        self._space = 0.0
        self._asked_at = -1e300
        self.torque = 0.0

    def render(self, surface: Surface, values: Mapping[str, Value]) -> None:
        """What the board is to run from now on: a surface, and the disk of a preset's `values`."""
        if surface is not self._surface:
            self._surface, self._table = surface, None
        packed = pack_disk({key: values[key] for key in DISK_KEYS}, self._sensor)
        if packed != self._packed:
            self._packed, self._disk_id = packed, 0

    def hear(self, samples: Iterable[Sample], now_s: float) -> None:
        """The device's reports that came together by `now_s`."""
        for _, reading in samples:
            if KNOB_STATE[0] in reading:
                self._state = reading
            elif KNOB_MOTION[0] in reading:
                self.torque = reading["torque_nm"]
                self._rate.add(now_s)
            self._watchdog.heard(now_s)

    def step(self, playing: bool, now_s: float) -> bytes:
        """What to send, at most every 2 ms; `playing`: there may be torque."""
        self.alive = self._watchdog.alive(now_s)
        if now_s < self._due:
            return b""
        self._due = max(self._due + PERIOD_S, now_s)
        sent = framed(bytes((ALIVE, playing and self.alive)))
        if self.alive and self._state:
            sent += self._ask(now_s)
        return sent

    def _ask(self, now_s: float) -> bytes:
        state = {name: int(value) for name, value in self._state.items()}
        sent = b""
        again = now_s - self._asked_at >= AGAIN_S
        if not self._disk_id:
            self._disk_id = state["knob_disk"] % 255 + 1
        if state["knob_disk"] == self._disk_id:
            self._begin = False
        elif again:
            self._asked_at = now_s
            sent += self._disk()
        if self._table is None and self._surface is not None:
            self._table = board_table(self._surface, state["knob_points"])
            known = (0, state["knob_table"], state["knob_filling"])
            self._table_id = next(n for n in range(1, 5) if n not in known)
            self._part, self._space = 0, 0.0
        if self._table is None or state["knob_table"] == self._table_id:
            return sent
        parts = -(-len(self._table.points) // PART_POINTS)
        filling = state["knob_filling"] == self._table_id
        if filling and state["knob_missing"] >= parts:
            if again:
                self._asked_at = now_s
                sent += self._use()
            return sent
        self._space = min(self._space + self._per_period, BURST)
        while self._space > 0.0:
            if self._part >= parts:  # once more from the first that was lost
                self._part = state["knob_missing"] if filling else 0
            part = self._part_of(self._part)
            self._part += 1
            self._space -= len(part)
            sent += part
        return sent

    def everything(self, points: int) -> list[bytes]:
        """All that a board of so many points needs, frame by frame."""
        assert self._surface is not None
        self._table = board_table(self._surface, points)
        self._table_id = self._disk_id = 1
        parts = range(-(-points // PART_POINTS))
        return [self._disk(), *map(self._part_of, parts), self._use()]

    def _disk(self) -> bytes:
        return framed(bytes((DISK, self._disk_id, self._begin)) + self._packed)

    def _use(self) -> bytes:
        assert self._table is not None
        head = struct.pack("<BBH", USE, self._table_id, FADE_MS)
        return framed(head + struct.pack("<2f", self._table.unit, self._table.hard))

    def _part_of(self, part: int) -> bytes:
        assert self._table is not None
        points = self._table.points[PART_POINTS * part :][:PART_POINTS].tolist()
        points += [0] * (PART_POINTS - len(points))
        return framed(struct.pack(f"<BBH{PART_POINTS}H", PART, self._table_id, part, *points))

    def end(self) -> bytes:
        """What to send last."""
        self.torque = 0.0
        return framed(bytes((ALIVE, 0)))

    def lost(self) -> None:
        """The port is gone: nothing is known until the device speaks again."""
        self._watchdog.forget()
        self._forget()
        self.alive = False

    @property
    def reports_per_s(self) -> float | None:
        """How often the device reports; None while that isn't known."""
        return self._rate.hz if self.alive else None

    @property
    def ready(self) -> bool:
        """Whether the board uses the table and the disk that it was given last."""
        state = self._state
        return bool(
            self._table is not None
            and state
            and state["knob_table"] == self._table_id
            and state["knob_disk"] == self._disk_id
        )

    def words(self, now_s: float) -> str:
        """How it stands, for a person."""
        if not self.alive:
            return "no force: the knob's board doesn't report"
        if not self.ready:
            missing = int(self._state.get("knob_missing", 0))
            return f"no force yet: its board is given the surface (part {missing})"
        return (
            f"force {1e3 * self.torque:+.2f} mN·m, made on its board, "
            f"{self._watchdog.silences} silences"
        )

    def report(self, now_s: float) -> dict[str, Any]:
        """How it stands, for a line of JSON."""
        state = self._state
        return {
            "alive": self.alive,
            "on_board": True,
            "ready": self.ready,
            "torque_nm": round(self.torque, 6),
            "steps_per_s": int(state.get("knob_hz", 0)),
            "points": int(state.get("knob_points", 0)),
            "refused": int(state.get("knob_rejected", 0)),
            "reports_per_s": None if self._rate.hz is None else round(self._rate.hz, 1),
            "silences": self._watchdog.silences,
        }
