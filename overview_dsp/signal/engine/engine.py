"""Engine: block processor that writes Python objects to the kernels' memory block.

Its saved state is JSON: parameters, event kinds and seed.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray, IntArray, SampleArray
from overview_dsp.design.gestures import SOURCES
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.design.presets.serialization import preset_from_dict, preset_to_dict
from overview_dsp.errors import InputError, NotPreparedError, OverviewError, quoted
from overview_dsp.kernels import block, layout
from overview_dsp.kernels.atomics import acquired
from overview_dsp.kernels.derive import derive
from overview_dsp.kernels.device.router import MAX_TACTORS
from overview_dsp.kernels.noise import seed_state
from overview_dsp.kernels.smoother import latency
from overview_dsp.public import short
from overview_dsp.signal.engine import coefficients
from overview_dsp.signal.engine.memory_reader import (
    APPLIED_EVENT,
    EngineParameter,
    Meters,
    Strikes,
    tail_seconds,
)
from overview_dsp.signal.engine.queues import ControlQueues, stamp_of
from overview_dsp.signal.engine.surface_slots import SurfaceHistory, write_surface
from overview_dsp.signal.engine.tactors import TactorRouter
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Event, Timeline


def _require_table(array: FloatArray, shape: tuple[int, ...], name: str) -> None:
    if array.dtype != np.float64 or array.shape != shape or not array.flags.c_contiguous:
        raise InputError(f"{name} must be a C-ordered float64 array {shape}")


MIN_SAMPLE_RATE = 1_000.0
MAX_SAMPLE_RATE = 768_000.0


_NO_TRACE = np.zeros(0)


class Engine:
    """Block processor for a preset and a timeline, with an interface like an audio plugin's.

    Nothing is allocated or compiled until `prepare`.

    Threads that may call concurrently:

    - one audio thread: `process`, or the stream that runs the kernel in `memory`;
    - any thread: `control`, `control_all`, `pop_applied`, and the properties that report the state
      (`meters`, `active_input`, `torque_integral`, `sample_time`, `preset` ...). Events of one
      source are applied in the order of the calls. A source therefore needs a single writer;
    - one thread of any kind: `pop_strikes` and `pop_strike_events`;
    - one thread of any kind: `pop_changes`;
    - one control thread: all other methods, such as `set`.

    `prepare`, `restart`, `reset` and `load_state` require that no other thread calls the engine and
    that no stream runs.

    Parameters
    ----------
    preset : Preset
        Parameters of feel and sound.
    timeline : Timeline
        Data to render.
    seed : int
        Seed of the texture noise.
    surface : Surface or None
        Surface of this timeline and preset; None builds it.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> engine.control(theta2=1.2, touching=True)
    >>> out = np.zeros((256, 2), dtype=np.float32)
    >>> engine.process(out)
    >>> bool(out.any())
    True
    """

    def __init__(
        self, preset: Preset, timeline: Timeline, *, seed: int = 0, surface: Surface | None = None
    ) -> None:
        if surface is None:
            surface = build_surface(timeline, preset)
        self._preset = validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
        self._timeline = timeline
        self._seed = validation.whole(seed, "seed")
        self._surface = validation.instance(
            surface, Surface, "surface", "ov.build_surface makes one"
        )
        self._slot_surfaces: list[Surface | None] = [None] * layout.SLOTS
        self._sample_rate = 0.0
        self._max_block_size = 0
        self._router: TactorRouter | None = None
        self._journal: deque[tuple[int, dict[str, Any] | None]] = deque(maxlen=layout.HOST_RING)

    def prepare(
        self,
        sample_rate: float = 48_000,
        max_block_size: int = 512,
        *,
        memory: FloatArray | None = None,
    ) -> None:
        """Allocate for a sample rate and a maximum block size.

        A later call with other values resets the engine but keeps the parameters.

        Parameters
        ----------
        sample_rate : float
            Hz, 1 000 to 768 000.
        max_block_size : int
            Frames of the largest block, at least 1.
        memory : float64 (kernels.layout.TOTAL,) or None
            Zeros to use instead of newly allocated memory.

        Raises
        ------
        InputError
            The sample rate is out of range or too low for the carrier, the block size is below 1,
            or the memory has a wrong type or shape.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=64)
        >>> engine.sample_rate
        8000.0
        """
        limits = MIN_SAMPLE_RATE, MAX_SAMPLE_RATE
        rate = validation.within(sample_rate, "sample_rate", *limits, " Hz")
        coefficients.check_carrier(self._preset, rate)
        if validation.whole(max_block_size, "max_block_size") < 1:
            raise InputError(f"max_block_size is {max_block_size}; must be at least 1 frame")
        if memory is not None:
            _require_table(memory, (layout.TOTAL,), "memory")
        coefficients.announce_compile("process")
        self._sample_rate = rate
        self._max_block_size = int(max_block_size)
        self._f64 = np.zeros(layout.TOTAL) if memory is None else memory
        self._i64 = self._f64.view(np.int64)
        self._u64 = self._f64.view(np.uint64)
        self._queues = ControlQueues(self._f64)
        self._struck = SurfaceHistory(self._queues.applied_at)
        self._i64[layout.S_CLICK_CHANNEL] = 0
        self._i64[layout.S_TACTOR_CHANNEL] = 1
        self._f64[layout.S_SAMPLE_RATE] = rate
        self._u64[layout.S_SEED] = seed_state(self._seed)
        self._slot_surfaces = [None] * layout.SLOTS
        self._router = None
        self.reset()

    def restart(
        self, preset: Preset, timeline: Timeline, *, seed: int = 0, surface: Surface | None = None
    ) -> None:
        """Reset with another preset and timeline, in the same memory.

        Parameters
        ----------
        preset : Preset
            Parameters of feel and sound.
        timeline : Timeline
            Data to render.
        seed : int
            Seed of the texture noise.
        surface : Surface or None
            Surface of this timeline and preset; None builds it.

        Raises
        ------
        InputError
            The preset's carrier doesn't fit the sample rate; nothing is changed.
        NotPreparedError
            `prepare` comes first.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.restart(ov.load_preset("plain"), match, seed=1)
        >>> engine.preset.name
        'plain'
        """
        self._require_prepared()
        coefficients.check_carrier(preset, self._sample_rate)
        built = build_surface(timeline, preset) if surface is None else surface
        self._preset, self._timeline, self._seed, self._surface = preset, timeline, seed, built
        self._u64[layout.S_SEED] = seed_state(seed)
        self.reset()

    def reset(self) -> None:
        """Reset the state; keep parameters, surface and seed, and drop pending events.

        Raises
        ------
        NotPreparedError
            `prepare` comes first.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.reset()
        >>> engine.sample_time
        0
        """
        self._require_prepared()
        coefficients.write_parameters(self._f64, self._preset)
        derive(self._f64, self._i64)
        self._i64[layout.ACTIVE_SLOT] = 0
        if self._slot_surfaces[0] is not self._surface:
            self._write_slot(0, self._surface)
        if self._router is not None:
            self._router.reset()
        block.reset(self._f64, self._i64, self._u64)
        self._queues.clear()
        self._journal.clear()
        self._struck.reset(self._surface, self._timeline)

    def _write_slot(self, slot: int, surface: Surface) -> None:
        write_surface(self._f64, slot, surface)
        self._slot_surfaces[slot] = surface
        if self._router is not None:
            self._router.write(slot, surface)

    def set_tactors(self, count: int) -> TactorRouter | None:
        """Choose the number of tactors that share the tactor's signal; not while a stream is open.

        `process` still writes one signal, which the router splits as the preset's
        `tactor.routing` says. A stream takes the number from its settings.

        Parameters
        ----------
        count : int
            Number of tactors, 1 to 8.

        Returns
        -------
        TactorRouter or None
            Router that splits the signal; None for one tactor.

        Raises
        ------
        InputError
            The number is out of range.
        NotPreparedError
            `prepare` comes first.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set_tactors(4).count
        4
        """
        self._require_prepared()
        count = validation.whole(count, "tactors", 1, MAX_TACTORS)
        if count != (1 if self._router is None else self._router.count):
            self._router = TactorRouter(count, self._sample_rate) if count > 1 else None
            for slot, surface in enumerate(self._slot_surfaces):
                if self._router is not None and surface is not None:
                    self._router.write(slot, surface)
        if self._router is not None:
            cursor = float(self._f64[layout.X]) / layout.CELLS
            self._router.reset(int(self._i64[layout.ACTIVE_SLOT]), cursor)
        return self._router

    @property
    def router(self) -> TactorRouter | None:
        """Router that splits the tactor's signal after `process`; None for one tactor."""
        return self._router

    @property
    def timeline(self) -> Timeline:
        """Present timeline."""
        return self._timeline

    @property
    def seed(self) -> int:
        """Seed of the texture noise."""
        return self._seed

    @property
    def preset(self) -> Preset:
        """Present preset, including later changes of parameters."""
        return self._preset

    @property
    def surface(self) -> Surface:
        """Present surface."""
        return self._surface

    @property
    def memory(self) -> FloatArray:
        """Memory block, float64, for an audio stream that runs the kernel itself."""
        self._require_prepared()
        return self._f64

    @property
    def sample_rate(self) -> float:
        """Sample rate, Hz; 0 before `prepare`."""
        return self._sample_rate

    @property
    def sample_time(self) -> int:
        """Number of samples processed since reset, which is the stamp of the next one."""
        self._require_prepared()
        return int(self._i64[layout.CLOCK])

    def _require_prepared(self) -> None:
        if not self._sample_rate:
            raise NotPreparedError("the engine is not prepared; call prepare(sample_rate=...)")

    def control(
        self, theta2: float, touching: bool, sample_time: int | None = None, source: str = "touch"
    ) -> None:
        """Queue a control event of an input.

        The meters count values of theta2 that are not finite or out of range. A full queue drops
        and counts the event.

        Thread: any; events of one source are applied in the order of the calls.

        Parameters
        ----------
        theta2 : float
            Input angle, rad; 0 = start of the timeline, pi = its end.
        touching : bool
            Whether the input touches the disk.
        sample_time : int or None
            Time in samples since reset; None is as soon as possible.
        source : {"touch", "twist", "serial", "osc", "midi", "remote"}
            Source of the event. The last source to touch controls the disk.

        Raises
        ------
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> engine.control(0.0, True)
        >>> engine.control(1.5, True, sample_time=4000)
        >>> engine.control(1.5, False, sample_time=8000)
        """
        self._require_prepared()
        self._queues.control(theta2, touching, stamp_of(sample_time), source)

    def control_all(
        self,
        theta2: FloatArray,
        touching: BoolArray,
        sample_times: IntArray,
        sources: NDArray[np.int8],
    ) -> None:
        """Queue many events of `control`, in order.

        Thread: any.

        Parameters
        ----------
        theta2 : float64 (events,)
            Angles, rad.
        touching : bool (events,)
            Whether the input touches the disk.
        sample_times : int64 (events,)
            Times in samples since reset.
        sources : int8 (events,)
            Sources, as indices in the order of `control`.

        Raises
        ------
        OverviewError
            A queue is full; no event is queued.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> gesture = ov.sweep(1.0)
        >>> stamps = gesture.stamps(engine.sample_rate)
        >>> engine.control_all(gesture.theta2, gesture.touching, stamps, gesture.source)
        """
        self._require_prepared()
        self._queues.control_all(theta2, touching, sample_times, sources)

    def set(self, id: str, value: Value, sample_time: int | None = None) -> None:
        """Change a parameter, smoothed over 20 ms from the given sample.

        A parameter of the friction table makes a new surface, which is crossfaded in.

        Parameters
        ----------
        id : str
            Parameter (`tactor.gain_db`) or key of an event kind (`kinds.goal.height`).
        value : float, bool or str
            Value in the parameter's unit.
        sample_time : int or None
            Time in samples since reset; None is as soon as possible.

        Raises
        ------
        InputError
            The parameter is unknown or the value is not allowed; nothing is changed.

        Examples
        --------
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
        """Change the preset: smooth its parameters and crossfade its surface.

        Parameters
        ----------
        preset : Preset
            New parameters of feel and sound.
        sample_time : int or None
            Time in samples since reset; None is as soon as possible.

        Raises
        ------
        InputError
            Its carrier doesn't fit the sample rate; nothing is changed.
        OverviewError
            As `set_surface`.

        Examples
        --------
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
        only_untouched: bool = False,
    ) -> None:
        """Change the timeline, for example to a window of it, with a crossfade.

        Parameters
        ----------
        timeline : Timeline
            New data.
        sample_time : int or None
            Time in samples since reset; None is as soon as possible.
        window : (float, float) or None
            Window of the first timeline that this is, s; for a recording.
        change : mapping or None
            Change of a live timeline, which a recording stores instead of a window.
        surface : Surface or None
            Surface of the timeline; None builds it.
        only_untouched : bool
            Whether a touch, even one that is still pending, prevents the change.

        Raises
        ------
        OverviewError
            As `set_surface`; or a touch prevents the change.

        Examples
        --------
        >>> engine.set_timeline(match.window(0.0, 600.0), window=(0.0, 600.0))
        >>> engine.timeline.duration_s
        600.0
        """
        surface = build_surface(timeline, self._preset) if surface is None else surface
        note = dict(change) if change is not None else None
        if note is None and window is not None:
            note = {"window": list(window)}
        self._change(self._preset, surface, sample_time, note, timeline, only_untouched)

    def set_surface(self, surface: Surface, sample_time: int | None = None) -> None:
        """Crossfade to another surface in 30 ms.

        A recording can't store this change, only those of `set`, `set_preset` and `set_timeline`.

        Parameters
        ----------
        surface : Surface
            Surface from `build_surface`.
        sample_time : int or None
            Time in samples since reset; None is as soon as possible.

        Raises
        ------
        OverviewError
            Two surfaces are already pending or fading: process a block first.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
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
        only_untouched: bool = False,
    ) -> None:
        """Apply a preset and a surface at one sample; on an error change nothing."""
        timeline = self._timeline if timeline is None else timeline
        if self._sample_rate:
            coefficients.check_carrier(preset, self._sample_rate)
            stamp = stamp_of(sample_time)
            changed = coefficients.changes(self._preset, preset, self._sample_rate)
            self._queues.require_capacity(len(changed) + 1)
            if surface is not None:
                slot = self._queues.free_slot()
                self._write_slot(slot, surface)
                changed.append((layout.COMMAND_SURFACE, float(slot)))
            # no touch can come between the check and the change
            with self._queues.no_new_events() if only_untouched else nullcontext():
                if only_untouched and self._queues.touched:
                    raise OverviewError("an input touches the disk; change the timeline later")
                coefficients.store_requested(self._f64, preset, changed)
                number = self._queues.push(changed, stamp) if changed else 0
            if changed:
                self._journal.append((number, note))
                if surface is not None:  # it comes last
                    last = number + len(changed) - 1
                    self._struck.add(last, surface, timeline)
        self._preset, self._timeline = preset, timeline
        if surface is not None:
            self._surface = surface

    def set_channels(self, click: int | None = 0, tactor: int | None = 1) -> None:
        """Choose the output channels; the others are silent.

        Parameters
        ----------
        click, tactor : int or None
            Channel index from 0; None disables the signal.

        Raises
        ------
        InputError
            A channel is negative, or both signals have the same channel.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        A pad whose voice coils are channels 3 and 4:

        >>> engine.set_channels(click=None, tactor=2)
        """
        self._require_prepared()
        for channel in (click, tactor):
            if channel is not None and channel < 0:
                raise InputError(f"channel is {channel}; must be 0 or more, or None for no output")
        if click is not None and click == tactor:
            raise InputError(f"clicks and tactor can't share channel {click}; give each its own")
        self._i64[layout.S_CLICK_CHANNEL] = -1 if click is None else click
        self._i64[layout.S_TACTOR_CHANNEL] = -1 if tactor is None else tactor

    def pop_applied(self, since: int) -> tuple[NDArray[np.void], int]:
        """Read the applied control events; the log keeps the latest 16384.

        Parameters
        ----------
        since : int
            Number of events read before.

        Returns
        -------
        events : record array
            `sample`, `source` (an index), `theta2` (rad, as used) and `touching`.
        count : int
            Number of events applied so far.

        Raises
        ------
        OverviewError
            More events were applied since then than the log keeps.
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.control(1.2, True)
        >>> engine.process(np.zeros((256, 2), dtype=np.float32))
        >>> events, count = engine.pop_applied(0)
        >>> count, float(events["theta2"][0])
        (1, 1.2)
        """
        memory, i64 = self.memory, self._i64
        since = validation.whole(since, "since", least=0)
        now = acquired(i64, layout.APPLIED)
        if since > now:
            raise InputError(
                f"since is {quoted(since)}; must be 0 to {now}, the events applied so far"
            )
        if now - since > layout.APPLIED_LOG:
            raise OverviewError(
                f"{now - since} control events were applied since the last call; the log keeps "
                f"{layout.APPLIED_LOG}; call more often"
            )
        at = np.arange(since, now) % layout.APPLIED_LOG
        events = np.empty(len(at), dtype=APPLIED_EVENT)
        events["sample"] = i64[layout.APPLIED_TIME + at]
        events["source"] = i64[layout.APPLIED_SOURCE + at]
        events["theta2"] = memory[layout.APPLIED_THETA2 + at]
        events["touching"] = i64[layout.APPLIED_TOUCHING + at]
        return events, now

    @property
    def parameters(self) -> Mapping[str, EngineParameter]:
        """All parameters by id, with range, unit, default, description and present value."""
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
        f64, i64 = self.memory, self._i64
        return Meters(
            blocks=int(i64[layout.M_BLOCKS]),
            late_events=int(i64[layout.M_LATE]),
            rejected_events=int(i64[layout.M_REJECTED]),
            clamped_events=int(i64[layout.M_CLAMPED]),
            dropped_events=self._queues.dropped,
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

    @property
    def torque_integral(self) -> tuple[float, float]:
        """Time processed since reset (s), and integral of the torque over it (N m s).

        The difference of two readings gives the mean torque between them, including peaks shorter
        than a block. Thread: any.
        """
        memory = self.memory
        while True:  # the audio thread may write between the two
            samples = int(self._i64[layout.M_SUMMED])
            integral = float(memory[layout.M_IMPULSE])
            if samples == self._i64[layout.M_SUMMED]:
                return samples / self._sample_rate, integral / self._sample_rate

    @property
    def active_input(self) -> tuple[str, float] | None:
        """Source that controls the disk and its theta2 (rad) as of the last block, or None."""
        memory, source = self.memory, int(self._i64[layout.HOLDER])
        if source < 0:
            return None
        return SOURCES[source], float(memory[layout.SOURCE_THETA2 + source])

    @property
    def touched(self) -> bool:
        """True while an input controls the disk, or will after the events that are pending."""
        self._require_prepared()
        return self._queues.touched

    @property
    def settled_at(self) -> int | None:
        """Sample since which the disk is at the input angle, past all events, or None.

        With sticking friction: since which it is at rest. None without an active input too.
        """
        memory, i64 = self.memory, self._i64
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

    @property
    def latency_samples(self) -> int:
        """Delay of a moving input by the smoother, samples (a tap is not delayed)."""
        return round(latency(float(self.memory[layout.C_SMOOTH])))

    @property
    def tail_seconds(self) -> float:
        """Upper bound of the time from the last control event to exact silence, s."""
        return tail_seconds(self._preset, self._surface)

    def pop_strikes(self) -> Strikes:
        """Return the strikes since the last call (at most the latest 16384).

        Returns
        -------
        Strikes
            Strikes in order of time.

        Raises
        ------
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> len(engine.pop_strikes())
        0
        """
        return self._pop_strikes()[0]

    def pop_strike_events(self) -> list[tuple[Event, float]]:
        """Return the events struck since the last call of this method or `pop_strikes`.

        Returns
        -------
        list of (Event, float)
            Event of the timeline at that time, and linear amplitude of its click.

        Raises
        ------
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.pop_strike_events()
        []
        """
        strikes, timelines = self._pop_strikes()
        return [
            (timeline.events[event], float(level))
            for event, level, timeline in zip(strikes.event, strikes.level, timelines, strict=True)
            if event >= 0 and timeline is not None
        ]

    def _pop_strikes(self) -> tuple[Strikes, list[Timeline | None]]:
        """Return the strikes and their timelines; None for one that is no longer known."""
        memory, i64 = self.memory, self._i64
        now = int(i64[layout.CLOCK])
        total = acquired(i64, layout.M_STRIKES)
        first = max(int(i64[layout.STRIKES_READ]), total - layout.STRIKE_LOG)
        i64[layout.STRIKES_READ] = total
        at = np.arange(first, total) % layout.STRIKE_LOG
        times = memory[layout.LOG_TIME + at]
        events, timelines = self._struck.find(i64[layout.LOG_EVENT + at], times, now)
        torque, level = memory[layout.LOG_TORQUE + at], memory[layout.LOG_LEVEL + at]
        return Strikes(times / self._sample_rate, events, torque, level), timelines

    def pop_changes(self) -> list[tuple[int, dict[str, Any] | None]]:
        """Return the parameter and surface changes applied since the last call.

        Returns
        -------
        list of (int, dict or None)
            Sample and change: `{"set": {id: value}}`, `{"preset": ...}`,
            `{"window": [start_s, end_s]}`, the `change` of `set_timeline`, or None for one that a
            recording can't store.

        Raises
        ------
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> engine = ov.Engine(plain, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.set("tactor.gain_db", -6.0)
        >>> engine.process(np.zeros((256, 2), dtype=np.float32))
        >>> engine.pop_changes()
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

    def tactor_of(self, torque: FloatArray) -> SampleArray:
        """Return the tactor signal of a torque signal, starting from rest.

        Parameters
        ----------
        torque : float64 (frames,)
            Torque of each frame, N m.

        Returns
        -------
        float32 (frames,)
            Linear samples; full scale is 1.

        Raises
        ------
        NotPreparedError
            Before `prepare`.

        Examples
        --------
        >>> result = ov.render(match, plain, ov.sweep(0.5), sample_rate=8000)
        >>> vibration = result.engine.tactor_of(result.trace.torque)
        >>> bool((vibration == result.samples[:, 1]).all())
        True
        """
        memory, out = self.memory, np.zeros(len(torque), dtype=np.float32)
        block.tactor_stage(memory, np.ascontiguousarray(torque, dtype=np.float64), out)
        return out

    def process(self, out: SampleArray, trace: FloatArray | None = None) -> None:
        """Overwrite a buffer with the next block; allocate nothing. Thread: audio.

        Parameters
        ----------
        out : float32 (frames, channels)
            C-ordered and writable buffer, overwritten.
        trace : float64 (frames, 9) or None
            Buffer for the columns of `Trace`, overwritten.

        Raises
        ------
        NotPreparedError
            Before `prepare`, or with more frames than prepared; nothing is processed.
        InputError
            An array has a wrong type, shape or order.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> out = np.zeros((256, 2), dtype=np.float32)
        >>> engine.process(out)
        >>> engine.sample_time
        256
        """
        self._require_prepared()
        frames, channels = validation.block(out, "out")
        if frames > self._max_block_size:
            raise NotPreparedError(
                f"block has {frames} frames; the engine is prepared for up to "
                f"{self._max_block_size}, call prepare(max_block_size={frames})"
            )
        needed = max(self._i64[layout.S_CLICK_CHANNEL], self._i64[layout.S_TACTOR_CHANNEL]) + 1
        if channels < needed:
            raise InputError(f"out has {channels} channels; the channel map needs {needed}")
        flat = _NO_TRACE
        if trace is not None:
            _require_table(trace, (frames, layout.TRACE), "trace")
            flat = trace.reshape(-1)
        block.process(
            self._f64, self._i64, self._u64, out.reshape(-1), frames, channels, flat,
            trace is not None,
        )  # fmt: skip

    def save_state(self) -> bytes:
        """Save parameters, event kinds and seed; the same engine gives the same bytes.

        Returns
        -------
        bytes
            State for `load_state`.

        Examples
        --------
        >>> ov.Engine(football, match).save_state() == ov.Engine(football, match).save_state()
        True
        """
        state = {"overview_state": 1, **preset_to_dict(self._preset), "seed": self._seed}
        return json.dumps(state, indent=1, ensure_ascii=False).encode()

    def load_state(self, state: bytes) -> None:
        """Load a saved state.

        Parameters
        ----------
        state : bytes
            State from `save_state`.

        Raises
        ------
        InputError
            The state is invalid; nothing is changed.

        Examples
        --------
        >>> state = ov.Engine(football, match, seed=7).save_state()
        >>> engine = ov.Engine(ov.load_preset("plain"), match)
        >>> engine.load_state(state)
        >>> engine.preset.name, engine.seed
        ('football', 7)
        """
        with validation.only_input_errors("not a saved state"):
            data = json.loads(state.decode())
            if data["overview_state"] != 1:
                version = data["overview_state"]
                raise InputError(f"overview_state is {version!r}; must be 1")
            preset, seed = preset_from_dict(data), int(data["seed"])
        if self._sample_rate:
            coefficients.check_carrier(preset, self._sample_rate)
        surface = build_surface(self._timeline, preset)
        self._preset, self._surface, self._seed = preset, surface, seed
        if self._sample_rate:
            self._u64[layout.S_SEED] = seed_state(seed)
            self.reset()

    def __repr__(self) -> str:
        rate = f"{self._sample_rate:g} Hz" if self._sample_rate else "not prepared"
        return f"<Engine: {short(self._preset.name)} on {short(self._timeline.title)}, {rate}>"
