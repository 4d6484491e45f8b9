"""The engine: prepare, control, process, report, reset; the one seam where objects become arrays.

Its saved state is JSON: parameters, event kinds and seed.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.design.presets.serialization import preset_from_dict, preset_to_dict
from overview_dsp.errors import InputError, NotPreparedError
from overview_dsp.kernels import block, layout
from overview_dsp.kernels.derive import derive
from overview_dsp.kernels.noise import seed_state
from overview_dsp.kernels.smoother import latency
from overview_dsp.public import short
from overview_dsp.signal.engine import reports
from overview_dsp.signal.engine.coefficients import (
    announce_compile,
    ask,
    changes,
    check_carrier,
    write_parameters,
)
from overview_dsp.signal.engine.queues import ControlQueues, stamp_of
from overview_dsp.signal.engine.reports import EngineParameter, Meters, Strikes, tail_seconds
from overview_dsp.signal.engine.surface_slots import StruckSurfaces, write_surface
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Event, Timeline


def encode_state(preset: Preset, seed: int) -> bytes:
    """The state as UTF-8 JSON; the same values give the same bytes."""
    state = {"overview_state": 1, **preset_to_dict(preset), "seed": seed}
    return json.dumps(state, indent=1, ensure_ascii=False).encode()


def decode_state(state: bytes) -> tuple[Preset, int]:
    """Preset and seed of a saved state; InputError if it isn't one."""
    try:
        data = json.loads(state.decode())
        if data["overview_state"] != 1:
            raise InputError(f"a state of version {data['overview_state']!r}; this reads 1")
        preset = preset_from_dict(data)
        seed = int(data["seed"])
    except InputError:
        raise
    except (ValueError, OverflowError, RecursionError) as error:
        raise InputError(f"not a saved state: {error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"not a saved state: {type(error).__name__} {error}") from None
    return preset, seed


MIN_SAMPLE_RATE = 1_000.0
MAX_SAMPLE_RATE = 768_000.0


_NO_TRACE = np.zeros(0)


class Engine:
    """A preset on a timeline, as a block processor with control events: the audio plugin's face.

    Nothing is allocated or compiled until `prepare`.

    Thread: who may call what, while others call too:

    - one audio thread: `process`, or the stream that runs the kernel in `memory`;
    - any thread: `control` and `control_all`, the properties that report the state (`meters`,
      `holder`, `impulse`, `sample_time`, `preset` ...), and `take_applied`. Events of one source
      are applied in the order of their calls, so a source whose order matters has one writer;
    - one thread, whichever: `take_strikes` and `take_struck_events`;
    - one thread, whichever: `take_changes`;
    - one control thread: everything else, as `set` and its kin.

    `prepare`, `restart`, `reset` and `load_state` begin anew: nobody else calls anything meanwhile,
    and no stream runs.

    Parameters
    ----------
    preset : Preset
        How the timeline is felt and heard.
    timeline : Timeline
        The data under the hand.
    seed : int
        Of the surface's grain.
    surface : Surface or None
        That of this timeline and preset, where it is built already.

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
        self,
        preset: Preset,
        timeline: Timeline,
        *,
        seed: int = 0,
        surface: Surface | None = None,
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
        self._struck = StruckSurfaces()
        self._journal: deque[tuple[int, dict[str, Any] | None]] = deque(maxlen=layout.HOST_RING)

    def prepare(
        self,
        sample_rate: float = 48_000,
        max_block_size: int = 512,
        *,
        memory: NDArray[np.float64] | None = None,
    ) -> None:
        """Allocate for a sample rate and a largest block.

        May be called again with other values; then everything is as new, parameters kept.

        Parameters
        ----------
        sample_rate : float
            Hz, 1 000 to 768 000.
        max_block_size : int
            Frames of the largest block, at least 1.
        memory : float64 (kernels.layout.TOTAL,) or None
            Zeros to be used in place of memory of its own.

        Raises
        ------
        InputError
            A rate out of range or too low for the carrier, a block size below 1, or a memory of
            another type or shape.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=64)
        >>> engine.sample_rate
        8000.0
        """
        rate = validation.real(sample_rate, "sample_rate")
        if not MIN_SAMPLE_RATE <= rate <= MAX_SAMPLE_RATE:
            raise InputError(
                f"sample rate {rate:g} Hz is out of range; "
                f"it is {MIN_SAMPLE_RATE:g} to {MAX_SAMPLE_RATE:g} Hz"
            )
        check_carrier(self._preset, rate)
        if validation.whole(max_block_size, "max_block_size") < 1:
            raise InputError(f"max_block_size = {max_block_size}; it is at least 1 frame")
        if memory is not None and (
            memory.dtype != np.float64
            or memory.shape != (layout.TOTAL,)
            or not memory.flags.c_contiguous
        ):
            raise InputError(f"memory must be a C-ordered float64 array ({layout.TOTAL},)")
        announce_compile("process")
        self._sample_rate = rate
        self._max_block_size = int(max_block_size)
        self._f64 = np.zeros(layout.TOTAL) if memory is None else memory
        self._i64 = self._f64.view(np.int64)
        self._u64 = self._f64.view(np.uint64)
        self._queues = ControlQueues(self._f64)
        self._i64[layout.S_CLICK_CHANNEL] = 0
        self._i64[layout.S_TACTOR_CHANNEL] = 1
        self._f64[layout.S_SAMPLE_RATE] = rate
        self._u64[layout.S_SEED] = seed_state(self._seed)
        self._slot_surfaces = [None] * layout.SLOTS
        self.reset()

    def restart(
        self,
        preset: Preset,
        timeline: Timeline,
        *,
        seed: int = 0,
        surface: Surface | None = None,
    ) -> None:
        """Begin anew with these, prepared as before and in the same memory.

        Parameters
        ----------
        preset : Preset
            How the timeline is felt and heard.
        timeline : Timeline
            The data under the hand.
        seed : int
            Of the surface's grain.
        surface : Surface or None
            That of this timeline and preset, where it is built already.

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
        check_carrier(preset, self._sample_rate)
        built = build_surface(timeline, preset) if surface is None else surface
        self._preset, self._timeline, self._seed, self._surface = preset, timeline, seed, built
        self._u64[layout.S_SEED] = seed_state(seed)
        self.reset()

    def reset(self) -> None:
        """Begin anew with the same parameters, surface and seed; waiting events are dropped.

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
        write_parameters(self._f64, self._preset)
        derive(self._f64, self._i64)
        self._i64[layout.ACTIVE_SLOT] = 0
        if self._slot_surfaces[0] is not self._surface:
            write_surface(self._f64, 0, self._surface)
            self._slot_surfaces[0] = self._surface
        block.reset(self._f64, self._i64, self._u64)
        self._queues.clear_dropped()
        self._journal.clear()
        self._struck.reset(self._surface, self._timeline)

    @property
    def timeline(self) -> Timeline:
        """The data under the hand."""
        return self._timeline

    @property
    def seed(self) -> int:
        """The seed of the surface's grain."""
        return self._seed

    @property
    def preset(self) -> Preset:
        """The preset, with the values set since."""
        return self._preset

    @property
    def surface(self) -> Surface:
        """The surface that was set last."""
        return self._surface

    @property
    def memory(self) -> NDArray[np.float64]:
        """The memory block, float64, for an audio stream that runs the kernel itself."""
        self._require_prepared()
        return self._f64

    @property
    def sample_rate(self) -> float:
        """The sample rate, Hz; 0 before `prepare`."""
        return self._sample_rate

    @property
    def sample_time(self) -> int:
        """The next sample's stamp: samples processed since reset."""
        self._require_prepared()
        return int(self._i64[layout.CLOCK])

    def _require_prepared(self) -> None:
        if not self._sample_rate:
            raise NotPreparedError("the engine is not prepared; call prepare(sample_rate=...)")

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
        >>> result = ov.render(match, plain, ov.sweep(0.5), sample_rate=8000)
        >>> vibration = result.engine.tactor_of(result.trace.torque)
        >>> bool((vibration == result.samples[:, 1]).all())
        True
        """
        self._require_prepared()
        return reports.tactor_of(self._f64, torque)

    def process(self, out: NDArray[np.float32], trace: NDArray[np.float64] | None = None) -> None:
        """Overwrite a buffer with the next block; allocates nothing. Thread: audio.

        Parameters
        ----------
        out : float32 (frames, channels)
            C-ordered and writable; overwritten.
        trace : float64 (frames, 9) or None
            Gets the columns of `Trace`, if given.

        Raises
        ------
        NotPreparedError
            Before `prepare`, or more frames than prepared; nothing was processed.
        InputError
            An array of the wrong type, shape or order.

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
                f"a block of {frames} frames; the engine is prepared for up to "
                f"{self._max_block_size}, call prepare(max_block_size={frames})"
            )
        needed = max(self._i64[layout.S_CLICK_CHANNEL], self._i64[layout.S_TACTOR_CHANNEL]) + 1
        if channels < needed:
            raise InputError(f"out has {channels} channels; the channel map needs {needed}")
        if trace is None:
            flat, traced = _NO_TRACE, False
        else:
            if (
                trace.dtype != np.float64
                or trace.shape != (frames, layout.TRACE)
                or not trace.flags.c_contiguous
            ):
                raise InputError(
                    f"trace must be a C-ordered float64 array ({frames}, {layout.TRACE})"
                )
            flat, traced = trace.reshape(-1), True
        block.process(
            self._f64, self._i64, self._u64, out.reshape(-1), frames, channels, flat, traced
        )

    def save_state(self) -> bytes:
        """Save parameters, event kinds and seed; the same engine gives the same bytes.

        Returns
        -------
        bytes
            For `load_state`.

        Examples
        --------
        >>> ov.Engine(football, match).save_state() == ov.Engine(football, match).save_state()
        True
        """
        return encode_state(self._preset, self._seed)

    def load_state(self, state: bytes) -> None:
        """Take over a saved state.

        Parameters
        ----------
        state : bytes
            Of `save_state`.

        Raises
        ------
        InputError
            It isn't one; nothing is changed.

        Examples
        --------
        >>> state = ov.Engine(football, match, seed=7).save_state()
        >>> engine = ov.Engine(ov.load_preset("plain"), match)
        >>> engine.load_state(state)
        >>> engine.preset.name, engine.seed
        ('football', 7)
        """
        preset, seed = decode_state(state)
        if self._sample_rate:
            check_carrier(preset, self._sample_rate)
        surface = build_surface(self._timeline, preset)
        self._preset, self._surface, self._seed = preset, surface, seed
        if self._sample_rate:
            self._u64[layout.S_SEED] = seed_state(seed)
            self.reset()

    def __repr__(self) -> str:
        rate = f"{self._sample_rate:g} Hz" if self._sample_rate else "not prepared"
        return f"<Engine: {short(self._preset.name)} on {short(self._timeline.title)}, {rate}>"
