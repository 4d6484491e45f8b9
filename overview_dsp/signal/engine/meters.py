"""What the engine says of itself: parameters with their values, meters, strikes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.public import counted, dataframe

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True)
class EngineParameter(Parameter):
    """A parameter with the value it has now.

    Parameters
    ----------
    id, default, low, high, unit, doc, choices, scale, surface : see `Parameter`
        What the parameter is.
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
    """What the audio side reports, as of the last block.

    Attributes
    ----------
    blocks : int
        Processed since `reset`, as all counters here.
    late_events, rejected_events, clamped_events, dropped_events : int
        Control events that came after their sample; whose theta2 was not finite (the hand stays
        where it was); whose theta2 was outside [0, pi]; that found the queue full.
    resets : int
        Blocks silenced because the state was not finite.
    limited_samples, strikes : int
        Samples held at the ceiling; events passed.
    peak_click, peak_tactor : float
        Highest sample of the last block, linear.
    torque, friction : float
        At the block's end, N m and N m s/rad.
    envelope, cursor : float
        Amplitude of the carrier, linear; where the disk is, 0 to 1.
    touching : bool
        Whether a hand holds on.
    engaged : bool
        Whether shaft 2 is engaged: after a release until the disk has arrived.
    silent_samples : int
        Since the last sample that was not zero.
    still_samples : int
        Since the disk was last more than a thousandth of the timeline from where its springs rest;
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
    """Events passed by the disk, and slips where bristles held it, in order.

    Arrays of equal length.

    Attributes
    ----------
    time_s : float64 (strikes,)
        When, s since reset, with its fraction of a sample.
    event : int64 (strikes,)
        Index into the events of the timeline under the disk then; -1 is the bare surface.
    torque : float64 (strikes,)
        Let go there, N m.
    level : float64 (strikes,)
        Amplitude of the click after compression, linear.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> match.events[result.strikes.event[0]].kind
    'period'
    """

    time_s: NDArray[np.float64]
    event: NDArray[np.int64]
    torque: NDArray[np.float64]
    level: NDArray[np.float64]

    def to_dataframe(self) -> DataFrame:
        """Give them as a pandas DataFrame, a row a strike.

        Returns
        -------
        pandas.DataFrame
            The columns above.

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
        """Leave out those of the bare surface.

        Returns
        -------
        Strikes
            The others, in order.

        Examples
        --------
        >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
        >>> len(result.strikes.of_events()) <= len(result.strikes)
        True
        """
        kept = self.event >= 0
        return Strikes(self.time_s[kept], self.event[kept], self.torque[kept], self.level[kept])

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        span = f", {self.time_s[0]:.3f} to {self.time_s[-1]:.3f} s" if len(self) else ""
        return f"<Strikes: {len(self)}{span}>"
