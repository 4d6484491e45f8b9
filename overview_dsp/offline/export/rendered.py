"""A rendered gesture as a clip: its vibration by the millisecond, and its strikes.

Both are what the engine rendered, so a clip has the physics in it: the speed of the hand, the
recoil, the event that lets go late.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.offline.export.clip import FLOOR, LEVELS_PER_S, MAX_CLIP_S, Clip, felt_level
from overview_dsp.offline.export.strikes import strikes_of
from overview_dsp.offline.rendering.offline import Result
from overview_dsp.offline.rendering.trace import Trace


def clip_of(result: Result[Trace | None]) -> Clip:
    """Make a clip of a rendered gesture, up to where its vibration has died away.

    Raises
    ------
    InputError
        It was rendered without a trace, nothing vibrates, or it is longer than ten minutes.
    """
    if result.trace is None:
        raise InputError("rendered without a trace: its envelope is needed, render with trace=True")
    if len(result.samples) > MAX_CLIP_S * result.sample_rate:
        raise InputError(
            f"{len(result.samples) / result.sample_rate:.0f} s of vibration; a clip holds up to "
            f"{MAX_CLIP_S:g} s, use a shorter gesture"
        )
    preset = result.engine.preset
    level = np.minimum(_by_millisecond(result.trace.envelope, result.sample_rate), 1.0)
    if preset.values["tactor.mute"]:
        level[:] = 0.0
    felt = np.flatnonzero(level > FLOOR)
    if not len(felt):
        raise InputError(
            "nothing vibrates in this gesture; use a longer sweep or unmute the tactor"
        )
    level = np.append(level[: felt[-1] + 1], 0.0)
    return Clip(
        result.engine.timeline.title,
        level,
        preset.number("tactor.frequency_hz"),
        strikes_of(result, felt_level(level)),
        result.engine.surface,
    )


def _by_millisecond(envelope: NDArray[np.float64], sample_rate: float) -> NDArray[np.float64]:
    """RMS of the envelope around each millisecond."""
    energy = np.concatenate([[0.0], np.cumsum(envelope * envelope)])
    frames = np.arange(len(energy), dtype=np.float64)
    count = math.ceil(len(envelope) / sample_rate * LEVELS_PER_S) + 1
    edges = (np.arange(count + 1) - 0.5) / LEVELS_PER_S * sample_rate
    edges = np.clip(edges, 0.0, len(envelope))
    width = np.maximum(np.diff(edges), 1e-9)
    mean = np.diff(np.interp(edges, frames, energy)) / width
    return np.asarray(np.sqrt(np.maximum(mean, 0.0)))
