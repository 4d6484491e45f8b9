"""What an engine says of itself: meters, strikes, changes that were applied."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.parameter import Parameter
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.kernels import layout
from overview_dsp.kernels.smoother import latency
from overview_dsp.signal.engine import reports
from overview_dsp.signal.engine.meters import EngineParameter, Meters, Strikes
from overview_dsp.signal.engine.prepared import PreparedEngine
from overview_dsp.signal.engine.tail import tail_seconds

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Event, Timeline


class ReportingEngine(PreparedEngine):
    """An engine that is looked at while it plays."""

    def take_applied(self, since: int) -> tuple[NDArray[np.void], int]:
        """Look up the control events that were applied; the log keeps the latest 16384.

        Parameters
        ----------
        since : int
            How many were looked at before.

        Returns
        -------
        events : record array
            `sample`, `source` (an index), `theta2` (rad, as used) and `touching`.
        count : int
            How many there are by now.

        Raises
        ------
        OverviewError
            More came since than the log keeps.
        NotPreparedError
            It is not prepared yet.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> match, plain = ov.load_timeline("world-cup-final-2018"), ov.load_preset("plain")
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.control(1.2, True)
        >>> engine.process(np.zeros((256, 2), dtype=np.float32))
        >>> events, count = engine.take_applied(0)
        >>> count, float(events["theta2"][0])
        (1, 1.2)
        """
        self._require_prepared()
        return reports.read_applied(self._f64, since)

    @property
    def parameters(self) -> Mapping[str, EngineParameter]:
        """Every parameter with its range, unit, default, sentence and present value, by id."""
        return {
            id: EngineParameter(
                **{item.name: getattr(known, item.name) for item in fields(Parameter)},
                value=self._preset.values[id],
            )
            for id, known in PARAMETERS.items()
        }

    @property
    def meters(self) -> Meters:
        """Counters and levels as of the last block."""
        self._require_prepared()
        return reports.read_meters(self._f64, self._queues.dropped)

    @property
    def impulse(self) -> tuple[float, float]:
        """The time processed since reset (s), and the torque's integral over it (N m s).

        Of two looks, the mean torque between them: what lasts a millisecond is in it, however
        long the blocks are. Thread: any.
        """
        self._require_prepared()
        summed, impulse = reports.read_impulse(self._f64)
        return summed / self._sample_rate, impulse / self._sample_rate

    @property
    def holder(self) -> tuple[str, float] | None:
        """The source that holds the disk and its theta2 (rad), as of the last block, or None."""
        self._require_prepared()
        return reports.read_holder(self._f64)

    @property
    def arrived_at(self) -> int | None:
        """Sample since which the disk is at the finger, past every event between, or None."""
        self._require_prepared()
        return reports.read_arrival(self._f64)

    @property
    def latency_samples(self) -> int:
        """How far the disk's input lags a moving hand, samples (a tap is not delayed)."""
        self._require_prepared()
        return round(latency(float(self._f64[layout.C_SMOOTH])))

    @property
    def tail_seconds(self) -> float:
        """Within how long after the last event of any hand the output is exactly zero, s."""
        return tail_seconds(self._preset, self._surface)

    def take_strikes(self) -> Strikes:
        """Look up the strikes since the last call (up to the log's 16384 latest).

        Returns
        -------
        Strikes
            In order.

        Raises
        ------
        NotPreparedError
            It is not prepared yet.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, plain = ov.load_timeline("world-cup-final-2018"), ov.load_preset("plain")
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> len(engine.take_strikes())
        0
        """
        return self._take_strikes()[0]

    def take_struck_events(self) -> list[tuple[Event, float]]:
        """Look up the events struck since the last call of this or `take_strikes`.

        Returns
        -------
        list of (Event, float)
            Each as it is in the timeline that was under the disk then, and the amplitude of its
            click, linear.

        Raises
        ------
        NotPreparedError
            It is not prepared yet.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, plain = ov.load_timeline("world-cup-final-2018"), ov.load_preset("plain")
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.take_struck_events()
        []
        """
        strikes, timelines = self._take_strikes()
        return [
            (timeline.events[event], float(level))
            for event, level, timeline in zip(strikes.event, strikes.level, timelines, strict=True)
            if event >= 0 and timeline is not None
        ]

    def _take_strikes(self) -> tuple[Strikes, list[Timeline | None]]:
        self._require_prepared()
        return reports.take_strikes(
            self._f64, self._struck, self._queues.applied_at, self._sample_rate
        )

    def take_changes(self) -> list[tuple[int, dict[str, Any] | None]]:
        """Look up the parameter and surface changes applied since the last call.

        Returns
        -------
        list of (int, dict or None)
            The sample and the change: `{"set": {id: value}}`, `{"preset": ...}`,
            `{"window": [start_s, end_s]}`, what `set_timeline` was given, or None for one that a
            recording can't hold.

        Raises
        ------
        NotPreparedError
            It is not prepared yet.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> match, plain = ov.load_timeline("world-cup-final-2018"), ov.load_preset("plain")
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set("tactor.gain_db", -6.0)
        >>> engine.process(np.zeros((256, 2), dtype=np.float32))
        >>> engine.take_changes()
        [(0, {'set': {'tactor.gain_db': -6.0}})]
        """
        self._require_prepared()
        taken = []
        while self._journal:
            applied = self._queues.applied_at(self._journal[0][0])
            if applied is None:
                break
            taken.append((applied, self._journal.popleft()[1]))
        return taken

    def tactor_of(self, torque: NDArray[np.float64]) -> NDArray[np.float32]:
        """Make the tactor channel that a torque signal gives from rest.

        Parameters
        ----------
        torque : float64 (frames,)
            N m, one value a frame.

        Returns
        -------
        float32 (frames,)
            Linear, full scale is 1.

        Raises
        ------
        NotPreparedError
            It is not prepared yet.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, plain = ov.load_timeline("world-cup-final-2018"), ov.load_preset("plain")
        >>> result = ov.render(match, plain, ov.sweep(0.5), sample_rate=8000)
        >>> vibration = result.engine.tactor_of(result.trace.torque)
        >>> bool((vibration == result.samples[:, 1]).all())
        True
        """
        self._require_prepared()
        return reports.tactor_of(self._f64, torque)
