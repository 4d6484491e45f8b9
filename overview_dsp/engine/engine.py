"""The engine: prepare, control, process, reset; the one seam where objects become arrays."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine import reports
from overview_dsp.engine.coefficients import (
    FADE_S,
    GLIDE_S,
    changes,
    check_carrier,
    coefficients,
)
from overview_dsp.engine.compile_notice import announce_compile
from overview_dsp.engine.meters import EngineParameter, Meters, Strikes
from overview_dsp.engine.queues import ControlQueues, stamp_of
from overview_dsp.engine.state import decode_state, encode_state
from overview_dsp.engine.surface_slots import write_surface
from overview_dsp.engine.tail import tail_seconds
from overview_dsp.errors import InputError, NotPreparedError
from overview_dsp.kernels import block, layout
from overview_dsp.kernels.noise import seed_state
from overview_dsp.kernels.smoother import latency
from overview_dsp.presets.dicts import preset_to_dict
from overview_dsp.presets.model import Preset
from overview_dsp.presets.parameter import Parameter, Value
from overview_dsp.presets.parameters import PARAMETERS
from overview_dsp.surface.build import build_surface
from overview_dsp.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.timeline import Timeline

MIN_SAMPLE_RATE = 1_000.0
MAX_SAMPLE_RATE = 768_000.0

_NO_TRACE = np.zeros(0)


class Engine:
    """A preset on a timeline, as a block processor with control events.

    Thread: `process` belongs to the audio thread, everything else to one control thread.
    """

    def __init__(
        self,
        preset: Preset,
        timeline: Timeline,
        *,
        seed: int = 0,
        surface: Surface | None = None,
    ) -> None:
        """Build the surface; nothing is allocated or compiled until `prepare`.

        `surface` is that of this timeline and preset, where it is built already.
        """
        self._preset = preset
        self._timeline = timeline
        self._seed = seed
        self._surface = build_surface(timeline, preset) if surface is None else surface
        self._slot_surfaces: list[Surface | None] = [None] * layout.SLOTS
        self._sample_rate = 0.0
        self._max_block_size = 0
        self._journal: deque[tuple[int, dict[str, Any] | None]] = deque(maxlen=layout.HOST_RING)

    # --- life -----------------------------------------------------------------------------------

    def prepare(
        self,
        sample_rate: float = 48_000,
        max_block_size: int = 512,
        *,
        memory: NDArray[np.float64] | None = None,
    ) -> None:
        """Allocate for a sample rate (Hz, 1 000 to 768 000) and a largest block (frames).

        May be called again with other values; then everything is as new, parameters kept.
        `memory`, zeros float64 [`kernels.layout.TOTAL`], is used in place of memory of its own.

        Raises
        ------
        InputError
            A rate out of range or too low for the carrier, a block size below 1, or a memory of
            another type or shape.
        """
        rate = float(sample_rate)
        if not MIN_SAMPLE_RATE <= rate <= MAX_SAMPLE_RATE:
            raise InputError(
                f"sample rate {sample_rate:g} Hz is out of range; "
                f"it is {MIN_SAMPLE_RATE:g} to {MAX_SAMPLE_RATE:g} Hz"
            )
        check_carrier(self._preset, rate)
        if max_block_size < 1:
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
        self._i64[layout.S_GLIDE] = round(GLIDE_S * rate)
        self._i64[layout.S_FADE] = round(FADE_S * rate)
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
        """As a new engine with these, prepared as this one is, in the same memory.

        Raises
        ------
        InputError
            The preset's carrier doesn't fit the sample rate; nothing is changed.
        """
        self._require_prepared()
        check_carrier(preset, self._sample_rate)
        built = build_surface(timeline, preset) if surface is None else surface
        self._preset, self._timeline, self._seed, self._surface = preset, timeline, seed, built
        self._u64[layout.S_SEED] = seed_state(seed)
        self.reset()

    def reset(self) -> None:
        """As new, with the same parameters, surface and seed; waiting events are dropped."""
        self._require_prepared()
        for column, value in coefficients(self._preset, self._sample_rate).items():
            self._f64[column] = value
            self._i64[layout.GLIDE_LEFT + column] = 0
        self._i64[layout.S_RELEASE_RETURNS] = self._preset.values["disk.release"] == "return"
        self._i64[layout.ACTIVE_SLOT] = 0
        if self._slot_surfaces[0] is not self._surface:
            write_surface(self._f64, 0, self._surface, self._sample_rate)
            self._slot_surfaces[0] = self._surface
        block.reset(self._f64, self._i64, self._u64)
        self._queues.dropped = 0
        self._journal.clear()

    # --- control thread -------------------------------------------------------------------------

    def control(
        self,
        theta2: float,
        touching: bool,
        sample_time: int | None = None,
        source: str = "touch",
    ) -> None:
        """A hand's event: its angle (rad, 0 to pi) and whether it holds on.

        `sample_time` counts samples since reset; None means as soon as possible. A theta2 that is
        not finite or is out of range is counted in the meters. A full ring drops the event and
        counts it.
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
        """Many events of `control`, in order; sources are indices of `SOURCES`.

        Raises
        ------
        OverviewError
            More than a ring has room for; none is taken.
        """
        self._require_prepared()
        self._queues.control_all(theta2, touching, sample_times, sources)

    def set(self, id: str, value: Value, sample_time: int | None = None) -> None:
        """Change a parameter; it glides for 20 ms from the stamped sample.

        `id` is one of the parameter table (`tactor.gain_db`) or of an event kind
        (`kinds.goal.height`); what belongs to the friction table makes a new surface, crossfaded.

        Raises
        ------
        InputError
            No such parameter, or a value that is not allowed; nothing is changed.
        """
        preset = self._preset.with_value(id, value)
        known = PARAMETERS.get(id)
        surface = None
        if known is None or known.surface:
            surface = build_surface(self._timeline, preset)
        self._change(preset, surface, sample_time, {"set": {id: value}})

    def set_preset(self, preset: Preset, sample_time: int | None = None) -> None:
        """Change to another preset: parameters glide, its surface is crossfaded in.

        Raises
        ------
        InputError
            Its carrier doesn't fit the sample rate; nothing is changed.
        OverviewError
            As `set_surface`.
        """
        surface = build_surface(self._timeline, preset)
        self._change(preset, surface, sample_time, {"preset": preset_to_dict(preset)})

    def set_timeline(
        self,
        timeline: Timeline,
        sample_time: int | None = None,
        window: tuple[float, float] | None = None,
    ) -> None:
        """Change to other data under the same preset, crossfaded: a zoom, say.

        `window` says which part (s) of the first timeline this is, for a recording.

        Raises
        ------
        OverviewError
            As `set_surface`.
        """
        surface = build_surface(timeline, self._preset)
        note = {"window": list(window)} if window is not None else None
        self._change(self._preset, surface, sample_time, note)
        self._timeline = timeline

    def set_surface(self, surface: Surface, sample_time: int | None = None) -> None:
        """Crossfade to another surface (new data, a zoom, a preset) in 30 ms.

        A recording can't hold a surface that came so; it holds those of `set`, `set_preset` and
        `set_timeline`.

        Raises
        ------
        OverviewError
            Two surfaces are waiting or fading already: process a block first.
        """
        self._require_prepared()
        self._change(self._preset, surface, sample_time, None)

    def _change(
        self,
        preset: Preset,
        surface: Surface | None,
        sample_time: int | None,
        note: dict[str, Any] | None,
    ) -> None:
        """Take over a preset and a surface, all at one sample; or nothing, with an error."""
        if self._sample_rate:
            check_carrier(preset, self._sample_rate)
            stamp = stamp_of(sample_time)
            told = changes(self._preset, preset, self._sample_rate)
            self._queues.require_room(len(told) + 1)
            if surface is not None:
                slot = self._queues.free_slot()
                write_surface(self._f64, slot, surface, self._sample_rate)
                self._slot_surfaces[slot] = surface
                told.append((layout.COMMAND_SURFACE, float(slot)))
            if told:
                self._journal.append((self._queues.push(told, stamp), note))
        self._preset = preset
        if surface is not None:
            self._surface = surface

    def set_channels(self, click: int | None = 0, tactor: int | None = 1) -> None:
        """Choose the output channels (from 0; None = nowhere). Others are silent.

        Raises
        ------
        InputError
            A negative channel, or one channel for both.
        """
        self._require_prepared()
        for channel in (click, tactor):
            if channel is not None and channel < 0:
                raise InputError(f"channel {channel}; channels count from 0, None is nowhere")
        if click is not None and click == tactor:
            raise InputError(f"clicks and tactor can't share channel {click}; give each its own")
        self._i64[layout.S_CLICK_CHANNEL] = -1 if click is None else click
        self._i64[layout.S_TACTOR_CHANNEL] = -1 if tactor is None else tactor

    # --- audio thread ---------------------------------------------------------------------------

    def process(self, out: NDArray[np.float32], trace: NDArray[np.float64] | None = None) -> None:
        """Overwrite `out`, float32 (frames, channels), with the next block.

        `trace`, float64 (frames, 9) if given, gets the columns of `Trace`.

        Raises
        ------
        NotPreparedError
            Before `prepare`, or more frames than prepared; nothing was processed.
        InputError
            An array of the wrong type, shape or order.
        """
        self._require_prepared()
        if (
            not isinstance(out, np.ndarray)
            or out.dtype != np.float32
            or out.ndim != 2
            or not out.flags.c_contiguous
            or not out.flags.writeable
        ):
            raise InputError("out must be a writable, C-ordered float32 array (frames, channels)")
        frames, channels = out.shape
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

    # --- what it says of itself -------------------------------------------------------------------

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
        """The preset with the values set since."""
        return self._preset

    @property
    def surface(self) -> Surface:
        """The surface set last."""
        return self._surface

    def take_applied(self, since: int) -> tuple[NDArray[np.void], int]:
        """The control events applied after the first `since` ones, and how many there are by now.

        A record array with `sample`, `source` (index of `SOURCES`), `theta2` (rad, as used) and
        `touching`; the log keeps the latest 16384.

        Raises
        ------
        OverviewError
            More came since than the log keeps.
        """
        self._require_prepared()
        return reports.read_applied(self._f64, since)

    @property
    def memory(self) -> NDArray[np.float64]:
        """The memory block of `kernels.layout`: for an audio stream that runs the kernel itself."""
        self._require_prepared()
        return self._f64

    @property
    def sample_rate(self) -> float:
        """Hz; 0 before `prepare`."""
        return self._sample_rate

    @property
    def sample_time(self) -> int:
        """Samples processed since reset: the stamp of the next sample."""
        self._require_prepared()
        return int(self._i64[layout.CLOCK])

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
    def latency_samples(self) -> int:
        """How many samples the disk's input lags a moving hand (a tap is not delayed)."""
        self._require_prepared()
        return round(latency(float(self._f64[layout.C_SMOOTH])))

    @property
    def tail_seconds(self) -> float:
        """Within how long after the last event of any hand the output is exactly zero."""
        return tail_seconds(self._preset, self._surface)

    def take_strikes(self) -> Strikes:
        """The strikes since the last call (up to the log's 16384 latest)."""
        self._require_prepared()
        surface = self._slot_surfaces[int(self._i64[layout.ACTIVE_SLOT])]
        assert surface is not None
        return reports.take_strikes(self._f64, surface, self._sample_rate)

    def take_changes(self) -> list[tuple[int, dict[str, Any] | None]]:
        """The parameter and surface changes applied since the last call, each with its sample.

        A change is {"set": {id: value}}, {"preset": ...}, {"window": [start_s, end_s]}, or None
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
        """The tactor channel that a torque signal (N m, one value a frame) gives from rest."""
        self._require_prepared()
        return reports.tactor_of(self._f64, torque)

    # --- state ------------------------------------------------------------------------------------

    def save_state(self) -> bytes:
        """Parameters, event kinds and seed as bytes; the same engine gives the same bytes."""
        return encode_state(self._preset, self._seed)

    def load_state(self, state: bytes) -> None:
        """Take over a saved state; InputError, and nothing changed, if it isn't one."""
        preset, seed = decode_state(state)
        if self._sample_rate:
            check_carrier(preset, self._sample_rate)
        surface = build_surface(self._timeline, preset)
        self._preset, self._surface, self._seed = preset, surface, seed
        if self._sample_rate:
            self._u64[layout.S_SEED] = seed_state(seed)
            self.reset()

    # --- inside -----------------------------------------------------------------------------------

    def _require_prepared(self) -> None:
        if not self._sample_rate:
            raise NotPreparedError("the engine is not prepared; call prepare(sample_rate=...)")
