"""The block driver: events, then runs of samples between them, then meters and the guard.

`process` cuts a block only where an event falls due or a coefficient glides, and every state column
is carried from sample to sample in full, so no partition into blocks can change a bit.

Thread: audio (`process`), main (`reset`, `tactor_stage`).
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import entry_point, inlined
from overview_dsp.kernels.control import apply_due, drop_waiting, glide_all, next_due
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.elementary import sin_turns
from overview_dsp.kernels.envelope import compress, follow
from overview_dsp.kernels.limiter import limit
from overview_dsp.kernels.motion import move
from overview_dsp.kernels.ordering import store_release
from overview_dsp.kernels.output import emit
from overview_dsp.kernels.shaping import shape
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.voice import sound


@inlined
def run(f64, i64, u64, out, channels, start, stop, trace, traced):
    """Samples `start` to `stop` of a block, between events: the whole voice, chunk by chunk."""
    while start < stop:
        frames = min(stop - start, layout.CHUNK)
        move(f64, i64, frames, trace, start * layout.TRACE, traced)
        shape(f64, frames)
        sound(f64, i64, u64, frames, trace, start * layout.TRACE, traced)
        emit(f64, i64, out, start, frames, channels)
        i64[layout.CLOCK] += frames
        start += frames


@inlined
def clear(f64, i64, u64):
    """Every state column and meter as new; coefficients, rings and surfaces stay."""
    for i in range(layout.STATE, layout.ACTIVE_SLOT):
        i64[i] = 0
    for i in range(layout.FADING_SLOT + 1, layout.TOTAL_STATE):
        i64[i] = 0
    store_release(i64, layout.FADING_SLOT, -1)
    i64[layout.STRIKES_READ] = 0
    for number in range(layout.CONTACT):
        i64[layout.STRIKES_SOUNDED + number] = 0
    i64[layout.HOLDER] = -1
    u64[layout.NOISE] = u64[layout.S_SEED]


@inlined
def is_finite(f64):
    """Whether every recursive state column is a finite number."""
    total = (
        f64[layout.X]
        + f64[layout.V]
        + f64[layout.SMOOTH_1]
        + f64[layout.SMOOTH_2]
        + f64[layout.FOLLOWER]
        + f64[layout.ENVELOPE_1]
        + f64[layout.ENVELOPE_2]
    )
    total = (
        total
        + f64[layout.TACTOR_DC_OUT]
        + f64[layout.CLICK_DC_OUT]
        + f64[layout.TEXTURE]
        + f64[layout.PHASE]
        + f64[layout.BRISTLE]
        + f64[layout.M_IMPULSE]
    )
    return total - total == 0.0


@inlined
def recover(f64, i64, u64, clock, out, start, stop):
    """After a block: a voice whose state isn't finite is as new, and its output zero."""
    if is_finite(f64):
        return
    blocks = i64[layout.M_BLOCKS]
    resets = i64[layout.M_RESETS]
    clear(f64, i64, u64)
    i64[layout.CLOCK] = clock
    i64[layout.M_BLOCKS] = blocks
    i64[layout.M_RESETS] = resets + 1
    for i in range(start, stop):
        out[i] = 0.0


@entry_point
def reset(f64, i64, u64):
    """As new: state and meters cleared, glides and crossfades finished, waiting events dropped.

    Thread: main, or audio between blocks.
    """
    clear(f64, i64, u64)
    store_release(i64, layout.APPLIED, 0)
    for i in range(layout.COEFFS):
        if i64[layout.GLIDE_LEFT + i] > 0:
            f64[i] = f64[layout.TARGET + i]
            i64[layout.GLIDE_LEFT + i] = 0
    drop_waiting(i64)


@entry_point
def process(f64, i64, u64, out, frames, channels, trace, traced):
    """One block of audio.

    Parameters
    ----------
    f64, i64, u64 : float64, int64, uint64 [layout.TOTAL]
        The memory block, seen three ways.
    out : float32 [frames * channels]
        Interleaved output, overwritten.
    frames, channels : int64
    trace : float64 [frames * layout.TRACE] or of any length
        Overwritten if `traced`.
    traced : bool

    Thread: audio. Never allocates, locks or raises.
    """
    f64[layout.M_PEAK_CLICK] = 0.0
    f64[layout.M_PEAK_TACTOR] = 0.0
    n = 0
    first = i64[layout.CLOCK]
    while n < frames:
        apply_due(f64, i64)
        stop = frames
        # a gliding coefficient is a new constant every sample
        if glide_all(f64, i64) > 0:
            stop = n + 1
        else:
            due = next_due(i64) - first
            if due < stop:
                # an event pushed just now may be due already
                stop = due if due > n else n + 1
        run(f64, i64, u64, out, channels, n, stop, trace, traced)
        n = stop
    i64[layout.M_BLOCKS] += 1
    recover(f64, i64, u64, first + frames, out, 0, frames * channels)


@entry_point
def tactor_stage(f64, torque, out):
    """The tactor channel of a torque signal alone, as `process` makes it from rest.

    Parameters
    ----------
    f64 : float64 [layout.TOTAL]
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
        amplitude = compress(
            torque[n], f64[layout.C_TORQUE], f64[layout.C_GATE], f64[layout.C_EXPONENT]
        )
        follower, e1, e2 = follow(
            amplitude, follower, e1, e2, f64[layout.C_DECAY], f64[layout.C_RISE]
        )
        phase = advance(phase, f64[layout.C_CARRIER])
        wave = e2 * f64[layout.C_TACTOR_GAIN] * sin_turns(phase)
        blocked = block_dc(wave, before, blocked, f64[layout.C_DC_POLE])
        before = wave
        out[n] = limit(blocked, f64[layout.C_CEILING])
