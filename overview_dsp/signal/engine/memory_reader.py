"""Parameters, meters and strikes of the engine; reader of its inputs; its tail.

The reader takes the memory block of `kernels.layout`, float64; the audio thread may be writing it.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import acquired
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.derive import ARRIVAL_S, PACE_MOST
from overview_dsp.kernels.layout import CELLS
from overview_dsp.kernels.output_gain import LEAST_CURSOR, SLOWEST_PACE, USUAL_PACE
from overview_dsp.kernels.texture import QUIET
from overview_dsp.public import counted, dataframe
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from pandas import DataFrame


APPLIED_EVENT = np.dtype(
    [("sample", np.int64), ("source", np.int64), ("theta2", np.float64), ("touching", np.bool_)]
)

LOG_FIRST_S = 2e-4  # delay between an event in the log and the update of the input's state, s


@dataclass(frozen=True)
class EngineParameter(Parameter):
    """A parameter with the value it has now.

    Parameters
    ----------
    id, default, low, high, unit, doc, choices, scale, surface : see `Parameter`
        Fields of the parameter.
    value : float, bool or str
        The present value, in the parameter's unit.

    Examples
    --------
    >>> ov.Engine(football, match).parameters["tactor.frequency_hz"].value
    250.0
    """

    value: Value = 0.0

    def __repr__(self) -> str:
        return super().__repr__().removesuffix(">") + f", now {self.value}>"


@dataclass(frozen=True)
class Meters:
    """Levels and counters of the audio thread as of the last block.

    Attributes
    ----------
    blocks : int
        Processed blocks since `reset`, as for all counters.
    late_events, rejected_events, clamped_events, dropped_events : int
        Control events that came after their sample; with a theta2 that is not finite (it is
        ignored); with a theta2 outside [0, pi]; that did not fit into the queue.
    resets : int
        Blocks silenced because the state was not finite.
    limited_samples, strikes : int
        Samples limited to the ceiling; events passed.
    peak_click, peak_tactor : float
        Highest sample of the last block, linear.
    torque, friction : float
        Values at the block's end, N m and N m s/rad.
    envelope, cursor : float
        Amplitude of the carrier, linear; position of the disk, 0 to 1.
    touching : bool
        Whether any input touches the disk.
    engaged : bool
        Whether shaft 2 is engaged; after a release until the disk has arrived.
    silent_samples : int
        Samples since the last one that was not zero.
    still_samples : int
        Samples since the disk was last more than 0.001 of the timeline from its rest position;
        0 from a release until the disk has arrived.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> meters = result.engine.meters
    >>> meters.dropped_events, meters.touching
    (0, False)
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
    engaged: bool
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
    """Events passed by the disk, and slips of bristles, in order of time.

    Arrays of equal length.

    Attributes
    ----------
    time_s : float64 (strikes,)
        Time since reset with sub-sample precision, s.
    event : int64 (strikes,)
        Index into the events of the timeline at that time; -1 is the base surface.
    torque : float64 (strikes,)
        Released torque, N m.
    level : float64 (strikes,)
        Amplitude of the click after compression, linear.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> match.events[result.strikes.event[0]].kind
    'period'
    """

    time_s: FloatArray
    event: IntArray
    torque: FloatArray
    level: FloatArray

    def to_dataframe(self) -> DataFrame:
        """Return a pandas DataFrame with one row per strike.

        Returns
        -------
        pandas.DataFrame
            Columns as the attributes above.

        Raises
        ------
        InputError
            pandas isn't installed.

        Examples
        --------
        >>> result = ov.render("world-cup-final-2018", "football", "sweep:0.5", sample_rate=8000)
        >>> list(result.strikes.to_dataframe())
        ['time_s', 'event', 'torque', 'level']
        """
        return dataframe(vars(self))

    def of_events(self) -> Strikes:
        """Return the strikes of events, without those of the base surface.

        Returns
        -------
        Strikes
            Strikes in order of time.

        Examples
        --------
        >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
        >>> len(result.strikes.of_events()) <= len(result.strikes)
        True
        """
        listed = self.event >= 0
        return Strikes(*(column[listed] for column in vars(self).values()))

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        span = f", {self.time_s[0]:.3f} to {self.time_s[-1]:.3f} s" if len(self) else ""
        return f"<Strikes: {len(self)}{span}>"


def read_inputs(memory: FloatArray) -> tuple[int, int, list[tuple[int, float]]]:
    """Return a sample, the number of events applied by then, and the touching inputs.

    Inputs are pairs of source (an index) and theta2 (rad), in the order of their touches.
    """
    i64 = memory.view(np.int64)
    while True:  # repeat if the audio thread applied events in between
        now = int(i64[layout.CLOCK])
        applied = acquired(i64, layout.APPLIED)
        time.sleep(LOG_FIRST_S)
        touched = i64[layout.SOURCE_TOUCHED_AT :][: layout.SOURCES].copy()
        held = np.flatnonzero(i64[layout.SOURCE_TOUCHING :][: layout.SOURCES])
        theta2 = memory[layout.SOURCE_THETA2 :][: layout.SOURCES].copy()
        if applied == acquired(i64, layout.APPLIED):
            order = sorted(held.tolist(), key=lambda source: int(touched[source]))
            return now, applied, [(source, float(theta2[source])) for source in order]


_MARGIN = 1.25  # the estimate assumes a quasi-static disk; events add their inertia
_SKIN_FALLS = 20.0  # e-foldings of the tactor's envelope until it is exactly zero
_DC_BLOCKER_S = 0.2


def tail_seconds(preset: Preset, surface: Surface) -> float:
    """Return an upper bound of the time from the last release to exact silence, s.

    The disk returns from the end of the timeline. In the friction of each cell it falls with
    its slower time constant, until its torque and its texture are inaudible.
    """
    number = preset.number
    inertia, k1, k2 = number("disk.inertia"), number("disk.k1"), number("disk.k2")
    springs = [k1 + k2, k1] if preset.values["disk.release"] == "recoil" else [k1 + k2]
    gate = gain_of_db(number("tactor.threshold_db")) * number("tactor.reference_torque_mnm") * 1e-3
    grain = gain_of_db(number("texture.gain_db")) / math.sqrt(1e-3)
    theta1_full = math.pi * k2 / (k1 + k2)
    slow, recoil = number("tactor.slow_gain_exponent"), number("tactor.recoil_gain_exponent")
    loudest = max((USUAL_PACE / SLOWEST_PACE) ** slow, LEAST_CURSOR**-recoil)
    has_clutch = number("clutch.max_speed_ratio") > 0.0
    longest = 0.0
    for k in springs:
        b = surface.friction
        root = np.sqrt(np.maximum(b * b - 4.0 * k * inertia, 0.0))
        falls = 2.0 * inertia / (b - root)
        fall = float(np.sum(falls[1:-1] * np.log(1.0 + 1.0 / np.arange(1, CELLS))))
        # below the first cell: down to the angle at which torque and texture become inaudible
        silent_torque = gate / loudest / k
        lowest = float(falls[:2].max())
        silent_grain = QUIET / (grain * loudest**2) * math.sqrt(lowest / k)
        last = min(silent_torque, silent_grain) / theta1_full
        fall += lowest * max(0.0, math.log(1.0 / (last * CELLS)))
        if surface.bristles is not None or surface.detents is not None:
            # a disk held away from the springs' rest position settles from any position
            fall += float(falls.max()) * math.log(CELLS)
        if has_clutch and k > k1:
            # to a resting input, at least in proportion to the remaining distance
            tap_s = number("clutch.tap_duration_s") or 1.0 / PACE_MOST
            fall += tap_s * math.log(CELLS)
            fall += 1.0 / (number("clutch.max_speed") or PACE_MOST)
        longest = max(longest, fall)
    ring = max(
        (
            mode.decay_ms * 1e-3
            for modes in (*surface.kind_modes, surface.own_modes)
            for mode in modes
        ),
        default=0.0,
    )
    skin = _SKIN_FALLS * (number("tactor.decay_ms") + 2.0 * number("tactor.rise_ms")) * 1e-3
    settle = 40.0 * number("input.smoothing_ms") * 1e-3
    return _MARGIN * longest + ARRIVAL_S + settle + skin + _DC_BLOCKER_S + 160.0 / 60.0 * ring
