"""Friction clicks: a bank of modal resonators for each event kind, struck by the torque released.

An event's friction turns the speed of the arriving disk into torque; when the disk passes it, or
breaks loose from it after sticking there, that torque is released:

    torque = (the event's own friction) * (highest |omega1| of late, forgotten within 0.2 s)
    level  = c / (1 + c),   c = (torque / full)**p

Bristles and end stops let go of the same torque at any speed; a slip of the bristles is a strike
too, of the torque it lets go. A well takes the speed that the disk has at its bottom.

A mode is a damped rotation, z[n+1] = z[n] * r * exp(i w), heard as its imaginary part. A strike at
a fraction of a sample turns the new rotation by the time that is left of the sample, so an onset is
placed exactly and the sampled mode is that of continuous time:

    z += level * gain * exp((ln r + i w) * rest),    rest = samples from blow to next sample

Eight successive samples of a mode are kept, each turned by eight samples' rotation at a time, so
they don't wait for each other. Which of them is heard is the clock's matter: blocks change no bit.

One blow would start a sine in full, and its spectrum, falling by 12 dB an octave, would fold back.
A strike is a short contact instead: a raised cosine of four samples, given as eight blows half a
sample apart. That is a low-pass in continuous time with its null at half the sample rate; what
folds back stays below -60 dB. Modes above 0.49 of the sample rate are left out by the
coefficients. A kind rings for a counted number of samples (to -160 dB) and is then exactly zero.

Thread: audio.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.kernels.bristle import moving
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.elementary import cos_turns, exp, plain, power, sin_turns
from overview_dsp.kernels.lanes import load, store

BLOW_SPACING = 0.5  # samples
NEVER = 0x7FFFFFFFFFFFFFFF
LAST_SAMPLE = 9007199254740992.0  # 2**53: up to it a time has every sample


@point
def strike(m, w, slot, event, approach, speed, sample, fraction):
    """Log that an event is passed `fraction` of a sample after time `sample`.

    `approach` is the speed the disk came with, `speed` the one it has, rad/s.
    """
    counts = approach
    if w[slot + layout.SLOT_MODELS] > 0:
        kind = w[slot + layout.SLOT_KIND + event]
        how = w[slot + layout.BRISTLES + kind * layout.BRISTLE_PARAMETERS + layout.P_STRIKE]
        if how == layout.STRIKE_BY_TORQUE:
            counts = moving(approach)
        elif how == layout.STRIKE_BY_SPEED:
            counts = speed
    log_strike(m, w, event, m[slot + layout.SLOT_RELEASE + event] * counts, sample, fraction)


@point
def log_strike(m, w, event, torque, sample, fraction):
    """Log that a torque (N m) is let go at an event (-1 = the bare surface)."""
    hardness = torque * m[layout.C_STRIKE_TORQUE]
    level = 0.0
    if hardness > 1e-12:
        level = power(hardness, m[layout.C_STRIKE_EXPONENT])
        # harder strikes approach full level smoothly
        level = level / (1.0 + level)
    at = w[layout.M_STRIKES] % layout.STRIKE_LOG
    m[layout.LOG_TIME + at] = float(sample) + fraction
    w[layout.LOG_EVENT + at] = event
    m[layout.LOG_TORQUE + at] = torque
    m[layout.LOG_LEVEL + at] = level
    w[layout.M_STRIKES] += 1


_sin_turns = plain(sin_turns)
# part of a strike that is in each blow: sin(pi (number + 1/2)/8)**2 / 4; they add up to 1
BLOW_WEIGHT = np.array(
    [
        0.125 - 0.125 * _sin_turns((number + 0.5) * (1.0 / layout.CONTACT) + 0.25)
        for number in range(layout.CONTACT)
    ]
)


@point
def blow_factors(m, w, slot, first, modes, key, half, rest):
    """What a blow has given each mode when its sample ends; blows two apart share it.

    Sets the modes' rotation too.
    """
    if w[layout.BLOW_KEY + half] == key and m[layout.BLOW_REST + half] == rest:
        return
    w[layout.BLOW_KEY + half] = key
    m[layout.BLOW_REST + half] = rest
    at = half * layout.MAX_MODES
    for j in range(first, first + modes):
        mode = slot + layout.MODES + j * layout.MODE_SIZE
        turns = m[mode + layout.MODE_TURNS] * rest
        decay = exp(m[mode + layout.MODE_DECAY] * rest)
        m[layout.BLOW_RE + at] = decay * cos_turns(turns)
        m[layout.BLOW_IM + at] = decay * sin_turns(turns)
        ringing = layout.BANK + j * layout.BANK_SIZE
        m[ringing + layout.BANK_COS] = m[mode + layout.MODE_COS]
        m[ringing + layout.BANK_SIN] = m[mode + layout.MODE_SIN]
        at += 1


@point
def blow(m, w, at, number, rest, sample):
    """Give blow `number` of the strike at log entry `at` to its modes, before `sample` sounds.

    `rest` is how long before the end of that sample it fell, samples.
    """
    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    event = w[layout.LOG_EVENT + at]
    kind = w[slot + layout.SLOT_KIND + event] if event >= 0 else layout.MAX_KINDS
    modes = w[slot + layout.KIND_MODES + kind]
    if modes == 0:
        return
    if w[layout.BANK_LEFT + kind] == 0:
        w[layout.RINGING_KIND + w[layout.RINGING]] = kind
        w[layout.RINGING] += 1
    w[layout.BANK_LEFT + kind] = w[slot + layout.KIND_RING + kind]
    w[layout.BANK_MODES + kind] = modes
    level = m[layout.LOG_LEVEL + at] * BLOW_WEIGHT[number]
    first = kind * layout.MAX_MODES
    half = number % 2
    # of this strike on this surface; never 0, as columns are after a reset
    key = (w[layout.STRIKES_SOUNDED + number] + 1) * layout.SLOTS + w[layout.ACTIVE_SLOT]
    blow_factors(m, w, slot, first, modes, key, half, rest)
    at = half * layout.MAX_MODES
    clock = -sample & (layout.PHASES - 1)  # of the rotations, that which phase 0 gets
    for j in range(first, first + modes):
        mode = slot + layout.MODES + j * layout.MODE_SIZE
        amplitude = level * m[mode + layout.MODE_GAIN]
        re = amplitude * m[layout.BLOW_RE + at]
        im = amplitude * m[layout.BLOW_IM + at]
        ringing = layout.BANK + j * layout.BANK_SIZE
        c = load(m, mode + layout.MODE_RE + clock)
        s = load(m, mode + layout.MODE_IM + clock)
        at_re = ringing + layout.BANK_RE
        at_im = ringing + layout.BANK_IM
        store(m, at_re, load(m, at_re) + (re * c - im * s))
        store(m, at_im, load(m, at_im) + (re * s + im * c))
        at += 1


@point
def sound_strikes(m, w, sample):
    """Give every blow that falls before the end of `sample` to the modes.

    Returns the sample in which the next blow falls, of strikes not sounded in full; or NEVER.
    """
    due = NEVER
    for number in range(layout.CONTACT):
        while w[layout.STRIKES_SOUNDED + number] < w[layout.M_STRIKES]:
            at = w[layout.STRIKES_SOUNDED + number] & (layout.STRIKE_LOG - 1)
            time = m[layout.LOG_TIME + at] + float(number) * BLOW_SPACING
            rest = float(sample + 1) - time
            if rest < 0.0:
                # a blow at a sample's very end is in it
                later = int(time) if time < LAST_SAMPLE else NEVER
                due = min(due, later - 1 if float(later) == time else later)
                break
            blow(m, w, at, number, rest, sample)
            w[layout.STRIKES_SOUNDED + number] += 1
    return due
