"""Derivation of an actuator's coefficients from its profile.

Thread: any, including audio, if no other thread changes the actuator.
"""

from __future__ import annotations

from math import pi, sqrt

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import entry_point, inlined
from overview_dsp.kernels.decibels import db_to_gain
from overview_dsp.kernels.derive import one_pole
from overview_dsp.kernels.limiter import TOP
from overview_dsp.kernels.math_functions import cos_turns, exp, sin_turns

LEAST_HEADROOM = 1e-6  # from the nominal drive to the peak, where they are the same
# time constant of the heat relative to the window at a duty of 1; longer by up to a window at lower
# duties. A longer one allows longer bursts but less continuous drive
MEMORY = 1.0 / 8.0
TAKEN_BACK = 0.25  # range of heat below the limit in which the drive is reduced, relative to it
# the weighting: a second-order cut of up to 24 dB, 1 at the highest sensitivity; fitted to
# `skin.pacinian_db` (within 3.5 dB from 50 to 800 Hz)
SKIN_HZ = 247.0
SKIN_WIDTH = 0.62
SKIN_MOST = 16.0


@inlined
def decay_of(turns, q):
    """Return a resonance's decay per sample, damping ratio, and turns per sample."""
    root = sqrt(1.0 - 0.25 / (q * q))
    return exp(-pi * turns / q), 0.5 / (q * root), turns * root


@inlined
def poles_at(turns, trace, product):
    """Return |z**2 - trace z + product| at a frequency, the attenuation of the poles."""
    real = cos_turns(2.0 * turns) - trace * cos_turns(turns) + product
    imaginary = sin_turns(2.0 * turns) - trace * sin_turns(turns)
    return sqrt(real * real + imaginary * imaginary)


@inlined
def derive_overdrive(f64, at, sample_rate):
    """Derive the mass's matrix and the feedback that moves its poles to those of a lower Q."""
    turns = f64[at + layout.GIVEN_RESONANCE_HZ] / sample_rate
    q = f64[at + layout.GIVEN_Q]
    target_q = f64[at + layout.GIVEN_OVERDRIVE_Q]
    fall, slant, swing = decay_of(turns, q)
    sine = sin_turns(swing)
    cosine = cos_turns(swing)
    a11 = fall * (cosine + slant * sine)
    a12 = fall * sine * sqrt(1.0 + slant * slant)
    a21 = -a12
    a22 = fall * (cosine - slant * sine)
    b1 = 1.0 - a11
    b2 = -a21
    f64[at + layout.ACT_A11] = a11
    f64[at + layout.ACT_A12] = a12
    f64[at + layout.ACT_A21] = a21
    f64[at + layout.ACT_A22] = a22
    f64[at + layout.ACT_B1] = b1
    f64[at + layout.ACT_B2] = b2
    f64[at + layout.ACT_FORWARD] = 1.0
    f64[at + layout.ACT_FROM_POSITION] = 0.0
    f64[at + layout.ACT_FROM_SPEED] = 0.0
    if target_q >= q:
        return
    trace = a11 + a22
    product = fall * fall
    new_fall, _, new_swing = decay_of(turns, target_q)
    new_trace = 2.0 * new_fall * cos_turns(new_swing)
    new_product = new_fall * new_fall
    # trace(A - b k) and det(A - b k) for the new poles: two linear equations
    c1 = a22 * b1 - a12 * b2
    c2 = a11 * b2 - a21 * b1
    r1 = trace - new_trace
    r2 = product - new_product
    size = b1 * c2 - b2 * c1
    f64[at + layout.ACT_FROM_POSITION] = (r1 * c2 - r2 * b2) / size
    f64[at + layout.ACT_FROM_SPEED] = (b1 * r2 - c1 * r1) / size
    forward = poles_at(turns, new_trace, new_product) / poles_at(turns, trace, product)
    f64[at + layout.ACT_FORWARD] = forward


@inlined
def derive_protection(f64, at, sample_rate):
    """Derive leak and limit of the heat, such that the mean over the window is below its limit."""
    window_s = f64[at + layout.GIVEN_WINDOW_S]
    peak = f64[at + layout.GIVEN_PEAK]
    window = window_s * sample_rate
    memory = (MEMORY + 1.0 - f64[at + layout.GIVEN_DUTY]) * window_s
    leak = one_pole(memory, sample_rate)
    limit = TOP * f64[at + layout.GIVEN_MEAN_SQUARE] * window / (window + 1.0 / leak)
    knee = TAKEN_BACK * limit
    # fast enough to keep the loop stable: its gain is the highest drive over the knee
    follow_s = 0.25 * memory / (1.0 + peak * peak / knee)
    f64[at + layout.ACT_LEAK] = leak
    f64[at + layout.ACT_LIMIT] = limit
    f64[at + layout.ACT_KNEE] = 1.0 / knee
    f64[at + layout.ACT_FOLLOW] = one_pole(follow_s, sample_rate)


@inlined
def derive_weighting(f64, at, sample_rate):
    """Derive the perceptual weighting, which is 1 at `SKIN_HZ`."""
    f64[at + layout.ACT_W0] = 1.0
    for column in range(layout.ACT_W1, layout.ACT_W_BACK_2 + 1):
        f64[at + column] = 0.0
    if f64[at + layout.GIVEN_PERCEPTUAL_WEIGHTING] == 0.0:
        return
    turns = SKIN_HZ / sample_rate
    sine = sin_turns(turns)
    cosine = cos_turns(turns)
    zeros = 0.5 * sine * SKIN_WIDTH
    poles = 0.5 * sine * SKIN_WIDTH * SKIN_MOST
    scale = SKIN_MOST / (1.0 + poles)
    f64[at + layout.ACT_W0] = scale * (1.0 + zeros)
    f64[at + layout.ACT_W1] = scale * -2.0 * cosine
    f64[at + layout.ACT_W2] = scale * (1.0 - zeros)
    f64[at + layout.ACT_W_BACK_1] = -2.0 * cosine / (1.0 + poles)
    f64[at + layout.ACT_W_BACK_2] = (1.0 - poles) / (1.0 + poles)


@entry_point
def derive_actuator(f64, at, sample_rate):
    """Derive an actuator's coefficients from its profile's columns and keep its state.

    Parameters
    ----------
    f64 : float64 [at + layout.ACT_SIZE or more]
        Memory.
    at : int64
        First column of the actuator.
    sample_rate : float64
        Hz.
    """
    nominal = f64[at + layout.GIVEN_NOMINAL]
    peak = f64[at + layout.GIVEN_PEAK]
    f64[at + layout.ACT_NOMINAL] = nominal * db_to_gain(f64[at + layout.GIVEN_GAIN_DB])
    f64[at + layout.ACT_BEND] = TOP * nominal
    f64[at + layout.ACT_PEAK] = TOP * peak
    f64[at + layout.ACT_ROOM] = max(LEAST_HEADROOM, TOP * (peak - nominal))
    derive_overdrive(f64, at, sample_rate)
    derive_protection(f64, at, sample_rate)
    derive_weighting(f64, at, sample_rate)
