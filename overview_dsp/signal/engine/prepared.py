"""An engine's memory: prepared for a sample rate, and begun anew."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, NotPreparedError
from overview_dsp.kernels import block, layout
from overview_dsp.kernels.derive import derive
from overview_dsp.kernels.noise import seed_state
from overview_dsp.signal.engine.coefficients import check_carrier, write_parameters
from overview_dsp.signal.engine.compile_notice import announce_compile
from overview_dsp.signal.engine.queues import ControlQueues
from overview_dsp.signal.engine.struck import StruckSurfaces
from overview_dsp.signal.engine.surface_slots import write_surface
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline

MIN_SAMPLE_RATE = 1_000.0
MAX_SAMPLE_RATE = 768_000.0


class PreparedEngine:
    """What an engine plays, and the memory block it is played from."""

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
        >>> import overview_dsp as ov
        >>> data, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(preset, data)
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
        >>> import overview_dsp as ov
        >>> data, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(preset, data)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> engine.restart(ov.load_preset("plain"), data, seed=1)
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
        >>> import overview_dsp as ov
        >>> data, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(preset, data)
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
