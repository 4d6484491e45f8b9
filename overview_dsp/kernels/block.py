"""The block driver: events, then runs of samples between them, then meters and the guard.

`process` cuts a block only where an event falls due or a coefficient glides, and every state column
is carried from sample to sample in full, so no partition into blocks can change a bit.

Thread: audio (`process`), main (`reset`, `tactor_stage`).
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import entry, point
from overview_dsp.kernels.control import apply_due, drop_waiting, glide_all, next_due
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.elementary import sin_turns
from overview_dsp.kernels.envelope import compress, follow
from overview_dsp.kernels.limiter import limit
from overview_dsp.kernels.motion import move
from overview_dsp.kernels.output import emit
from overview_dsp.kernels.shaping import shape
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.voice import sound


@point
def run(m, w, u, out, channels, start, stop, trace, traced):
    """Samples `start` to `stop` of a block, between events: the whole voice, chunk by chunk."""
    while start < stop:
        frames = min(stop - start, layout.CHUNK)
        move(m, w, frames, trace, start * layout.TRACE, traced)
        shape(m, frames)
        sound(m, w, u, frames, trace, start * layout.TRACE, traced)
        emit(m, w, out, start, frames, channels)
        w[layout.CLOCK] += frames
        start += frames


@point
def clear(m, w, u):
    """Every state column and meter as new; coefficients, rings and surfaces stay."""
    slot = w[layout.ACTIVE_SLOT]
    for i in range(layout.STATE, layout.TOTAL_STATE):
        w[i] = 0
    w[layout.STRIKES_READ] = 0
    for number in range(layout.CONTACT):
        w[layout.STRIKES_SOUNDED + number] = 0
    w[layout.HOLDER] = -1
    w[layout.FADING_SLOT] = -1
    w[layout.ACTIVE_SLOT] = slot
    u[layout.NOISE] = u[layout.S_SEED]


@point
def is_finite(m):
    """Whether every recursive state column is a finite number."""
    total = (
        m[layout.X]
        + m[layout.V]
        + m[layout.SMOOTH_1]
        + m[layout.SMOOTH_2]
        + m[layout.FOLLOWER]
        + m[layout.ENVELOPE_1]
        + m[layout.ENVELOPE_2]
    )
    total = (
        total
        + m[layout.TACTOR_DC_OUT]
        + m[layout.CLICK_DC_OUT]
        + m[layout.TEXTURE]
        + m[layout.PHASE]
        + m[layout.BRISTLE]
        + m[layout.M_IMPULSE]
    )
    return total - total == 0.0


@point
def recover(m, w, u, clock, out, start, stop):
    """After a block: a voice whose state isn't finite is as new, and its output zero."""
    if is_finite(m):
        return
    blocks = w[layout.M_BLOCKS]
    resets = w[layout.M_RESETS]
    clear(m, w, u)
    w[layout.CLOCK] = clock
    w[layout.M_BLOCKS] = blocks
    w[layout.M_RESETS] = resets + 1
    for i in range(start, stop):
        out[i] = 0.0


@entry
def reset(m, w, u):
    """As new: state and meters cleared, glides and crossfades finished, waiting events dropped.

    Thread: main, or audio between blocks.
    """
    clear(m, w, u)
    w[layout.APPLIED] = 0
    for i in range(layout.COEFFS):
        if w[layout.GLIDE_LEFT + i] > 0:
            m[i] = m[layout.TARGET + i]
            w[layout.GLIDE_LEFT + i] = 0
    drop_waiting(w)


@entry
def process(m, w, u, out, frames, channels, trace, traced):
    """One block of audio.

    Parameters
    ----------
    m, w, u : float64, int64, uint64 [layout.TOTAL]
        The memory block, seen three ways.
    out : float32 [frames * channels]
        Interleaved output, overwritten.
    frames, channels : int64
    trace : float64 [frames * layout.TRACE] or of any length
        Overwritten if `traced`.
    traced : bool

    Thread: audio. Never allocates, locks or raises.
    """
    m[layout.M_PEAK_CLICK] = 0.0
    m[layout.M_PEAK_TACTOR] = 0.0
    n = 0
    first = w[layout.CLOCK]
    while n < frames:
        apply_due(m, w)
        stop = frames
        # a gliding coefficient is a new constant every sample
        if glide_all(m, w) > 0:
            stop = n + 1
        else:
            due = next_due(w) - first
            if due < stop:
                # an event pushed just now may be due already
                stop = due if due > n else n + 1
        run(m, w, u, out, channels, n, stop, trace, traced)
        n = stop
    w[layout.M_BLOCKS] += 1
    recover(m, w, u, first + frames, out, 0, frames * channels)


@entry
def tactor_stage(m, torque, out):
    """The tactor channel of a torque signal alone, as `process` makes it from rest.

    Parameters
    ----------
    m : float64 [layout.TOTAL]
        Only the coefficients are read.
    torque : float64 [frames]
        N m.
    out : float32 [frames]
        Overwritten.

    Thread: main.
    """
    follower = 0.0
    e1 = 0.0
    e2 = 0.0
    phase = 0.0
    before = 0.0
    blocked = 0.0
    for n in range(torque.size):
        amplitude = compress(torque[n], m[layout.C_TORQUE], m[layout.C_GATE], m[layout.C_EXPONENT])
        follower, e1, e2 = follow(amplitude, follower, e1, e2, m[layout.C_DECAY], m[layout.C_RISE])
        phase = advance(phase, m[layout.C_CARRIER])
        wave = e2 * m[layout.C_TACTOR_GAIN] * sin_turns(phase)
        blocked = block_dc(wave, before, blocked, m[layout.C_DC_POLE])
        before = wave
        out[n] = limit(blocked, m[layout.C_CEILING])
