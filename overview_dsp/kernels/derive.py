"""Derivation of the kernels' coefficients from parameters.

The memory block holds the parameters, too. An engine, page or plugin with a block can thus change
the sample rate or a parameter with the same bits. All exponentials and sines are
the kernels' own functions.

Thread: any, including audio, if no other thread changes parameters.
"""

from __future__ import annotations

import math

from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import load_acquire, store_release
from overview_dsp.kernels.clutch import OFF
from overview_dsp.kernels.compiling import entry_point, inlined, outlined
from overview_dsp.kernels.dc_block import CORNER_HZ
from overview_dsp.kernels.decibels import db_to_gain
from overview_dsp.kernels.math_functions import ROUND, exp, sin_turns

CARRIER_LIMIT = 0.45  # highest carrier frequency relative to the sample rate
MODE_LIMIT = 0.49  # modes above this part of the sample rate are omitted, as they would alias
RING_DB = 160.0  # decay after which a click is exactly zero
GLIDE_S = 0.02  # duration of parameter smoothing
FADE_S = 0.03  # duration of a crossfade between surfaces
APPROACH_S = 0.2  # memory of the arriving disk's speed, as long as it may stick
TEXTURE_LEVEL_S = 0.05  # time constant of the texture's level: many small contacts start gradually
PACE_S = 0.08  # time constant of the input's pace, after the input smoother
PACE_LEAST = 0.02  # timelines per second: slower inputs are at rest (3.6 degrees per second)
PACE_MOST = 6.0  # faster inputs are jumps
ARRIVAL_S = 2.5  # longest engagement of shaft 2 after a release
FOREVER = 1 << 40  # samples
LOG_1000 = 6.907755278982137  # of a fall by 60 dB
MILLIWATT = 1e-3
WHITE = 3.0  # 1 / the variance of white noise in -1 to 1
USUAL_RATE = 48_000.0  # Hz
LOWEST_RATE, HIGHEST_RATE = 1_000.0, 768_000.0  # Hz


@inlined
def one_pole(time_constant_s, sample_rate):
    """Return the coefficient a of y += a * (x - y) for a time constant."""
    return 1.0 - exp(-1.0 / (time_constant_s * sample_rate))


@outlined
def derive_into(f64, to):
    """Write all smoothed coefficients to the `COEFFS` columns from `to` on."""
    sample_rate = f64[layout.S_SAMPLE_RATE]
    dt = 1.0 / sample_rate
    inertia = f64[layout.PARAM_DISK_INERTIA]
    k1 = f64[layout.PARAM_DISK_K1]
    k2 = f64[layout.PARAM_DISK_K2]
    to_theta1 = math.pi / layout.CELLS * (k2 / (k1 + k2))
    f64[to + layout.C_SPRING_HELD] = (k1 + k2) / inertia * dt * dt
    f64[to + layout.C_SPRING_FREE] = k1 / inertia * dt * dt
    f64[to + layout.C_INERTIA] = inertia / dt
    f64[to + layout.C_THETA] = to_theta1
    f64[to + layout.C_OMEGA] = to_theta1 * sample_rate
    f64[to + layout.C_SMOOTH] = one_pole(f64[layout.PARAM_INPUT_SMOOTHING_MS] * 1e-3, sample_rate)
    f64[to + layout.C_TORQUE] = 1e3 / f64[layout.PARAM_TACTOR_REFERENCE_TORQUE_MNM]
    f64[to + layout.C_GATE] = db_to_gain(f64[layout.PARAM_TACTOR_THRESHOLD_DB])
    f64[to + layout.C_EXPONENT] = f64[layout.PARAM_TACTOR_COMPRESSION]
    f64[to + layout.C_DECAY] = one_pole(f64[layout.PARAM_TACTOR_DECAY_MS] * 1e-3, sample_rate)
    f64[to + layout.C_RISE] = one_pole(f64[layout.PARAM_TACTOR_RISE_MS] * 1e-3, sample_rate)
    f64[to + layout.C_CARRIER] = f64[layout.PARAM_TACTOR_FREQUENCY_HZ] * dt
    tactor = db_to_gain(f64[layout.PARAM_TACTOR_GAIN_DB])
    f64[to + layout.C_TACTOR_GAIN] = 0.0 if f64[layout.PARAM_TACTOR_MUTE] > 0.0 else tactor
    click = db_to_gain(f64[layout.PARAM_CLICK_GAIN_DB])
    f64[to + layout.C_CLICK_GAIN] = 0.0 if f64[layout.PARAM_CLICK_MUTE] > 0.0 else click
    f64[to + layout.C_STRIKE_TORQUE] = 1e3 / f64[layout.PARAM_CLICK_REFERENCE_TORQUE_MNM]
    f64[to + layout.C_STRIKE_EXPONENT] = f64[layout.PARAM_CLICK_COMPRESSION]
    # white noise spreads its power over half the sample rate; the texture's low-pass has a fixed
    # band
    noise_scale = math.sqrt(WHITE * sample_rate / USUAL_RATE) / math.sqrt(MILLIWATT)
    f64[to + layout.C_TEXTURE_GAIN] = db_to_gain(f64[layout.PARAM_TEXTURE_GAIN_DB]) * noise_scale
    brightness = f64[layout.PARAM_TEXTURE_BRIGHTNESS_HZ]
    f64[to + layout.C_TEXTURE_CUTOFF] = 2.0 * math.pi * brightness * dt
    f64[to + layout.C_CEILING] = db_to_gain(f64[layout.PARAM_OUTPUT_CEILING_DB])
    f64[to + layout.C_TEXTURE_LEVEL] = one_pole(TEXTURE_LEVEL_S, sample_rate)
    f64[to + layout.C_FORGET] = exp(-dt / APPROACH_S)
    ratio = f64[layout.PARAM_CLUTCH_MAX_SPEED_RATIO]
    f64[to + layout.C_SPEED_RATIO] = ratio if ratio > 0.0 else 1.0
    f64[to + layout.C_REACH] = 1.0 / ((k1 + k2) * dt) if ratio > 0.0 else OFF
    tap_s = f64[layout.PARAM_CLUTCH_TAP_DURATION_S]
    f64[to + layout.C_TAP_RATE] = dt / tap_s if tap_s > 0.0 else PACE_MOST * dt
    lag_s = f64[layout.PARAM_CLUTCH_TIME_CONSTANT_S]
    f64[to + layout.C_LAG_RATE] = dt / lag_s if lag_s > 0.0 else OFF
    windup = f64[layout.PARAM_CLUTCH_WINDUP_RATIO]
    f64[to + layout.C_WINDUP] = windup if windup > 0.0 and ratio > 0.0 else OFF
    speed = f64[layout.PARAM_CLUTCH_MAX_SPEED]
    f64[to + layout.C_MAX_SPEED] = speed * layout.CELLS * dt if speed > 0.0 else OFF
    backlash = f64[layout.PARAM_CLUTCH_BACKLASH_PERCENT] if ratio > 0.0 else 0.0
    f64[to + layout.C_BACKLASH] = backlash * 1e-2 * layout.CELLS
    f64[to + layout.C_PACE] = one_pole(PACE_S, sample_rate)
    f64[to + layout.C_PACE_LEAST] = PACE_LEAST * layout.CELLS * dt
    f64[to + layout.C_PACE_MOST] = PACE_MOST * layout.CELLS * dt
    f64[to + layout.C_SLOW_EXPONENT] = f64[layout.PARAM_TACTOR_SLOW_GAIN_EXPONENT]
    f64[to + layout.C_RECOIL_EXPONENT] = f64[layout.PARAM_TACTOR_RECOIL_GAIN_EXPONENT]
    f64[to + layout.C_DC_POLE] = exp(-2.0 * math.pi * CORNER_HZ * dt)


@inlined
def derive_mode(f64, mode, turns, decay, gain_db):
    """Write a mode's columns from its turns and the log of its decay per sample."""
    for n in range(layout.PHASES + 1):
        radius = exp(float(n) * decay)
        re = radius * sin_turns(float(n) * turns + 0.25)
        im = radius * sin_turns(float(n) * turns)
        if n < layout.PHASES:
            # stored twice, so that PHASES columns can be read from any phase
            f64[mode + layout.MODE_RE + n] = re
            f64[mode + layout.MODE_RE + layout.PHASES + n] = re
            f64[mode + layout.MODE_IM + n] = im
            f64[mode + layout.MODE_IM + layout.PHASES + n] = im
        else:
            f64[mode + layout.MODE_COS] = re
            f64[mode + layout.MODE_SIN] = im
    f64[mode + layout.MODE_TURNS] = turns
    f64[mode + layout.MODE_DECAY] = decay
    f64[mode + layout.MODE_GAIN] = db_to_gain(gain_db)


@inlined
def ceil_to_int(x):
    """Return x >= 0 rounded up, at most `FOREVER`; `FOREVER` for NaN."""
    if not x < FOREVER:
        return FOREVER
    whole = int(x)
    return whole + 1 if float(whole) < x else whole


@entry_point
def derive_clicks(f64, i64, slot):
    """Derive the modes of a surface's kinds from their clicks.

    Parameters
    ----------
    f64, i64 : float64, int64 [layout.SURFACES + layout.SLOT_SIZE or more]
        The memory block, seen two ways.
    slot : int64
        First column of the surface.
    """
    sample_rate = f64[layout.S_SAMPLE_RATE]
    for kind in range(layout.BANKS):
        audible = 0
        longest = 0
        for number in range(i64[slot + layout.KIND_CLICK + kind]):
            click = kind * layout.MAX_MODES + number
            source = slot + layout.CLICKS + click * layout.CLICK_SIZE
            turns = f64[source + layout.CLICK_FREQUENCY_HZ] / sample_rate
            if not 0.0 < turns <= MODE_LIMIT:
                continue
            decay_ms = f64[source + layout.CLICK_DECAY_MS]
            decay = -LOG_1000 / (decay_ms * 1e-3 * sample_rate)
            mode = kind * layout.MAX_MODES + audible
            mode = slot + layout.MODES + mode * layout.MODE_SIZE
            derive_mode(f64, mode, turns, decay, f64[source + layout.CLICK_GAIN_DB])
            longest = max(longest, ceil_to_int(RING_DB / 60.0 * decay_ms * 1e-3 * sample_rate))
            audible += 1
        i64[slot + layout.KIND_MODES + kind] = audible
        i64[slot + layout.KIND_RING + kind] = longest


@entry_point
def derive(f64, i64):
    """Derive the coefficients from parameters and sample rate, without smoothing.

    Parameters
    ----------
    f64, i64 : float64, int64 [layout.SET_UP or more]
        The memory block, seen two ways.
    """
    derive_into(f64, layout.COEFF)
    for i in range(layout.COEFFS):
        f64[layout.ASKED + i] = f64[layout.COEFF + i]
        i64[layout.GLIDE_LEFT + i] = 0
    i64[layout.S_GLIDE] = int(GLIDE_S * f64[layout.S_SAMPLE_RATE] + ROUND - ROUND)
    i64[layout.S_FADE] = int(FADE_S * f64[layout.S_SAMPLE_RATE] + ROUND - ROUND)
    i64[layout.S_ARRIVAL] = int(ARRIVAL_S * f64[layout.S_SAMPLE_RATE] + ROUND - ROUND)
    i64[layout.S_RELEASE_RETURNS] = int(f64[layout.PARAM_DISK_RELEASE])
    i64[layout.ASKED_RETURNS] = i64[layout.S_RELEASE_RETURNS]


@inlined
def derive_at(f64, i64, sample_rate):
    """Derive everything that depends on the sample rate (Hz); return whether the rate is valid.

    Call `reset` afterwards.
    """
    carrier = f64[layout.PARAM_TACTOR_FREQUENCY_HZ]
    # written so that NaN fails
    if not (LOWEST_RATE <= sample_rate <= HIGHEST_RATE and carrier < CARRIER_LIMIT * sample_rate):
        return False
    f64[layout.S_SAMPLE_RATE] = sample_rate
    derive(f64, i64)
    for number in range(layout.SLOTS):
        derive_clicks(f64, i64, layout.SURFACES + number * layout.SLOT_SIZE)
    return True


@inlined
def push_change(f64, i64, at, stamp, what, value):
    """Write a parameter event as entry `at` of the host's ring without publishing it."""
    at = at % layout.HOST_RING
    i64[layout.HOST_TIME + at] = stamp
    i64[layout.HOST_WHAT + at] = what
    f64[layout.HOST_VALUE + at] = value


@entry_point
def push_parameters(f64, i64, stamp):
    """Push the changed coefficients of the parameters; return whether the ring had space.

    If not, the next call pushes them.

    Parameters
    ----------
    f64, i64 : float64, int64 [layout.TOTAL]
        The memory block, seen two ways.
    stamp : int64
        Time in samples since reset; -1 is as soon as possible.

    Thread: that which changes parameters.
    """
    derive_into(f64, layout.DERIVED)
    written = i64[layout.HOST_WRITTEN]
    waiting = written - load_acquire(i64, layout.HOST_READ)
    if waiting + layout.COEFFS + 1 > layout.HOST_RING:
        return False
    at = written
    for i in range(layout.COEFFS):
        if f64[layout.DERIVED + i] != f64[layout.ASKED + i]:
            f64[layout.ASKED + i] = f64[layout.DERIVED + i]
            push_change(f64, i64, at, stamp, i, f64[layout.DERIVED + i])
            at += 1
    returns = int(f64[layout.PARAM_DISK_RELEASE])
    if returns != i64[layout.ASKED_RETURNS]:
        i64[layout.ASKED_RETURNS] = returns
        push_change(f64, i64, at, stamp, layout.COMMAND_RELEASE_RETURNS, float(returns))
        at += 1
    store_release(i64, layout.HOST_WRITTEN, at)
    return True


@inlined
def set_parameter(f64, i64, number, value, stamp):
    """Set parameter `number` from a sample on (-1: as soon as possible).

    Return False if the number or the value is invalid, or if the ring is full. In the last case the
    next successful call sets it.
    """
    if number < 0 or number >= layout.PARAMETERS or value - value != 0.0:
        return False
    at = layout.PARAMS + number
    carrier = value if at == layout.PARAM_TACTOR_FREQUENCY_HZ else 0.0
    if not carrier < CARRIER_LIMIT * f64[layout.S_SAMPLE_RATE]:
        return False
    f64[at] = value
    return push_parameters(f64, i64, stamp)
