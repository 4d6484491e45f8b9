"""Modal bank: ringing modes of all struck kinds, one chunk at a time.

Between two pulses, and until a kind becomes silent, only the modes' rotation changes. Each mode
then rotates through the whole run at once. Sums are in the order of the
kinds and their modes, as for single samples.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import sound_strikes
from overview_dsp.kernels.compiling import NOT_NEGATIVE, inlined
from overview_dsp.kernels.simd.vector import load, store

LAST = layout.PHASES - 1


@inlined
def turn(f64, j, phase):
    """Return a mode's sample at a phase of the clock, and rotate that phase."""
    mode = (layout.BANK + j * layout.BANK_SIZE) & NOT_NEGATIVE
    at = mode + phase
    re = f64[at + layout.BANK_RE]
    im = f64[at + layout.BANK_IM]
    c = f64[mode + layout.BANK_COS]
    s = f64[mode + layout.BANK_SIN]
    f64[at + layout.BANK_RE] = c * re - s * im
    f64[at + layout.BANK_IM] = s * re + c * im
    return im


@inlined
def ring_once(f64, i64, sample):
    """Return one sample of all ringing kinds; remove kinds that become silent."""
    total = 0.0
    i = 0
    while i < i64[layout.RINGING]:
        kind = i64[layout.RINGING_KIND + i]
        first = kind * layout.MAX_MODES
        for j in range(first, first + i64[layout.BANK_MODES + kind]):
            total += turn(f64, j, sample & LAST)
        i64[layout.BANK_LEFT + kind] -= 1
        if i64[layout.BANK_LEFT + kind] == 0:
            start = layout.BANK + first * layout.BANK_SIZE
            for at in range(start, start + layout.MAX_MODES * layout.BANK_SIZE):
                f64[at] = 0.0
            i64[layout.RINGING] -= 1
            i64[layout.RINGING_KIND + i] = i64[layout.RINGING_KIND + i64[layout.RINGING]]
        else:
            i += 1
    return total


@inlined
def turn_alone(f64, j, clock, start, stop):
    """Add a mode to samples of the D_RING column, one by one."""
    for n in range(start, stop):
        f64[layout.D_RING + n] += turn(f64, j, (clock + n) & LAST)


@inlined
def ring_mode(f64, j, clock, start, stop):
    """Add a mode to samples `start` to `stop` of the D_RING column; sample 0 is at `clock`."""
    whole = start + (-(clock + start) & LAST)
    rest = whole + (max(stop - whole, 0) & ~LAST)
    turn_alone(f64, j, clock, start, min(whole, stop))
    mode = (layout.BANK + j * layout.BANK_SIZE) & NOT_NEGATIVE
    c = f64[mode + layout.BANK_COS]
    s = f64[mode + layout.BANK_SIN]
    re = load(f64, mode + layout.BANK_RE)
    im = load(f64, mode + layout.BANK_IM)
    for n in range(whole, rest, layout.PHASES):
        store(f64, layout.D_RING + n, load(f64, layout.D_RING + n) + im)
        re, im = c * re - s * im, s * re + c * im
    store(f64, mode + layout.BANK_RE, re)
    store(f64, mode + layout.BANK_IM, im)
    turn_alone(f64, j, clock, max(rest, start), stop)


@inlined
def ring_on(f64, i64, start, stop):
    """Fill samples `start` to `stop` of D_RING, in which no kind becomes silent."""
    for n in range(start, stop):
        f64[layout.D_RING + n] = 0.0
    for i in range(i64[layout.RINGING]):
        kind = i64[layout.RINGING_KIND + i]
        i64[layout.BANK_LEFT + kind] -= stop - start
        first = kind * layout.MAX_MODES
        for j in range(first, first + i64[layout.BANK_MODES + kind]):
            ring_mode(f64, j, i64[layout.CLOCK], start, stop)


@inlined
def ring(f64, i64, frames):
    """Fill the D_RING column of a chunk in runs between pulses and ends of kinds."""
    clock = i64[layout.CLOCK]
    n = 0
    while n < frames:
        stop = frames
        if i64[layout.STRIKES_SOUNDED + layout.CONTACT - 1] < i64[layout.M_STRIKES]:
            stop = min(stop, sound_strikes(f64, i64, clock + n) - clock)
        for i in range(i64[layout.RINGING]):
            silent_in = i64[layout.BANK_LEFT + i64[layout.RINGING_KIND + i]]
            stop = min(stop, n + silent_in - 1)
        if stop > n + 1:
            ring_on(f64, i64, n, stop)
            n = stop
        else:
            f64[layout.D_RING + n] = ring_once(f64, i64, clock + n)
            n += 1
