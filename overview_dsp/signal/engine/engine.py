"""The engine: prepare, control, process, reset; the one seam where objects become arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, NotPreparedError
from overview_dsp.kernels import block, layout
from overview_dsp.kernels.noise import seed_state
from overview_dsp.public import short
from overview_dsp.signal.engine.coefficients import check_carrier
from overview_dsp.signal.engine.controlled import ControlledEngine
from overview_dsp.signal.engine.reporting import ReportingEngine
from overview_dsp.signal.engine.state import decode_state, encode_state
from overview_dsp.signal.surface.build import build_surface

_NO_TRACE = np.zeros(0)


class Engine(ControlledEngine, ReportingEngine):
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
    >>> import numpy as np
    >>> import overview_dsp as ov
    >>> timeline, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> engine = ov.Engine(preset, timeline)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> engine.control(theta2=1.2, touching=True)
    >>> out = np.zeros((256, 2), dtype=np.float32)
    >>> engine.process(out)
    >>> bool(out.any())
    True
    """

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
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> timeline, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> engine = ov.Engine(preset, timeline)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> out = np.zeros((256, 2), dtype=np.float32)
        >>> engine.process(out)
        >>> engine.sample_time
        256
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

    def save_state(self) -> bytes:
        """Save parameters, event kinds and seed; the same engine gives the same bytes.

        Returns
        -------
        bytes
            For `load_state`.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> timeline, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> ov.Engine(preset, timeline).save_state() == ov.Engine(preset, timeline).save_state()
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
        >>> import overview_dsp as ov
        >>> timeline, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> state = ov.Engine(preset, timeline, seed=7).save_state()
        >>> engine = ov.Engine(ov.load_preset("plain"), timeline)
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
