"""What rings: the modes of every kind that was struck, for one chunk at a time.

Between two blows, and until a kind falls silent, nothing changes but the modes' own rotation: then
each is turned through the whole run with its state at hand. Sums are taken in the order of the
kinds and their modes, as sample after sample would.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import next_blow, sound_strikes
from overview_dsp.kernels.compiling import point


@point
def ring_once(m, w):
    """One sample of everything that rings; what falls silent in it is put away."""
    total = 0.0
    i = 0
    while i < w[layout.RINGING]:
        kind = w[layout.RINGING_KIND + i]
        first = kind * layout.MAX_MODES
        last = first + w[layout.BANK_MODES + kind]
        for j in range(first, last):
            re = m[layout.BANK_RE + j]
            im = m[layout.BANK_IM + j]
            total += im
            c = m[layout.BANK_COS + j]
            s = m[layout.BANK_SIN + j]
            m[layout.BANK_RE + j] = c * re - s * im
            m[layout.BANK_IM + j] = s * re + c * im
        w[layout.BANK_LEFT + kind] -= 1
        if w[layout.BANK_LEFT + kind] == 0:
            for j in range(first, first + layout.MAX_MODES):
                m[layout.BANK_RE + j] = 0.0
                m[layout.BANK_IM + j] = 0.0
            w[layout.RINGING] -= 1
            w[layout.RINGING_KIND + i] = w[layout.RINGING_KIND + w[layout.RINGING]]
        else:
            i += 1
    return total


@point
def ring_mode(m, j, start, stop):
    """Add a mode to samples `start` to `stop` of the D_RING column."""
    re = m[layout.BANK_RE + j]
    im = m[layout.BANK_IM + j]
    c = m[layout.BANK_COS + j]
    s = m[layout.BANK_SIN + j]
    for n in range(start, stop):
        m[layout.D_RING + n] += im
        re, im = c * re - s * im, s * re + c * im
    m[layout.BANK_RE + j] = re
    m[layout.BANK_IM + j] = im


@point
def ring_two_modes(m, j, start, stop):
    """Add modes j and j + 1, as `ring_mode` would one after the other; their chains overlap."""
    re = m[layout.BANK_RE + j]
    im = m[layout.BANK_IM + j]
    c = m[layout.BANK_COS + j]
    s = m[layout.BANK_SIN + j]
    re2 = m[layout.BANK_RE + j + 1]
    im2 = m[layout.BANK_IM + j + 1]
    c2 = m[layout.BANK_COS + j + 1]
    s2 = m[layout.BANK_SIN + j + 1]
    for n in range(start, stop):
        m[layout.D_RING + n] = (m[layout.D_RING + n] + im) + im2
        re, im = c * re - s * im, s * re + c * im
        re2, im2 = c2 * re2 - s2 * im2, s2 * re2 + c2 * im2
    m[layout.BANK_RE + j] = re
    m[layout.BANK_IM + j] = im
    m[layout.BANK_RE + j + 1] = re2
    m[layout.BANK_IM + j + 1] = im2


@point
def ring_three_modes(m, j, start, stop):
    """Add modes j, j + 1 and j + 2, as `ring_two_modes`."""
    re = m[layout.BANK_RE + j]
    im = m[layout.BANK_IM + j]
    c = m[layout.BANK_COS + j]
    s = m[layout.BANK_SIN + j]
    re2 = m[layout.BANK_RE + j + 1]
    im2 = m[layout.BANK_IM + j + 1]
    c2 = m[layout.BANK_COS + j + 1]
    s2 = m[layout.BANK_SIN + j + 1]
    re3 = m[layout.BANK_RE + j + 2]
    im3 = m[layout.BANK_IM + j + 2]
    c3 = m[layout.BANK_COS + j + 2]
    s3 = m[layout.BANK_SIN + j + 2]
    for n in range(start, stop):
        m[layout.D_RING + n] = ((m[layout.D_RING + n] + im) + im2) + im3
        re, im = c * re - s * im, s * re + c * im
        re2, im2 = c2 * re2 - s2 * im2, s2 * re2 + c2 * im2
        re3, im3 = c3 * re3 - s3 * im3, s3 * re3 + c3 * im3
    m[layout.BANK_RE + j] = re
    m[layout.BANK_IM + j] = im
    m[layout.BANK_RE + j + 1] = re2
    m[layout.BANK_IM + j + 1] = im2
    m[layout.BANK_RE + j + 2] = re3
    m[layout.BANK_IM + j + 2] = im3


@point
def ring_on(m, w, start, stop):
    """Samples `start` to `stop` of the D_RING column, in which nothing falls silent."""
    for n in range(start, stop):
        m[layout.D_RING + n] = 0.0
    for i in range(w[layout.RINGING]):
        kind = w[layout.RINGING_KIND + i]
        w[layout.BANK_LEFT + kind] -= stop - start
        j = kind * layout.MAX_MODES
        last = j + w[layout.BANK_MODES + kind]
        while j + 2 < last:
            ring_three_modes(m, j, start, stop)
            j += 3
        if j + 1 < last:
            ring_two_modes(m, j, start, stop)
        elif j < last:
            ring_mode(m, j, start, stop)


@point
def ring(m, w, frames):
    """Fill the D_RING column of one chunk: in runs, between blows and kinds that fall silent."""
    clock = w[layout.CLOCK]
    n = 0
    while n < frames:
        stop = frames
        if w[layout.STRIKES_SOUNDED + layout.CONTACT - 1] < w[layout.M_STRIKES]:
            sound_strikes(m, w, clock + n)
            stop = min(stop, next_blow(m, w) - clock)
        for i in range(w[layout.RINGING]):
            silent_in = w[layout.BANK_LEFT + w[layout.RINGING_KIND + i]]
            stop = min(stop, n + silent_in - 1)
        if stop > n:
            ring_on(m, w, n, stop)
            n = stop
        else:
            m[layout.D_RING + n] = ring_once(m, w)
            n += 1
