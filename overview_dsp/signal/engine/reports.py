"""What a prepared engine's memory block says: meters, logs and levels, read by the control thread.

Each function takes the block of `kernels.layout`, float64; the audio thread may be writing it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.gestures import SOURCES
from overview_dsp.errors import InputError, OverviewError, shown
from overview_dsp.kernels import block, layout
from overview_dsp.kernels.ordering import acquired
from overview_dsp.signal.engine.meters import Meters, Strikes
from overview_dsp.signal.engine.struck import StruckSurfaces

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline

APPLIED_EVENT = np.dtype(
    [("sample", np.int64), ("source", np.int64), ("theta2", np.float64), ("touching", np.bool_)]
)

LOG_FIRST_S = 2e-4
"""An event is in the log a little before the hand's state shows it."""


def read_meters(memory: NDArray[np.float64], dropped_events: int) -> Meters:
    """Counters and levels as of the last block."""
    f64, i64 = memory, memory.view(np.int64)
    return Meters(
        blocks=int(i64[layout.M_BLOCKS]),
        late_events=int(i64[layout.M_LATE]),
        rejected_events=int(i64[layout.M_REJECTED]),
        clamped_events=int(i64[layout.M_CLAMPED]),
        dropped_events=dropped_events,
        resets=int(i64[layout.M_RESETS]),
        limited_samples=int(i64[layout.M_LIMITED]),
        strikes=int(i64[layout.M_STRIKES]),
        peak_click=float(f64[layout.M_PEAK_CLICK]),
        peak_tactor=float(f64[layout.M_PEAK_TACTOR]),
        torque=float(f64[layout.M_TORQUE]),
        friction=float(f64[layout.M_FRICTION]),
        envelope=float(f64[layout.M_ENVELOPE]),
        cursor=float(f64[layout.X]) / layout.CELLS,
        touching=bool(i64[layout.HOLDER] >= 0),
        engaged=bool(i64[layout.ENGAGED]),
        silent_samples=int(i64[layout.M_SILENT]),
        still_samples=0 if i64[layout.WAITING] else int(i64[layout.M_STILL]),
    )


def read_impulse(memory: NDArray[np.float64]) -> tuple[int, float]:
    """The samples summed since reset, and the sum of the torque over them (N m samples)."""
    i64 = memory.view(np.int64)
    while True:  # the audio thread may write between the two
        summed = int(i64[layout.M_SUMMED])
        impulse = float(memory[layout.M_IMPULSE])
        if summed == i64[layout.M_SUMMED]:
            return summed, impulse


def read_holder(memory: NDArray[np.float64]) -> tuple[str, float] | None:
    """The source that holds the disk and its theta2 (rad), as of the last block, or None."""
    source = int(memory.view(np.int64)[layout.HOLDER])
    if source < 0:
        return None
    return SOURCES[source], float(memory[layout.SOURCE_THETA2 + source])


def read_arrival(memory: NDArray[np.float64]) -> int | None:
    """The sample since which the disk is where the finger points and no event lies between them.

    Where friction sticks: since which it stands still. None while it isn't so, or nobody holds it.
    """
    i64 = memory.view(np.int64)
    still = int(i64[layout.M_STILL])
    if still == 0 or not i64[layout.ENGAGED]:
        return None
    slot = layout.SURFACES + int(i64[layout.ACTIVE_SLOT]) * layout.SLOT_SIZE
    for edge, following in (
        (layout.SLOT_LOWER, layout.NEXT_LOWER),
        (layout.SLOT_UPPER, layout.NEXT_UPPER),
    ):
        edges = memory[slot + edge :][: int(i64[slot + layout.SLOT_EVENTS])]
        below = int(np.searchsorted(edges, memory[layout.INPUT], side="right"))
        # friction that sticks may hold the disk before an event for ever
        if below != i64[following] and i64[slot + layout.SLOT_MODELS] == 0:
            return None
    since = int(i64[layout.CLOCK]) - still
    strikes = int(i64[layout.M_STRIKES])
    if strikes == 0:
        return since
    return max(since, int(memory[layout.LOG_TIME + (strikes - 1) % layout.STRIKE_LOG]))


def read_applied(memory: NDArray[np.float64], since: int) -> tuple[NDArray[np.void], int]:
    """The control events applied after the first `since` ones, and how many there are by now.

    Raises
    ------
    OverviewError
        More came since than the log keeps.
    """
    since = validation.whole(since, "since", least=0)
    i64 = memory.view(np.int64)
    now = acquired(i64, layout.APPLIED)
    if since > now:
        raise InputError(f"since is {shown(since)}; {now} control events were applied by now")
    if now - since > layout.APPLIED_LOG:
        raise OverviewError(
            f"{now - since} control events since the last look; the log keeps "
            f"{layout.APPLIED_LOG}: look more often"
        )
    at = np.arange(since, now) % layout.APPLIED_LOG
    events = np.empty(len(at), dtype=APPLIED_EVENT)
    events["sample"] = i64[layout.APPLIED_TIME + at]
    events["source"] = i64[layout.APPLIED_SOURCE + at]
    events["theta2"] = memory[layout.APPLIED_THETA2 + at]
    events["touching"] = i64[layout.APPLIED_TOUCHING + at]
    return events, now


def take_strikes(
    memory: NDArray[np.float64],
    struck: StruckSurfaces,
    applied_at: Callable[[int], int | None],
    sample_rate: float,
) -> tuple[Strikes, list[Timeline | None]]:
    """The strikes since the last call (up to the log's latest), by the surfaces they fell on.

    And each one's timeline, None where that isn't known any more.
    """
    i64 = memory.view(np.int64)
    now = int(i64[layout.CLOCK])
    total = acquired(i64, layout.M_STRIKES)
    first = max(int(i64[layout.STRIKES_READ]), total - layout.STRIKE_LOG)
    i64[layout.STRIKES_READ] = total
    at = np.arange(first, total) % layout.STRIKE_LOG
    times = memory[layout.LOG_TIME + at]
    events, timelines = struck.find(i64[layout.LOG_EVENT + at], times, now, applied_at)
    strikes = Strikes(
        time_s=times / sample_rate,
        event=events,
        torque=memory[layout.LOG_TORQUE + at],
        level=memory[layout.LOG_LEVEL + at],
    )
    return strikes, timelines


def read_hands(memory: NDArray[np.float64]) -> tuple[int, int, list[tuple[int, float]]]:
    """A sample, how many events were applied by then, and the hands that hold on after those.

    Each hand's source (an index) and theta2 (rad), in the order in which they touched.
    """
    i64 = memory.view(np.int64)
    while True:  # the audio thread may apply events meanwhile
        now = int(i64[layout.CLOCK])
        applied = acquired(i64, layout.APPLIED)
        time.sleep(LOG_FIRST_S)
        touched = i64[layout.SOURCE_TOUCHED_AT :][: layout.SOURCES].copy()
        held = np.flatnonzero(i64[layout.SOURCE_TOUCHING :][: layout.SOURCES])
        theta2 = memory[layout.SOURCE_THETA2 :][: layout.SOURCES].copy()
        if applied == acquired(i64, layout.APPLIED):
            order = sorted(held.tolist(), key=lambda source: int(touched[source]))
            return now, applied, [(source, float(theta2[source])) for source in order]


def tactor_of(memory: NDArray[np.float64], torque: NDArray[np.float64]) -> NDArray[np.float32]:
    """The tactor channel that a torque signal (N m, one value a frame) gives from rest."""
    out = np.zeros(len(torque), dtype=np.float32)
    block.tactor_stage(memory, np.ascontiguousarray(torque, dtype=np.float64), out)
    return out
