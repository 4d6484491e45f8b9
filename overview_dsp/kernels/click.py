"""Friction clicks: a bank of modal resonators per event kind, excited by released torque.

An event's friction turns the speed of the arriving disk into torque. This torque is released when
the disk passes the event or breaks loose from it:

    torque = (the event's friction) * (highest recent |omega1|, decaying within 0.2 s)
    level  = c / (1 + c),   c = (torque / full)**p

Bristles and end stops release the same torque at any speed. A slip of bristles is also a strike,
by the torque it releases. A detent uses the speed of the disk at its bottom.

A mode is a damped rotation, z[n+1] = z[n] * r * exp(i w); its imaginary part is the output. A
strike at a fraction of a sample rotates the new state by the rest of the sample. Onsets are thus
exact, and the sampled mode equals that of continuous time:

    z += level * gain * exp((ln r + i w) * rest),    rest = samples from pulse to next sample

Eight successive samples of a mode are stored, and each is rotated by eight samples at a time. They
are independent of each other. The clock selects the output, so blocks change no bit.

A single pulse would start a sine abruptly, and its spectrum of -12 dB per octave would alias.
A strike is therefore a short contact: a raised cosine of four samples, made of eight pulses half a
sample apart. This is a low-pass in continuous time with its null at half the sample rate, and
aliases stay below -60 dB. Modes above 0.49 of the sample rate are omitted by the
coefficients. A kind rings for a counted number of samples (to -160 dB) and is then exactly zero.

Thread: audio.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import store_release
from overview_dsp.kernels.bristle import moving
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.math_functions import cos_turns, exp, plain, power, sin_turns
from overview_dsp.kernels.simd.vector import load, store

PULSE_SPACING = 0.5  # samples
NEVER = 0x7FFFFFFFFFFFFFFF
LAST_SAMPLE = 9007199254740992.0  # 2**53: up to it a time has every sample


@inlined
def strike(f64, i64, slot, event, approach, speed, sample, fraction):
    """Log the strike of an event that is passed `fraction` of a sample after `sample`.

    `approach` is the highest recent speed of the disk, `speed` the present one, rad/s.
    """
    counts = approach
    if i64[slot + layout.SLOT_MODELS] > 0:
        kind = i64[slot + layout.SLOT_KIND + event]
        how = i64[slot + layout.BRISTLES + kind * layout.BRISTLE_PARAMETERS + layout.P_STRIKE]
        if how == layout.STRIKE_BY_TORQUE:
            counts = moving(approach)
        elif how == layout.STRIKE_BY_SPEED:
            counts = speed
    log_strike(f64, i64, event, f64[slot + layout.SLOT_RELEASE + event] * counts, sample, fraction)


@inlined
def log_strike(f64, i64, event, torque, sample, fraction):
    """Log the release of a torque (N m) at an event (-1 = the base surface)."""
    hardness = torque * f64[layout.C_STRIKE_TORQUE]
    level = 0.0
    if hardness > 1e-12:
        level = power(hardness, f64[layout.C_STRIKE_EXPONENT])
        # harder strikes approach full level smoothly
        level = level / (1.0 + level)
    at = i64[layout.M_STRIKES] % layout.STRIKE_LOG
    f64[layout.LOG_TIME + at] = float(sample) + fraction
    i64[layout.LOG_EVENT + at] = event
    f64[layout.LOG_TORQUE + at] = torque
    f64[layout.LOG_LEVEL + at] = level
    store_release(i64, layout.M_STRIKES, i64[layout.M_STRIKES] + 1)


_sin_turns = plain(sin_turns)
# weight of each pulse of a strike: sin(pi (number + 1/2)/8)**2 / 4; their sum is 1
PULSE_WEIGHT = np.array(
    [
        0.125 - 0.125 * _sin_turns((number + 0.5) * (1.0 / layout.CONTACT) + 0.25)
        for number in range(layout.CONTACT)
    ]
)


@inlined
def pulse_factors(f64, i64, slot, first, modes, key, half, rest):
    """Compute the state of each mode at the end of the sample of a pulse of unit weight.

    Every second pulse of a strike has the same state. Also sets the rotation of the modes.
    """
    if i64[layout.PULSE_KEY + half] == key and f64[layout.PULSE_REST + half] == rest:
        return
    i64[layout.PULSE_KEY + half] = key
    f64[layout.PULSE_REST + half] = rest
    at = half * layout.MAX_MODES
    for j in range(first, first + modes):
        mode = slot + layout.MODES + j * layout.MODE_SIZE
        turns = f64[mode + layout.MODE_TURNS] * rest
        decay = exp(f64[mode + layout.MODE_DECAY] * rest)
        f64[layout.PULSE_RE + at] = decay * cos_turns(turns)
        f64[layout.PULSE_IM + at] = decay * sin_turns(turns)
        ringing = layout.BANK + j * layout.BANK_SIZE
        f64[ringing + layout.BANK_COS] = f64[mode + layout.MODE_COS]
        f64[ringing + layout.BANK_SIN] = f64[mode + layout.MODE_SIN]
        at += 1


@inlined
def pulse(f64, i64, at, number, rest, sample):
    """Add pulse `number` of the strike at log entry `at` to its modes, before `sample`.

    `rest` is the time from the pulse to the end of that sample, samples.
    """
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    event = i64[layout.LOG_EVENT + at]
    kind = i64[slot + layout.SLOT_KIND + event] if event >= 0 else layout.MAX_KINDS
    modes = i64[slot + layout.KIND_MODES + kind]
    if modes == 0:
        return
    if i64[layout.BANK_LEFT + kind] == 0:
        i64[layout.RINGING_KIND + i64[layout.RINGING]] = kind
        i64[layout.RINGING] += 1
    i64[layout.BANK_LEFT + kind] = i64[slot + layout.KIND_RING + kind]
    i64[layout.BANK_MODES + kind] = modes
    level = f64[layout.LOG_LEVEL + at] * PULSE_WEIGHT[number]
    first = kind * layout.MAX_MODES
    half = number % 2
    # identifies this strike on this surface; never 0, the value after a reset
    key = (i64[layout.STRIKES_SOUNDED + number] + 1) * layout.SLOTS + i64[layout.ACTIVE_SLOT]
    pulse_factors(f64, i64, slot, first, modes, key, half, rest)
    at = half * layout.MAX_MODES
    clock = -sample & (layout.PHASES - 1)  # rotation of phase 0
    for j in range(first, first + modes):
        mode = slot + layout.MODES + j * layout.MODE_SIZE
        amplitude = level * f64[mode + layout.MODE_GAIN]
        re = amplitude * f64[layout.PULSE_RE + at]
        im = amplitude * f64[layout.PULSE_IM + at]
        ringing = layout.BANK + j * layout.BANK_SIZE
        c = load(f64, mode + layout.MODE_RE + clock)
        s = load(f64, mode + layout.MODE_IM + clock)
        at_re = ringing + layout.BANK_RE
        at_im = ringing + layout.BANK_IM
        store(f64, at_re, load(f64, at_re) + (re * c - im * s))
        store(f64, at_im, load(f64, at_im) + (re * s + im * c))
        at += 1


@inlined
def sound_strikes(f64, i64, sample):
    """Add every pulse before the end of `sample` to the modes.

    Returns the sample of the next pulse of unfinished strikes, or NEVER.
    """
    due = NEVER
    for number in range(layout.CONTACT):
        while i64[layout.STRIKES_SOUNDED + number] < i64[layout.M_STRIKES]:
            at = i64[layout.STRIKES_SOUNDED + number] & (layout.STRIKE_LOG - 1)
            time = f64[layout.LOG_TIME + at] + float(number) * PULSE_SPACING
            rest = float(sample + 1) - time
            if rest < 0.0:
                # a pulse exactly at a sample's end belongs to it
                later = int(time) if time < LAST_SAMPLE else NEVER
                due = min(due, later - 1 if float(later) == time else later)
                break
            pulse(f64, i64, at, number, rest, sample)
            i64[layout.STRIKES_SOUNDED + number] += 1
    return due
