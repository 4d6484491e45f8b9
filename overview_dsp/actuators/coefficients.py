"""An actuator becomes coefficients: what a profile says, turned into what the kernel multiplies by.

Every exponential, sine and cosine here is the kernels' own, so that two machines derive the same
bits.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp.actuators.model import LOWEST_Q, Actuator
from overview_dsp.engine.coefficients import one_pole
from overview_dsp.errors import InputError
from overview_dsp.kernels import elementary, layout
from overview_dsp.kernels.limiter import TOP
from overview_dsp.units import db_to_gain

HIGHEST_PART = 0.45
"""A resonance must lie below this part of the sample rate."""

LEAST_HEADROOM = 1e-6
"""From the nominal drive to the peak, where they are the same."""

MEMORY = 1.0 / 8.0
"""The heat's memory, of the window, where the duty is 1; up to a window longer where it is less.
A longer one allows longer bursts, and less for good."""

KNEE = 0.25
"""The drive is taken back within this part of the heat's limit below it."""

SKIN_HZ = 247.0
SKIN_WIDTH = 0.62
SKIN_MOST = 16.0
"""The weighting: a second-order cut as deep as 24 dB, 1 where the skin feels most; fitted to
`skin.pacinian_db` (within 3.5 dB from 50 to 800 Hz)."""

_exp2 = elementary.plain(elementary.exp2)
_sin = elementary.plain(elementary.sin_turns)


def _exp(x: float) -> float:
    return float(_exp2(x * elementary.LOG2_E))


def _sine(turns: float) -> float:
    return float(_sin(turns))


def _cosine(turns: float) -> float:
    return float(_sin(turns + 0.25))


def write_actuator(
    memory: NDArray[np.float64],
    at: int,
    actuator: Actuator | None,
    sample_rate: float,
) -> None:
    """Put an actuator's coefficients into memory at `at`, its state as new; None: no actuator.

    Its heat stays: an output that is opened again finds it as warm as it was left. Before the
    audio runs.

    Raises
    ------
    InputError
        A resonance that the sample rate (Hz) is too low for.
    """
    wanted: dict[int, float] = {}
    if actuator is not None:
        wanted = {
            layout.ACT_NOMINAL: actuator.nominal * db_to_gain(actuator.gain_db),
            layout.ACT_BEND: TOP * actuator.nominal,
            layout.ACT_PEAK: TOP * actuator.peak,
            layout.ACT_ROOM: max(LEAST_HEADROOM, TOP * (actuator.peak - actuator.nominal)),
            **_sharpening(actuator, sample_rate),
            **_protection(actuator, sample_rate),
            **_weighting(actuator, sample_rate),
        }
    heat = float(memory[at + layout.ACT_HEAT])
    memory[at : at + layout.ACT_SIZE] = 0.0
    for column, value in wanted.items():
        memory[at + column] = value
    memory[at + layout.ACT_HEAT] = min(heat, float(memory[at + layout.ACT_LIMIT]))
    memory.view(np.int64)[at + layout.ACT_ON] = actuator is not None


def _sharpening(actuator: Actuator, sample_rate: float) -> dict[int, float]:
    """The mass's matrix, and the feedback that moves its poles to those of a lower Q."""
    _check_rate(actuator, actuator.resonance_hz, sample_rate)
    turns = actuator.resonance_hz / sample_rate
    q = actuator.q
    wanted = max(LOWEST_Q, q / actuator.number("shaping.sharpen"))
    fall, slant, swing = _decay(turns, q)
    sine, cosine = _sine(swing), _cosine(swing)
    a11, a12 = fall * (cosine + slant * sine), fall * sine * math.sqrt(1.0 + slant * slant)
    a21, a22 = -a12, fall * (cosine - slant * sine)
    b1, b2 = 1.0 - a11, -a21
    matrix = {
        layout.ACT_A11: a11, layout.ACT_A12: a12, layout.ACT_A21: a21, layout.ACT_A22: a22,
        layout.ACT_B1: b1, layout.ACT_B2: b2,
    }  # fmt: skip
    if wanted >= q:
        return {**matrix, layout.ACT_FORWARD: 1.0}
    trace, product = a11 + a22, fall * fall
    new_fall, _, new_swing = _decay(turns, wanted)
    new_trace, new_product = 2.0 * new_fall * _cosine(new_swing), new_fall * new_fall
    # trace(A - b k) and det(A - b k) as wanted: two linear equations
    c1, c2 = a22 * b1 - a12 * b2, a11 * b2 - a21 * b1
    r1, r2 = trace - new_trace, product - new_product
    size = b1 * c2 - b2 * c1
    k1, k2 = (r1 * c2 - r2 * b2) / size, (b1 * r2 - c1 * r1) / size
    forward = _poles_at(turns, new_trace, new_product) / _poles_at(turns, trace, product)
    return {
        **matrix,
        layout.ACT_FORWARD: forward,
        layout.ACT_FROM_POSITION: k1,
        layout.ACT_FROM_SPEED: k2,
    }


def _decay(turns: float, q: float) -> tuple[float, float, float]:
    """Of a resonance: decay a sample, damping over swing, turns of its swing a sample."""
    root = math.sqrt(1.0 - 0.25 / (q * q))
    return _exp(-math.pi * turns / q), 0.5 / (q * root), turns * root


def _poles_at(turns: float, trace: float, product: float) -> float:
    """|z**2 - trace z + product| at a frequency: what the poles take off there."""
    real = _cosine(2.0 * turns) - trace * _cosine(turns) + product
    imaginary = _sine(2.0 * turns) - trace * _sine(turns)
    return math.sqrt(real * real + imaginary * imaginary)


def _protection(actuator: Actuator, sample_rate: float) -> dict[int, float]:
    """The heat's leak and limit, such that the mean over the window never passes its own."""
    window = actuator.window_s * sample_rate
    memory = (MEMORY + 1.0 - actuator.number("drive.duty")) * actuator.window_s
    leak = one_pole(memory, sample_rate)
    limit = TOP * actuator.mean_square * window / (window + 1.0 / leak)
    knee = KNEE * limit
    # followed so fast that the loop doesn't swing: its gain is the hottest drive over the knee
    follow_s = 0.25 * memory / (1.0 + actuator.peak * actuator.peak / knee)
    return {
        layout.ACT_LEAK: leak,
        layout.ACT_LIMIT: limit,
        layout.ACT_KNEE: 1.0 / knee,
        layout.ACT_FOLLOW: one_pole(follow_s, sample_rate),
    }


def _weighting(actuator: Actuator, sample_rate: float) -> dict[int, float]:
    """The section that raises what the skin feels less; 1 at `SKIN_HZ`."""
    if not actuator.values["shaping.equal_sensation"]:
        return {layout.ACT_W0: 1.0}
    _check_rate(actuator, SKIN_HZ, sample_rate)
    turns = SKIN_HZ / sample_rate
    sine, cosine = _sine(turns), _cosine(turns)
    zeros, poles = 0.5 * sine * SKIN_WIDTH, 0.5 * sine * SKIN_WIDTH * SKIN_MOST
    scale = SKIN_MOST / (1.0 + poles)
    return {
        layout.ACT_W0: scale * (1.0 + zeros),
        layout.ACT_W1: scale * -2.0 * cosine,
        layout.ACT_W2: scale * (1.0 - zeros),
        layout.ACT_W_BACK_1: -2.0 * cosine / (1.0 + poles),
        layout.ACT_W_BACK_2: (1.0 - poles) / (1.0 + poles),
    }


def _check_rate(actuator: Actuator, frequency_hz: float, sample_rate: float) -> None:
    # written so that NaN fails
    if not frequency_hz / HIGHEST_PART < sample_rate < math.inf:
        raise InputError(
            f"actuator {actuator.name} needs a sample rate above "
            f"{frequency_hz / HIGHEST_PART:.0f} Hz, not {sample_rate:g}"
        )
