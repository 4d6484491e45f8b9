"""What the engine says of itself: parameters with their values, meters, strikes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.presets.parameter import Parameter, Value
from overview_dsp.public.reprs import counted


@dataclass(frozen=True)
class EngineParameter(Parameter):
    """A parameter with the value it has now."""

    value: Value = 0.0

    def __repr__(self) -> str:
        return super().__repr__().removesuffix(">") + f", now {self.value}>"


@dataclass(frozen=True)
class Meters:
    """What the audio side reports, as of the last block.

    Counters since `reset`: `blocks`, `late_events` (came after their sample), `rejected_events`
    (theta2 not finite: the hand stays where it was), `clamped_events` (theta2 outside [0, pi]),
    `dropped_events` (a full ring), `resets` (blocks silenced because the state was not finite),
    `limited_samples`, `strikes`. Levels: `peak_click`, `peak_tactor` of the last block (linear),
    `torque` (N m), `friction` (N m s/rad), `envelope`, `cursor` (0..1). `silent_samples`: since the
    last sample that was not zero. `still_samples`: since the disk was last more than a thousandth
    of the timeline away from where its springs rest.
    """

    blocks: int
    late_events: int
    rejected_events: int
    clamped_events: int
    dropped_events: int
    resets: int
    limited_samples: int
    strikes: int
    peak_click: float
    peak_tactor: float
    torque: float
    friction: float
    envelope: float
    cursor: float
    touching: bool
    silent_samples: int
    still_samples: int

    def __repr__(self) -> str:
        lost = self.late_events + self.rejected_events + self.clamped_events + self.dropped_events
        return (
            f"<Meters: {counted(self.blocks, 'block')}, {counted(self.strikes, 'strike')}, "
            f"peaks {self.peak_click:.3g} and {self.peak_tactor:.3g}, cursor {self.cursor:.3g}, "
            f"{counted(lost, 'event')} late, clamped or lost>"
        )


@dataclass(frozen=True)
class Strikes:
    """Events passed by the disk, and slips where bristles held it, in order.

    `time_s` (with its fraction of a sample), `event` (index into the timeline's events; -1 = the
    bare surface), `torque` (released, N m), `level` (amplitude after compression): arrays
    of equal length.
    """

    time_s: NDArray[np.float64]
    event: NDArray[np.int64]
    torque: NDArray[np.float64]
    level: NDArray[np.float64]

    def of_events(self) -> Strikes:
        """Without those of the bare surface."""
        kept = self.event >= 0
        return Strikes(self.time_s[kept], self.event[kept], self.torque[kept], self.level[kept])

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        span = f", {self.time_s[0]:.3f} to {self.time_s[-1]:.3f} s" if len(self) else ""
        return f"<Strikes: {len(self)}{span}>"
