"""What rings: the modes of every kind that was struck, for one chunk at a time.

Between two blows, and until a kind falls silent, nothing changes but the modes' own rotation: then
each is turned through the whole run with its state at hand. Sums are taken in the order of the
kinds and their modes, as sample after sample would.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import sound_strikes
from overview_dsp.kernels.compiling import NOT_NEGATIVE, point
from overview_dsp.kernels.lanes import load, store

LAST = layout.PHASES - 1


@point
def turn(m, j, phase):
    """A mode's sample at one phase of the clock, and that phase turned to its next."""
    mode = (layout.BANK + j * layout.BANK_SIZE) & NOT_NEGATIVE
    at = mode + phase
    re = m[at + layout.BANK_RE]
    im = m[at + layout.BANK_IM]
    c = m[mode + layout.BANK_COS]
    s = m[mode + layout.BANK_SIN]
    m[at + layout.BANK_RE] = c * re - s * im
    m[at + layout.BANK_IM] = s * re + c * im
    return im


@point
def ring_once(m, w, sample):
    """One sample of everything that rings; what falls silent in it is put away."""
    total = 0.0
    i = 0
    while i < w[layout.RINGING]:
        kind = w[layout.RINGING_KIND + i]
        first = kind * layout.MAX_MODES
        for j in range(first, first + w[layout.BANK_MODES + kind]):
            total += turn(m, j, sample & LAST)
        w[layout.BANK_LEFT + kind] -= 1
        if w[layout.BANK_LEFT + kind] == 0:
            start = layout.BANK + first * layout.BANK_SIZE
            for at in range(start, start + layout.MAX_MODES * layout.BANK_SIZE):
                m[at] = 0.0
            w[layout.RINGING] -= 1
            w[layout.RINGING_KIND + i] = w[layout.RINGING_KIND + w[layout.RINGING]]
        else:
            i += 1
    return total


@point
def turn_alone(m, j, clock, start, stop):
    """Add a mode to a few samples of the D_RING column, one after another."""
    for n in range(start, stop):
        m[layout.D_RING + n] += turn(m, j, (clock + n) & LAST)


@point
def ring_mode(m, j, clock, start, stop):
    """Add a mode to samples `start` to `stop` of the D_RING column; sample 0 is at `clock`."""
    whole = start + (-(clock + start) & LAST)
    rest = whole + (max(stop - whole, 0) & ~LAST)
    turn_alone(m, j, clock, start, min(whole, stop))
    mode = (layout.BANK + j * layout.BANK_SIZE) & NOT_NEGATIVE
    c = m[mode + layout.BANK_COS]
    s = m[mode + layout.BANK_SIN]
    re = load(m, mode + layout.BANK_RE)
    im = load(m, mode + layout.BANK_IM)
    for n in range(whole, rest, layout.PHASES):
        store(m, layout.D_RING + n, load(m, layout.D_RING + n) + im)
        re, im = c * re - s * im, s * re + c * im
    store(m, mode + layout.BANK_RE, re)
    store(m, mode + layout.BANK_IM, im)
    turn_alone(m, j, clock, max(rest, start), stop)


@point
def ring_on(m, w, start, stop):
    """Samples `start` to `stop` of the D_RING column, in which nothing falls silent."""
    for n in range(start, stop):
        m[layout.D_RING + n] = 0.0
    for i in range(w[layout.RINGING]):
        kind = w[layout.RINGING_KIND + i]
        w[layout.BANK_LEFT + kind] -= stop - start
        first = kind * layout.MAX_MODES
        for j in range(first, first + w[layout.BANK_MODES + kind]):
            ring_mode(m, j, w[layout.CLOCK], start, stop)


@point
def ring(m, w, frames):
    """Fill the D_RING column of one chunk: in runs, between blows and kinds that fall silent."""
    clock = w[layout.CLOCK]
    n = 0
    while n < frames:
        stop = frames
        if w[layout.STRIKES_SOUNDED + layout.CONTACT - 1] < w[layout.M_STRIKES]:
            stop = min(stop, sound_strikes(m, w, clock + n) - clock)
        for i in range(w[layout.RINGING]):
            silent_in = w[layout.BANK_LEFT + w[layout.RINGING_KIND + i]]
            stop = min(stop, n + silent_in - 1)
        if stop > n + 1:
            ring_on(m, w, n, stop)
            n = stop
        else:
            m[layout.D_RING + n] = ring_once(m, w, clock + n)
            n += 1
