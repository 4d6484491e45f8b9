"""What the control thread asks of an engine: a hand's events, and changes, each at its sample."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.presets.dicts import preset_to_dict
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from overview_dsp.signal.engine.coefficients import ask, changes, check_carrier
from overview_dsp.signal.engine.prepared import PreparedEngine
from overview_dsp.signal.engine.queues import stamp_of
from overview_dsp.signal.engine.surface_slots import write_surface
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline


class ControlledEngine(PreparedEngine):
    """An engine that is moved by hands, and changed while it plays."""

    def control(
        self,
        theta2: float,
        touching: bool,
        sample_time: int | None = None,
        source: str = "touch",
    ) -> None:
        """Queue a hand's event.

        A theta2 that is not finite or is out of range is counted in the meters; a full queue drops
        the event and counts it.

        Thread: any; events of one source are applied in the order of the calls.

        Parameters
        ----------
        theta2 : float
            The hand's angle, rad; 0 = start of the timeline, pi = its end.
        touching : bool
            Whether the hand holds on.
        sample_time : int or None
            When, in samples since reset; None is as soon as possible.
        source : {"touch", "twist", "serial", "osc", "midi", "remote"}
            Which source; the last to touch holds the disk.

        Raises
        ------
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.control(0.0, True)
        >>> engine.control(1.5, True, sample_time=4000)
        >>> engine.control(1.5, False, sample_time=8000)
        """
        self._require_prepared()
        self._queues.control(theta2, touching, stamp_of(sample_time), source)

    def control_all(
        self,
        theta2: NDArray[np.float64],
        touching: NDArray[np.bool_],
        sample_times: NDArray[np.int64],
        sources: NDArray[np.int8],
    ) -> None:
        """Queue many events of `control`, in order.

        Thread: any.

        Parameters
        ----------
        theta2 : float64 (events,)
            Angles, rad.
        touching : bool (events,)
            Whether the hand holds on.
        sample_times : int64 (events,)
            When, in samples since reset.
        sources : int8 (events,)
            Which source, as an index of the sources in `control`'s order.

        Raises
        ------
        OverviewError
            More than a queue holds; none is taken.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> gesture = ov.sweep(1.0)
        >>> stamps = gesture.stamps(engine.sample_rate)
        >>> engine.control_all(gesture.theta2, gesture.touching, stamps, gesture.source)
        """
        self._require_prepared()
        self._queues.control_all(theta2, touching, sample_times, sources)

    def set(self, id: str, value: Value, sample_time: int | None = None) -> None:
        """Change a parameter; it glides for 20 ms from the stamped sample.

        What belongs to the friction table makes a new surface, which is crossfaded in.

        Parameters
        ----------
        id : str
            One of the parameter table (`tactor.gain_db`) or of an event kind (`kinds.goal.height`).
        value : float, bool or str
            In the parameter's unit.
        sample_time : int or None
            When, in samples since reset; None is as soon as possible.

        Raises
        ------
        InputError
            No such parameter, or a value that is not allowed; nothing is changed.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set("tactor.gain_db", -6.0)
        >>> engine.parameters["tactor.gain_db"].value
        -6.0
        """
        preset = self._preset.with_value(id, value)
        known = PARAMETERS.get(id)
        surface = None
        if known is None or known.surface:
            surface = build_surface(self._timeline, preset)
        self._change(preset, surface, sample_time, {"set": {id: value}})

    def set_preset(self, preset: Preset, sample_time: int | None = None) -> None:
        """Change to another preset: parameters glide, its surface is crossfaded in.

        Parameters
        ----------
        preset : Preset
            How the timeline is felt and heard from then on.
        sample_time : int or None
            When, in samples since reset; None is as soon as possible.

        Raises
        ------
        InputError
            Its carrier doesn't fit the sample rate; nothing is changed.
        OverviewError
            As `set_surface`.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set_preset(ov.load_preset("football-stadium"))
        >>> engine.preset.name
        'football-stadium'
        """
        surface = build_surface(self._timeline, preset)
        self._change(preset, surface, sample_time, {"preset": preset_to_dict(preset)})

    def set_timeline(
        self,
        timeline: Timeline,
        sample_time: int | None = None,
        window: tuple[float, float] | None = None,
        change: Mapping[str, Any] | None = None,
        surface: Surface | None = None,
    ) -> None:
        """Change to other data under the same preset, crossfaded: a zoom, say.

        Parameters
        ----------
        timeline : Timeline
            The data from then on.
        sample_time : int or None
            When, in samples since reset; None is as soon as possible.
        window : (float, float) or None
            Which part of the first timeline this is, s; for a recording.
        change : mapping or None
            What a recording holds in place of a window: how a timeline that grows has changed.
        surface : Surface or None
            Its surface, where that was built already; None builds it.

        Raises
        ------
        OverviewError
            As `set_surface`.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set_timeline(match.window(0.0, 600.0), window=(0.0, 600.0))
        >>> engine.timeline.duration_s
        600.0
        """
        surface = build_surface(timeline, self._preset) if surface is None else surface
        note = dict(change) if change is not None else None
        if note is None and window is not None:
            note = {"window": list(window)}
        self._change(self._preset, surface, sample_time, note, timeline)

    def set_surface(self, surface: Surface, sample_time: int | None = None) -> None:
        """Crossfade to another surface (new data, a zoom, a preset) in 30 ms.

        A recording can't hold a surface that came so; it holds those of `set`, `set_preset` and
        `set_timeline`.

        Parameters
        ----------
        surface : Surface
            Of `build_surface`.
        sample_time : int or None
            When, in samples since reset; None is as soon as possible.

        Raises
        ------
        OverviewError
            Two surfaces are waiting or fading already: process a block first.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set_surface(ov.build_surface(match.window(0.0, 600.0), football))
        """
        self._require_prepared()
        validation.instance(surface, Surface, "surface", "ov.build_surface makes one")
        self._change(self._preset, surface, sample_time, None)

    def _change(
        self,
        preset: Preset,
        surface: Surface | None,
        sample_time: int | None,
        note: dict[str, Any] | None,
        timeline: Timeline | None = None,
    ) -> None:
        """Take over a preset and a surface, all at one sample; or nothing, with an error."""
        timeline = self._timeline if timeline is None else timeline
        if self._sample_rate:
            check_carrier(preset, self._sample_rate)
            stamp = stamp_of(sample_time)
            changed = changes(self._preset, preset, self._sample_rate)
            self._queues.require_capacity(len(changed) + 1)
            if surface is not None:
                slot = self._queues.free_slot()
                write_surface(self._f64, slot, surface)
                self._slot_surfaces[slot] = surface
                changed.append((layout.COMMAND_SURFACE, float(slot)))
            ask(self._f64, preset, changed)
            if changed:
                number = self._queues.push(changed, stamp)
                self._journal.append((number, note))
                if surface is not None:  # it comes last
                    last = number + len(changed) - 1
                    self._struck.add(last, surface, timeline, self._queues.applied_at)
        self._preset, self._timeline = preset, timeline
        if surface is not None:
            self._surface = surface

    def set_channels(self, click: int | None = 0, tactor: int | None = 1) -> None:
        """Choose the output channels; the others are silent.

        Parameters
        ----------
        click, tactor : int or None
            From 0; None is nowhere.

        Raises
        ------
        InputError
            A negative channel, or one channel for both.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        A pad whose voice coils are channels 3 and 4:

        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set_channels(click=None, tactor=2)
        """
        self._require_prepared()
        for channel in (click, tactor):
            if channel is not None and channel < 0:
                raise InputError(f"channel {channel}; channels count from 0, None is nowhere")
        if click is not None and click == tactor:
            raise InputError(f"clicks and tactor can't share channel {click}; give each its own")
        self._i64[layout.S_CLICK_CHANNEL] = -1 if click is None else click
        self._i64[layout.S_TACTOR_CHANNEL] = -1 if tactor is None else tactor
